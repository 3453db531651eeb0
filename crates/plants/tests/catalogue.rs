//! Every effect of the catalogue in a model file: it is read, simulated, and makes a difference.

mod support;

use lacuna_effects::{Acts, CATALOGUE, Law};
use lacuna_plants::integrate::rk4_sampled;
use lacuna_plants::model::{Augmentation, NewEffect};
use lacuna_plants::{Model, Plant, System};
use support::read;

/// Two joints, a drive of each kind, and two tanks.
const MODEL: &str = r#"
name = "bench"
[[input]]
name = "tau"
unit = "N m"
[[input]]
name = "pump"
unit = "V"
[[coordinate]]
name = "q1"
velocity = "dq1"
unit = "rad"
[[coordinate]]
name = "q2"
velocity = "dq2"
unit = "rad"
[mechanics]
mass  = [["1.2", "0.2*cos(q2)"], ["0.2*cos(q2)", "0.5"]]
force = ["tau - 0.4*dq1 - 3*q1", "-0.3*dq2 - 2*q2 - 0.5*tau"]
[[state]]
name = "h1"
unit = "m"
derivative = "0.5*pump - 0.3*sqrt(max(h1, 0))"
[[state]]
name = "h2"
unit = "m"
derivative = "0.3*sqrt(max(h1, 0)) - 0.25*h2"
"#;

const CURVE: &str = "from = -1.0\nto = 1.0\nforce = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, \
    0.8, 0.9, 1.0, 1.1, 1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.0, -0.1]";

/// Class, what is put in its entry, and on which of its channels it is tried.
const EFFECTS: &[(&str, &str, &[&str])] = &[
    ("viscous_friction", "coefficient = 0.5", &["q1", "q2"]),
    ("coulomb_friction", "magnitude = 0.2", &["q1", "q2", "h1"]),
    ("coulomb_friction", "magnitude = 0.2\nsmoothing_velocity = 1e-12", &["q1", "h1"]),
    ("stribeck_friction", "coulomb = 0.2\nstatic = 0.4\nstribeck_velocity = 0.1", &["q1"]),
    ("stribeck_friction", "coulomb = 0.2\nstatic = 0.4\nstribeck_velocity = 1e-12", &["q2"]),
    ("asymmetric_friction", "positive = 0.2\nnegative = 0.1", &["q1", "h1"]),
    ("position_friction", "magnitude = 0.2\nslope = 0.3", &["q1"]),
    ("time_friction", "initial = 0.4\nfinal = 0.1\ntime_constant = 2", &["q1"]),
    (
        "lugre_friction",
        "coulomb = 0.2\nstatic_ratio = 1.5\nstribeck_velocity = 0.1\ntravel = 0.02",
        &["q1"],
    ),
    ("load_friction", "other = \"tau\"\nmagnitude = 0.2\nshare = 0.3", &["q1", "q2"]),
    ("input_damping", "other = \"pump\"\ncoefficient = 0.5", &["q1", "q2"]),
    ("maxwell_slip", "coulomb = 0.2\ntravel = 0.02", &["q1"]),
    ("quadratic_drag", "coefficient = 0.5", &["q1"]),
    ("position_damping", "coefficient = 5", &["q1", "q2"]),
    ("constant_force", "force = 0.3", &["q2", "h1"]),
    ("linear_stiffness", "stiffness = 2.0", &["q1"]),
    ("quadratic_stiffness", "stiffness = 2.0", &["q1"]),
    ("cubic_stiffness", "stiffness = 2.0", &["q1"]),
    ("saturating_stiffness", "stiffness = 2.0\nreach = 0.2", &["q1"]),
    ("added_inertia", "inertia = 0.2", &["q1", "q2"]),
    ("end_stop", "stiffness = 100\nposition = 0.1", &["q1"]),
    ("end_stop", "stiffness = 100\nposition = 0.05\nside = -1", &["q1"]),
    ("damped_stop", "stiffness = 100\ndissipation = 2\nposition = 0.1", &["q1"]),
    ("gravity_torque", "magnitude = 2.0", &["q1"]),
    ("cogging", "amplitude = 0.3\nwavenumber = 12", &["q1"]),
    ("coupling_stiffness", "other = \"q2\"\nstiffness = 2.0", &["q1"]),
    ("coupling_stiffness", "other = \"h2\"\nstiffness = 0.2", &["h1"]),
    ("coupling_friction", "other = \"q2\"\nmagnitude = 0.2", &["q1"]),
    ("transmission_backlash", "other = \"q2\"\nstiffness = 2.0\ngap = 0.1", &["q1"]),
    ("coriolis_coupling", "other = \"q2\"\ncoefficient = 2.0", &["q1"]),
    ("cross_damping", "other = \"q2\"\ncoefficient = 2.0", &["q1"]),
    ("hysteresis", "stiffness = 3.0\nbeta = 5\ngamma = 4", &["q1"]),
    ("hysteresis", "stiffness = 3.0\nbeta = 1\ngamma = -1.4", &["q1"]),
    ("backlash", "stiffness = 2.0\ngap = 0.1", &["q1"]),
    ("backlash", "stiffness = 2.0\ngap = 1e-12", &["q1"]),
    ("viscoelastic", "stiffness = 2.0\ntime_constant = 0.3", &["q1"]),
    ("hidden_resonance", "mass = 0.2\nfrequency = 9\ndamping_ratio = 0.05", &["q1"]),
    ("elastic_drive", "mass = 0.02\nfrequency = 9\ndamping_ratio = 0.05", &["q1"]),
    ("periodic_disturbance", "amplitude = 0.3\nangular_frequency = 4", &["q1", "h2"]),
    ("step_change", "force = 0.3\ntime = 2.5", &["q1", "h2"]),
    ("linear_loss", "rate = 0.1", &["h1", "h2"]),
    ("quadratic_loss", "coefficient = 0.1", &["h1"]),
    ("overflow", "rate = 5.0\nposition = 0.6", &["h1"]),
    ("spill", "other = \"h2\"\nrate = 5.0\nposition = 0.6\nshare = 0.7", &["h1"]),
    ("unknown_function", "over = \"q1\"", &["q1"]),
    ("unknown_function", "over = \"dq2\"", &["q2"]),
    ("unknown_function", "over = \"h2\"", &["h2"]),
    ("unknown_function", "over = \"t\"", &["q1", "h1"]),
    ("gain_error", "gain = 0.8", &["tau", "pump"]),
    ("dead_zone", "half_width = 0.2", &["tau", "pump"]),
    ("saturation", "limit = 0.5", &["tau", "pump"]),
    ("input_delay", "delay = 0.15", &["tau", "pump"]),
    ("input_delay", "delay = 1e6", &["tau"]),
    ("actuator_lag", "time_constant = 0.2", &["tau", "pump"]),
    ("actuator_lag", "time_constant = 1e9", &["tau"]),
    ("sensor_scale", "scale = 1.1", &["q1", "dq2", "h1"]),
    ("sensor_bias", "bias = 0.05", &["q1", "dq2", "h1"]),
    ("sensor_dead_zone", "half_width = 0.05", &["q1", "dq1", "h1"]),
    ("sensor_delay", "delay = 0.1", &["q1", "dq2", "h1"]),
    ("sensor_delay", "delay = 1e6", &["q1"]),
];

