//! Dry friction between two coordinates: `magnitude tanh((ratio v_j - v_i) / smoothing_velocity)`.
//!
//! What rubs moves with `ratio v_j - v_i`: 1 where one coordinate rubs on the other, -1 where a gear adds their
//! motions, as in the wrist of a robot whose last motor drives through the joint before. The other coordinate
//! gets `-ratio` times the force, so that friction only ever takes power.

use crate::dry_friction::{
    Dry, DryFriction, SMOOTHING_VELOCITY, smoothing_prior, smoothing_velocities,
};
use crate::{
    Acts, At, Dimension, Effect, Law, Nature, Number, Parameter, Prior, Range, Scales, Variable,
    coulomb_friction,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "coupling_friction",
    words: "dry friction between two coordinates",
    formula: "magnitude tanh((ratio v_j - v_i) / smoothing_velocity)",
    parameters: &[
        Parameter::new("magnitude", Dimension::FORCE, Range::NonNegative),
        SMOOTHING_VELOCITY,
        Parameter::new("ratio", Dimension::NUMBER, Range::Any).or(1.0),
    ],
    depends_on: &[Variable::Velocity, Variable::OtherVelocity],
    acts: Acts::Coordinates,
    law: Law::Force(&Dry(CouplingFriction)),
    priors,
    shapes,
    nature: Nature { apart: Some(&coulomb_friction::EFFECT), ..Nature::PLAIN },
};

/// Ratios that are looked for.
const RATIOS: [f64; 2] = [1.0, -1.0];

#[derive(Debug)]
struct CouplingFriction;

impl DryFriction<1> for CouplingFriction {
    const SMOOTHING: usize = 0;

    #[inline(always)]
    fn magnitudes<T: Number>(&self, _shape: &[T], _at: &At<T>) -> [T; 1] {
        [T::constant(1.0)]
    }

    #[inline(always)]
    fn sliding<T: Number>(&self, shape: &[T], at: &At<T>) -> T {
        at.v() - shape[1] * at.other_v(0)
    }

    fn reacts(&self) -> bool {
        true
    }

    fn passed_on<T: Number>(&self, shape: &[T]) -> T {
        shape[1]
    }
}

/// The magnitudes of what rubs: the velocity is that of one coordinate against the other.
fn relative(scales: &Scales) -> Scales {
    Scales { v: scales.apart.1, force: scales.force.min(scales.other.2), ..*scales }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    let relative = relative(scales);
    vec![Prior::magnitude(relative.force), smoothing_prior(&relative), Prior::Fixed]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let velocities = smoothing_velocities(&relative(scales));
    RATIOS.iter().flat_map(|ratio| velocities.map(|v_s| vec![v_s, *ratio])).collect()
}
