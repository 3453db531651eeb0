//! Cubic stiffness: `-stiffness q^3`.

use crate::law::{Acts, Effect, ForceLaw, Law, Local, Parameter, Range, Scales, Variable};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "cubic_stiffness",
    words: "cubic stiffness",
    formula: "-stiffness q^3",
    parameters: &[Parameter::new("stiffness", Dimension::new(1, -3, 0), Range::Any)],
    depends_on: &[Variable::Coordinate],
    acts: Acts::Coordinates,
    law: Law::Force(&CubicStiffness),
};

#[derive(Debug)]
struct CubicStiffness;

impl ForceLaw for CubicStiffness {
    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        vec![Prior::amplitude(scales.force / scales.half_range().powi(3))]
    }

    fn basis(&self, _shape: &[f64], at: &Local, _memory: &[f64], basis: &mut [f64]) {
        basis[0] = -at.q.powi(3);
    }
}
