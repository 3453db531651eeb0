//! The catalogue as a whole: names, completeness, units.

use lacuna_effects::{Acts, CATALOGUE, Dimension, Law, find};
use std::collections::BTreeSet;

/// The class names of the design, but for parameter_error, which is no law, and those that were
/// added to it.
const DESIGNED: [&str; 50] = [
    "viscous_friction",
    "coulomb_friction",
    "stribeck_friction",
    "asymmetric_friction",
    "position_friction",
    "time_friction",
    "load_friction",
    "quadratic_drag",
    "constant_force",
    "position_damping",
    "input_damping",
    "linear_stiffness",
    "quadratic_stiffness",
    "cubic_stiffness",
    "saturating_stiffness",
    "added_inertia",
    "payload",
    "base_tilt",
    "end_stop",
    "damped_stop",
    "gravity_torque",
    "cogging",
    "coupling_stiffness",
    "coupling_friction",
    "transmission_backlash",
    "coriolis_coupling",
    "cross_damping",
    "lugre_friction",
    "maxwell_slip",
    "hysteresis",
    "viscoelastic",
    "hidden_resonance",
    "elastic_drive",
    "backlash",
    "periodic_disturbance",
    "step_change",
    "gain_error",
    "dead_zone",
    "saturation",
    "input_delay",
    "actuator_lag",
    "sensor_scale",
    "sensor_bias",
    "sensor_dead_zone",
    "sensor_delay",
    "linear_loss",
    "quadratic_loss",
    "overflow",
    "spill",
    "unknown_function",
];

#[test]
fn every_designed_effect_is_there_once() {
    let classes: Vec<_> = CATALOGUE.iter().map(|e| e.class).collect();
    let unique: BTreeSet<_> = classes.iter().collect();
    assert_eq!(unique.len(), classes.len());
    for class in DESIGNED {
        assert_eq!(find(class).map(|e| e.class), Some(class));
    }
    assert!(find("Coulomb_friction").is_none() && find("").is_none());
}

#[test]
fn parameters_have_unique_names_and_laws_use_them_all() {
    for effect in CATALOGUE {
        let names: BTreeSet<_> = effect.parameters.iter().map(|p| p.name).collect();
        assert_eq!(names.len(), effect.parameters.len(), "{}", effect.class);
        for name in &names {
            let free = |c: char| !c.is_ascii_lowercase() && c != '_';
            assert!(!name.is_empty() && !name.contains(free), "{}: {name}", effect.class);
            // An end stop's side is told in words.
            assert!(effect.formula.contains(name), "{}: no {name} in its formula", effect.class);
        }
        for p in effect.parameters {
            assert!(p.default.is_none_or(|v| p.range.contains(v)), "{} {}", effect.class, p.name);
        }
        // `class`, `channel` and `other` are keys of a model file's [[effect]].
        for key in ["class", "channel", "other"] {
            assert!(!names.contains(key), "{}", effect.class);
        }
        if let Law::Force(law) = effect.law {
            assert!(law.amplitudes() > 0, "{}", effect.class);
        }
    }
}

/// Units of all parameters of an effect, given those of its channel.
fn units(class: &str, force: &str, coordinate: &str, input: &str) -> Vec<String> {
    let parameters = find(class).expect("in the catalogue").parameters;
    parameters.iter().map(|p| p.unit.text(force, coordinate, input)).collect()
}

