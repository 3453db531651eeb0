//! Gram matrices of functionals that overlap.
//!
//! C is sparse: each functional looks at one window. Functionals are taken in groups of neighbours that span a few
//! hundred samples, and G in blocks, one for each pair of groups: the kernel is evaluated once for a pair of samples of
//! a block however many windows overlap there, and matrix products do the sums. A block is computed by one thread in a
//! fixed order, so the result does not depend on the number of threads.

use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

use crate::functional::Functional;
use crate::kernel::Kernel;
use crate::occupation_kernels::OccupationKernels;
use crate::simd::{Profile, coordinate_by_coordinate, kernel_row};

/// Samples that a group of functionals may span, and rows and columns of a tile of kernel values: tile and factors fit
/// into a second-level cache.
const TILE: usize = 256;

pub(super) fn gram<K: Kernel + ?Sized>(kernel: &K, occupation: &OccupationKernels) -> Mat<f64> {
    let groups = group(occupation.functionals());
    let pairs: Vec<(usize, usize)> =
        (0..groups.len()).flat_map(|p| (p..groups.len()).map(move |q| (p, q))).collect();
    let blocks: Vec<Mat<f64>> =
        pairs.par_iter().map(|&(p, q)| block(kernel, occupation, &groups[p], &groups[q])).collect();
    let mut gram = Mat::zeros(occupation.functionals().len(), occupation.functionals().len());
    for (&(p, q), block) in pairs.iter().zip(&blocks) {
        place(gram.as_mut(), &groups[p], &groups[q], block.as_ref(), p == q);
    }
    gram
}

/// Neighbouring functionals, as the dense matrix of their weights on the samples that they span.
struct Group {
    /// Index of the first functional.
    start: usize,
    /// Samples that the functionals look at.
    span: Range<usize>,
    /// Samples x functionals.
    weights: Mat<f64>,
}

fn group(functionals: &[Functional]) -> Vec<Group> {
    let mut groups = Vec::new();
    let mut start = 0;
    while start < functionals.len() {
        let mut span = functionals[start].first..functionals[start].end();
        let mut end = start + 1;
        while end < functionals.len() {
            let next = &functionals[end];
            let wider = span.start.min(next.first)..span.end.max(next.end());
            if wider.len() > TILE {
                break;
            }
            (span, end) = (wider, end + 1);
        }
        let weights = dense(&functionals[start..end], &span);
        groups.push(Group { start, span, weights });
        start = end;
    }
    groups
}

fn dense(functionals: &[Functional], span: &Range<usize>) -> Mat<f64> {
    let mut weights = Mat::zeros(span.len(), functionals.len());
    for (column, functional) in functionals.iter().enumerate() {
        for (k, &weight) in functional.weights.iter().enumerate() {
            weights[(functional.first - span.start + k, column)] = weight;
        }
    }
    weights
}

/// C_p M C_q^T, tile by tile, so that memory does not grow with the length of a recording.
fn block<K: Kernel + ?Sized>(
    kernel: &K,
    occupation: &OccupationKernels,
    p: &Group,
    q: &Group,
) -> Mat<f64> {
    let mut block = Mat::zeros(p.weights.ncols(), q.weights.ncols());
    let mut tile = Tile::default();
    for rows in tiles(&p.span) {
        let mut right = Mat::zeros(rows.len(), q.weights.ncols());
        for columns in tiles(&q.span) {
            let values = tile.fill(kernel, occupation, &rows, &columns);
            let values = MatRef::from_row_major_slice(values, rows.len(), columns.len());
            let weights = q.weights.as_ref().subrows(columns.start - q.span.start, columns.len());
            matmul(right.as_mut(), Accum::Add, values, weights, 1.0, Par::Seq);
        }
        let weights = p.weights.as_ref().subrows(rows.start - p.span.start, rows.len());
        matmul(block.as_mut(), Accum::Add, weights.transpose(), right.as_ref(), 1.0, Par::Seq);
    }
    block
}

fn tiles(span: &Range<usize>) -> impl Iterator<Item = Range<usize>> + use<> {
    let end = span.end;
    span.clone().step_by(TILE).map(move |start| start..end.min(start + TILE))
}

/// Room for the values of a tile and for the points of its columns.
#[derive(Default)]
struct Tile {
    values: Vec<f64>,
    points: Vec<f64>,
    inputs: Vec<f64>,
    factors: Vec<f64>,
}

impl Tile {
    /// K(x_k, x_l) (1 + u_k . u_l) for k in `rows`, l in `columns`, row-major.
    fn fill<K: Kernel + ?Sized>(
        &mut self,
        kernel: &K,
        occupation: &OccupationKernels,
        rows: &Range<usize>,
        columns: &Range<usize>,
    ) -> &[f64] {
        let (d, m) = (occupation.argument_count(), occupation.input_count());
        coordinate_by_coordinate(
            &occupation.arguments()[columns.start * d..columns.end * d],
            d,
            &mut self.points,
        );
        coordinate_by_coordinate(
            &occupation.inputs()[columns.start * m..columns.end * m],
            m,
            &mut self.inputs,
        );
        self.values.resize(rows.len() * columns.len(), 0.0);
        self.factors.resize(columns.len(), 0.0);
        for (k, values) in rows.clone().zip(self.values.chunks_exact_mut(columns.len())) {
            kernel.evaluate_row(occupation.argument(k), &self.points, values);
            if m > 0 {
                // 1 + u_k . u_l is a polynomial kernel of degree 1.
                let linear = Profile::Power { degree: 1, offset: 1.0 };
                let u = occupation.input(k);
                kernel_row(linear, (1.0, None), u, &self.inputs, &mut self.factors);
                values.iter_mut().zip(&self.factors).for_each(|(value, factor)| *value *= factor);
            }
        }
        &self.values
    }
}

/// Writes a block and its mirror image; of a block on the diagonal, only the upper triangle counts.
fn place(mut gram: MatMut<'_, f64>, p: &Group, q: &Group, block: MatRef<'_, f64>, diagonal: bool) {
    for b in 0..block.ncols() {
        let rows = if diagonal { b + 1 } else { block.nrows() };
        for a in 0..rows {
            gram[(p.start + a, q.start + b)] = block[(a, b)];
            gram[(q.start + b, p.start + a)] = block[(a, b)];
        }
    }
}
