//! Dry friction that differs between the two directions: `-positive tanh(v / smoothing_velocity) for v > 0, -negative tanh(v / smoothing_velocity) for v < 0`.

use crate::law::{Acts, Effect, ForceLaw, Law, Local, Parameter, Range, Scales, Variable};
use crate::law::{SMOOTHING_VELOCITY, smooth_sign, smoothing_prior, smoothing_velocities};
use crate::{Dimension, Prior};

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
    acts: Acts::CoordinatesAndStates,
    law: Law::Force(&AsymmetricFriction),
};

#[derive(Debug)]
struct AsymmetricFriction;

impl ForceLaw for AsymmetricFriction {
    fn amplitudes(&self) -> usize {
        2
    }

    fn basis(&self, shape: &[f64], at: &Local, _memory: &[f64], basis: &mut [f64]) {
        let sign = smooth_sign(at.v, shape[0]);
        basis[0] = -sign.max(0.0);
        basis[1] = -sign.min(0.0);
    }

    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        vec![
            Prior::magnitude(scales.force),
            Prior::magnitude(scales.force),
            smoothing_prior(scales),
        ]
    }

    fn shapes(&self, scales: &Scales) -> Vec<Vec<f64>> {
        smoothing_velocities(scales).map(|v_s| vec![v_s]).to_vec()
    }
}
