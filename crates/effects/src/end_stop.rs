//! An elastic end stop: `-stiffness max(q - position, 0), or its mirror image for side = -1`.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable,
};

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
    nature: Nature { edge: true, ..Nature::PLAIN },
};

#[derive(Debug)]
struct EndStop;

impl ForceLaw for EndStop {
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        let beyond = shape[1] * (at.q() - shape[0]);
        [-shape[1] * beyond.max(T::constant(0.0))]
    }

    /// A side of 0 (none given) is the side on which the stop stands.
    fn internal(&self, physical: &[f64]) -> Vec<f64> {
        let side = if physical[2] == 0.0 { physical[1].signum() } else { physical[2].signum() };
        vec![physical[0], physical[1], side]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    let reach = scales.half_range();
    let position = Prior::near(scales.centre(), 0.7 * reach, scales.q);
    vec![Prior::magnitude(20.0 * scales.force / reach), position, Prior::Fixed]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let centre = 0.5 * (scales.q.0 + scales.q.1);
    let reach = scales.half_range();
    let shares = [0.4, 0.5, 0.6, 0.7, 0.78, 0.85, 0.91, 0.96];
    let at = |side: f64| shares.map(|share| vec![centre + side * share * reach, side]);
    at(1.0).into_iter().chain(at(-1.0)).collect()
}
