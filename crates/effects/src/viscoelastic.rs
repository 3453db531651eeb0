//! A viscoelastic (Maxwell) element: `-stiffness z, z' = v - z / time_constant`.

use crate::{
    Acts, At, Biased, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range,
    Scales, Variable, linear_stiffness,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "viscoelastic",
    words: "a viscoelastic (Maxwell) element",
    formula: "-stiffness z, z' = v - z / time_constant",
    parameters: &[
        Parameter::new("stiffness", Dimension::new(1, -1, 0), Range::NonNegative),
        Parameter::new("time_constant", Dimension::TIME, Range::Positive),
    ],
    depends_on: &[Variable::Velocity],
    acts: Acts::Coordinates,
    law: Law::Force(&Viscoelastic),
    priors,
    shapes,
    nature: Nature {
        // Of what relaxes in no time that there is, a spring.
        biased: Some(Biased { effect: &linear_stiffness::EFFECT, numbers: |p| (vec![p[0]], 0.0) }),
        ..Nature::PLAIN
    },
};

#[derive(Debug)]
struct Viscoelastic;

impl ForceLaw for Viscoelastic {
    #[inline(always)]
    fn basis<T: Number>(&self, _shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [-at.memory[0]]
    }

    fn memory(&self) -> usize {
        1
    }

    fn memory_rate<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [at.v() - at.memory[0] / shape[0]]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    let time = 1.0 / scales.rate();
    let time_constant = Prior::order(time, 2.5, (0.1 * time, 8.0 * time));
    vec![Prior::magnitude(scales.force / scales.half_range()), time_constant]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let time = scales.half_range() / scales.v;
    [0.25, 0.6, 1.2, 2.5, 5.0].map(|share| vec![share * time]).to_vec()
}
