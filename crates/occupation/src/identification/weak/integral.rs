//! Integrals of many functions at once.

use pulp::{Simd, WithSimd};

use super::reduction::Reduction;
use super::window::WeakWindow;
use crate::simd::{add_scaled, widest};

/// Functions' values at the nodes of a window (a row a node, side by side) times input `block`, integrated from its first
/// sample: for each p below `levels` N rows of derivative p, one level after the other.
pub(super) struct Integral<'a> {
    pub window: &'a WeakWindow,
    pub block: usize,
    pub levels: usize,
    pub columns: usize,
    pub values: &'a [f64],
    /// Levels x N rows.
    pub integrated: &'a mut [f64],
}

impl Integral<'_> {
    pub fn work_out(self) {
        widest().dispatch(self);
    }
}

impl WithSimd for Integral<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { window, block, levels, columns, values, integrated } = self;
        let (times, order) = (window.motion.times(), window.order);
        let samples = times.len();
        if columns == 0 {
            return;
        }
        // y, y', ..., y^(s-1) of the integrands.
        let mut state = vec![0.0; order * columns];
        for level in 0..levels {
            integrated[level * samples * columns..][..columns].fill(0.0);
        }
        for k in 0..samples - 1 {
            advance(&mut state, columns, times[k + 1] - times[k]);
            let first = window.first_node(k);
            for (p, entries) in state.chunks_exact_mut(columns).enumerate() {
                let weights = window.weights(k, block, order - 1 - p);
                let nodes = values[first * columns..].chunks_exact(columns);
                for (weight, values) in weights.iter().zip(nodes) {
                    add_scaled(entries, *weight, values);
                }
            }
            for (p, entries) in state.chunks_exact(columns).enumerate().take(levels) {
                let row = (p * samples + k + 1) * columns;
                integrated[row..row + columns].copy_from_slice(entries);
            }
        }
    }
}

/// Taylor: y^(p) += sum_(q > p) h^(q-p) / (q-p)! y^(q).
#[inline(always)]
fn advance(state: &mut [f64], columns: usize, step: f64) {
    let order = state.len() / columns;
    for p in 0..order {
        let (own, higher) = state[p * columns..].split_at_mut(columns);
        let mut taylor = 1.0;
        for (q, other) in higher.chunks_exact(columns).enumerate() {
            taylor *= step / (q + 1) as f64;
            add_scaled(own, taylor, other);
        }
    }
}

/// [`Reduction::reflect`] for many columns side by side.
pub(crate) struct Reflection<'a> {
    pub reduction: &'a Reduction,
    pub columns: usize,
    pub rows: &'a mut [f64],
}

impl Reflection<'_> {
    pub fn work_out(self) {
        widest().dispatch(self);
    }
}

impl WithSimd for Reflection<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { reduction, columns, rows } = self;
        if columns == 0 {
            return;
        }
        let mut shares = vec![0.0; columns];
        for (first, v) in reduction.vectors().enumerate() {
            let rows = &mut rows[first * columns..];
            shares.fill(0.0);
            for (entry, row) in v.iter().zip(rows.chunks_exact(columns)) {
                add_scaled(&mut shares, *entry, row);
            }
            for (entry, row) in v.iter().zip(rows.chunks_exact_mut(columns)) {
                add_scaled(row, -2.0 * entry, &shares);
            }
        }
    }
}
