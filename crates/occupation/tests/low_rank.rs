//! A fit of low rank is the dense fit, as far as its landmarks go.

use lacuna_occupation::{
    ExponentialDotProduct, FitError, Gaussian, InitialDerivative, KernelSpec, Limits, Quadrature,
    Regression, StreamError, TestFunction, TrajectoryData, TrajectoryError, Way,
};

const COUNT: usize = 300;

/// x' = (x2, -sin x1 + u) from places that fill a square.
fn trajectory(k: usize) -> Result<TrajectoryData, TrajectoryError> {
    let share = |golden: f64| (k as f64 * golden).fract();
    let mut x = [4.0 * share(0.618_034) - 2.0, 4.0 * share(0.754_877_666) - 2.0];
    let (step, samples) = (0.05, 15);
    let (mut states, mut inputs) = (Vec::new(), Vec::new());
    for l in 0..samples {
        states.extend(x);
        let u = (3.0 * step * l as f64 + k as f64).sin();
        inputs.push(u);
        for _ in 0..20 {
            let h = step / 20.0;
            let slope = -x[0].sin() + u;
            x = [x[0] + h * x[1] + 0.5 * h * h * slope, x[1] + h * slope];
        }
    }
    let times = (0..samples).map(|l| step * l as f64).collect();
    TrajectoryData::new(times, states.clone(), inputs, states)
}

fn regression(kernel: KernelSpec, test_function: TestFunction) -> Regression {
    let whiten = matches!(test_function, TestFunction::Compact { .. });
    Regression {
        kernel,
        order: 1,
        test_function,
        quadrature: Quadrature::Trapezoid,
        lambda: 1e-4,
        initial_derivative: InitialDerivative::default(),
        whiten,
    }
}

fn regressions() -> [Regression; 3] {
    let endpoint = TestFunction::Endpoint { order: 1 };
    let compact = TestFunction::Compact { exponent: 2, width: 0.4, stride: 3 };
    [
        regression(ExponentialDotProduct { mu: 4.0 }.into(), endpoint),
        regression(Gaussian { widths: vec![2.0, 1.5] }.into(), endpoint),
        regression(Gaussian { widths: vec![2.0] }.into(), compact),
    ]
}

const LOW_RANK: Limits = Limits { dense: 0, landmarks: 200, left: 1e-12 };

#[test]
fn with_enough_landmarks_it_is_the_dense_fit() {
    for regression in regressions() {
        let all: Vec<TrajectoryData> = (0..COUNT).map(|k| trajectory(k).unwrap()).collect();
        let dense = regression.fit(&all).unwrap();
        let fitted = regression.fit_streamed(COUNT, trajectory, LOW_RANK).unwrap();
        let Way::LowRank(way) = fitted.way else { panic!("{}", fitted.way) };
        assert!(way.landmarks < COUNT && way.left < 1e-6, "{}", fitted.way);
        let (mut f, mut g) = ([0.0; 2], [0.0; 2]);
        let (mut f_dense, mut g_dense) = ([0.0; 2], [0.0; 2]);
        for k in 0..20 {
            let x = [0.2 * f64::from(k) - 2.0, 1.5 - 0.15 * f64::from(k)];
            dense.evaluate(&x, &mut f_dense, &mut g_dense).unwrap();
            fitted.model.evaluate(&x, &mut f, &mut g).unwrap();
            for (found, expected) in f.iter().chain(&g).zip(f_dense.iter().chain(&g_dense)) {
                assert!((found - expected).abs() < 2e-4, "{found} {expected}");
            }
        }
    }
}

/// Few landmarks are told: half of them give another answer.
#[test]
fn the_change_tells_of_too_few_landmarks() {
    let [regression, ..] = regressions();
    let change = |landmarks| {
        let limits = Limits { landmarks, ..LOW_RANK };
        let fitted = regression.fit_streamed(COUNT, trajectory, limits).unwrap();
        let Way::LowRank(way) = fitted.way else { panic!("{}", fitted.way) };
        way.change
    };
    let (few, many) = (change(8), change(100));
    assert!(few[0] > 0.05 && many[0] < 0.01, "{few:?} {many:?}");
    assert!(few[1] > 10.0 * many[1], "{few:?} {many:?}");
}

#[test]
fn small_data_are_dense_and_threads_do_not_matter() {
    let [regression, ..] = regressions();
    let fitted = regression.fit_streamed(20, trajectory, Limits::default()).unwrap();
    assert_eq!(fitted.way, Way::Dense { functionals: 20 });
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| regression.fit_streamed(COUNT, trajectory, LOW_RANK)).unwrap()
    };
    let (one, three) = (run(1), run(3));
    assert_eq!((one.model, one.way), (three.model, three.way));
}

#[test]
fn bad_trajectories_are_named() {
    let [regression, ..] = regressions();
    let broken = |k: usize| if k == 137 { Err("torn") } else { Ok(trajectory(k).unwrap()) };
    let error = regression.fit_streamed(COUNT, broken, LOW_RANK).unwrap_err();
    assert_eq!(error.to_string(), "trajectory 137: torn");
    let other = |k: usize| match trajectory(k) {
        Ok(data) if k == 7 => TrajectoryData::new(
            data.times().to_vec(),
            data.inputs().to_vec(),
            vec![],
            data.inputs().to_vec(),
        ),
        data => data,
    };
    let error = regression.fit_streamed(COUNT, other, LOW_RANK).unwrap_err();
    assert!(matches!(error, StreamError::Fit(FitError::Shape { trajectory: 7, .. })), "{error}");
    let error = regression.fit_streamed(0, trajectory, LOW_RANK).unwrap_err();
    assert!(matches!(error, StreamError::Fit(FitError::NoTrajectory)));
}

/// One long recording has as many candidates as many short ones; a kernel that overflows has none.
#[test]
fn few_long_trajectories_have_landmarks_too() {
    let long = |_: usize| {
        let parts: Vec<TrajectoryData> = (0..40).map(|k| trajectory(k).unwrap()).collect();
        let states: Vec<f64> = parts.iter().flat_map(|p| p.arguments()).copied().collect();
        let inputs: Vec<f64> = parts.iter().flat_map(|p| p.inputs()).copied().collect();
        let times = (0..inputs.len()).map(|k| 0.05 * k as f64).collect();
        TrajectoryData::new(times, states.clone(), inputs, states)
    };
    let [_, _, regression] = regressions();
    let fitted = regression.fit_streamed(1, long, LOW_RANK).unwrap();
    let Way::LowRank(way) = fitted.way else { panic!("{}", fitted.way) };
    assert!(way.landmarks > 20 && way.functionals > 150, "{}", fitted.way);
    let kernel = ExponentialDotProduct { mu: 1e-4 }.into();
    let error = Regression { kernel, ..regression }.fit_streamed(1, long, LOW_RANK).unwrap_err();
    assert!(matches!(error, StreamError::Fit(FitError::NoLandmark)), "{error}");
}
