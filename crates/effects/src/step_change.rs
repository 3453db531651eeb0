//! A force that begins at a time: `force for t >= time`.

use crate::{
    Acts, At, Dimension, Effect, ForceLaw, Law, Nature, Number, Parameter, Prior, Range, Scales,
    Variable,
};

pub(crate) static EFFECT: Effect = Effect {
    class: "step_change",
    words: "a force that begins at a time",
    formula: "force for t >= time",
    parameters: &[
        Parameter::new("force", Dimension::FORCE, Range::Any),
        Parameter::new("time", Dimension::TIME, Range::Any),
    ],
    depends_on: &[Variable::Time],
    acts: Acts::CoordinatesAndStates,
    law: Law::Force(&StepChange),
    priors,
    shapes,
    nature: Nature { onset: Some("time"), ..Nature::PLAIN },
};

#[derive(Debug)]
struct StepChange;

impl ForceLaw for StepChange {
    #[inline(always)]
    fn basis<T: Number>(&self, shape: &[T], at: &At<T>) -> impl AsRef<[T]> {
        [begun(at.t, shape[0], at.sample)]
    }
}

fn priors(scales: &Scales) -> Vec<Prior> {
    let (begin, length) = (scales.time.0, scales.duration());
    let time = Prior::near(
        begin + 0.5 * length,
        0.25 * length,
        (begin + 0.03 * length, begin + 0.97 * length),
    );
    vec![Prior::amplitude(scales.force), time]
}

fn shapes(scales: &Scales) -> Vec<Vec<f64>> {
    let begin = scales.time.0;
    (3..48).map(|k| vec![begin + 0.02 * f64::from(k) * scales.duration()]).collect()
}

/// 1 from `onset` on. Its derivative by the onset is that of a ramp over the sample that follows
/// it: samples tell no more of when it began.
#[inline(always)]
fn begun<T: Number>(t: f64, onset: T, sample: f64) -> T {
    let since = t - onset.value();
    let slope = if (0.0..sample).contains(&since) { -1.0 / sample } else { 0.0 };
    onset.mapped(if since >= 0.0 { 1.0 } else { 0.0 }, slope)
}
