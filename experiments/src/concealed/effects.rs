//! Effects of the catalogue with magnitudes drawn.
//!
//! The strength of a force effect is a share of the standard deviation of the generalised force
//! that the channel feels without it; shapes are shares of the range and speed of its motion. The
//! shares are drawn; none of them is known to the tool.

use lacuna_effects::{Effect, Law};
use lacuna_plants::Model;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

use super::machine::is_mass;
use super::scales::{ChannelScale, Scales};
use super::several::{self, several};

/// Named numbers of an effect.
pub type Numbers = BTreeMap<&'static str, f64>;

/// Uniform between two limits.
pub fn uniform(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.random_range(0.0..1.0)
}

/// Uniform in the logarithm.
pub fn log_uniform(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    uniform(rng, low.ln(), high.ln()).exp()
}

/// A fair sign.
pub fn sign(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random_range(0.0..1.0) < 0.5 { -1.0 } else { 1.0 }
}

/// Draw the numbers of an effect at a place; `other` is the other coordinate of a coupling.
pub fn draw(
    effect: &Effect,
    model: &Model,
    scales: &Scales,
    place: usize,
    other: Option<usize>,
    rng: &mut ChaCha8Rng,
) -> Numbers {
    match effect.law {
        Law::Force(_) => {
            let other = other.map(|o| scales.channels[o]);
            force(effect.class, scales.channels[place], other, scales.time, rng)
        }
        Law::Input(_) => input(effect.class, scales.inputs[place], scales.time[0], rng),
        Law::Sensor(_) => {
            let n = model.coordinates.len();
            let channel = if place < n { place } else { place - n };
            sensor(effect.class, scales.channels[channel], scales.time[0], rng)
        }
        Law::Structure(_) => structure(effect.class, model, rng),
    }
}

/// What a robot's file leaves out of its structure.
fn structure(class: &str, model: &Model, rng: &mut ChaCha8Rng) -> Numbers {
    let tilt = |rng: &mut ChaCha8Rng| sign(rng) * uniform(rng, 0.03, 0.12);
    if class == "base_tilt" {
        return Numbers::from([("roll", tilt(rng)), ("pitch", tilt(rng))]);
    }
    // That of the last link.
    let last = model.parameters.iter().rfind(|p| is_mass(p)).map_or(1.0, |p| p.value);
    let mut aside = |reach: f64| uniform(rng, -reach, reach);
    Numbers::from([
        ("com_x", aside(0.05)),
        ("com_y", aside(0.05)),
        ("com_z", aside(0.05) + 0.15),
        ("gyration_radius", 0.03 + aside(0.02)),
        ("mass", last * (0.35 + aside(0.2))),
    ])
}

fn input(class: &str, [sd, greatest]: [f64; 2], step: f64, rng: &mut ChaCha8Rng) -> Numbers {
    let mut of = |name, low: f64, high: f64, unit: f64| (name, unit * uniform(rng, low, high));
    Numbers::from([match class {
        "gain_error" => {
            let (name, error) = of("gain", 0.12, 0.3, 1.0);
            (name, 1.0 + sign(rng) * error)
        }
        "dead_zone" => of("half_width", 0.2, 0.5, sd),
        "saturation" => of("limit", 0.45, 0.7, greatest),
        "input_delay" => of("delay", 2.0, 8.0, step),
        _ => of("time_constant", 3.0, 12.0, step),
    }])
}

fn sensor(class: &str, scale: ChannelScale, step: f64, rng: &mut ChaCha8Rng) -> Numbers {
    let number = match class {
        "sensor_scale" => ("scale", 1.0 + sign(rng) * uniform(rng, 0.06, 0.15)),
        "sensor_bias" => ("bias", sign(rng) * uniform(rng, 0.1, 0.3) * scale.half_range()),
        _ => ("delay", uniform(rng, 2.0, 6.0) * step),
    };
    Numbers::from([number])
}

