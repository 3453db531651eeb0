//! Dry (Coulomb) friction: `-magnitude tanh(v / smoothing_velocity)`.

use crate::dry_friction::{
    Dry, DryFriction, FAMILY, SMOOTHING_VELOCITY, shared, smoothing_prior, smoothing_velocities,
};
use crate::{
    Acts, At, Dimension, Effect, Kin, Law, Nature, Number, Parameter, Prior, Quantity, Range,
    Scales, Stated, Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "coulomb_friction",
    words: "dry (Coulomb) friction",
    formula: "-magnitude tanh(v / smoothing_velocity)",
    parameters: &[
        Parameter::new("magnitude", Dimension::FORCE, Range::NonNegative),
        SMOOTHING_VELOCITY,
    ],
    depends_on: &[Variable::Velocity],
    acts: Acts::CoordinatesAndSpeeds,
    law: Law::Force(&Dry(CoulombFriction)),
    priors,
    shapes,
    nature: Nature {
        kin: Some(Kin {
            family: &FAMILY,
            shared: |p, _| shared(p[0], 0.0, p[1]),
            begun: |s, _| vec![vec![s[0], s[2]]],
        }),
        stated: Some(Stated::all(Quantity::Friction)),
        ..Nature::PLAIN
    },
};

#[derive(Debug)]
struct CoulombFriction;

impl DryFriction<1> for CoulombFriction {
    const SMOOTHING: usize = 0;

    #[inline(always)]
    fn magnitudes<T: Number>(&self, _shape: &[T], _at: &At<T>) -> [T; 1] {
        [T::constant(1.0)]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::magnitude(scales.force), smoothing_prior(scales)]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    smoothing_velocities(scales).map(|v_s| vec![v_s]).to_vec()
}
