//! The extended Kalman filter of a window, in innovations form: where noise drives the machine,
//! the model is corrected by what is measured, and what is fitted is what it could not foresee.
//!
//! ```text
//! nu_k = (y_k - h(x_k)) / sigma,   z_k = W_k nu_k,   x_k <- x_k + G_k z_k
//! -2 log likelihood = sum_k |z_k|^2 + log det S,     S_k = (W_k^T W_k)^-1 = C_k P_k C_k^T + R
//! ```
//!
//! W is lower triangular. The state at the window's beginning is a parameter, P is 0 there. Without
//! noise that drives, G = 0 and W = 1: what is left is the plain residual. While theta is
//! fitted, G and W stay as they are, so that derivatives run through the corrections.

use super::covariance::Covariance;
use super::{ProcessNoise, Window};
use crate::dataset::Observed;
use lacuna_numbers::Linear;

/// Gains and whitening of one window, sample by sample.
#[derive(Clone, Debug)]
pub struct Filter {
    width: usize,
    outputs: usize,
    /// G, one row of `width` an output.
    gains: Vec<f64>,
    /// W, row-major `outputs x outputs`; rows of 0 where nothing was measured.
    whiteners: Vec<f64>,
    /// nu, along the run that the filter was made on; 0 where nothing was measured.
    innovations: Vec<f64>,
    /// Sum of log det S: how much wider innovations are than the outputs' noise.
    pub log_determinant: f64,
    /// What the sum of |z|^2 would be if nothing drove the machine: that of the outputs' noise.
    pub quiet: f64,
    /// Variances of the state's entries at the window's end.
    pub(super) unknown: Vec<f64>,
}

/// A filter under way through its window.
pub(super) struct Making {
    filter: Filter,
    unknown: Covariance,
    /// What it would not know if nothing drove the machine.
    quiet: Covariance,
    /// R: variances of the outputs' noise.
    noise: Vec<f64>,
}

impl Making {
    /// For a state whose entries begin with these variances, and outputs of this noise.
    pub(super) fn new(variances: &[f64], noise: &ProcessNoise) -> Self {
        let (width, outputs) = (variances.len(), noise.outputs.len());
        let filter = Filter {
            width,
            outputs,
            gains: vec![],
            whiteners: vec![],
            innovations: vec![],
            log_determinant: 0.0,
            quiet: 0.0,
            unknown: vec![],
        };
        let noise = noise.outputs.iter().map(|r| r * r).collect();
        Self { filter, unknown: Covariance::of(variances), quiet: Covariance::of(variances), noise }
    }

    /// Take up a sample: `rows` of C and innovations, in units of the noise; NaN where nothing was
    /// measured.
    pub(super) fn measure(&mut self, rows: &[f64], innovations: &[f64]) {
        let Self { filter, unknown, quiet, noise } = self;
        let (n, p) = (filter.width, filter.outputs);
        let (g, w) = (filter.gains.len(), filter.whiteners.len());
        filter.gains.resize(g + p * n, 0.0);
        filter.whiteners.resize(w + p * p, 0.0);
        let (gains, whiteners) = (&mut filter.gains[g..], &mut filter.whiteners[w..]);
        let mut projected = vec![0.0; n];
        for o in 0..p {
            let measured = innovations[o].is_finite();
            filter.innovations.push(if measured { innovations[o] } else { 0.0 });
            if !measured {
                continue;
            }
            let c = &rows[o * n..(o + 1) * n];
            let (before, own) = gains.split_at_mut(o * n);
            let own = &mut own[..n];
            let (s, scale) = unknown.measure(c, noise[o], own);
            filter.quiet += (quiet.seen_by(c, &mut projected) + noise[o]) / s;
            quiet.corrected(c, noise[o], own, s);
            filter.log_determinant += s.ln();
            // The outputs before it have moved the state.
            let (rows_before, row) = whiteners.split_at_mut(o * p);
            row[o] = scale;
            for (j, gain) in before.chunks_exact(n).enumerate() {
                let seen: f64 = c.iter().zip(gain).map(|(a, b)| a * b).sum();
                for l in 0..=j {
                    row[l] -= scale * seen * rows_before[j * p + l];
                }
            }
        }
    }

