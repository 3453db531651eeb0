//! What an actuator makes of a command, or a sensor of what it measures: against it, or, where time
//! matters, both in time.

use lacuna_charts::{Axis, Colour, Line, Style};
use lacuna_effects::{AnySeriesLaw, Effect, Law, Variable};

use super::rig::Rig;
use super::{Drawn, typical};

/// Samples of a series, and the time between two (s).
const SAMPLES: usize = 401;
const STEP: f64 = 0.01;
/// A command that is held: shares of the largest, and when each begins (s).
const HELD: [(f64, f64); 4] = [(0.0, 0.0), (0.5, 0.6), (2.0, -0.4), (3.2, 0.2)];

/// The picture of such a law; what the ideal one does is dashed.
#[must_use]
pub fn drawn(effect: &Effect, law: &'static dyn AnySeriesLaw) -> Drawn {
    let rig = Rig::joint();
    let parameters = typical::parameters(effect, &rig.scales);
    let is_input = matches!(effect.law, Law::Input(_));
    let variable = if is_input { Variable::Input } else { Variable::Coordinate };
    let (x, y) = if is_input { ("command", "effective") } else { ("true", "measured") };
    let applied = |step: f64, series: &[f64]| -> Vec<f64> {
        let times: Vec<f64> = (0..SAMPLES).map(|k| step * k as f64).collect();
        law.plain().applied(&parameters, &times, series)
    };
    let signal = signal(&rig, is_input);
    let made = applied(STEP, &signal);
    if made == applied(2.0 * STEP, &signal) {
        let range = rig.range(variable);
        let ramp: Vec<f64> = (0..SAMPLES)
            .map(|k| range.0 + (range.1 - range.0) * k as f64 / (SAMPLES - 1) as f64)
            .collect();
        let of = |values: &[f64]| ramp.iter().copied().zip(values.iter().copied()).collect();
        let lines = pair(("ideal", of(&ramp)), ("with it", of(&applied(STEP, &ramp))));
        return (
            Axis::linear(x, unit(&rig, variable)),
            Axis::linear(y, unit(&rig, variable)),
            lines,
        );
    }
    let of = |values: &[f64]| {
        values.iter().enumerate().map(|(k, v)| (STEP * k as f64, *v)).collect::<Vec<_>>()
    };
    let lines = pair((x, of(&signal)), (y, of(&made)));
    let what = if is_input { "input" } else { rig.channel[0] };
    (rig.axis(Variable::Time), Axis::linear(what, unit(&rig, variable)), lines)
}

fn pair(ideal: (&str, Vec<(f64, f64)>), made: (&str, Vec<(f64, f64)>)) -> Vec<Line> {
    vec![
        Line::new(ideal.0, Colour::Ink, Style::Dashed, ideal.1),
        Line::new(made.0, Colour::Blue, Style::Solid, made.1),
    ]
}

fn unit(rig: &Rig, variable: Variable) -> &str {
    if variable == Variable::Input { "V" } else { rig.channel[1] }
}

/// A command in steps, or the motion of the joint.
fn signal(rig: &Rig, is_input: bool) -> Vec<f64> {
    let time = |k: usize| STEP * k as f64;
    if is_input {
        let held = |t: f64| HELD.iter().rev().find(|(begin, _)| *begin <= t).map_or(0.0, |h| h.1);
        return (0..SAMPLES).map(|k| rig.scales.input.1 * held(time(k))).collect();
    }
    let turned = |k: usize| time(k) * rig.scales.rate() / std::f64::consts::FRAC_1_SQRT_2;
    (0..SAMPLES).map(|k| rig.scales.half_range() * turned(k).sin()).collect()
}
