//! Damping that grows with the distance from the origin: `-coefficient q^2 v`.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable, one_shape,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "position_damping",
    words: "damping that grows with position",
    formula: "-coefficient q^2 v",
    parameters: &[Parameter::new("coefficient", Dimension::new(1, -3, 1), Range::NonNegative)],
    depends_on: &[Variable::Coordinate, Variable::Velocity],
    acts: Acts::Coordinates,
    law: Law::Force(&PositionDamping),
    priors,
    shapes: one_shape,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct PositionDamping;

impl ForceLaw for PositionDamping {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-at.q().powi(2) * at.v()]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::magnitude(scales.force / (scales.v * scales.half_range().powi(2)))]
}
