//! Many occupation kernels at one point.
//!
//! ```text
//! Gamma_a(x) = sum_k c_a(k) K(x, x_k) (1, u_k)^T
//! ```
//!
//! Eight functionals stand side by side in the lanes of vectors, their samples one after the other: sums stay in
//! registers; lanes are added last, in their order. A shorter functional is filled up with samples of no weight.

use std::ops::Range;
use std::slice::ChunksExact;

use pulp::{Simd, WithSimd};

use super::profile::{Form, Shape, dispatch};
use super::row::accumulate;
use super::{WithProfile, widest};

/// Functionals side by side, whatever the width of the vectors.
pub(crate) const LANES: usize = 8;
/// Samples that are taken together in narrow vectors.
const AT_ONCE: usize = 4;
/// Most sums of a functional that stand in registers.
const MOST: usize = 8;
/// Most rows of a contraction, and most rows times columns: they stand on the stack.
pub(crate) const MOST_ROWS: usize = 16;
pub(crate) const MOST_ENTRIES: usize = 64;
/// Most arguments of a contraction: they stand on the stack.
pub(crate) const MOST_ARGUMENTS: usize = 64;

/// Occupation kernels Gamma_a, laid out for sums over their samples.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OccupationSums {
    form: Form,
    /// 1 + m.
    columns: usize,
    count: usize,
    blocks: Vec<Block>,
}

/// Eight functionals: for each of their samples d scaled arguments and 1 + m weights c (1, u), eight of each.
#[derive(Debug, Clone, PartialEq)]
struct Block {
    samples: Vec<f64>,
}

/// One functional: the arguments (samples x d) and inputs (samples x m) that it looks at, and its weights.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Looks<'a> {
    pub weights: &'a [f64],
    pub arguments: &'a [f64],
    pub inputs: &'a [f64],
}

impl OccupationSums {
    /// Of `count` functionals with m inputs.
    pub fn new<'a>(
        form: Form,
        inputs: usize,
        count: usize,
        functional: impl Fn(usize) -> Looks<'a>,
    ) -> Self {
        let block = |b: usize| {
            let lanes: Vec<Looks> =
                (LANES * b..count.min(LANES * (b + 1))).map(&functional).collect();
            Block::of(&form, inputs, &lanes)
        };
        let blocks = (0..count.div_ceil(LANES)).map(block).collect();
        Self { form, columns: inputs + 1, count, blocks }
    }

    /// Number of blocks of eight.
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// Number of functionals.
    pub fn count(&self) -> usize {
        self.count
    }

    /// 1 + m.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// x in the scale of the arguments.
    pub fn scale(&self, x: &[f64], scaled: &mut [f64]) {
        let entries = x.iter().zip(&self.form.scales).zip(scaled);
        entries.for_each(|((x, scale), to)| *to = x * scale);
    }

    /// sum_a W_ai Gamma_aj(x) for x (not scaled) and the weights W of eight functionals after eight, coordinate by
    /// coordinate: `entries[i (1 + m) + j]`. Allocates nothing.
    pub fn contract(&self, x: &[f64], weights: &[[f64; LANES]], entries: &mut [f64]) {
        let mut room = [0.0; MOST_ARGUMENTS];
        let scaled = &mut room[..x.len()];
        self.scale(x, scaled);
        dispatch(self.form.profile, Contraction { sums: self, x: scaled, weights, entries });
    }

    /// Gamma_a at points (scaled, rows of d) for the eight a of a block: `values[(p (1 + m) + j) 8 + a]`.
    pub fn block(&self, block: usize, points: &[f64], values: &mut [f64]) {
        let samples = &self.blocks[block].samples;
        let (d, columns) = (self.form.scales.len(), self.columns);
        dispatch(self.form.profile, Sums { d, columns, samples, points, values });
    }
}

