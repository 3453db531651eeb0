//! Compiled models against the sums they were made of.

use lacuna_realtime::Region;

use super::*;
use crate::identified::{Expansion, SavedExpansion};
use crate::kernel::{ExponentialDotProduct, Gaussian, KernelSpec, Matern, Polynomial, Smoothness};

/// Numbers in (-1, 1) that repeat.
fn numbers(seed: usize, count: usize) -> Vec<f64> {
    let base = [2, 3, 5, 7, 11, 13][seed % 6];
    (0..count).map(|k| 2.0 * halton::number(base, 20 * seed + k + 1) - 1.0).collect()
}

/// One expansion for the given entries, on points in (-2, 2)^d.
fn expansion(kernel: KernelSpec, d: usize, points: usize, entries: &[(usize, usize)]) -> Expansion {
    let spread: Vec<Vec<f64>> = (0..d).map(|i| numbers(i, points)).collect();
    let rows = (0..points).flat_map(|k| spread.iter().map(move |s| 2.0 * s[k]));
    let saved = SavedExpansion {
        kernel,
        centre: Vec::new(),
        widths: Vec::new(),
        points: rows.collect(),
        entries: entries.to_vec(),
        weights: numbers(d + 1, points * entries.len()),
    };
    Expansion::new(saved, d)
}

fn exponential(d: usize, points: usize) -> IdentifiedModel {
    let kernel = ExponentialDotProduct { mu: 5.0 };
    let entries = [(0, 0), (0, 1), (1, 0), (1, 1)];
    let expansions = vec![expansion(kernel.into(), d, points, &entries)];
    IdentifiedModel::of_expansions(1, [2, 1, d], expansions, None)
}

fn cube(d: usize, side: f64) -> Domain {
    Domain::new(vec![-side; d], vec![side; d]).unwrap()
}

/// Largest error over the magnitude of the proof, on a grid that is none of the module's points.
fn error(model: &IdentifiedModel, compiled: &Compiled) -> Vec<f64> {
    let (n, m, d) = (model.dimension(), model.inputs(), model.arguments());
    let evaluator = compiled.evaluator();
    let (mut exact, mut found) = (vec![0.0; n * (1 + m)], vec![0.0; n * (1 + m)]);
    let mut errors = vec![0.0_f64; exact.len()];
    for k in 0..3000_usize {
        let x: Vec<f64> = (0..d)
            .map(|i| {
                let u = (k * [1, 7, 31, 77, 113, 239][i % 6] % 101) as f64 / 100.0;
                let (l, u_) = (evaluator.lower()[i], evaluator.upper()[i]);
                (l + u * (u_ - l)).clamp(l, u_)
            })
            .collect();
        let (f, g) = exact.split_at_mut(n);
        model.evaluate(&x, f, g).unwrap();
        let (f, g) = found.split_at_mut(n);
        assert_eq!(evaluator.evaluate(&x, f, g), Ok(Region::Inside));
        for e in 0..exact.len() {
            errors[e] = errors[e].max((exact[e] - found[e]).abs());
        }
    }
    let pairs = errors.iter().zip(compiled.functions());
    pairs.map(|(e, f)| if *e > 0.0 { e / f.magnitude } else { 0.0 }).collect()
}

#[test]
fn smooth_models_become_series_within_the_tolerance() {
    for (d, points, tolerance) in [(1, 200, 1e-9), (2, 500, 1e-6), (3, 2000, 1e-6), (4, 3000, 1e-3)]
    {
        let model = exponential(d, points);
        let compiled = compile(&model, &cube(d, 2.0), tolerance).unwrap();
        for (function, error) in compiled.functions().iter().zip(error(&model, &compiled)) {
            assert_eq!(function.representation, Representation::Series);
            assert!(function.relative <= tolerance, "{d}: {function:?}");
            // On other points the error may be a little larger than where it was measured.
            assert!(error <= 1.2 * function.relative, "{d}: {error:e} {function:?}");
            assert!(function.estimate >= function.absolute, "{d}: {function:?}");
        }
        assert!(10 * compiled.evaluator().numbers() < 4 * points * (d + 4), "{d}");
    }
}

#[test]
fn arguments_that_do_not_matter_are_dropped() {
    let widths = vec![1e9, 1.5, 1e9];
    let gaussian = expansion(Gaussian { widths }.into(), 3, 300, &[(0, 0)]);
    let model = IdentifiedModel::of_expansions(2, [1, 1, 3], vec![gaussian], None);
    let compiled = compile(&model, &cube(3, 2.0), 1e-6).unwrap();
    let series = compiled.evaluator().series().unwrap();
    assert!(series.degrees[0] == 0 && series.degrees[1] > 0 && series.degrees[2] == 0);
    assert!(error(&model, &compiled)[0] <= 1e-6);
    // There is no sum for g at all.
    assert_eq!(compiled.functions()[1].representation, Representation::Zero);
    assert_eq!((compiled.functions()[1].absolute, compiled.functions()[1].relative), (0.0, 0.0));
}

#[test]
fn a_polynomial_is_its_own_series() {
    let kernel = Polynomial { degree: 3, offset: 1.0, scale: 2.0 };
    let cubic = expansion(kernel.into(), 2, 400, &[(0, 0), (0, 1)]);
    let model = IdentifiedModel::of_expansions(1, [1, 1, 2], vec![cubic], None);
    let compiled = compile(&model, &cube(2, 3.0), 1e-9).unwrap();
    for function in compiled.functions() {
        assert_eq!(function.representation, Representation::Series);
        assert!(function.coefficients <= 10 && function.relative < 1e-11, "{function:?}");
    }
}

