//! A spring to another coordinate: `stiffness (q_j - q_i)`.

use crate::law::{Acts, Effect, ForceLaw, Law, Local, Parameter, Range, Scales, Variable};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "coupling_stiffness",
    words: "a spring to another coordinate",
    formula: "stiffness (q_j - q_i)",
    parameters: &[Parameter::new("stiffness", Dimension::new(1, -1, 0), Range::Any)],
    depends_on: &[Variable::Coordinate, Variable::OtherCoordinate],
    acts: Acts::CoordinatesAndStates,
    law: Law::Force(&CouplingStiffness),
};

#[derive(Debug)]
struct CouplingStiffness;

impl ForceLaw for CouplingStiffness {
    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        vec![Prior::amplitude(
            (scales.force / scales.half_range()).min(scales.other.2 / scales.other.0),
        )]
    }

    fn basis(&self, _shape: &[f64], at: &Local, _memory: &[f64], basis: &mut [f64]) {
        basis[0] = at.other_q - at.q;
    }

    fn reacts(&self) -> bool {
        true
    }
}
