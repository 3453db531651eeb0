//! Dry friction between two coordinates: `magnitude tanh((v_j - v_i) / smoothing_velocity)`.

use crate::dry_friction::{SMOOTHING_VELOCITY, smooth_sign, smoothing_prior, smoothing_velocities};
use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "coupling_friction",
    words: "dry friction between two coordinates",
    formula: "magnitude tanh((v_j - v_i) / smoothing_velocity)",
    parameters: &[
        Parameter::new("magnitude", Dimension::FORCE, Range::NonNegative),
        SMOOTHING_VELOCITY,
    ],
    depends_on: &[Variable::Velocity, Variable::OtherVelocity],
    acts: Acts::Coordinates,
    law: Law::Force(&CouplingFriction),
    priors,
    shapes,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct CouplingFriction;

impl ForceLaw for CouplingFriction {
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [smooth_sign(at.other_v(0) - at.v(), shape[0])]
    }

    fn reacts(&self) -> bool {
        true
    }
}

/// The magnitudes of what rubs: the velocity is that of one coordinate against the other.
fn relative(scales: &Scales) -> Scales {
    Scales { v: scales.apart.1, force: scales.force.min(scales.other.2), ..*scales }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    let relative = relative(scales);
    vec![Prior::magnitude(relative.force), smoothing_prior(&relative)]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    smoothing_velocities(&relative(scales)).map(|v_s| vec![v_s]).to_vec()
}
