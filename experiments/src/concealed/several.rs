//! Effects of the catalogue that depend on several variables, or on what the plain classes do not know.

use lacuna_effects::Effect;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

use super::effects::{Numbers, sign, uniform};
use super::scales::ChannelScale;

/// Their classes.
const SEVERAL: [&str; 8] = [
    "position_damping",
    "position_friction",
    "time_friction",
    "coupling_friction",
    "transmission_backlash",
    "quadratic_stiffness",
    "added_inertia",
    "lugre_friction",
];

/// Those of the catalogue.
pub fn several() -> impl Iterator<Item = &'static Effect> {
    SEVERAL.iter().filter_map(|class| lacuna_effects::find(class))
}

/// Simpler classes of a coordinate that hold most of what an effect does: nearest names.
pub fn nearest(class: &str) -> &'static [&'static str] {
    match class {
        "position_damping" => &["viscous_friction", "quadratic_drag"],
        "position_friction" | "time_friction" => &["coulomb_friction", "stribeck_friction"],
        "lugre_friction" => &["stribeck_friction", "coulomb_friction", "hysteresis"],
        "transmission_backlash" => &["coupling_stiffness"],
        _ => &[],
    }
}

/// Numbers of one of this strength on a channel; `other` is the other coordinate of a coupling.
pub fn draw(
    class: &str,
    c: ChannelScale,
    other: Option<ChannelScale>,
    duration: f64,
    (strength, smoothing): (f64, (&'static str, f64)),
    rng: &mut ChaCha8Rng,
) -> Numbers {
    let (half, v) = (c.half_range(), c.velocity);
    let far = half.max(c.centre().abs());
    match class {
        "position_damping" => BTreeMap::from([("coefficient", 2.0 * strength / (v * far * far))]),
        "position_friction" => BTreeMap::from([
            ("magnitude", strength),
            ("slope", sign(rng) * uniform(rng, 0.4, 0.8) * strength / far),
            smoothing,
        ]),
        "time_friction" => {
            let (cold, warm) = (strength, uniform(rng, 0.2, 0.5) * strength);
            BTreeMap::from([
                ("initial", cold),
                ("final", warm),
                ("time_constant", uniform(rng, 0.15, 0.6) * duration),
                smoothing,
            ])
        }
        "coupling_friction" => {
            let speed = v.max(other.map_or(0.0, |o| o.velocity));
            let smoothing = ("smoothing_velocity", uniform(rng, 0.005, 0.02) * speed);
            BTreeMap::from([
                ("magnitude", strength.min(other.map_or(strength, |o| 0.4 * o.force))),
                smoothing,
            ])
        }
        "transmission_backlash" => {
            let gap = uniform(rng, 0.1, 0.5) * half;
            BTreeMap::from([("stiffness", 2.0 * strength / gap), ("gap", gap)])
        }
        "quadratic_stiffness" => {
            BTreeMap::from([("stiffness", sign(rng) * 2.0 * strength / (far * far))])
        }
        "added_inertia" => BTreeMap::from([("inertia", uniform(rng, 0.1, 0.4) * c.mass)]),
        _ => BTreeMap::from([
            ("coulomb", strength),
            ("static_ratio", uniform(rng, 1.2, 1.8)),
            ("stribeck_velocity", uniform(rng, 0.1, 0.3) * v),
            ("travel", uniform(rng, 0.003, 0.02) * half),
        ]),
    }
}
