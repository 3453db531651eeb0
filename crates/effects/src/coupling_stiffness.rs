//! A spring to another coordinate: `stiffness (q_j - q_i)`.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable, linear_stiffness, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "coupling_stiffness",
    words: "a spring to another coordinate",
    formula: "stiffness (q_j - q_i)",
    parameters: &[Parameter::new("stiffness", Dimension::new(1, -1, 0), Range::Any)],
    depends_on: &[Variable::Coordinate, Variable::OtherCoordinate],
    acts: Acts::CoordinatesAndStates,
    law: Law::Force(&CouplingStiffness),
    priors,
    shapes: one_shape,
    nature: Nature { apart: Some(&linear_stiffness::EFFECT), ..Nature::PLAIN },
};

#[derive(Debug)]
struct CouplingStiffness;

impl ForceLaw for CouplingStiffness {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [at.other_q(0) - at.q()]
    }

    fn reacts(&self) -> bool {
        true
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::amplitude(
        (scales.force / scales.half_range()).min(scales.other.2 / scales.other.0),
    )]
}
