//! A payload: a mass that a link carries and the model does not know of.
//!
//! With its centre c in the link's frame it adds to the link's mass m, to its first moment m c, and to
//! its inertia about the frame's origin
//!
//! ```text
//! m (|c|^2 1 - c c^T + r^2 1)
//! ```
//!
//! with a radius of gyration r about its own centre that is the same about all axes, as that of a ball or
//! a cube: 0 is a point mass. What a long or flat one has otherwise is neglected. Mass matrix, Coriolis
//! forces and gravity follow.

use crate::law::BODY;
use crate::{
    Acts, Dimension, Effect, Law, Nature, Number, Parameter, Prior, Range, Scales, StructureLaw,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "payload",
    words: "a payload",
    formula: "mass at (com_x, com_y, com_z) of the link, with the inertia mass gyration_radius^2",
    parameters: &[
        Parameter::new("mass", Dimension::MASS, Range::Positive),
        Parameter::new("com_x", Dimension::LENGTH, Range::Any),
        Parameter::new("com_y", Dimension::LENGTH, Range::Any),
        Parameter::new("com_z", Dimension::LENGTH, Range::Any),
        Parameter::new("gyration_radius", Dimension::LENGTH, Range::NonNegative).or(0.0),
    ],
    depends_on: &[],
    acts: Acts::Links,
    law: Law::Structure(&Payload),
    priors,
    shapes,
    nature: Nature::PLAIN,
};

#[derive(Debug)]
struct Payload;

impl StructureLaw for Payload {
    fn amplitudes(&self) -> usize {
        1
    }

    fn numbers<T: Number>(&self, parameters: &[T]) -> impl AsRef<[T]> {
        let (m, [x, y, z], r) =
            (parameters[0], [parameters[1], parameters[2], parameters[3]], parameters[4]);
        let own = r * r;
        let about_origin = [
            y * y + z * z + own,
            -(x * y),
            -(x * z),
            x * x + z * z + own,
            -(y * z),
            x * x + y * y + own,
        ];
        let mut numbers = [m; BODY];
        let rest = [x, y, z].into_iter().chain(about_origin);
        numbers[1..].iter_mut().zip(rest).for_each(|(number, value)| *number = m * value);
        numbers
    }
}

/// Usual size of a payload's radius of gyration, as a share of how far its link reaches: a can or a tool,
/// not another link.
const COMPACT: f64 = 0.2;

/// Up to about half of what the robot itself moves, somewhere within its link's reach.
fn priors(scales: &Scales) -> Vec<Prior> {
    let (mass, reach) = scales.link;
    let centre = Prior::amplitude(reach);
    let radius = Prior::order(COMPACT * reach, 2.5, (0.01 * COMPACT * reach, 2.0 * reach));
    vec![Prior::magnitude(0.5 * mass), centre, centre, centre, radius]
}

/// Centres all over the link's reach, of a compact payload.
fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    const SHARES: [f64; 7] = [-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5];
    let reach = scales.link.1;
    let at = |x: f64, y: f64, z: f64| vec![x * reach, y * reach, z * reach, COMPACT * reach];
    let plane = |x: f64| SHARES.iter().flat_map(move |&y| SHARES.iter().map(move |&z| at(x, y, z)));
    SHARES.iter().flat_map(|&x| plane(x)).collect()
}
