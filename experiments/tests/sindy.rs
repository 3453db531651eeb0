//! Sparse regression on the Duffing data.

use experiments::duffing_data::{Errors, NOISE, TrialErrors, trajectories};
use experiments::sindy::{SparseRegressionError, sindyc, wsindy};

/// Greatest errors of f and g that PySINDy 2.1.0 makes on trials 0, 1 and 2 of seed 1:
/// `FiniteDifference(d=2)` and `STLSQ()`, on 1, x, x^2, x^3, sin x, cos x and the same times u.
const PYSINDY: [[f64; 2]; 3] = [
    [0.6540314817672623, 1.18222657399181],
    [0.9660776001166731, 2.1637999436627293],
    [1.0418989491580604, 1.1866693953577536],
];

#[test]
fn sindyc_agrees_with_pysindy() {
    for (trial, expected) in (0..).zip(PYSINDY) {
        let model = sindyc(&trajectories(1, trial, NOISE).unwrap(), 2).unwrap();
        let TrialErrors { max_f, max_g, .. } = Errors::of(&model).unwrap().summary();
        for (a, b) in [max_f, max_g].into_iter().zip(expected) {
            assert!((a - b).abs() < 1e-8 * b, "trial {trial}: {a} is not {b}");
        }
    }
}

/// All functions of the oscillator are in the library: without noise the error is that of the
/// differences (third derivatives times step^2) or of the quadrature alone.
#[test]
fn the_oscillator_is_found_without_noise() {
    let data = trajectories(1, 0, 0.0).unwrap();
    let strong = Errors::of(&sindyc(&data, 2).unwrap()).unwrap().summary();
    assert!(strong.max_f < 0.01 && strong.max_g < 0.01, "{strong:?}");
    let weak = Errors::of(&wsindy(&data, 2).unwrap()).unwrap().summary();
    assert!(weak.max_f < 1e-4 && weak.max_g < 1e-4, "{weak:?}");
}

#[test]
fn recordings_shorter_than_a_window_are_refused() {
    let data = trajectories(1, 0, NOISE).unwrap();
    let short = |d: &lacuna_occupation::TrajectoryData| {
        let first = |values: &[f64]| values[..20].to_vec();
        let (x, y) = (first(d.arguments()), first(d.coordinates()));
        lacuna_occupation::TrajectoryData::new(first(d.times()), x, first(d.inputs()), y).unwrap()
    };
    let short: Vec<_> = data.iter().map(short).collect();
    assert!(sindyc(&short, 2).is_ok());
    assert!(matches!(wsindy(&short, 2), Err(SparseRegressionError::TestFunction(_))));
}
