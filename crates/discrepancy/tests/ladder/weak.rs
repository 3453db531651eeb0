//! The weak residual: white where nothing is missing, and on time.

use crate::machines::{Bench, ON_PENDULUM, ON_TANKS, ON_TWO_MASS, SLIDE};
use lacuna_discrepancy::Dataset;
use lacuna_discrepancy::evidence::{Normal, regress};
use lacuna_discrepancy::weak::WeakForm;
use lacuna_plants::Model;

/// A dataset whose noise is known rather than estimated.
fn dataset(bench: &Bench, truth: &Model, seed: u64, late: f64) -> Dataset {
    let recordings = bench.record_late(truth, seed, 3, late);
    let mut dataset = Dataset::new(&bench.model(), &recordings).expect("a dataset");
    dataset.noise.iter_mut().for_each(|n| n.sd = bench.noise);
    dataset
}

#[test]
fn the_estimated_noise_is_that_of_the_sensors() {
    for bench in [ON_PENDULUM, ON_TWO_MASS, ON_TANKS] {
        let model = bench.model();
        let dataset = Dataset::new(&model, &bench.record(&model, 50, 3)).expect("a dataset");
        for noise in &dataset.noise {
            assert!((noise.sd / bench.noise - 1.0).abs() < 0.06, "{}: {noise:?}", model.name);
        }
    }
}

/// chi^2 / n of the whitened residual of the true model without any white force, where no
/// force reads the noisy motion: then the covariance is exact.
#[test]
fn the_residual_of_the_true_model_is_white_noise() {
    let bench = Bench { text: SLIDE, samples: 5000, ..ON_PENDULUM };
    let (mut chi2, mut lag, mut rows_used, mut pairs) = (0.0, 0.0, 0.0, 0.0);
    for seed in 51..56 {
        let model = bench.model();
        let dataset = dataset(&bench, &model, seed, 0.0);
        let weak = WeakForm::new(&model, &dataset).expect("a weak form");
        let whitener = weak.whitener(&[0.0]).expect("a whitener");
        let white = whitener.whiten(&weak.residual(&model.values()));
        chi2 += white.iter().map(|r| r * r).sum::<f64>();
        rows_used += white.len() as f64;
        // Neighbours in a segment do not know of each other.
        for (_, rows) in weak.segments() {
            lag += white[rows.clone()].windows(2).map(|p| p[0] * p[1]).sum::<f64>();
            pairs += rows.len() as f64 - 1.0;
        }
    }
    // The standard deviation of chi^2 / n is sqrt(2 / n): a tenth is several of them.
    assert!(rows_used > 1500.0, "{rows_used}");
    let share = chi2 / rows_used;
    assert!((0.9..1.1).contains(&share), "chi2/n {share} of {rows_used}");
    assert!((lag / pairs).abs() < 4.0 / pairs.sqrt(), "{}", lag / pairs);
}

/// The noise in the arguments of the forces is in no standard deviation here (the white force
/// stands for it), so that a few per cent remain beside it.
const BIAS: f64 = 0.05;

/// The residual regressed on what inputs one sample late would change is the delay in
/// samples: none for a held input that is on time, a half for one that is half a sample late.
#[test]
fn a_held_input_is_on_time() {
    for bench in [ON_PENDULUM, ON_TWO_MASS, ON_TANKS] {
        for late in [0.0, 0.5] {
            let model = bench.model();
            let dataset = dataset(&bench, &model, 52, late * bench.step);
            let weak = WeakForm::new(&model, &dataset).expect("a weak form");
            let whitener = weak.whitener(&vec![0.0; weak.channels().len()]).expect("a whitener");
            let target = whitener.whiten(&weak.residual(&model.values()));
            let column = whitener.whiten(&weak.input_column(&model.values(), |s| {
                let u = &s.commands;
                (0..u.len()).map(|k| u[k.saturating_sub(1)]).collect()
            }));
            let prior = Normal { mean: 0.0, sd: 100.0 };
            let fit = regress(&target, &[&column], &[prior], 0.0).expect("finite");
            let (delay, std) = (fit.coefficients[0], fit.std(0));
            assert!(std < 0.1, "{}: the delay is not seen, {std}", model.name);
            assert!(
                (delay - late).abs() < BIAS.max(4.0 * std),
                "{}: {delay} +- {std}, truth {late}",
                model.name
            );
        }
    }
}

/// A concealed constant force is the coefficient of its own column.
#[test]
fn a_missing_force_is_seen_at_its_size() {
    for (bench, channel, force) in
        [(ON_PENDULUM, "q", 0.02), (ON_TWO_MASS, "x2", -0.3), (ON_TANKS, "h2", 0.002)]
    {
        let effect = format!(
            "[[effect]]\nclass = \"constant_force\"\nchannel = \"{channel}\"\nforce = {force}"
        );
        let model = bench.model();
        let dataset = dataset(&bench, &bench.truth(&effect), 53, 0.0);
        let weak = WeakForm::new(&model, &dataset).expect("a weak form");
        let whitener = weak.whitener(&vec![0.0; weak.channels().len()]).expect("a whitener");
        let target = whitener.whiten(&weak.residual(&model.values()));
        let on = (0..model.channels()).find(|&c| model.channel_name(c) == channel).expect("there");
        let column = weak.force_column(&model.values(), on, None, |s| vec![1.0; s.len()]);
        let prior = Normal { mean: 0.0, sd: 1e3 };
        let fit = regress(&target, &[&whitener.whiten(&column)], &[prior], 0.0).expect("finite");
        let (found, std) = (fit.coefficients[0], fit.std(0));
        assert!(
            (found - force).abs() < f64::max(4.0 * std, BIAS * force.abs()),
            "{channel}: {found} +- {std}, truth {force}"
        );
        assert!(std < 0.2 * force.abs(), "{channel}: {std}");
    }
}

/// Parameter columns are the residual's derivatives: moving a parameter moves the residual
/// along its column.
#[test]
fn parameter_columns_are_derivatives_of_the_residual() {
    let bench = ON_TWO_MASS;
    let model = bench.model();
    let dataset = dataset(&bench, &model, 54, 0.0);
    let weak = WeakForm::new(&model, &dataset).expect("a weak form");
    let nominal = model.values();
    let residual = weak.residual(&nominal);
    let columns = weak.parameter_columns(&nominal);
    assert_eq!(columns.len(), 4);
    for (k, column) in columns {
        let mut moved = nominal.clone();
        let step = 1e-4 * nominal[k];
        moved[k] += step;
        let after = weak.residual(&moved);
        let norm = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>().sqrt();
        let left: Vec<f64> =
            (0..column.len()).map(|a| residual[a] - after[a] - step * column[a]).collect();
        assert!(norm(&left) < 1e-3 * step * norm(&column), "{}", model.parameters[k].name);
    }
}