    /// A step of the machine, see [`Covariance::step`].
    pub(super) fn step(&mut self, map: &[f64], stride: usize, driven: &[(usize, f64)]) {
        self.unknown.step(map, stride, driven);
        self.quiet.step(map, stride, &[]);
    }

    /// Move a state by what was measured last.
    pub(super) fn correct(&self, state: &mut [f64]) {
        let f = &self.filter;
        let at = f.innovations.len() / f.outputs - 1;
        f.correct(at, &f.innovations[at * f.outputs..], state);
    }

    pub(super) fn done(self) -> Filter {
        Filter { unknown: self.unknown.variances(), ..self.filter }
    }
}

impl Filter {
    /// Move a state by the innovations (in units of the noise; 0 where nothing was measured) of
    /// the window's sample `at`.
    #[inline(always)]
    pub(super) fn correct<T: Linear>(&self, at: usize, innovations: &[T], state: &mut [T]) {
        let (n, p) = (self.width, self.outputs);
        let gains = &self.gains[at * p * n..(at + 1) * p * n];
        let whiteners = &self.whiteners[at * p * p..(at + 1) * p * p];
        for (gain, row) in gains.chunks_exact(n).zip(whiteners.chunks_exact(p)) {
            let mut z = T::ZERO;
            for (nu, w) in innovations.iter().zip(row).filter(|(_, w)| **w != 0.0) {
                z = z + *nu * *w;
            }
            for (x, g) in state.iter_mut().zip(gain) {
                T::by_itself();
                *x = *x + z * *g;
            }
        }
    }

    /// Whiten changes of the outputs at sample `at`, in units of the noise, several of each output;
    /// what was not measured has none.
    #[inline(always)]
    pub(super) fn whiten_sample<T: Linear>(&self, at: usize, changes: &mut [T]) {
        let p = self.outputs;
        let (whiteners, each) = (&self.whiteners[at * p * p..(at + 1) * p * p], changes.len() / p);
        // From the last one on: those before it are still as they were.
        for o in (0..p).rev() {
            for g in 0..each {
                let mut sum = T::ZERO;
                for (j, w) in whiteners[o * p..=o * p + o].iter().enumerate() {
                    sum = sum + changes[j * each + g] * *w;
                }
                changes[o * each + g] = sum;
            }
        }
    }

    /// Innovations of sample `at`, in units of the noise.
    pub(super) fn innovations(&self, at: usize) -> &[f64] {
        &self.innovations[at * self.outputs..(at + 1) * self.outputs]
    }

    /// Whether an output was measured at a sample.
    pub(super) fn measured(&self, at: usize, output: usize) -> bool {
        self.whiteners[(at * self.outputs + output) * self.outputs + output] != 0.0
    }

    /// Whiten columns of a window, whose rows are the measured samples, output by output.
    pub(crate) fn whiten<'c>(
        &self,
        observed: &Observed,
        w: &Window,
        columns: impl Iterator<Item = &'c mut Vec<f64>>,
    ) {
        let (p, places) = (self.outputs, places(observed, w));
        let mut sample = vec![0.0; p];
        for column in columns {
            for (at, row) in places.chunks_exact(p).enumerate() {
                for (value, &place) in sample.iter_mut().zip(row) {
                    *value = column.get(place).copied().unwrap_or(0.0);
                }
                self.whiten_sample(at, &mut sample);
                for (value, &place) in sample.iter().zip(row) {
                    if let Some(x) = column.get_mut(place) {
                        *x = *value;
                    }
                }
            }
        }
    }
}

/// The place of what was not measured.
const NOWHERE: usize = usize::MAX;

/// The row of each output at each sample of a window, if it was measured there.
fn places(observed: &Observed, w: &Window) -> Vec<usize> {
    let p = observed.outputs.len();
    let mut places = vec![NOWHERE; w.range.len() * p];
    let mut next = 0;
    for (o, series) in observed.outputs.iter().enumerate() {
        for (at, y) in series[w.range.clone()].iter().enumerate() {
            if y.is_finite() {
                places[at * p + o] = next;
                next += 1;
            }
        }
    }
    places
}
