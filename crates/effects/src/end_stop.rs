//! An elastic end stop: `-stiffness max(q - position, 0), or its mirror image for side = -1`.

use crate::{
    Acts, At, Biased, Dimension, Effect, Family, ForceLaw, Kin, Law, Nature, Number, Parameter,
    Prior, Range, Scales, Variable, linear_stiffness,
};

/// The laws of end stops. Their shared numbers: stiffness, position, side.
pub(crate) static FAMILY: Family = Family { words: "end stops" };

pub(crate) static EFFECT: Effect = Effect {
    class: "end_stop",
    words: "an elastic end stop",
    formula: "-stiffness max(q - position, 0), or its mirror image for side = -1",
    parameters: &[
        Parameter::new("stiffness", Dimension::new(1, -1, 0), Range::NonNegative),
        Parameter::new("position", Dimension::COORDINATE, Range::Any),
        Parameter::side("side"),
    ],
    depends_on: &[Variable::Coordinate],
    acts: Acts::Coordinates,
    law: Law::Force(&EndStop),
    priors,
    shapes,
    nature: Nature {
        kin: Some(Kin::of(&FAMILY)),
        edge: true,
        // Never left, it is a spring about where it stands.
        biased: Some(Biased::about(&linear_stiffness::EFFECT)),
        ..Nature::PLAIN
    },
};

#[derive(Debug)]
struct EndStop;

impl ForceLaw for EndStop {
    #[inline(always)]
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        let beyond = shape[1] * (at.q() - shape[0]);
        [-shape[1] * beyond.max(T::constant(0.0))]
    }

    fn internal(&self, physical: &[f64]) -> Vec<f64> {
        vec![physical[0], physical[1], stands(physical[1], physical[2])]
    }
}

/// The side of a stop: 0 (none given) is that on which it stands.
pub(crate) fn stands(position: f64, side: f64) -> f64 {
    if side == 0.0 { position.signum() } else { side.signum() }
}

/// A usual stiffness: the force that moves the channel presses it in by a twentieth of its way.
pub(crate) fn stiffness(scales: &Scales) -> f64 {
    20.0 * scales.force / scales.half_range()
}

/// A stop stands where the channel comes.
pub(crate) fn position_prior(scales: &Scales) -> Prior {
    Prior::near(scales.centre(), 0.7 * scales.half_range(), scales.q)
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::magnitude(stiffness(scales)), position_prior(scales), Prior::Fixed]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let centre = 0.5 * (scales.q.0 + scales.q.1);
    let reach = scales.half_range();
    let shares = [0.4, 0.5, 0.6, 0.7, 0.78, 0.85, 0.91, 0.96];
    let at = |side: f64| shares.map(|share| vec![centre + side * share * reach, side]);
    at(1.0).into_iter().chain(at(-1.0)).collect()
}
