//! Inputs that are no actuators, and what is known of their noise.

use crate::driven::with_noisy_input;
use crate::machines::{ON_PENDULUM, diagnosed};
use lacuna_discrepancy::Dataset;
use lacuna_discrepancy::candidates::candidates;
use lacuna_discrepancy::diagnosis::{Diagnosis, Verdict};
use lacuna_discrepancy::likelihood::{FULL, Fit, Hypothesis, Problem, ProcessNoise, intensity};
use lacuna_effects::Law;
use lacuna_excitation::{add_gaussian_noise, rng};
use lacuna_plants::{Model, System, integrate::rk4_sampled};
use lacuna_recordings::{Column, Recording};
use std::sync::Arc;

#[test]
fn no_effect_of_actuators_is_looked_for_where_there_is_none() {
    let mut model = ON_PENDULUM.model();
    let on_inputs = |model: &Model| {
        let all = candidates(model, &[0]);
        all.iter().filter(|c| matches!(c.effect.law, Law::Input(_))).count()
    };
    let others = candidates(&model, &[0]).len() - on_inputs(&model);
    assert!(on_inputs(&model) >= 5);
    model.inputs[0].actuator = false;
    assert_eq!(on_inputs(&model), 0);
    assert_eq!(candidates(&model, &[0]).len(), others);
}

#[test]
fn noise_that_is_stated_is_not_estimated() {
    let mut model = ON_PENDULUM.model();
    let (recordings, sd) = with_noisy_input(ON_PENDULUM.record(&model, 910, 3), 0.05, 910);
    let dataset = Dataset::new(&model, &recordings).expect("a dataset");
    for stated in [0.7 * sd, 0.0] {
        model.inputs[0].noise = Some(stated);
        let problem = Problem::new(&model, &dataset).expect("a problem");
        assert_eq!(problem.input_noise(0), stated);
        let begun = Fit::begin(&problem, Hypothesis::of(&model), 3).expect("a fit");
        let half = ProcessNoise { inputs: vec![0.5 * sd], ..ProcessNoise::none(&problem) };
        let fit = begun.driven_by(Some(Arc::new(half)), FULL).and_then(|f| f.at_level(0, FULL));
        let (noise, _) =
            intensity::most_likely(&fit.expect("a fit"), 2.0, None).expect("likelihoods");
        assert_eq!(noise.inputs, [stated], "{noise:?}");
        // What is not noise on the input is a force then.
        assert!(stated > 0.0 || noise.forces[0] > 0.0, "{noise:?}");
    }
}

/// A cart whose mass is recorded: what is loaded changes while it moves.
const CART: &str = r#"
name = "cart"
[parameters]
c = { value = 0.8, unit = "N s/m", tolerance = 0.2 }
[[input]]
name = "u"
unit = "N"
[[input]]
name = "mass"
unit = "kg"
actuator = false
noise = 0
[[coordinate]]
name = "x"
velocity = "v"
unit = "m"
[mechanics]
mass = [["mass"]]
force = ["u - c*v - 6*x"]
"#;

fn on_cart(concealed: &str) -> Diagnosis {
    let read = |text: &str| Model::from_text(text, "cart.toml").expect("the model is right");
    let (model, truth) = (read(CART), read(&format!("{CART}{concealed}")));
    // The torques that drive a pendulum, ten times as large.
    let torques = ON_PENDULUM.record(&ON_PENDULUM.model(), 31, 4);
    let recordings: Vec<Recording> = torques
        .into_iter()
        .zip(0..)
        .map(|(driven, run)| {
            let time = driven.time;
            let u: Vec<f64> = driven.columns[0].values.iter().map(|u| 10.0 * u).collect();
            let mass: Vec<f64> =
                time.iter().map(|t| if (t % 4.0) < 2.0 { 0.8 } else { 1.7 }).collect();
            let commands: Vec<f64> = u.iter().zip(&mass).flat_map(|(u, m)| [*u, *m]).collect();
            let system = System::new(&truth);
            let start = system.at_rest(&[0.1, 0.0]);
            let motion = rk4_sampled(&system, &start, &time, &commands, truth.hold, 8);
            let motion = motion.expect("it does not diverge");
            let mut x: Vec<f64> = (0..time.len()).map(|k| motion.state(k)[0]).collect();
            add_gaussian_noise(&mut x, 2e-4, &mut rng(77, run)).expect("a deviation");
            let column = |name: &str, values| Column { name: name.to_owned(), values };
            let columns = vec![column("u", u), column("mass", mass), column("x", x)];
            Recording { name: driven.name, time, columns }
        })
        .collect();
    diagnosed(&model, &recordings).diagnosis
}

#[test]
fn a_mass_may_be_a_recorded_column() {
    let d = on_cart("");
    assert_eq!(d.verdict, Verdict::NoMismatch, "{:?}", d.findings);
    let d = on_cart(
        "[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"x\"\nmagnitude = 0.4\nsmoothing_velocity = 0.01\n",
    );
    let found: Vec<_> = d.findings.iter().map(|f| (&*f.class, &*f.channel)).collect();
    assert_eq!(found, [("coulomb_friction", "x")]);
    let fit = &d.fit.held_out["x"];
    assert!(fit.rmse_after < 1.2 * fit.noise && fit.rmse_before > 5.0 * fit.noise, "{fit:?}");
    assert_eq!(d.location.channels["x"].unit, "N");
}
