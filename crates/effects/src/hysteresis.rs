//! Hysteresis (Bouc-Wen): `-stiffness z, z' = v - beta |v| z - gamma v |z|`.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "hysteresis",
    words: "hysteresis (Bouc-Wen)",
    formula: "-stiffness z, z' = v - beta |v| z - gamma v |z|",
    parameters: &[
        Parameter::new("stiffness", Dimension::new(1, -1, 0), Range::NonNegative),
        Parameter::new("beta", Dimension::new(0, -1, 0), Range::NonNegative),
        Parameter::new("gamma", Dimension::new(0, -1, 0), Range::Any),
    ],
    depends_on: &[Variable::Velocity],
    acts: Acts::Coordinates,
    law: Law::Force(&Hysteresis),
    priors,
    shapes,
    nature: Nature { memory_spread, ..Nature::PLAIN },
};

#[derive(Debug)]
struct Hysteresis;

impl ForceLaw for Hysteresis {
    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-at.memory[0]]
    }

    fn memory(&self) -> usize {
        1
    }

    fn memory_rate<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        let (v, z) = (at.v(), at.memory[0]);
        [v - shape[0] * v.abs() * z - shape[1] * v * z.abs()]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    let travel = 0.3 * scales.stroke;
    let loop_prior =
        Prior::order(0.5 / travel, 2.5, (0.3 / scales.half_range(), 25.0 / scales.stroke));
    vec![Prior::magnitude(2.0 * scales.force / scales.half_range()), loop_prior, loop_prior]
}

/// Equal beta and gamma: the loop unloads elastically. The force saturates after a
/// travel of `1 / (beta + gamma)`.
fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let travel = [0.05, 0.1, 0.2, 0.4, 0.8].map(|share| share * scales.half_range());
    travel.map(|d| vec![0.5 / d, 0.5 / d]).to_vec()
}

fn memory_spread(shape: &[f64], _scales: &Scales, spread: &mut [f64]) {
    spread[0] = 1.0 / (shape[0] + shape[1]).max(f64::MIN_POSITIVE);
}
