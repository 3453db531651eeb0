//! Backlash in the transmission to another coordinate: `-stiffness clamp(q_j - q_i, -gap/2, gap/2)`.
//!
//! A shaft of this stiffness with play pushes with `stiffness deadband(q_j - q_i, gap/2)`: within
//! the gap with nothing, beyond it as a spring that begins at the gap's edge. The model has the
//! shaft without play, `stiffness (q_j - q_i)`; this law is the difference of the two, which
//! takes back what the model transmits within the gap. It acts on both coordinates, and stores
//! and loses no more energy than the spring that it takes back.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "transmission_backlash",
    words: "backlash in the transmission to another coordinate",
    formula: "-stiffness clamp(q_j - q_i, -gap/2, gap/2)",
    parameters: &[
        Parameter::new("stiffness", Dimension::new(1, -1, 0), Range::NonNegative),
        Parameter::new("gap", Dimension::COORDINATE, Range::NonNegative),
    ],
    depends_on: &[Variable::Coordinate, Variable::OtherCoordinate],
    acts: Acts::Coordinates,
    law: Law::Force(&TransmissionBacklash),
    priors,
    shapes,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct TransmissionBacklash;

impl ForceLaw for TransmissionBacklash {
    #[inline(always)]
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        let half = shape[0] * 0.5;
        [-(at.other_q(0) - at.q()).clamp(-half, half)]
    }

    fn reacts(&self) -> bool {
        true
    }
}

/// A shaft is stiff: nearly all of the difference may be its play.
fn priors(scales: &Scales) -> Vec<Prior> {
    let (reach, force) = (scales.apart.0, scales.force.min(scales.other.2));
    let gap = Prior::order(reach, 3.0, (0.02 * reach, 2.0 * reach));
    vec![Prior::magnitude(20.0 * force / reach), gap]
}

/// From a twentieth of the difference's range to nearly all of it.
fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let shares = [0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.92];
    shares.map(|share| vec![2.0 * share * scales.apart.0]).to_vec()
}
