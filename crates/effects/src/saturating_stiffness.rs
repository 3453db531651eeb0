//! A spring that gives way: `-stiffness q / sqrt(1 + (q / reach)^2)`, linear near 0 and never more than
//! `stiffness reach`. Rubber, magnets and belts do so.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable, cubic_stiffness,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "saturating_stiffness",
    words: "a spring that gives way",
    formula: "-stiffness q / sqrt(1 + (q / reach)^2)",
    parameters: &[
        Parameter::new("stiffness", Dimension::new(1, -1, 0), Range::Any),
        Parameter::new("reach", Dimension::new(0, 1, 0), Range::Positive),
    ],
    depends_on: &[Variable::Coordinate],
    acts: Acts::Coordinates,
    law: Law::Force(&SaturatingStiffness),
    priors,
    shapes,
    nature: Nature { variation_of: Some(&cubic_stiffness::EFFECT), ..Nature::PLAIN },
};

#[derive(Debug)]
struct SaturatingStiffness;

impl ForceLaw for SaturatingStiffness {
    #[inline(always)]
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        let part = at.q() / shape[0];
        [-at.q() / (part * part + 1.0).sqrt()]
    }
}

/// Within three ranges: beyond, it is linear.
fn priors(scales: &Scales) -> Vec<Prior> {
    let half = scales.half_range();
    vec![
        Prior::amplitude(2.0 * scales.force / half),
        Prior::order(0.4 * half, 2.5, (0.03 * half, 3.0 * half)),
    ]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    [0.1, 0.2, 0.4, 0.8, 1.6].map(|share| vec![share * scales.half_range()]).to_vec()
}
