//! Dry friction that differs between the two directions: `-positive tanh(v / smoothing_velocity) for v > 0, -negative tanh(v / smoothing_velocity) for v < 0`.

use crate::dry_friction::{
    Dry, DryFriction, FAMILY, SMOOTHING_VELOCITY, shared, smoothing_prior, smoothing_velocities,
};
use crate::{
    Acts, At, Biased, Dimension, Effect, Kin, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Stated, Variable, coulomb_friction,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "asymmetric_friction",
    words: "dry friction that differs between the two directions",
    formula: "-positive tanh(v / smoothing_velocity) for v > 0, -negative tanh(v / smoothing_velocity) for v < 0",
    parameters: &[
        Parameter::new("positive", Dimension::FORCE, Range::NonNegative),
        Parameter::new("negative", Dimension::FORCE, Range::NonNegative),
        SMOOTHING_VELOCITY,
    ],
    depends_on: &[Variable::Velocity],
    acts: Acts::CoordinatesAndSpeeds,
    law: Law::Force(&Dry(AsymmetricFriction)),
    priors,
    shapes,
    nature: Nature {
        kin: Some(Kin {
            family: &FAMILY,
            shared: |p, _| shared(0.5 * (p[0] + p[1]), 0.5 * (p[1] - p[0]), p[2]),
            begun: |s, _| vec![vec![s[0] - s[1], s[0] + s[1], s[2]]],
        }),
        biased: Some(Biased {
            effect: &coulomb_friction::EFFECT,
            numbers: |p| (vec![0.5 * (p[0] + p[1]), p[2]], 0.5 * (p[1] - p[0])),
        }),
        stated: Some(Stated::friction(&[0.5, 0.5], "the difference between the directions")),
        ..Nature::PLAIN
    },
};

#[derive(Debug)]
struct AsymmetricFriction;

impl DryFriction<2> for AsymmetricFriction {
    const SMOOTHING: usize = 0;

    #[inline(always)]
    fn magnitudes<T: Number>(&self, _shape: &[T], at: &At<T>) -> [T; 2] {
        let (whole, none) = (T::constant(1.0), T::constant(0.0));
        if at.v().value() >= 0.0 { [whole, none] } else { [none, whole] }
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::magnitude(scales.force), Prior::magnitude(scales.force), smoothing_prior(scales)]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    smoothing_velocities(scales).map(|v_s| vec![v_s]).to_vec()
}
