//! A memory that rings: what a torque makes of the joint, against its frequency.
//!
//! Along `q = sin(w t)` the law answers, once it has settled, with a force of the complex amplitude D:
//!
//! ```text
//! |q''/u| = w^2 / |-M w^2 - D(w)|,   1/M without the effect
//! ```

use lacuna_charts::{Axis, Colour, Line, Style};
use std::f64::consts::TAU;

use super::Drawn;
use super::force::Force;
use super::rig::Moment;

/// Frequencies, evenly in their logarithm, between these (rad/s).
const FREQUENCIES: usize = 161;
const BAND: (f64, f64) = (1.0, 30.0);
/// How long the law settles (s), and samples a second at least.
const SETTLING: f64 = 40.0;
const SAMPLES: f64 = 200.0;

/// Acceleration per torque with the effect, without it, and with the simplest law of its family.
#[must_use]
pub fn drawn(force: &Force) -> Drawn {
    let inertia = force.rig.scales.inertia;
    let without = [BAND.0, BAND.1].map(|w| (w, inertia.recip())).to_vec();
    let mut lines = vec![
        Line::new("without it", Colour::Ink, Style::Broad, without),
        Line::new("with it", Colour::Blue, Style::Solid, response(force, inertia)),
    ];
    if let Some(simplest) = force.simplest() {
        let points = response(&simplest, inertia);
        lines.push(Line::new(simplest.effect.class, Colour::Vermilion, Style::Dashed, points));
    }
    let [_, unit, torque] = force.rig.channel;
    let gain = format!("{unit}/s\u{b2} per {torque}");
    (Axis::log("frequency", "rad/s"), Axis::log("acceleration per torque", &gain), lines)
}

fn response(force: &Force, inertia: f64) -> Vec<(f64, f64)> {
    let (low, high) = BAND;
    let w = |k: usize| low * (high / low).powf(k as f64 / (FREQUENCIES - 1) as f64);
    let gain = |w: f64| {
        let [real, imaginary] = amplitude(force, w);
        w * w / (-inertia * w * w - real).hypot(imaginary)
    };
    (0..FREQUENCIES).map(|k| (w(k), gain(w(k)))).collect()
}

/// Real and imaginary part of D: the force in phase with `sin(w t)`, and a quarter of a cycle ahead.
fn amplitude(force: &Force, w: f64) -> [f64; 2] {
    let period = TAU / w;
    let samples = (SAMPLES * period).ceil().max(64.0) as usize;
    let cycles = (SETTLING / period).ceil() as usize;
    let moment = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / samples as f64).sin_cos();
        let t = period * k as f64 / samples as f64;
        Moment { t, q: sin, v: w * cos, acceleration: -w * w * sin, ..force.rig.rest() }
    };
    let motion: Vec<Moment> = (0..(cycles + 1) * samples).map(moment).collect();
    let forces = force.along(&motion);
    let last = motion.iter().zip(&forces).skip(cycles * samples);
    last.fold([0.0; 2], |[real, imaginary], (m, r)| {
        let share = 2.0 * r / samples as f64;
        [real + share * m.q, imaginary + share * m.v / w]
    })
}
