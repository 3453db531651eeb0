//! Dry (Coulomb) friction: `-magnitude tanh(v / smoothing_velocity)`.

use crate::dry_friction::{
    FAMILY, SMOOTHING_VELOCITY, shared, smooth_sign, smoothing_prior, smoothing_velocities,
};
use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Kin, Law, Nature, Number, Parameter, Prior, Quantity,
    Range, Scales, Stated, Variable,
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
    law: Law::Force(&CoulombFriction),
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

impl ForceLaw for CoulombFriction {
    #[inline(always)]
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-smooth_sign(at.v(), shape[0])]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![Prior::magnitude(scales.force), smoothing_prior(scales)]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    smoothing_velocities(scales).map(|v_s| vec![v_s]).to_vec()
}
