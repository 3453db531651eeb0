//! Cogging (a force periodic in position): `amplitude sin(wavenumber q + phase)`.

use crate::sine::{sine_internal, sine_physical};
use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "cogging",
    words: "cogging (a force periodic in position)",
    formula: "amplitude sin(wavenumber q + phase)",
    parameters: &[
        Parameter::new("amplitude", Dimension::FORCE, Range::NonNegative),
        Parameter::new("wavenumber", Dimension::new(0, -1, 0), Range::Positive),
        Parameter::new("phase", Dimension::ANGLE, Range::Any).or(0.0),
    ],
    depends_on: &[Variable::Coordinate],
    acts: Acts::Coordinates,
    law: Law::Force(&Cogging),
    priors,
    shapes,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct Cogging;

impl ForceLaw for Cogging {
    fn amplitudes(&self) -> usize {
        2
    }

    fn internal(&self, physical: &[f64]) -> Vec<f64> {
        sine_internal(physical)
    }

    fn physical(&self, internal: &[f64]) -> Vec<f64> {
        sine_physical(internal)
    }

    #[inline(always)]
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        let (sine, cosine) = (shape[0] * at.q()).sin_cos();
        [sine, cosine]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    let pi = std::f64::consts::PI;
    let fastest = scales
        .pitches
        .into_iter()
        .fold(16.0 * pi / scales.stroke, |most, pitch| most.max(pitch + pi / scales.half_range()));
    let pitch = Prior::order(3.0 * pi / scales.stroke, 2.0, (pi / scales.half_range(), fastest));
    vec![Prior::amplitude(scales.force), Prior::amplitude(scales.force), pitch]
}

/// From one period over the range to twenty ([`crate::PITCHES`]), finely enough that a peak of the evidence, as wide as
/// one period over the range, cannot fall between; beyond them those that stand out.
fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let fundamental = std::f64::consts::PI / scales.half_range();
    let grid = (0..40).map(|k| 1.2 * fundamental * 1.075f64.powi(k));
    grid.chain(scales.pitches.into_iter().filter(|k| *k > 0.0)).map(|k| vec![k]).collect()
}
