//! Bad input is a typed error, models survive their files, and results do not depend on the number of threads.

use lacuna_occupation::{
    ExponentialDotProduct, FitError, Gaussian, IdentifiedModel, InitialDerivative, KernelError,
    ModelFileError, Quadrature, Regression, TestFunction, TestFunctionError, TrajectoryData,
    TrajectoryError,
};

fn regression() -> Regression {
    Regression {
        kernel: ExponentialDotProduct { mu: 5.0 }.into(),
        order: 2,
        test_function: TestFunction::Compact { exponent: 4, width: 0.5, stride: 2 },
        quadrature: Quadrature::Trapezoid,
        lambda: 1e-6,
        initial_derivative: InitialDerivative::Given,
        whiten: true,
    }
}

fn endpoint() -> Regression {
    Regression { test_function: TestFunction::Endpoint { order: 2 }, whiten: false, ..regression() }
}

fn ramp(duration: f64, inputs: usize) -> TrajectoryData {
    let times: Vec<f64> = (0..=20).map(|k| duration * f64::from(k) / 20.0).collect();
    TrajectoryData::new(times.clone(), times.clone(), vec![0.5; 21 * inputs], times).unwrap()
}

#[test]
fn trajectories_must_have_their_shape() {
    let times = || vec![0.0, 0.1, 0.2];
    let three = || vec![1.0; 3];
    let error = TrajectoryData::new(vec![0.0], vec![1.0], vec![], vec![1.0]).unwrap_err();
    assert_eq!(error, TrajectoryError::TooFewSamples { expected: 2, found: 1 });
    let error = TrajectoryData::new(times(), vec![1.0; 4], vec![], three()).unwrap_err();
    assert_eq!(error, TrajectoryError::Shape { what: "arguments", expected: 3, found: 4 });
    let error = TrajectoryData::new(times(), three(), vec![], vec![]).unwrap_err();
    assert_eq!(error, TrajectoryError::Shape { what: "coordinates", expected: 3, found: 0 });
    let error = TrajectoryData::new(
        times(),
        three(),
        vec![0.0, 1.0, 0.0, f64::INFINITY, 0.0, 0.0],
        three(),
    );
    let expected =
        TrajectoryError::NotFinite { what: "inputs", row: 1, column: 1, found: f64::INFINITY };
    assert_eq!(error.unwrap_err(), expected);
    let error = TrajectoryData::new(vec![0.0, 0.2, 0.1], three(), vec![], three()).unwrap_err();
    assert!(matches!(error, TrajectoryError::Times(_)), "{error}");
    let wide = TrajectoryData::new(times(), three(), vec![], vec![1.0; 6]).unwrap();
    let error = wide.with_initial_derivatives(vec![1.0; 3]).unwrap_err();
    assert_eq!(
        error,
        TrajectoryError::Shape { what: "initial derivatives", expected: 2, found: 3 }
    );
}

#[test]
fn settings_out_of_range_are_refused() {
    let data = [ramp(1.0, 1)];
    let fit = |regression: Regression| regression.fit(&data).unwrap_err();
    assert_eq!(regression().fit(&[]).unwrap_err(), FitError::NoTrajectory);
    assert_eq!(fit(Regression { lambda: 0.0, ..regression() }), FitError::Lambda { found: 0.0 });
    assert!(matches!(
        fit(Regression { lambda: f64::NAN, ..regression() }),
        FitError::Lambda { .. }
    ));
    assert_eq!(fit(Regression { order: 0, ..regression() }), FitError::Order);
    let order = TestFunctionError::Order { expected: 1, found: 2 };
    assert_eq!(
        fit(Regression { order: 1, ..endpoint() }),
        FitError::TestFunction { trajectory: 0, source: order }
    );
    let kernel = Gaussian { widths: vec![-1.0] }.into();
    let width = KernelError::NotPositive { parameter: "width", found: -1.0 };
    assert_eq!(fit(Regression { kernel, ..regression() }), FitError::Kernel(width));
    let missing = FitError::InitialDerivatives { trajectory: 0, expected: 1, found: 0 };
    assert_eq!(fit(endpoint()), missing);
}

