//! Where effects of the catalogue make sense.

use lacuna_effects::{Acts, CATALOGUE, Effect, Law};
use lacuna_plants::Model;

use super::plants::PlantSpec;

/// Where an effect of the catalogue can act on a plant: channel, input or entry of the machine's
/// state, whichever its law has.
pub fn places(spec: &PlantSpec, model: &Model, effect: &Effect) -> Vec<usize> {
    if spec.without.contains(&effect.class) {
        return Vec::new();
    }
    let coordinates = 0..model.coordinates.len();
    if effect.couples() && model.coordinates.len() < 2 {
        return Vec::new();
    }
    let in_radians = |c: &usize| model.coordinates[*c].unit == "rad";
    let on_states = (0..model.states.len()).filter(|&s| {
        let name = model.states[s].name.as_str();
        spec.on_states
            .iter()
            .any(|(state, classes)| *state == name && classes.contains(&effect.class))
    });
    let on_states = on_states.map(|s| model.coordinates.len() + s);
    match (effect.law, effect.acts) {
        (Law::Input(_), _) => (0..model.inputs.len()).collect(),
        (Law::Sensor(_), _) => sensors(spec, model),
        // A payload hangs on the last link.
        (Law::Structure(_), _) => {
            let all = 0..model.structures(effect).len();
            let mut told = all.filter(|&k| model.tells_structure(effect.acts, k));
            told.next_back().into_iter().collect()
        }
        (_, Acts::States) => on_states.collect(),
        (_, Acts::CoordinatesAndStates | Acts::CoordinatesAndSpeeds) => {
            coordinates.chain(on_states).collect()
        }
        // The weight of an arm turns; a carriage on a level has none.
        _ if effect.class == "gravity_torque" => coordinates.filter(in_radians).collect(),
        _ => coordinates.collect(),
    }
}

/// Entries of the machine's state that a sensor can measure wrongly: positions and states.
fn sensors(spec: &PlantSpec, model: &Model) -> Vec<usize> {
    let n = model.coordinates.len();
    (0..model.machine_states())
        .filter(|&i| !(n..2 * n).contains(&i) && !spec.inner.contains(&model.state_name(i)))
        .collect()
}

/// Classes of the catalogue that this study knows how to draw.
pub fn classes() -> impl Iterator<Item = &'static Effect> {
    // The numbers of an effect are drawn by name, so that a class this study does not know yet
    // is left out rather than drawn wrongly.
    among(KNOWN)
}

/// Those of them, and those beside, that robots lack.
pub fn robots_classes() -> impl Iterator<Item = &'static Effect> {
    among(ROBOTS)
}

fn among(classes: &'static [&'static str]) -> impl Iterator<Item = &'static Effect> {
    CATALOGUE.iter().copied().filter(|e| classes.contains(&e.class))
}

const ROBOTS: &[&str] = &[
    "viscous_friction",
    "coulomb_friction",
    "stribeck_friction",
    "linear_stiffness",
    "end_stop",
    "cogging",
    "hidden_resonance",
    "periodic_disturbance",
    "step_change",
    "added_inertia",
    "payload",
    "base_tilt",
    "gain_error",
    "dead_zone",
    "saturation",
    "input_delay",
    "actuator_lag",
    "sensor_scale",
    "sensor_delay",
];

const KNOWN: &[&str] = &[
    "viscous_friction",
    "coulomb_friction",
    "stribeck_friction",
    "asymmetric_friction",
    "quadratic_drag",
    "constant_force",
    "linear_stiffness",
    "cubic_stiffness",
    "end_stop",
    "gravity_torque",
    "cogging",
    "coupling_stiffness",
    "coriolis_coupling",
    "hysteresis",
    "viscoelastic",
    "hidden_resonance",
    "periodic_disturbance",
    "step_change",
    "linear_loss",
    "quadratic_loss",
    "gain_error",
    "dead_zone",
    "saturation",
    "input_delay",
    "actuator_lag",
    "sensor_scale",
    "sensor_bias",
    "sensor_delay",
];