/// Numbers of a force effect on a channel.
fn force(
    class: &str,
    c: ChannelScale,
    other: Option<ChannelScale>,
    [_, duration]: [f64; 2],
    rng: &mut ChaCha8Rng,
) -> Numbers {
    let strength = log_uniform(rng, 0.1, 0.4) * c.force;
    let (half, v) = (c.half_range(), c.velocity);
    let smoothing = ("smoothing_velocity", uniform(rng, 0.005, 0.02) * v);
    if several().any(|e| e.class == class) {
        return several::draw(class, c, other, duration, (strength, smoothing), rng);
    }
    // Angular frequency of the motion.
    let w = c.rate / half;
    match class {
        "viscous_friction" => Numbers::from([("coefficient", strength / v)]),
        "coulomb_friction" => Numbers::from([("magnitude", strength), smoothing]),
        "stribeck_friction" => Numbers::from([
            ("coulomb", strength),
            ("static", uniform(rng, 1.7, 2.6) * strength),
            ("stribeck_velocity", uniform(rng, 0.15, 0.5) * v),
            smoothing,
        ]),
        "asymmetric_friction" => {
            let weak = uniform(rng, 0.25, 0.55) * strength;
            let (a, b) = if sign(rng) > 0.0 { (strength, weak) } else { (weak, strength) };
            Numbers::from([("positive", a), ("negative", b), smoothing])
        }
        "quadratic_drag" => Numbers::from([("coefficient", 0.7 * strength / (v * v))]),
        "constant_force" => Numbers::from([("force", sign(rng) * strength)]),
        "linear_stiffness" => Numbers::from([("stiffness", 2.0 * strength / half)]),
        "cubic_stiffness" => Numbers::from([("stiffness", 4.0 * strength / half.powi(3))]),
        "end_stop" => end_stop(c, strength, rng),
        "gravity_torque" => Numbers::from([("magnitude", 2.0 * strength / half.min(1.5))]),
        "cogging" => Numbers::from([
            ("amplitude", 1.4 * strength),
            ("wavenumber", uniform(rng, 2.0, 7.0) * std::f64::consts::PI / half),
            ("phase", uniform(rng, 0.0, std::f64::consts::TAU)),
        ]),
        "coupling_stiffness" => {
            let reach = half.max(other.map_or(0.0, |o| o.half_range()));
            Numbers::from([("stiffness", 2.0 * strength / reach)])
        }
        "coriolis_coupling" => {
            let speed = other.map_or(v, |o| o.velocity);
            Numbers::from([("coefficient", sign(rng) * strength / (v * speed))])
        }
        "hysteresis" => {
            let travel = uniform(rng, 0.1, 0.4) * half;
            let shape = 0.5 / travel;
            Numbers::from([
                ("stiffness", 1.2 * strength / travel),
                ("beta", shape),
                ("gamma", shape),
            ])
        }
        "viscoelastic" => Numbers::from([
            ("stiffness", 2.0 * strength / half),
            ("time_constant", uniform(rng, 0.5, 2.0) / w),
        ]),
        "hidden_resonance" => Numbers::from([
            ("mass", uniform(rng, 0.05, 0.25) * c.mass),
            ("frequency", uniform(rng, 1.3, 4.0) * w),
            ("damping_ratio", uniform(rng, 0.02, 0.1)),
        ]),
        "periodic_disturbance" => Numbers::from([
            ("amplitude", 1.4 * strength),
            ("angular_frequency", uniform(rng, 1.2, 5.0) * w),
            ("phase", uniform(rng, 0.0, std::f64::consts::TAU)),
        ]),
        "step_change" => Numbers::from([
            ("force", 1.5 * sign(rng) * strength),
            ("time", uniform(rng, 0.3, 0.7) * duration),
        ]),
        "linear_loss" => Numbers::from([("rate", strength / v)]),
        _ => Numbers::from([("coefficient", 0.7 * strength / (v * c.range[1].abs().max(v)))]),
    }
}

/// A stop that the motion reaches, on one side.
fn end_stop(c: ChannelScale, strength: f64, rng: &mut ChaCha8Rng) -> Numbers {
    let side = sign(rng);
    let share = uniform(rng, 0.45, 0.75);
    Numbers::from([
        ("stiffness", uniform(rng, 2.5, 6.0) * strength / ((1.0 - share) * c.half_range())),
        ("position", c.centre() + side * share * c.half_range()),
        ("side", side),
    ])
}

/// The numbers in the catalogue's order, its own default where none was drawn.
pub fn in_order(effect: &Effect, numbers: &Numbers) -> Vec<f64> {
    let number = |p: &lacuna_effects::Parameter| {
        numbers.get(p.name).copied().or(p.default).unwrap_or(f64::NAN)
    };
    effect.parameters.iter().map(number).collect()
}