/// Entries with which an effect does nothing.
const NEUTRAL: &[(&str, &str, &str)] = &[
    ("input_delay", "tau", "delay = 0"),
    ("sensor_delay", "q1", "delay = 0"),
    ("dead_zone", "tau", "half_width = 0"),
    ("saturation", "tau", "limit = 1e9"),
    ("gain_error", "tau", "gain = 1"),
    ("sensor_scale", "dq1", "scale = 1"),
    ("sensor_dead_zone", "q1", "half_width = 0"),
    ("overflow", "h1", "rate = 5\nposition = 1e6"),
    ("end_stop", "q1", "stiffness = 100\nposition = 1e6"),
    ("step_change", "q1", "force = 1\ntime = 1e6"),
    ("backlash", "q1", "stiffness = 2\ngap = 1e6"),
    ("added_inertia", "q1", "inertia = 0"),
    ("load_friction", "q1", "other = \"tau\"\nmagnitude = 0\nshare = 0"),
    ("transmission_backlash", "q1", "other = \"q2\"\nstiffness = 2\ngap = 0"),
    ("spill", "h1", "other = \"h2\"\nrate = 5\nposition = 1e6\nshare = 0.7"),
];

fn with(class: &str, channel: &str, entries: &str) -> Model {
    let entries = match class {
        "unknown_function" => format!("{entries}\n{CURVE}"),
        _ => entries.to_owned(),
    };
    let text =
        format!("{MODEL}\n[[effect]]\nclass = \"{class}\"\nchannel = \"{channel}\"\n{entries}\n");
    read(&text)
}

/// What the sensors show of every state, sampled unevenly, started at `start`.
fn seen(model: &Model, start: &[f64]) -> Vec<Vec<f64>> {
    let times: Vec<f64> =
        (0..800).map(|k| 0.01 * f64::from(k) + 0.004 * f64::from(k % 3)).collect();
    let commands: Vec<f64> =
        times.iter().flat_map(|t| [0.9 * (1.7 * t).sin(), 0.5 + 0.4 * (0.9 * t).cos()]).collect();
    let effective = model.effective_inputs(&times, &commands);
    let system = System::new(model);
    let states = rk4_sampled(&system, &system.at_rest(start), &times, &effective, model.hold, 4)
        .expect("finite");
    let series = |i| (0..times.len()).map(|k| states.state(k)[i]).collect();
    (0..model.machine_states()).map(|i| model.observed(i, &times, series(i))).collect()
}