impl Block {
    fn of(form: &Form, inputs: usize, lanes: &[Looks<'_>]) -> Self {
        let d = form.scales.len();
        let longest = lanes.iter().map(|looks| looks.weights.len()).max().unwrap_or(0);
        let width = d + 1 + inputs;
        let mut samples = vec![0.0; longest * width * LANES];
        for (lane, looks) in lanes.iter().enumerate() {
            for (k, &weight) in looks.weights.iter().enumerate() {
                let mut put = |row: usize, value: f64| {
                    samples[(k * width + row) * LANES + lane] = value;
                };
                for (i, scale) in form.scales.iter().enumerate() {
                    put(i, looks.arguments[k * d + i] * scale);
                }
                put(d, weight);
                for j in 0..inputs {
                    put(d + 1 + j, weight * looks.inputs[k * inputs + j]);
                }
            }
        }
        Self { samples }
    }
}

/// Gamma_a of one block at points.
struct Sums<'a> {
    d: usize,
    columns: usize,
    samples: &'a [f64],
    points: &'a [f64],
    values: &'a mut [f64],
}

/// W^T Gamma at one point.
struct Contraction<'a> {
    sums: &'a OccupationSums,
    x: &'a [f64],
    weights: &'a [[f64; LANES]],
    entries: &'a mut [f64],
}

/// One of them with the type of a profile.
struct Of<T, P, const RADIAL: bool> {
    what: T,
    shape: P,
}

impl WithProfile for Sums<'_> {
    type Output = ();

    #[inline(always)]
    fn with_profile<P: Shape, const RADIAL: bool>(self, shape: P) {
        widest().dispatch(Of::<_, P, RADIAL> { what: self, shape });
    }
}

impl WithProfile for Contraction<'_> {
    type Output = ();

    #[inline(always)]
    fn with_profile<P: Shape, const RADIAL: bool>(self, shape: P) {
        widest().dispatch(Of::<_, P, RADIAL> { what: self, shape });
    }
}

// The usual numbers of arguments and inputs are compiled for themselves; 0 stands for any number.

impl<P: Shape, const RADIAL: bool> WithSimd for Of<Sums<'_>, P, RADIAL> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { what, shape } = self;
        match (what.d, what.columns) {
            (1, 2) => what.run::<S, P, RADIAL, 1, 2>(simd, shape),
            (4, 1) => what.run::<S, P, RADIAL, 4, 1>(simd, shape),
            (4, 3) => what.run::<S, P, RADIAL, 4, 3>(simd, shape),
            _ => what.run::<S, P, RADIAL, 0, 0>(simd, shape),
        }
    }
}

impl<P: Shape, const RADIAL: bool> WithSimd for Of<Contraction<'_>, P, RADIAL> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { what, shape } = self;
        match (what.x.len(), what.sums.columns) {
            (4, 1) => what.run::<S, P, RADIAL, 4, 1>(simd, shape),
            (4, 3) => what.run::<S, P, RADIAL, 4, 3>(simd, shape),
            _ => what.run::<S, P, RADIAL, 0, 0>(simd, shape),
        }
    }
}

impl Sums<'_> {
    #[inline(always)]
    fn run<S: Simd, P: Shape, const RADIAL: bool, const D: usize, const C: usize>(
        self,
        simd: S,
        shape: P,
    ) {
        let d = if D > 0 { D } else { self.d };
        let columns = if C > 0 { C } else { self.columns };
        let outputs = self.values.chunks_exact_mut(columns * LANES);
        for (x, values) in self.points.chunks_exact(d).zip(outputs) {
            for from in (0..columns).step_by(MOST) {
                let part = from..columns.min(from + MOST);
                for lane in (0..LANES).step_by(S::F64_LANES) {
                    let samples = self.samples.chunks_exact((d + columns) * LANES);
                    let sums = gamma::<S, P, RADIAL>(simd, shape, x, samples, part.clone(), lane);
                    for (sum, j) in sums.iter().zip(part.clone()) {
                        let to = &mut values[j * LANES + lane..][..S::F64_LANES];
                        S::as_mut_simd_f64s(to).0[0] = *sum;
                    }
                }
            }
        }
    }
}

