//! What runs over the brim of one first-order state and enters another: `-rate max(x - position, 0), of which share enters the other state`.
//!
//! Both states change by the same stream; `share` is what of it arrives, each counted in its
//! own unit: of two tanks with areas A_i and A_j, the part that is caught times `A_i / A_j`.

use crate::overflow::{self, FAMILY};
use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Kin, Law, Nature, Number, Parameter, Prior, Range,
    Scales, Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "spill",
    words: "an overflow of which a share enters another state",
    formula: "-rate max(x - position, 0), of which share enters the other state",
    parameters: &[
        Parameter::new("rate", Dimension::new(1, -1, 0), Range::NonNegative),
        Parameter::new("position", Dimension::COORDINATE, Range::Any),
        Parameter::new("share", Dimension::NUMBER, Range::NonNegative),
    ],
    depends_on: &[Variable::Coordinate],
    acts: Acts::States,
    law: Law::Force(&Spill),
    priors,
    shapes,
    nature: Nature {
        kin: Some(Kin { family: &FAMILY, shared: |p, _| vec![p[0], p[1]], begun }),
        edge: true,
        ..Nature::PLAIN
    },
};

#[derive(Debug)]
struct Spill;

impl ForceLaw for Spill {
    #[inline(always)]
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-(at.q() - shape[0]).max(T::constant(0.0))]
    }

    fn reacts(&self) -> bool {
        true
    }

    fn passed_on<T: Number>(&self, shape: &[T]) -> T {
        shape[1]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    let share = Prior::near(0.5, 0.5, (0.0, f64::INFINITY));
    overflow::priors(scales).into_iter().chain([share]).collect()
}

/// How much of it is caught: little, or nearly all.
const CAUGHT: [f64; 2] = [0.3, 0.9];

/// An overflow of which little is caught, and one of which nearly all is.
fn begun(shared: &[f64], _: &Scales) -> Vec<Vec<f64>> {
    CAUGHT.map(|share| vec![shared[0], shared[1], share]).to_vec()
}

/// Every brim of an overflow, with little and with nearly all caught.
fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let caught = |brim: Vec<f64>| CAUGHT.map(|share| vec![brim[0], share]);
    overflow::shapes(scales).into_iter().flat_map(caught).collect()
}
