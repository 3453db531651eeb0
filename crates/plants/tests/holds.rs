//! The step that fits and predictions share agrees with the plain integrator, whatever the inputs do
//! between their samples.

use lacuna_plants::model::StepInput;
use lacuna_plants::{Hold, Model, System, rk4_sampled};

const OSCILLATOR: &str = r#"
name = "oscillator"

[parameters]
m = { value = 0.7, unit = "kg" }
k = { value = 90.0, unit = "N/m" }

[[input]]
name = "F"
unit = "N"

[[coordinate]]
name = "x"
velocity = "v"
unit = "m"

[mechanics]
mass = [["m"]]
force = ["F - k*x - 0.4*v + 3*x^3"]

[recordings]
input_hold = "HOLD"
"#;

const SUBSTEPS: usize = 2;

#[test]
fn the_hot_loop_agrees_with_the_general_one() {
    for (hold, name, jitter) in [
        (Hold::ZeroOrder, "zero-order", 0.003),
        (Hold::Linear, "linear", 0.003),
        (Hold::BandLimited, "band-limited", 0.0),
        (Hold::BandLimited, "band-limited", 0.003),
    ] {
        let model = Model::from_text(&OSCILLATOR.replace("HOLD", name), "model.toml");
        let model = model.unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(model.hold, hold);
        let time = |k: i32| 0.02 * f64::from(k) + jitter * f64::from(k % 3);
        let times: Vec<f64> = (0..60).map(time).collect();
        let values: Vec<f64> = times.iter().map(|t| (50.0 * t).sin()).collect();
        let system = System::new(&model);
        let mut x = vec![0.3, -1.0];
        let mut found = x.clone();
        let mut workspace = system.workspace();
        for (k, pair) in times.windows(2).enumerate() {
            let stages = hold.stages((&times, &values), k..k + 2, 1, SUBSTEPS);
            let (here, next) = (k..k + 1, hold.end_of_step(k)..hold.end_of_step(k) + 1);
            let input = match stages.is_empty() {
                true => StepInput::Line(&values[here], &values[next]),
                false => StepInput::Stages(&stages),
            };
            system.advance(&mut workspace, (pair[0], pair[1]), input, SUBSTEPS, &mut x);
            found.extend_from_slice(&x);
        }
        let run = rk4_sampled(&system, &[0.3, -1.0], &times, &values, hold, SUBSTEPS);
        let expected = run.expect("finite").states;
        for (a, b) in found.iter().zip(&expected) {
            assert!((a - b).abs() < 1e-10, "{name}: {a} {b}");
        }
    }
}
