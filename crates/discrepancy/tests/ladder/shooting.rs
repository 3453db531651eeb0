//! Multiple shooting: parameters come back, and their standard deviations are honest.

use crate::machines::{Bench, ON_PENDULUM, ON_TANKS};
use lacuna_discrepancy::Dataset;
use lacuna_discrepancy::shooting::Shooting;
use lacuna_plants::model::ModelEffect;

/// Errors of all parameters in units of their standard deviations, over several seeds.
fn standardised_errors(bench: Bench, seeds: std::ops::Range<u64>) -> Vec<f64> {
    let bench = Bench { samples: bench.samples / 2, ..bench };
    let model = bench.model();
    let mut truth = model.clone();
    for (p, share) in truth.parameters.iter_mut().zip([1.06, 0.93, 1.04]) {
        p.value += (share - 1.0) * 10.0 * p.std();
    }
    let span = bench.step * bench.samples as f64;
    seeds
        .flat_map(|seed| {
            let dataset = Dataset::new(&model, &bench.record(&truth, seed, 2)).expect("a dataset");
            let fit =
                Shooting::new(&model, &dataset, vec![]).fit(&model.values(), span / 10.0, span);
            // Windows grow to the whole recording.
            assert_eq!(fit.horizon, span, "{} seed {seed}", model.name);
            let reduced = fit.reduced();
            assert!((0.9..1.1).contains(&reduced), "{} seed {seed}: {reduced}", model.name);
            let truth = truth.values();
            let free = (0..truth.len()).filter(|&k| model.parameters[k].std() > 0.0);
            free.map(|k| (fit.parameters[k] - truth[k]) / fit.parameter_std[k]).collect::<Vec<_>>()
        })
        .collect()
}

#[test]
fn parameters_are_recovered_with_standard_deviations_that_cover() {
    for (bench, seeds) in [(ON_PENDULUM, 60..68), (ON_TANKS, 70..78)] {
        let z = standardised_errors(bench, seeds);
        assert!(z.len() >= 16);
        assert!(z.iter().all(|z| z.abs() < 4.0), "{z:?}");
        let rms = (z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64).sqrt();
        // Deviations that cover have rms 1; sixteen or more of them scatter about it.
        assert!((0.4..1.6).contains(&rms), "rms {rms}: {z:?}");
    }
}

#[test]
fn an_effect_is_fitted_from_a_rough_start() {
    let bench = ON_PENDULUM;
    let effect = "[[effect]]\nclass = \"cubic_stiffness\"\nchannel = \"q\"\nstiffness = 0.25";
    let truth = bench.truth(effect);
    let model = bench.model();
    let dataset = Dataset::new(&model, &bench.record(&truth, 80, 2)).expect("a dataset");
    let start = ModelEffect { parameters: vec![0.1], ..truth.effects[0].clone() };
    let fit = Shooting::new(&model, &dataset, vec![start]).fit(&model.values(), 0.5, 10.0);
    let found = &fit.effects[0];
    let std = found.std[0].expect("a fitted parameter has a standard deviation");
    assert!((found.parameters[0] - 0.25).abs() < 4.0 * std, "{} +- {std}", found.parameters[0]);
    assert!(std > 0.0 && std < 0.05, "{std}");
    assert!((0.9..1.1).contains(&fit.reduced()), "{}", fit.reduced());
    assert!(fit.colour < 3.0, "{}", fit.colour);
}

#[test]
fn held_parameters_stay_where_they_are() {
    let bench = Bench { samples: 400, ..ON_PENDULUM };
    let model = bench.model();
    let dataset = Dataset::new(&model, &bench.record(&model, 81, 1)).expect("a dataset");
    let start: Vec<f64> = model.values().iter().map(|v| 1.05 * v).collect();
    let fit = Shooting::new(&model, &dataset, vec![]).with_parameters_held().fit(&start, 0.5, 4.0);
    assert_eq!(fit.parameters, start);
    assert_eq!(fit.parameter_std, [0.0; 3]);
}
