//! The step that fits and predictions share agrees with the general integrator, whatever the inputs
//! do between their samples.

use lacuna_plants::{Hold, Model, SampledInput, Substeps, System, rk4};

const SUBSTEPS: usize = 2;

#[test]
fn steps_agree_with_the_general_integrator() {
    for (hold, name, jitter) in [
        (Hold::ZeroOrder, "zero-order", 0.003),
        (Hold::Linear, "linear", 0.003),
        (Hold::BandLimited, "band-limited", 0.0),
        (Hold::BandLimited, "band-limited", 0.003),
    ] {
        let text = include_str!("../../../examples/arm/model.toml");
        let model = Model::from_text(&text.replace("zero-order", name), "model.toml");
        let model = model.unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(model.hold, hold);
        let time = |k: i32| 0.02 * f64::from(k) + jitter * f64::from(k % 3);
        let times: Vec<f64> = (0..60).map(time).collect();
        let values: Vec<f64> = times.iter().map(|t| (50.0 * t).sin()).collect();
        let system = System::new(&model);
        let mut x = vec![0.3, -1.0];
        let mut found = x.clone();
        let mut workspace = system.workspace();
        let inputs = hold.along((&times, &values), 0..times.len(), 1, SUBSTEPS);
        for (k, pair) in times.windows(2).enumerate() {
            let span = (pair[0], pair[1]);
            system.advance(&mut workspace, span, inputs.step(k), Substeps::even(SUBSTEPS), &mut x);
            found.extend_from_slice(&x);
        }
        let input = SampledInput { times: &times, values: &values, hold };
        let expected: Vec<f64> = times
            .windows(2)
            .scan(vec![0.3, -1.0], |x, pair| {
                // Steps of the same length: halves of each sample.
                let step = (pair[1] - pair[0]) / SUBSTEPS as f64;
                let run = rk4(&system, x, &input, pair, step).expect("finite");
                *x = run.state(1).to_vec();
                Some(x.clone())
            })
            .flatten()
            .collect();
        for (a, b) in found[2..].iter().zip(&expected) {
            assert!((a - b).abs() < 1e-10, "{name}: {a} {b}");
        }
    }
}