#[test]
fn units_on_a_linear_and_a_rotary_coordinate() {
    let table: &[(&str, &[&str], &[&str])] = &[
        ("viscous_friction", &["N s/m"], &["N m s/rad"]),
        ("coulomb_friction", &["N", "m/s"], &["N m", "rad/s"]),
        ("stribeck_friction", &["N", "N", "m/s", "m/s"], &["N m", "N m", "rad/s", "rad/s"]),
        ("asymmetric_friction", &["N", "N", "m/s"], &["N m", "N m", "rad/s"]),
        ("position_friction", &["N", "N/m", "m/s"], &["N m", "N m/rad", "rad/s"]),
        ("time_friction", &["N", "N", "s", "m/s", "s"], &["N m", "N m", "s", "rad/s", "s"]),
        ("lugre_friction", &["N", "1", "m/s", "m"], &["N m", "1", "rad/s", "rad"]),
        ("maxwell_slip", &["N", "m"], &["N m", "rad"]),
        ("coupling_friction", &["N", "m/s", "1"], &["N m", "rad/s", "1"]),
        ("transmission_backlash", &["N/m", "m"], &["N m/rad", "rad"]),
        ("quadratic_drag", &["N s^2/m^2"], &["N m s^2/rad^2"]),
        ("position_damping", &["N s/m^3"], &["N m s/rad^3"]),
        ("constant_force", &["N"], &["N m"]),
        ("linear_stiffness", &["N/m"], &["N m/rad"]),
        ("quadratic_stiffness", &["N/m^2"], &["N m/rad^2"]),
        ("cubic_stiffness", &["N/m^3"], &["N m/rad^3"]),
        ("saturating_stiffness", &["N/m", "m"], &["N m/rad", "rad"]),
        ("added_inertia", &["N s^2/m"], &["N m s^2/rad"]),
        ("payload", &["kg", "m", "m", "m", "m"], &["kg", "m", "m", "m", "m"]),
        ("base_tilt", &["rad", "rad"], &["rad", "rad"]),
        ("end_stop", &["N/m", "m", "1"], &["N m/rad", "rad", "1"]),
        ("damped_stop", &["N/m", "s/m", "m", "1"], &["N m/rad", "s/rad", "rad", "1"]),
        ("gravity_torque", &["N"], &["N m"]),
        ("cogging", &["N", "1/m", "rad"], &["N m", "1/rad", "rad"]),
        ("coupling_stiffness", &["N/m"], &["N m/rad"]),
        ("coriolis_coupling", &["N s^2/m^2"], &["N m s^2/rad^2"]),
        ("cross_damping", &["N s/m"], &["N m s/rad"]),
        ("hysteresis", &["N/m", "1/m", "1/m"], &["N m/rad", "1/rad", "1/rad"]),
        ("backlash", &["N/m", "m"], &["N m/rad", "rad"]),
        ("viscoelastic", &["N/m", "s"], &["N m/rad", "s"]),
        ("hidden_resonance", &["N s^2/m", "rad/s", "1"], &["N m s^2/rad", "rad/s", "1"]),
        ("elastic_drive", &["N s^2/m", "rad/s", "1"], &["N m s^2/rad", "rad/s", "1"]),
        ("periodic_disturbance", &["N", "rad/s", "rad", "s"], &["N m", "rad/s", "rad", "s"]),
        ("step_change", &["N", "s"], &["N m", "s"]),
        ("unknown_function", &["N", "m", "m", "1"], &["N m", "rad", "rad", "1"]),
        ("sensor_scale", &["1"], &["1"]),
        ("sensor_bias", &["m"], &["rad"]),
        ("sensor_dead_zone", &["m"], &["rad"]),
        ("sensor_delay", &["s"], &["s"]),
    ];
    for (class, linear, rotary) in table {
        assert_eq!(units(class, "N", "m", ""), *linear, "{class}");
        assert_eq!(units(class, "N m", "rad", ""), *rotary, "{class}");
    }
    let covered: BTreeSet<_> = table.iter().map(|row| row.0).collect();
    for effect in CATALOGUE {
        let elsewhere = matches!(effect.law, Law::Input(_))
            || effect.acts == Acts::States
            || effect.names_input();
        assert!(elsewhere || covered.contains(effect.class), "{} is untested", effect.class);
    }
}

#[test]
fn units_on_an_input() {
    let table = [
        ("gain_error", &["1"][..]),
        ("dead_zone", &["V"]),
        ("saturation", &["V"]),
        ("input_delay", &["s"]),
        ("actuator_lag", &["s", "1"]),
    ];
    for (class, unit) in table {
        assert_eq!(units(class, "", "", "V"), unit, "{class}");
    }
}

/// A law that names an input has coefficients per unit of it.
#[test]
fn units_beside_an_input() {
    assert_eq!(units("load_friction", "N", "m", "A"), ["N", "N/A", "m/s"]);
    assert_eq!(units("load_friction", "N m", "rad", "N m"), ["N m", "1", "rad/s"]);
    assert_eq!(units("input_damping", "N", "m", "A"), ["N s/(m A)"]);
}

/// The generalised force of a first-order state is its rate.
#[test]
fn units_on_a_first_order_state() {
    assert_eq!(units("constant_force", "m/s", "m", ""), ["m/s"]);
    assert_eq!(units("periodic_disturbance", "m/s", "m", ""), ["m/s", "rad/s", "rad", "s"]);
    assert_eq!(units("linear_loss", "m/s", "m", ""), ["1/s"]);
    assert_eq!(units("quadratic_loss", "m/s", "m", ""), ["1/(m s)"]);
    assert_eq!(units("overflow", "m/s", "m", ""), ["1/s", "m"]);
    assert_eq!(units("spill", "m/s", "m", ""), ["1/s", "m", "1"]);
    assert_eq!(units("linear_loss", "degC/s", "degC", ""), ["1/s"]);
    // A speed as a first-order state: its rate is an acceleration.
    let rate = Dimension::VELOCITY.text("", "m/s", "");
    assert_eq!(rate, "m/s^2");
    assert_eq!(units("linear_loss", &rate, "m/s", ""), ["1/s"]);
    assert_eq!(units("quadratic_loss", &rate, "m/s", ""), ["1/m"]);
}
