//! An overflow above a level (a tank's brim): `-rate max(x - position, 0)`.

use crate::{
    Acts, At, Biased, Dimension, Effect, Family, ForceLaw, Kin, Law, Nature, Number, Parameter,
    Prior, Range, Scales, Variable, linear_loss,
};

/// What runs over a brim. The laws' shared numbers: rate, position.
pub(crate) static FAMILY: Family = Family { words: "an overflow" };

pub(crate) static EFFECT: Effect = Effect {
    class: "overflow",
    words: "an overflow above a level",
    formula: "-rate max(x - position, 0)",
    parameters: &[
        Parameter::new("rate", Dimension::new(1, -1, 0), Range::NonNegative),
        Parameter::new("position", Dimension::COORDINATE, Range::Any),
    ],
    depends_on: &[Variable::Coordinate],
    acts: Acts::States,
    law: Law::Force(&Overflow),
    priors,
    shapes,
    nature: Nature {
        kin: Some(Kin::of(&FAMILY)),
        edge: true,
        // Always over the brim, it is a loss about it.
        biased: Some(Biased::about(&linear_loss::EFFECT)),
        ..Nature::PLAIN
    },
};

#[derive(Debug)]
struct Overflow;

impl ForceLaw for Overflow {
    #[inline(always)]
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-(at.q() - shape[0]).max(T::constant(0.0))]
    }
}

pub(crate) fn priors(scales: &Scales) -> Vec<Prior> {
    let reach = scales.half_range();
    let brim = Prior::near(scales.q.0 + 1.7 * reach, 0.4 * reach, scales.q);
    // A hard brim: what moves the state lifts it over by no more than a hundredth of its way. Harder
    // ones look the same.
    let hard = 100.0 * scales.force / reach;
    vec![Prior::near(0.0, hard, (0.0, hard)), brim]
}

/// Brims in the upper part of the state's range.
pub(crate) fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let (low, high) = scales.q;
    let shares = [0.7, 0.75, 0.8, 0.85, 0.89, 0.925, 0.955, 0.98];
    shares.map(|share| vec![low + share * (high - low)]).to_vec()
}