impl Contraction<'_> {
    #[inline(always)]
    fn run<S: Simd, P: Shape, const RADIAL: bool, const D: usize, const C: usize>(
        self,
        simd: S,
        shape: P,
    ) {
        let x = if D > 0 { &self.x[..D] } else { self.x };
        let columns = if C > 0 { C } else { self.sums.columns };
        let n = self.entries.len() / columns;
        let mut room = [[0.0; LANES]; MOST_ENTRIES];
        let lanes = &mut room[..self.entries.len()];
        let blocks = self.sums.blocks.iter().zip(self.weights.chunks_exact(n));
        for from in (0..columns).step_by(MOST) {
            let part = from..columns.min(from + MOST);
            for lane in (0..LANES).step_by(S::F64_LANES) {
                let mut totals = [[simd.splat_f64s(0.0); MOST]; MOST_ROWS];
                for (block, weights) in blocks.clone() {
                    let samples = block.samples.chunks_exact((x.len() + columns) * LANES);
                    let sums = gamma::<S, P, RADIAL>(simd, shape, x, samples, part.clone(), lane);
                    for (total, weight) in totals.iter_mut().zip(weights) {
                        let weight = S::as_simd_f64s(&weight[lane..lane + S::F64_LANES]).0[0];
                        for (total, (&sum, _)) in
                            total.iter_mut().zip(sums.iter().zip(part.clone()))
                        {
                            *total = simd.mul_add_e_f64s(sum, weight, *total);
                        }
                    }
                }
                for (total, row) in totals.iter().zip(lanes.chunks_exact_mut(columns)) {
                    for (&total, j) in total.iter().zip(part.clone()) {
                        let to = &mut row[j][lane..lane + S::F64_LANES];
                        S::as_mut_simd_f64s(to).0[0] = total;
                    }
                }
            }
        }
        for (entry, lanes) in self.entries.iter_mut().zip(lanes) {
            *entry = lanes.iter().sum();
        }
    }
}

/// sum_k K(x, x_k) c_k (1, u_k) for the columns of a part, in the lanes from `lane` on.
#[inline(always)]
fn gamma<S: Simd, P: Shape, const RADIAL: bool>(
    simd: S,
    shape: P,
    x: &[f64],
    mut samples: ChunksExact<'_, f64>,
    part: Range<usize>,
    lane: usize,
) -> [S::f64s; MOST] {
    let mut sums = [simd.splat_f64s(0.0); MOST];
    // Processors with narrow vectors have few registers: constants are loaded once for several samples.
    while S::F64_LANES < LANES && samples.len() >= AT_ONCE {
        let mut group = [&[][..]; AT_ONCE];
        let mut kernels = [simd.splat_f64s(0.0); AT_ONCE];
        for (sample, s) in group.iter_mut().zip(&mut kernels) {
            *sample = samples.next().unwrap_or_default();
            *s = argument::<S, RADIAL>(simd, x, sample, lane);
        }
        for kernel in &mut kernels {
            *kernel = shape.of(simd, *kernel);
        }
        for (sample, kernel) in group.into_iter().zip(kernels) {
            add_weighted(simd, kernel, &sample[x.len() * LANES + lane..], part.clone(), &mut sums);
        }
    }
    for sample in samples {
        let kernel = shape.of(simd, argument::<S, RADIAL>(simd, x, sample, lane));
        add_weighted(simd, kernel, &sample[x.len() * LANES + lane..], part.clone(), &mut sums);
    }
    sums
}

/// What the profile is taken of.
#[inline(always)]
fn argument<S: Simd, const RADIAL: bool>(
    simd: S,
    x: &[f64],
    sample: &[f64],
    lane: usize,
) -> S::f64s {
    let mut s = simd.splat_f64s(0.0);
    for (i, &own) in x.iter().enumerate() {
        let other = S::as_simd_f64s(&sample[i * LANES + lane..][..S::F64_LANES]).0[0];
        s = accumulate::<S, RADIAL>(simd, simd.splat_f64s(own), other, s);
    }
    s
}

/// Adds a kernel value times each weight.
#[inline(always)]
fn add_weighted<S: Simd>(
    simd: S,
    kernel: S::f64s,
    weights: &[f64],
    part: Range<usize>,
    sums: &mut [S::f64s; MOST],
) {
    for (sum, j) in sums.iter_mut().zip(part) {
        let weight = S::as_simd_f64s(&weights[j * LANES..][..S::F64_LANES]).0[0];
        *sum = simd.mul_add_e_f64s(kernel, weight, *sum);
    }
}
