//! Quadratic drag: `-coefficient v |v|`.

use crate::law::{Acts, Effect, ForceLaw, Law, Local, Parameter, Range, Scales, Variable};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "quadratic_drag",
    words: "quadratic drag",
    formula: "-coefficient v |v|",
    parameters: &[Parameter::new("coefficient", Dimension::new(1, -2, 2), Range::NonNegative)],
    depends_on: &[Variable::Velocity],
    acts: Acts::Coordinates,
    law: Law::Force(&QuadraticDrag),
};

#[derive(Debug)]
struct QuadraticDrag;

impl ForceLaw for QuadraticDrag {
    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        vec![Prior::magnitude(scales.force / scales.v.powi(2))]
    }

    fn basis(&self, _shape: &[f64], at: &Local, _memory: &[f64], basis: &mut [f64]) {
        basis[0] = -at.v * at.v.abs();
    }
}