#[test]
fn what_is_not_smooth_remains_a_sum_and_says_so() {
    for smoothness in [Smoothness::Half, Smoothness::ThreeHalves, Smoothness::FiveHalves] {
        let matern = Matern { smoothness, widths: vec![0.7] };
        let sum = expansion(matern.into(), 3, 90, &[(0, 0), (0, 1)]);
        let model = IdentifiedModel::of_expansions(1, [1, 1, 3], vec![sum], None);
        let compiled = compile(&model, &cube(3, 2.0), 1e-6).unwrap();
        for (function, error) in compiled.functions().iter().zip(error(&model, &compiled)) {
            assert_eq!(function.representation, Representation::Landmarks);
            assert!(function.relative <= 1e-12 && error < 1e-12, "{function:?}");
        }
        assert!(compiled.evaluator().series().is_none());
    }
}

#[test]
fn many_arguments_do_not_blow_up() {
    let gaussian = expansion(Gaussian { widths: vec![2.0] }.into(), 7, 60, &[(0, 0), (0, 1)]);
    let model = IdentifiedModel::of_expansions(1, [1, 1, 7], vec![gaussian], None);
    let compiled = compile(&model, &cube(7, 2.0), 1e-6).unwrap();
    assert!(compiled.evaluator().numbers() <= 64 * (7 + 2));
    assert!(compiled.relative_error() <= 1e-6);
    assert!(error(&model, &compiled).iter().all(|e| *e <= 1e-6));
}

#[test]
fn landmarks_of_no_weight_are_left_out_and_counted() {
    let matern = Matern { smoothness: Smoothness::Half, widths: vec![0.7] };
    let mut sum = expansion(matern.into(), 2, 64, &[(0, 0)]).saved;
    sum.weights.iter_mut().step_by(2).for_each(|w| *w *= 1e-9);
    let sum = Expansion::new(sum, 2);
    let model = IdentifiedModel::of_expansions(1, [1, 0, 2], vec![sum], None);
    let compiled = compile(&model, &cube(2, 2.0), 1e-5).unwrap();
    let function = &compiled.functions()[0];
    assert_eq!((function.representation, function.coefficients), (Representation::Landmarks, 32));
    assert!(0.0 < function.absolute && function.absolute <= function.estimate, "{function:?}");
    assert!(function.estimate < 1e-5 * function.magnitude);
}

#[test]
fn a_compiled_model_comes_back_from_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("compiled.json");
    let matern = Matern { smoothness: Smoothness::Half, widths: vec![0.7] };
    let kernel = ExponentialDotProduct { mu: 5.0 };
    let expansions = vec![
        expansion(kernel.into(), 2, 300, &[(0, 0)]),
        expansion(matern.into(), 2, 30, &[(0, 1)]),
    ];
    let model = IdentifiedModel::of_expansions(2, [1, 1, 2], expansions, None);
    let compiled = compile(&model, &cube(2, 2.0), 1e-6).unwrap();
    assert!(compiled.evaluator().series().is_some() && compiled.evaluator().sums().len() == 1);
    std::fs::write(&path, compiled.to_json()).unwrap();
    assert_eq!(Compiled::load(&path).unwrap(), compiled);
    let refused = |from: &str, to: &str, part: &str| {
        std::fs::write(&path, compiled.to_json().replacen(from, to, 1)).unwrap();
        let said = Compiled::load(&path).unwrap_err().to_string();
        assert!(said.contains("compiled.json") && said.contains(part), "{said}");
    };
    refused("\"compiled\":1", "\"compiled\":7", "version 1");
    refused("\"compiled\":1", "\"a\":1", "compiled");
    refused("\"inputs\":1", "\"inputs\":2", "functions: expected 3, found 2");
    refused("\"lower\":[-2.0,", "\"lower\":[2.0,", "argument 0 of the box");
    refused("\"blocks\":[[0,", "\"blocks\":[[999,", "index 999");
}

#[test]
fn what_cannot_be_compiled_is_refused() {
    let model = exponential(2, 50);
    assert!(matches!(
        compile(&model, &cube(3, 1.0), 1e-6),
        Err(CompileError::Sides { expected: 2, found: 3 })
    ));
    for tolerance in [0.0, 1e-12, 0.5, f64::NAN] {
        let refused = compile(&model, &cube(2, 1.0), tolerance);
        assert!(matches!(refused, Err(CompileError::Tolerance { .. })), "{refused:?}");
    }
    let refused = compile(&model, &cube(2, 1e4), 1e-6);
    assert!(matches!(refused, Err(CompileError::NotFinite { .. })), "{refused:?}");
    let empty = |l: f64, u: f64| Domain::new(vec![0.0, l], vec![1.0, u]).unwrap_err();
    assert_eq!(empty(2.0, 2.0), CompileError::Empty { argument: 1, lower: 2.0, upper: 2.0 });
    assert!(matches!(empty(f64::NAN, 2.0), CompileError::Empty { argument: 1, .. }));
    assert!(matches!(
        Domain::new(vec![0.0], vec![1.0, 2.0]),
        Err(CompileError::Sides { expected: 1, found: 2 })
    ));
}

#[test]
fn the_range_of_the_points_is_told() {
    let [lower, upper] = Domain::range_of_points(&exponential(3, 100));
    for i in 0..3 {
        assert!((-2.0..-1.8).contains(&lower[i]) && (1.8..2.0).contains(&upper[i]));
    }
}
