//! The covariance P of what a filter does not know of the state, in units of the outputs' noise.
//!
//! ```text
//! measured:  s = c P c^T + r,  g = P c^T / sqrt(s),  P <- P - g g^T
//! a step:    P <- A P A^T + sum_j q_j b_j b_j^T
//! ```
//!
//! Outputs of one sample are taken one after the other, so that nothing is inverted.

use super::lanes::Lanes;
use lacuna_numbers::Linear;
use std::ops::{Mul, Sub};

/// What a covariance is made of: a number, or several side by side.
pub(super) trait Entry: Linear + Sub<Output = Self> + Mul<Output = Self> {
    /// 1 / sqrt(x).
    fn inverse_root(self) -> Self;

    /// `self + other factor`.
    fn plus(self, other: Self, factor: f64) -> Self;
}

impl Entry for f64 {
    #[inline(always)]
    fn inverse_root(self) -> Self {
        self.sqrt().recip()
    }

    #[inline(always)]
    fn plus(self, other: Self, factor: f64) -> Self {
        self + other * factor
    }
}

impl Entry for Lanes {
    #[inline(always)]
    fn inverse_root(self) -> Self {
        self.map(f64::inverse_root)
    }

    #[inline(always)]
    fn plus(self, other: Self, factor: f64) -> Self {
        Self(std::array::from_fn(|l| other.0[l].mul_add(factor, self.0[l])))
    }
}

/// A covariance under way.
#[derive(Clone, Debug)]
pub(super) struct Covariance<T = f64> {
    width: usize,
    /// Row-major, symmetric.
    p: Vec<T>,
    room: Vec<T>,
}

impl<T: Entry> Covariance<T> {
    /// Of a state that is known.
    pub(super) fn known(width: usize) -> Self {
        Self { width, p: vec![T::ZERO; width * width], room: vec![T::ZERO; width * width] }
    }

    /// `c P c^T`, with `P c^T` in `projected`.
    #[inline(always)]
    pub(super) fn seen_by(&self, c: &[f64], projected: &mut [T]) -> T {
        // Most outputs are an entry of the state.
        let mut seen = c.iter().enumerate().filter(|(_, c)| **c != 0.0);
        if let (Some((l, c)), None) = (seen.next(), seen.next()) {
            let row = &self.p[l * self.width..(l + 1) * self.width];
            for (to, p) in projected.iter_mut().zip(row) {
                T::by_itself();
                *to = *p * *c;
            }
            return projected[l] * *c;
        }
        for (row, p) in self.p.chunks_exact(self.width).zip(projected.iter_mut()) {
            *p = weighted(row, c);
        }
        weighted(projected, c)
    }

    /// Take up what an output says whose row is `c` and whose noise has variance `r`: the variance s
    /// of its innovation and 1 / sqrt(s), and the gain g by which one standard deviation of it moves
    /// the state.
    #[inline(always)]
    pub(super) fn measure(&mut self, c: &[f64], r: T, gain: &mut [T]) -> (T, T) {
        let s = self.seen_by(c, gain) + r;
        let scale = s.inverse_root();
        for g in gain.iter_mut() {
            T::by_itself();
            *g = *g * scale;
        }
        for (row, a) in self.p.chunks_exact_mut(self.width).zip(&*gain) {
            for (p, b) in row.iter_mut().zip(&*gain) {
                T::by_itself();
                *p = *p - *a * *b;
            }
        }
        (s, scale)
    }

    /// A step of the map whose rows, of `stride` entries, begin with those of A; what drives it
    /// stands in the columns `driven` of the map, each with its variance.
    #[inline(always)]
    pub(super) fn step(&mut self, map: &[f64], stride: usize, driven: &[(usize, T)]) {
        let n = self.width;
        let row = |i: usize| &map[i * stride..i * stride + n];
        // P is symmetric: its rows are its columns.
        for (i, room) in self.room.chunks_exact_mut(n).enumerate() {
            products(&self.p, row(i), room);
        }
        for (j, p) in self.p.chunks_exact_mut(n).enumerate() {
            products(&self.room, row(j), &mut p[..=j]);
        }
        for (at, q) in driven {
            for (j, p) in self.p.chunks_exact_mut(n).enumerate() {
                let own = *q * map[j * stride + at];
                for (i, p) in p[..=j].iter_mut().enumerate() {
                    *p = p.plus(own, map[i * stride + at]);
                }
            }
        }
        for j in 0..n {
            for i in 0..j {
                self.p[i * n + j] = self.p[j * n + i];
            }
        }
    }
}

/// Products of the rows of a matrix with a vector. Several rows at a time: sums that wait for nothing
/// but themselves are slow.
#[inline(always)]
fn products<T: Entry>(rows: &[T], weights: &[f64], out: &mut [T]) {
    let (rows, out) = in_blocks::<8, T>(rows, weights, out);
    let (rows, out) = in_blocks::<4, T>(rows, weights, out);
    for (out, row) in out.iter_mut().zip(rows.chunks_exact(weights.len())) {
        *out = weighted(row, weights);
    }
}

/// So many at a time; those that are left.
#[inline(always)]
fn in_blocks<'r, const ROWS: usize, T: Entry>(
    mut rows: &'r [T],
    weights: &[f64],
    mut out: &'r mut [T],
) -> (&'r [T], &'r mut [T]) {
    let n = weights.len();
    while out.len() >= ROWS {
        let (own, after) = rows.split_at(ROWS * n);
        let (block, left) = std::mem::take(&mut out).split_at_mut(ROWS);
        let mut sums = [T::ZERO; ROWS];
        for (l, w) in weights.iter().enumerate() {
            for (b, sum) in sums.iter_mut().enumerate() {
                *sum = sum.plus(own[b * n + l], *w);
            }
        }
        block.copy_from_slice(&sums);
        (rows, out) = (after, left);
    }
    (rows, out)
}

/// Their sum with these weights.
#[inline(always)]
pub(super) fn weighted<T: Entry>(a: &[T], b: &[f64]) -> T {
    a.iter().zip(b).fold(T::ZERO, |sum, (a, b)| sum.plus(*a, *b))
}

impl Covariance {
    /// Of a state whose entries have these variances, and nothing in common.
    pub(super) fn of(variances: &[f64]) -> Self {
        let mut this = Self::known(variances.len());
        for (i, v) in variances.iter().enumerate() {
            this.p[i * this.width + i] = *v;
        }
        this
    }

    /// Variances of the state's entries.
    pub(super) fn variances(&self) -> Vec<f64> {
        self.p.iter().step_by(self.width + 1).copied().collect()
    }

    /// What a gain that was made for another covariance leaves: `M P M^T + r g g^T / s` with
    /// `M = 1 - g c / sqrt(s)`.
    pub(super) fn corrected(&mut self, c: &[f64], r: f64, gain: &[f64], s: f64) {
        let n = self.width;
        let scale = s.sqrt().recip();
        let mut projected = vec![0.0; n];
        let seen = self.seen_by(c, &mut projected);
        for i in 0..n {
            for j in 0..n {
                let (a, b) = (gain[i] * scale, gain[j] * scale);
                self.p[i * n + j] += a * b * (seen + r) - a * projected[j] - b * projected[i];
            }
        }
    }
}
