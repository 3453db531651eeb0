//! The peers' way on recordings without a sensor's noise to speak of.

use super::*;
use lacuna_plants::{SampledInput, System, rk4};
use lacuna_recordings::Column;

const MODEL: &str = include_str!("../plants/stage.toml");

/// Recordings of the stage with effects that the model leaves out.
fn recordings(effects: &str) -> Vec<Recording> {
    let model = Model::from_text(&format!("{MODEL}\n{effects}"), "truth.toml").unwrap();
    let system = System::new(&model);
    let one = |k: u32| {
        let times: Vec<f64> = (0..1500).map(|s| 0.005 * f64::from(s)).collect();
        let phase = f64::from(k);
        let current: Vec<f64> =
            times.iter().map(|t| 12.0 * ((3.0 + 0.3 * phase) * t + phase).sin()).collect();
        let input = SampledInput { times: &times, values: &current, hold: model.hold };
        let path = rk4(&system, &system.at_rest(&[0.0, 0.0]), &input, &times, 1e-3).unwrap();
        // A regular pattern of the size of a sensor's noise: the smoother needs some.
        let x =
            (0..1500).map(|s| path.state(s)[0] + 1e-5 * f64::from((s as u32 * 7919) % 11) / 11.0);
        let columns = vec![
            Column { name: "x".to_owned(), values: x.collect() },
            Column { name: "i_cmd".to_owned(), values: current.clone() },
        ];
        Recording { name: String::new(), time: times.clone(), columns }
    };
    (0..5).map(one).collect()
}

fn found(effects: &str) -> Vec<String> {
    let model = Model::from_text(MODEL, "model.toml").unwrap();
    let diagnosis = find(&model, &recordings(effects)).unwrap();
    diagnosis.findings.into_iter().map(|f| f.class).collect()
}

#[test]
fn effects_of_the_library_are_found_on_clean_data() {
    let drag = "[[effect]]\nclass = \"quadratic_drag\"\nchannel = \"x\"\ncoefficient = 900.0\n";
    assert!(found(drag).contains(&"quadratic_drag".to_owned()), "{:?}", found(drag));
    let spring = "[[effect]]\nclass = \"linear_stiffness\"\nchannel = \"x\"\nstiffness = 600.0\n";
    assert_eq!(found(spring), ["linear_stiffness"]);
}

#[test]
fn nothing_is_found_where_nothing_is_missing() {
    assert_eq!(found(""), [""; 0]);
}
