//! Integrals of kernel values along a trajectory.

use pulp::{Simd, WithSimd};

use super::super::field::Field;
use super::integrator::Nodes;
use crate::simd::{add_scaled, widest};

/// The integrals up to the end of an interval, from those up to its start.
pub(super) struct Accumulation<'a> {
    pub field: &'a Field,
    pub nodes: &'a Nodes,
    pub before: &'a [f64],
    pub after: &'a mut [f64],
}

impl Accumulation<'_> {
    pub fn work_out(self) {
        widest().dispatch(self);
    }
}

impl WithSimd for Accumulation<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { field, nodes, before, after } = self;
        let features = field.features();
        if features == 0 {
            return;
        }
        let count = after.len() / features;
        for (a, row) in after.chunks_exact_mut(features).enumerate() {
            for (b, old) in before.chunks_exact(features).enumerate() {
                add_scaled(row, nodes.to_end[a * count + b], old);
            }
            let matrices = nodes.to_end.chunks_exact(count * count);
            for (to_end, values) in matrices.zip(nodes.values.chunks_exact(features)) {
                let mut first = 0;
                for term in &field.terms {
                    let last = first + term.basis.rank();
                    let factor = to_end[a * count + count - field.dimension + term.row];
                    if factor != 0.0 {
                        add_scaled(&mut row[first..last], factor, &values[first..last]);
                    }
                    first = last;
                }
            }
        }
    }
}
