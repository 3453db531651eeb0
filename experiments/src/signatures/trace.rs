//! A law along a motion to and fro, against the coordinate: loops of what remembers, and edges.

use lacuna_charts::{Colour, Line, Style};
use lacuna_effects::Variable;

use super::Drawn;
use super::force::Force;

/// Samples of a cycle, and cycles after which memory has settled.
const SAMPLES: usize = 1600;
const SETTLED: usize = 4;
/// Stroke and speed of a motion, as shares of the usual ones.
const USUAL: (f64, f64) = (1.0, 1.0);
const SLOW: (f64, f64) = (1.0, 0.2);
const SMALL: (f64, f64) = (0.25, 1.0);

/// The force of the last of some cycles. What remembers is shown slow and over a small stroke as well.
#[must_use]
pub fn drawn(force: &Force) -> Drawn {
    let mut lines = vec![];
    if force.remembers() {
        lines.push(line(force, "usual", (Colour::Blue, Style::Solid), USUAL));
        lines.push(line(force, "slow", (Colour::Green, Style::Dashed), SLOW));
        lines.push(line(force, "small", (Colour::Purple, Style::Solid), SMALL));
    } else {
        lines.push(line(force, on(force, "it"), (Colour::Blue, Style::Solid), USUAL));
    }
    if let Some(share) = force.passed_on().filter(|_| !force.effect.is_mutual()) {
        let points = cycle(force, USUAL).into_iter().map(|(q, r)| (q, -share * r)).collect();
        let label = on(force, "the other");
        lines.push(Line::new(label, Colour::Green, Style::Solid, points));
    }
    if let Some(simplest) = force.simplest() {
        let label = simplest.effect.class;
        lines.push(line(&simplest, label, (Colour::Vermilion, Style::Dashed), USUAL));
    }
    (force.rig.axis(Variable::Coordinate), force.rig.force_axis(), lines)
}

/// On what a force acts; nothing where there is but one thing.
fn on<'a>(force: &Force, what: &'a str) -> &'a str {
    let both = force.passed_on().is_some() && !force.effect.is_mutual();
    if both { what } else { "" }
}

fn line(force: &Force, label: &str, look: (Colour, Style), shares: (f64, f64)) -> Line {
    Line::new(label, look.0, look.1, cycle(force, shares))
}

/// Coordinate and force over the last cycle.
fn cycle(force: &Force, shares: (f64, f64)) -> Vec<(f64, f64)> {
    let motion = force.rig.cycles(shares, SETTLED, SAMPLES);
    let forces = force.along(&motion);
    let last = motion.len().saturating_sub(SAMPLES + 1);
    motion.iter().map(|m| m.q).zip(forces).skip(last).collect()
}
