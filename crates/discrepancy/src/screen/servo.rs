//! What acts within a position servo, as a small force on the coordinate that it drives: by how much its force along a
//! motion is another with the effect than without.

use crate::candidates::{Candidate, Term};
use crate::trajectories::SmoothedRecording;
use lacuna_plants::model::{ModelEffect, Servos};
use lacuna_plants::{Hold, Model};

/// The change of one coordinate's force along a motion.
pub(crate) struct Change {
    pub coordinate: usize,
    /// From each sample to the next, under the command that is held there.
    pub between: Vec<f64>,
    /// At each sample; where the command jumps, the mean of before and after.
    pub at: Vec<f64>,
    /// The force itself, at each sample.
    pub force: Vec<f64>,
}

/// What a term changes, given the model's parameters and what acts already; none where it acts within no servo.
pub(crate) fn change(
    model: &Model,
    (parameters, effects): (&[f64], &[ModelEffect]),
    term: &Term,
    motion: &SmoothedRecording,
) -> Option<Change> {
    let Candidate { effect, channel, .. } = term.candidate;
    model.in_servo(effect, channel)?;
    let (servo, own) = model.servo_of(channel)?;
    let without = model.servos(parameters, effects);
    let with = model.servos(parameters, &[effects, &[term.as_effect()]].concat());
    Some(Change::of((&without, &with), (servo, own.coordinate), (model, motion)))
}

impl Change {
    fn of(
        (without, with): (&Servos, &Servos),
        (servo, coordinate): (usize, usize),
        (model, motion): (&Model, &SmoothedRecording),
    ) -> Self {
        let m = model.input_width();
        let inputs = |k: usize| &motion.inputs[k * m..(k + 1) * m];
        let change = |k: usize, u: usize| {
            let (state, u) = (motion.state(k), inputs(u));
            with.force(servo, state, u) - without.force(servo, state, u)
        };
        let last = motion.len().saturating_sub(1);
        let held = model.hold == Hold::ZeroOrder;
        let between = |k: usize| {
            let next = (k + 1).min(last);
            0.5 * (change(k, k) + change(next, if held { k } else { next }))
        };
        let at = |k: usize| match held && k > 0 {
            true => 0.5 * (change(k, k - 1) + change(k, k)),
            false => change(k, k),
        };
        let force = |k: usize| without.force(servo, motion.state(k), inputs(k));
        let all = 0..motion.len();
        Self {
            coordinate,
            between: all.clone().map(between).collect(),
            at: all.clone().map(at).collect(),
            force: all.map(force).collect(),
        }
    }
}
