//! Linear stiffness: `-stiffness q`.

use crate::law::{Acts, Effect, ForceLaw, Law, Local, Parameter, Range, Scales, Variable};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "linear_stiffness",
    words: "linear stiffness",
    formula: "-stiffness q",
    parameters: &[Parameter::new("stiffness", Dimension::new(1, -1, 0), Range::Any)],
    depends_on: &[Variable::Coordinate],
    acts: Acts::Coordinates,
    law: Law::Force(&LinearStiffness),
};

#[derive(Debug)]
struct LinearStiffness;

impl ForceLaw for LinearStiffness {
    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        vec![Prior::amplitude(scales.force / scales.half_range())]
    }

    fn basis(&self, _shape: &[f64], at: &Local, _memory: &[f64], basis: &mut [f64]) {
        basis[0] = -at.q;
    }
}