#[test]
fn trajectories_must_agree_and_be_long_enough() {
    let error = regression().fit(&[ramp(1.0, 1), ramp(1.0, 2)]).unwrap_err();
    assert_eq!(error, FitError::Shape { trajectory: 1, what: "inputs", expected: 1, found: 2 });
    let error = regression().fit(&[ramp(1.0, 1), ramp(0.4, 1)]).unwrap_err();
    let source = TestFunctionError::WindowTooLong { width: 0.5, duration: 0.4 };
    assert_eq!(error, FitError::TestFunction { trajectory: 1, source });
}

#[test]
fn a_kernel_that_overflows_is_a_typed_error() {
    let kernel = ExponentialDotProduct { mu: 1e-3 }.into();
    let error = Regression { kernel, ..regression() }.fit(&[ramp(1.0, 1)]).unwrap_err();
    assert!(
        matches!(error, FitError::NotPositiveDefinite { .. } | FitError::NotFinite { .. }),
        "{error}"
    );
}

#[test]
fn rounding_that_makes_the_gram_matrix_indefinite_is_a_typed_error() {
    // The same trajectory forty times: G has rank one per window, and lambda is far below its rounding errors.
    let data = vec![ramp(1.0, 1); 40];
    let error = Regression { lambda: 1e-30, whiten: false, ..regression() }.fit(&data).unwrap_err();
    assert!(matches!(error, FitError::NotPositiveDefinite { lambda: 1e-30, .. }), "{error}");
}

#[test]
fn autonomous_systems_have_no_control_effectiveness() {
    // x' = 2 along the ramp x = 2 t
    let times: Vec<f64> = (0..=20).map(|k| 0.05 * f64::from(k)).collect();
    let x: Vec<f64> = times.iter().map(|t| 2.0 * t).collect();
    let data = TrajectoryData::new(times, x.clone(), vec![], x).unwrap();
    let model =
        Regression { order: 1, lambda: 1e-9, whiten: false, ..regression() }.fit(&[data]).unwrap();
    let mut f = [0.0];
    model.evaluate(&[1.0], &mut f, &mut []).unwrap();
    assert!((f[0] - 2.0).abs() < 1e-4, "{}", f[0]);
    assert_eq!((model.dimension(), model.inputs(), model.arguments(), model.order()), (1, 0, 1, 1));
}

#[test]
fn slices_of_the_wrong_length_are_refused() {
    let model = regression().fit(&[ramp(1.0, 2)]).unwrap();
    let error = model.evaluate(&[1.0], &mut [0.0], &mut [0.0]).unwrap_err();
    assert_eq!((error.what, error.expected, error.found), ("g", 2, 1));
    assert!(model.evaluate(&[1.0, 2.0], &mut [0.0], &mut [0.0; 2]).is_err());
    assert!(model.evaluate(&[1.0], &mut [], &mut [0.0; 2]).is_err());
}

