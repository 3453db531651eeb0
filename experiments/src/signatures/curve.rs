//! A law without memory against one of its variables, at three values of the other.

use lacuna_charts::{Colour, Line, Style};
use lacuna_effects::Variable;

use super::force::Force;
use super::{Drawn, typical};

/// Points of a curve.
const POINTS: usize = 801;
/// Variables in the order in which a law is known by them.
const KNOWN_BY: [Variable; 7] = [
    Variable::OtherVelocity,
    Variable::OtherCoordinate,
    Variable::Velocity,
    Variable::Acceleration,
    Variable::Coordinate,
    Variable::OtherInput,
    Variable::Time,
];

/// Shares of a variable's range, from its middle, at which it is held: three that differ in size as well.
const HELD: [(f64, Colour); 3] =
    [(-1.0 / 3.0, Colour::Green), (0.0, Colour::Purple), (2.0 / 3.0, Colour::Blue)];

/// The force over the variable that it is known by; where it depends on one more, for three values of
/// that. The simplest law of its family is dashed.
#[must_use]
pub fn drawn(force: &Force) -> Drawn {
    let internal = typical::parameters(force.effect, &force.rig.scales);
    let variables = force.effect.variables(&typical::physical(force.effect, &internal));
    let mut ordered = KNOWN_BY.into_iter().filter(|v| variables.contains(v));
    // What depends on nothing lasts.
    let x = ordered.next().unwrap_or(Variable::Time);
    let mut lines = match ordered.next() {
        None => vec![Line::new("", Colour::Blue, Style::Solid, over(force, x, None))],
        Some(held) => at_three(force, x, held),
    };
    if x == Variable::Time {
        let (begin, end) = force.rig.range(x);
        lines.push(Line::new("", Colour::Ink, Style::Thin, vec![(begin, 0.0), (end, 0.0)]));
    }
    if let Some(simplest) = force.simplest() {
        let points = over(&simplest, x, None);
        let label = simplest.effect.class;
        lines.push(Line::new(label, Colour::Vermilion, Style::Dashed, points));
    }
    (force.rig.axis(x), force.rig.force_axis(), lines)
}

/// Curves for three values of a variable.
fn at_three(force: &Force, x: Variable, held: Variable) -> Vec<Line> {
    let (low, high) = force.rig.range(held);
    let unit = force.rig.axis(held).unit;
    let line = |(k, (share, colour)): (usize, (f64, Colour))| {
        let value = match held {
            // Of an input its size counts, and time begins.
            Variable::OtherInput | Variable::Time => 0.5 * k as f64 * high,
            _ => 0.5 * (low + high) + 0.5 * share * (high - low),
        };
        let unit = if k + 1 == HELD.len() { &*unit } else { "" };
        let label = format!("{} = {} {unit}", symbol(held), said(value));
        Line::new(label.trim_end(), colour, Style::Solid, over(force, x, Some((held, value))))
    };
    HELD.into_iter().enumerate().map(line).collect()
}

/// A variable as formulas of the catalogue have it.
fn symbol(variable: Variable) -> &'static str {
    match variable {
        Variable::Coordinate => "q",
        Variable::Velocity => "v",
        Variable::Acceleration => "a",
        Variable::OtherCoordinate => "q_j",
        Variable::OtherVelocity => "v_j",
        Variable::Time => "t",
        Variable::Input | Variable::OtherInput => "u",
    }
}

/// A value with two digits.
fn said(value: f64) -> String {
    let rounded: f64 = format!("{value:.1e}").parse().unwrap_or(value);
    rounded.to_string().replace('-', "\u{2212}")
}

fn over(force: &Force, x: Variable, held: Option<(Variable, f64)>) -> Vec<(f64, f64)> {
    let (low, high) = force.rig.range(x);
    let rest = force.rig.rest();
    let rest = held.map_or(rest, |(held, value)| rest.with(held, value));
    let share = |k: usize| k as f64 / (POINTS - 1) as f64;
    let at = |k: usize| low + share(k) * (high - low);
    (0..POINTS).map(|k| (at(k), force.at(rest.with(x, at(k))))).collect()
}
