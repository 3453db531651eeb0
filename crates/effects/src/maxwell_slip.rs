//! Friction of elements that stick and slip (Maxwell slip): `-magnitude (z_1 + z_2 + z_3) / (3 travel), z_k moves with q and stays at its limit, limits travel on average in ratios 1/spread : 1 : spread`.
//!
//! Three springs in parallel, each behind a dry contact (Jenkins elements): one that is bent to
//! its limit slips, and when the motion turns it sticks again. The friction of small motions, before
//! the surfaces slide, depends so on where they turned: loops nest in loops. All
//! springs are as stiff, together `magnitude / travel`; `magnitude` is the friction when all slip.
//!
//! The edge of each limit l is a ramp of a quarter of it:
//!
//! ```text
//! z' = v (1 - clamp(1 + (|z| / l - 1) / 0.25, 0, 2))   if v pushes (v z > 0), else v
//! ```
//!
//! No rate is larger than `|v|`, which no step makes unstable.

use crate::dry_friction::{travel_prior, travels};
use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "maxwell_slip",
    words: "friction of elements that stick and slip (Maxwell slip)",
    formula: "-magnitude (z_1 + z_2 + z_3) / (3 travel), z_k moves with q and stays at its limit, limits travel on average in ratios 1/spread : 1 : spread",
    parameters: &[
        Parameter::new("magnitude", Dimension::FORCE, Range::NonNegative),
        Parameter::new("travel", Dimension::COORDINATE, Range::Positive),
        Parameter::new("spread", Dimension::NUMBER, Range::Positive),
    ],
    depends_on: &[Variable::Velocity],
    acts: Acts::Coordinates,
    law: Law::Force(&MaxwellSlip),
    priors,
    shapes,
    nature: Nature {
        memory_spread: |shape, _, spread| spread.copy_from_slice(&limits(shape)),
        ..Nature::PLAIN
    },
};

/// Width of the edge in limits.
const EDGE: f64 = 0.25;
/// Samples of the usual motion that the least travel takes: the narrowest limit is wider than one.
const SLOWEST: f64 = 8.0;

#[derive(Debug)]
struct MaxwellSlip;

impl ForceLaw for MaxwellSlip {
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        let bent = at.memory[0] + at.memory[1] + at.memory[2];
        [-bent / (shape[0] * 3.0)]
    }

    fn memory(&self) -> usize {
        3
    }

    fn memory_rate<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        let (v, limits) = (at.v(), limits(shape));
        [0, 1, 2].map(|k| {
            let z = at.memory[k];
            if v.value() * z.value() <= 0.0 {
                return v;
            }
            let slipping = (z.abs() / limits[k] - 1.0) / EDGE + 1.0;
            v * (-slipping.clamp(T::constant(0.0), T::constant(2.0)) + 1.0)
        })
    }
}

/// The limits of the three.
#[inline(always)]
fn limits<T: Number>(shape: &[T]) -> [T; 3] {
    let (travel, spread) = (shape[0], shape[1]);
    let unit = travel * 3.0 / (T::constant(1.0) / spread + 1.0 + spread);
    [unit / spread, unit, unit * spread]
}

fn priors(scales: &Scales) -> Vec<Prior> {
    vec![
        Prior::magnitude(scales.force),
        travel_prior(scales, SLOWEST),
        Prior::order(2.0, 1.5, (1.0, 4.0)),
    ]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let spread = |travel: f64| [1.2, 2.5].map(|spread| vec![travel, spread]);
    travels(scales, SLOWEST).into_iter().flat_map(spread).collect()
}