#[test]
fn a_saved_model_comes_back_with_the_same_bits() {
    let times: Vec<f64> = (0..200).map(|k| 0.01 * f64::from(k)).collect();
    let x: Vec<f64> = times.iter().map(|t| (2.0 * t).sin()).collect();
    let model = regression()
        .fit(&[TrajectoryData::new(times.clone(), x.clone(), times, x).unwrap()])
        .unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.json");
    model.save(&path).unwrap();
    assert_eq!(IdentifiedModel::load(&path).unwrap(), model);

    let text = std::fs::read_to_string(&path).unwrap();
    let damaged = |from: &str, to: &str| {
        assert!(text.contains(from), "{from} is not in the file");
        std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
        IdentifiedModel::load(&path).unwrap_err().to_string()
    };
    assert!(damaged(r#""version":3"#, r#""version":1"#).contains("expected version 3"));
    assert!(damaged(r#""entries":[[0,0]"#, r#""entries":[[1,0]"#).contains("row 1"));
    assert!(damaged(r#""weights":["#, r#""weights":[1.5,"#).contains("weights"));
    assert!(
        damaged(r#""arguments":1"#, r#""arguments":0"#).contains("arguments must be at least 1")
    );
    assert!(damaged(r#""mu":5.0"#, r#""mu":-5.0"#).contains("mu must be positive"));
    let first_order = TestFunction::Endpoint { order: 1 };
    let whole = Regression { order: 1, test_function: first_order, ..endpoint() }
        .fit(&[ramp(1.0, 1), ramp(2.0, 1)])
        .unwrap();
    whole.save(&path).unwrap();
    assert_eq!(IdentifiedModel::load(&path).unwrap(), whole);
    let text = std::fs::read_to_string(&path).unwrap();
    for (from, to, expected) in [
        (r#""lengths":["#, r#""lengths":[3,"#, "lengths: expected 42 values, found 45"),
        (r#""inputs":["#, r#""inputs":[1.5,"#, "inputs: expected 42 values, found 43"),
    ] {
        std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let error = IdentifiedModel::load(&path).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let absent = IdentifiedModel::load(&folder.path().join("absent.json")).unwrap_err();
    assert!(
        matches!(absent, ModelFileError::Io { kind: std::io::ErrorKind::NotFound, .. }),
        "{absent}"
    );
}

/// Whitened ridge regression by its definition, W = L^-T (L^-1 G L^-T + lambda I)^-1 L^-1 Y: the whitened weights
/// V = L^T W obey (L^-1 G L^-T + lambda I) V = L^-1 Y.
#[test]
fn whitened_fits_are_the_ridge_regression_of_the_whitened_system() {
    let times: Vec<f64> = (0..100).map(|k| 0.02 * f64::from(k)).collect();
    let x: Vec<f64> = times.iter().map(|t| (2.0 * t).sin()).collect();
    let data = [TrajectoryData::new(times, x.clone(), vec![], x).unwrap()];
    let (lambda, test_function) =
        (1e-2, TestFunction::Compact { exponent: 4, width: 0.5, stride: 8 });
    let system = Regression { lambda, test_function, ..regression() }.assemble(&data).unwrap();
    let weights = system.weights(lambda).unwrap();
    let factor = system.noise_covariance.as_ref().unwrap().clone().cholesky().unwrap();
    let size = weights.nrows();
    let whiten = |mut column: Vec<f64>| {
        factor.solve_lower_in_place(&mut column).unwrap();
        column
    };
    let whitened_weights: Vec<f64> =
        (0..size).map(|b| (b..size).map(|a| factor.get(a, b) * weights[(a, 0)]).sum()).collect();
    // L^-1 G L^-T V = L^-1 G W
    let product = |a: usize| (0..size).map(|b| system.gram[(a, b)] * weights[(b, 0)]).sum();
    let predicted = whiten((0..size).map(product).collect());
    let right = whiten((0..size).map(|a| system.right_hand_sides[(a, 0)]).collect());
    let largest = right.iter().fold(0.0_f64, |max, value| max.max(value.abs()));
    for a in 0..size {
        let left = predicted[a] + lambda * whitened_weights[a];
        assert!((left - right[a]).abs() < 1e-9 * largest, "row {a}: {left}, expected {}", right[a]);
    }
}

/// One long recording, of more samples than a tile holds, and windows that overlap across tiles.
#[test]
fn gram_matrices_do_not_depend_on_tiles_or_threads() {
    let times: Vec<f64> = (0..900).map(|k| 0.01 * f64::from(k)).collect();
    let x: Vec<f64> = times.iter().map(|t| t.sin()).collect();
    let u: Vec<f64> = times.iter().map(|t| (3.0 * t).cos()).collect();
    let data = [TrajectoryData::new(times, x.clone(), u.clone(), x.clone()).unwrap()];
    let wide = TestFunction::Compact { exponent: 4, width: 4.0, stride: 100 };
    for test_function in [regression().test_function, wide] {
        let regression = Regression { test_function, ..regression() };
        let with_threads = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| (regression.assemble(&data).unwrap(), regression.fit(&data).unwrap()))
        };
        let ((system, model), (system_of_three, model_of_three)) =
            (with_threads(1), with_threads(3));
        assert_eq!(system.gram, system_of_three.gram);
        assert_eq!(model, model_of_three);

        // G_ab from its definition, for some pairs of windows.
        let functionals = system.occupation.functionals();
        for a in [0, functionals.len() / 2, functionals.len() - 1] {
            for b in 0..functionals.len() {
                let mut expected = 0.0;
                for (k, c) in functionals[a].weights.iter().enumerate() {
                    for (l, d) in functionals[b].weights.iter().enumerate() {
                        let (k, l) = (functionals[a].first + k, functionals[b].first + l);
                        expected += c * d * (x[k] * x[l] / 5.0).exp() * (1.0 + u[k] * u[l]);
                    }
                }
                let found = system.gram[(a, b)];
                assert!(
                    (found - expected).abs() < 1e-12,
                    "({a}, {b}): {found}, expected {expected}"
                );
                assert_eq!(found, system.gram[(b, a)]);
            }
        }
    }
}
