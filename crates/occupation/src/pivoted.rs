//! Pivoted Cholesky factorisation of a kernel's values on points.
//!
//! Points are taken one by one where the kernel is worst represented by those before (S. Fine, K. Scheinberg, JMLR 2001):
//! K(x_k, x_l) ~ sum_j factor_j(k) factor_j(l).

use rayon::prelude::*;

use crate::kernel::Kernel;

/// Points that one thread looks at.
const GROUP: usize = 1024;

/// When the factorisation ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stop {
    /// Most points.
    pub most: usize,
    /// Largest variance that may be left.
    pub absolute: f64,
    /// The same over the largest variance of all.
    pub relative: f64,
}

/// The factorisation.
pub(crate) struct Pivoted {
    /// Points in the order in which they were taken.
    pub pivots: Vec<usize>,
    /// Features of all points, one feature after the other.
    pub factor: Vec<Vec<f64>>,
    /// Largest variance that is left, over the largest of all.
    pub left: f64,
    /// Whether that is as little as was asked for.
    pub complete: bool,
}

impl Pivoted {
    /// Of points in d dimensions, stored coordinate by coordinate.
    pub fn of<K: Kernel>(kernel: &K, columns: &[f64], d: usize, stop: Stop) -> Self {
        let count = columns.len() / d;
        let point = |k: usize| -> Vec<f64> { (0..d).map(|i| columns[i * count + k]).collect() };
        let mut left: Vec<f64> =
            (0..count).map(|k| kernel.evaluate(&point(k), &point(k))).collect();
        let of_all = greatest(&left).1;
        let enough = stop.absolute.max(stop.relative * of_all);
        let (mut pivots, mut factor): (Vec<usize>, Vec<Vec<f64>>) = (Vec::new(), Vec::new());
        let mut worst = greatest(&left);
        while pivots.len() < stop.most.min(count) && worst.1 > enough && worst.1.is_finite() {
            let (pivot, variance) = worst;
            let mut column = vec![0.0; count];
            kernel.evaluate_row(&point(pivot), columns, &mut column);
            take_out(&mut column, &factor, pivot);
            let root = variance.sqrt();
            column.iter_mut().for_each(|c| *c /= root);
            left.iter_mut().zip(&column).for_each(|(v, c)| *v = (*v - c * c).max(0.0));
            left[pivot] = 0.0;
            pivots.push(pivot);
            factor.push(column);
            worst = greatest(&left);
        }
        Self { pivots, factor, left: worst.1 / of_all, complete: worst.1 <= enough }
    }
}

/// Subtracts what the features before say of the pivot's column; points do not know of one another.
fn take_out(column: &mut [f64], factor: &[Vec<f64>], pivot: usize) {
    column.par_chunks_mut(GROUP).enumerate().for_each(|(g, column)| {
        for before in factor {
            let scale = before[pivot];
            let own = &before[g * GROUP..][..column.len()];
            column.iter_mut().zip(own).for_each(|(c, b)| *c -= scale * b);
        }
    });
}

/// The first of the largest, if it is above zero.
fn greatest(values: &[f64]) -> (usize, f64) {
    let mut best = (0, 0.0);
    for (k, &value) in values.iter().enumerate() {
        if value > best.1 {
            best = (k, value);
        }
    }
    best
}
