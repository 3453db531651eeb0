//! Friction with a Stribeck peak at low speed: `-(coulomb + (static - coulomb) exp(-(v / stribeck_velocity)^2)) tanh(v / smoothing_velocity)`.

use crate::law::{Acts, Effect, ForceLaw, Law, Local, Parameter, Range, Scales, Variable};
use crate::law::{SMOOTHING_VELOCITY, smooth_sign, smoothing_prior, smoothing_velocities};
use crate::{Dimension, Prior};

pub(crate) static EFFECT: Effect = Effect {
    class: "stribeck_friction",
    words: "friction with a Stribeck peak at low speed",
    formula: "-(coulomb + (static - coulomb) exp(-(v / stribeck_velocity)^2)) tanh(v / smoothing_velocity)",
    parameters: &[
        Parameter::new("coulomb", Dimension::FORCE, Range::NonNegative),
        Parameter::new("static", Dimension::FORCE, Range::NonNegative),
        Parameter::new("stribeck_velocity", Dimension::VELOCITY, Range::Positive),
        SMOOTHING_VELOCITY,
    ],
    depends_on: &[Variable::Velocity],
    acts: Acts::Coordinates,
    law: Law::Force(&StribeckFriction),
};

#[derive(Debug)]
struct StribeckFriction;

impl ForceLaw for StribeckFriction {
    fn amplitudes(&self) -> usize {
        2
    }

    fn basis(&self, shape: &[f64], at: &Local, _memory: &[f64], basis: &mut [f64]) {
        let sign = smooth_sign(at.v, shape[1]);
        let low_speed = (-(at.v / shape[0]).powi(2)).exp();
        basis[0] = -(1.0 - low_speed) * sign;
        basis[1] = -low_speed * sign;
    }

    fn priors(&self, scales: &Scales) -> Vec<Prior> {
        vec![
            Prior::magnitude(scales.force),
            Prior::magnitude(1.5 * scales.force),
            Prior::order(0.35 * scales.v, 2.5, (0.05 * scales.v, 4.0 * scales.v)),
            smoothing_prior(scales),
        ]
    }

    fn shapes(&self, scales: &Scales) -> Vec<Vec<f64>> {
        let [sharp, medium, _] = smoothing_velocities(scales);
        let widths = [0.1, 0.2, 0.4, 0.8, 1.6].map(|share| share * scales.v);
        widths.iter().flat_map(|&w| [vec![w, sharp], vec![w, medium]]).collect()
    }
}