/// Largest difference of two sets of series.
fn difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

const START: [f64; 6] = [0.3, -0.2, 0.0, 0.4, 0.5, 0.3];

#[test]
fn every_effect_is_read_simulated_and_makes_a_difference() {
    let without = seen(&read(MODEL), &START);
    for (class, entries, channels) in EFFECTS {
        for channel in *channels {
            let model = with(class, channel, entries);
            let found = seen(&model, &START);
            assert!(found.iter().flatten().all(|v| v.is_finite()), "{class} on {channel}");
            let moved = difference(&found, &without);
            assert!(moved > 1e-3, "{class} on {channel} ({entries}): moves by {moved}");
        }
    }
}

#[test]
fn the_table_has_every_effect_on_every_kind_of_channel_it_acts_on() {
    // What changes a robot's structure needs a robot: `structure.rs`.
    let of_robots = |e: &&&lacuna_effects::Effect| matches!(e.law, Law::Structure(_));
    for effect in CATALOGUE.iter().filter(|e| !of_robots(e)) {
        let rows = EFFECTS.iter().filter(|row| row.0 == effect.class);
        let channels: Vec<_> = rows.flat_map(|row| row.2).collect();
        let on = |prefix: &str| channels.iter().any(|c| c.starts_with(prefix));
        let wanted: &[&str] = match (effect.law, effect.acts) {
            (Law::Input(_), _) => &["tau", "pump"],
            (Law::Sensor(_), _) => &["q", "d", "h"],
            (Law::Force(_), Acts::Coordinates) => &["q"],
            (Law::Force(_), Acts::States) => &["h"],
            (Law::Force(_), _) => &["q", "h"],
            (Law::Structure(_), _) => &[],
        };
        assert!(wanted.iter().all(|prefix| on(prefix)), "{}: {channels:?}", effect.class);
    }
}

#[test]
fn neutral_parameters_change_nothing() {
    let without = seen(&read(MODEL), &START);
    for (class, channel, entries) in NEUTRAL {
        // The memory of a play that never closes stays where it began.
        let start = if *class == "backlash" { [0.0; 6] } else { START };
        let without =
            if *class == "backlash" { seen(&read(MODEL), &start) } else { without.clone() };
        let moved = difference(&seen(&with(class, channel, entries), &start), &without);
        assert!(moved < 1e-9, "{class} on {channel}: moves by {moved}");
    }
}

/// Far from the origin, and at standstill where laws divide by speeds.
#[test]
fn far_and_still_states_stay_finite() {
    for (class, entries, channels) in EFFECTS {
        for start in [[0.0; 6], [1e6, -1e6, 0.0, 0.0, 1e6, 1e6]] {
            let model = with(class, channels[0], entries);
            let system = System::new(&model);
            let state = system.at_rest(&start);
            let mut rate = vec![f64::NAN; state.len()];
            system.derivative(0.0, &state, &[0.0, 0.0], &mut rate);
            assert!(rate.iter().all(|r| r.is_finite()), "{class} at {start:?}: {rate:?}");
        }
    }
}

/// What a file says of an effect is what is written of it.
#[test]
fn every_effect_is_written_as_it_was_read() {
    for (class, entries, channels) in EFFECTS {
        let model = with(class, channels[0], entries);
        let effects = vec![NewEffect::of(&model, &model.effects[0])];
        let augmentation = Augmentation { parameters: vec![], effects };
        let text = read(MODEL).augmented_text(&augmentation).expect("can be written");
        let again = &read(&text).effects[0];
        let (one, other) = (&model.effects[0], again);
        assert_eq!((one.channel, one.other), (other.channel, other.other), "{class}");
        assert_eq!(one.parameters, other.parameters, "{class}: {text}");
    }
}

/// A law may name the inputs that drive its channel, and those that drive nothing.
#[test]
fn inputs_about_a_channel_drive_it_or_nothing() {
    let spare = "[[input]]\nname = \"current\"\nunit = \"A\"\n[[coordinate]]";
    let model = read(&MODEL.replacen("[[coordinate]]", spare, 1));
    let about = |name: &str| -> Vec<&str> {
        let channel = (0..model.channels()).find(|&c| model.channel_name(c) == name);
        let inputs = model.inputs_about(channel.expect("a channel")).into_iter();
        inputs.map(|j| model.inputs[j].name.as_str()).collect()
    };
    assert_eq!(about("q1"), ["tau", "current"]);
    assert_eq!(about("q2"), ["tau", "current"]);
    assert_eq!(about("h1"), ["pump", "current"]);
    assert_eq!(about("h2"), ["current"]);
}
