//! Dry friction that grows with the load: `-(magnitude + share |u|) tanh(v / smoothing_velocity)`.
//!
//! u is an input of the machine, such as the torque that a gear transmits: its flanks rub harder the
//! more they carry, whichever way. `share` is the force lost per unit of the input; where both are in
//! one unit it is a coefficient of friction. Both parts are magnitudes, so that it dissipates under
//! any load.

use crate::dry_friction::{
    Dry, DryFriction, FAMILY, SMOOTHING_VELOCITY, shared, smoothing_prior, smoothing_velocities,
};
use crate::{
    Acts, At, Dimension, Effect, Kin, Law, Nature, Number, Parameter, Prior, Range, Scales, Stated,
    Variable, coulomb_friction,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "load_friction",
    words: "dry friction that grows with the load",
    formula: "-(magnitude + share |u|) tanh(v / smoothing_velocity)",
    parameters: &[
        Parameter::new("magnitude", Dimension::FORCE, Range::NonNegative),
        Parameter::new("share", Dimension::FORCE.per_input(), Range::NonNegative),
        SMOOTHING_VELOCITY,
    ],
    depends_on: &[Variable::Velocity, Variable::OtherInput],
    acts: Acts::Coordinates,
    law: Law::Force(&Dry(LoadFriction)),
    priors,
    shapes,
    nature: Nature {
        kin: Some(Kin {
            family: &FAMILY,
            shared: |p, scales| shared(p[0] + p[1] * scales.usual_input(), 0.0, p[2]),
            begun,
        }),
        variation_of: Some(&coulomb_friction::EFFECT),
        stated: Some(Stated::friction(&[1.0], "the growth with the load")),
        ..Nature::PLAIN
    },
};

#[derive(Debug)]
struct LoadFriction;

impl DryFriction<2> for LoadFriction {
    const SMOOTHING: usize = 0;

    #[inline(always)]
    fn magnitudes<T: Number>(&self, _shape: &[T], at: &At<T>) -> [T; 2] {
        [T::constant(1.0), at.input().abs()]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    let share = scales.force / scales.usual_input();
    vec![Prior::magnitude(scales.force), Prior::magnitude(share), smoothing_prior(scales)]
}

/// A load that is always 0 is none.
fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let shapes = smoothing_velocities(scales).map(|v_s| vec![v_s]).to_vec();
    if scales.usual_input() > 0.0 { shapes } else { vec![] }
}

/// Half of the friction is there without a load, half by the usual one.
fn begun(shared: &[f64], scales: &Scales) -> Vec<Vec<f64>> {
    let (half, usual) = (0.5 * shared[0], scales.usual_input());
    if usual > 0.0 { vec![vec![half, half / usual, shared[2]]] } else { vec![] }
}
