//! Dry (Coulomb) friction: `-magnitude tanh(v / smoothing_velocity)`.

use crate::law::{Acts, Effect, ForceLaw, Law, Local, Parameter, Range, Scales, Variable};
use crate::law::{SMOOTHING_VELOCITY, smooth_sign, smoothing_prior, smoothing_velocities};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "coulomb_friction",
    words: "dry (Coulomb) friction",
    formula: "-magnitude tanh(v / smoothing_velocity)",
    parameters: &[
        Parameter::new("magnitude", Dimension::FORCE, Range::NonNegative),
        SMOOTHING_VELOCITY,
    ],
    depends_on: &[Variable::Velocity],
    acts: Acts::CoordinatesAndStates,
    law: Law::Force(&CoulombFriction),
};

#[derive(Debug)]
struct CoulombFriction;

impl ForceLaw for CoulombFriction {
    fn basis(&self, shape: &[f64], at: &Local, _memory: &[f64], basis: &mut [f64]) {
        basis[0] = -smooth_sign(at.v, shape[0]);
    }

    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        vec![Prior::magnitude(scales.force), smoothing_prior(scales)]
    }

    fn shapes(&self, scales: &Scales) -> Vec<Vec<f64>> {
        smoothing_velocities(scales).map(|v_s| vec![v_s]).to_vec()
    }
}
