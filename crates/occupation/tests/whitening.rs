//! Banded covariances and their factors.

use lacuna_occupation::{
    BandedCholesky, Functional, Quadrature, SymmetricBanded, TestFunction, WhiteningError,
};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Second-derivative functionals of windows of 0.4 s that slide by two samples over 1 s.
fn windows() -> Vec<Functional> {
    let times: Vec<f64> = (0..51).map(|k| 0.02 * f64::from(k)).collect();
    let test_function = TestFunction::Compact { exponent: 4, width: 0.4, stride: 2 };
    test_function.functionals(&times, Quadrature::Trapezoid, 2).unwrap()
}

/// L^-1 S L^-T from a factor and a matrix given entry by entry.
fn whitened(factor: &BandedCholesky, entry: impl Fn(usize, usize) -> f64) -> Vec<Vec<f64>> {
    let size = factor.size();
    let solve = |mut column: Vec<f64>| {
        factor.solve_lower_in_place(&mut column).unwrap();
        column
    };
    let half: Vec<Vec<f64>> =
        (0..size).map(|b| solve((0..size).map(|a| entry(a, b)).collect())).collect();
    (0..size).map(|a| solve(half.iter().map(|column| column[a]).collect())).collect()
}

fn assert_identity(matrix: &[Vec<f64>], tolerance: f64) {
    for (a, row) in matrix.iter().enumerate() {
        for (b, &found) in row.iter().enumerate() {
            let expected = if a == b { 1.0 } else { 0.0 };
            assert!(
                (found - expected).abs() < tolerance,
                "({a}, {b}): {found}, expected {expected}"
            );
        }
    }
}

#[test]
fn whitening_makes_the_covariance_the_identity() {
    let functionals = windows();
    let factor = BandedCholesky::of_functionals(&functionals).unwrap();
    // The covariance from its definition, over all samples and without bands.
    let weight = |a: usize, k: usize| {
        let functional = &functionals[a];
        k.checked_sub(functional.first)
            .and_then(|k| functional.weights.get(k))
            .copied()
            .unwrap_or(0.0)
    };
    let covariance = |a: usize, b: usize| (0..51).map(|k| weight(a, k) * weight(b, k)).sum();
    assert_identity(&whitened(&factor, covariance), 1e-5);
}

#[test]
fn whitened_noise_has_unit_covariance() {
    let functionals = windows();
    let factor = BandedCholesky::of_functionals(&functionals).unwrap();
    let trials = 20_000;
    let size = functionals.len();
    let mut sums = vec![vec![0.0; size]; size];
    for trial in 0..trials {
        let mut generator = ChaCha8Rng::seed_from_u64(7);
        generator.set_stream(trial);
        let noise: Vec<f64> = StandardNormal.sample_iter(&mut generator).take(51).collect();
        let mut residual: Vec<f64> =
            functionals.iter().map(|functional| functional.apply(&noise)).collect();
        factor.solve_lower_in_place(&mut residual).unwrap();
        for a in 0..size {
            (0..size).for_each(|b| sums[a][b] += residual[a] * residual[b] / trials as f64);
        }
    }
    // An entry has a standard deviation of sqrt(2 / 20000) = 0.01 at most; five of them.
    assert_identity(&sums, 0.05);
}

#[test]
fn noise_terms_add_before_the_factorisation() {
    let functionals = windows();
    let white = SymmetricBanded::covariance(&functionals).unwrap();
    let mut sum = SymmetricBanded::zeros(white.size(), 0).plus(&white, 4.0).unwrap();
    sum.add_diagonal(0.5);
    assert_eq!(sum.bandwidth(), white.bandwidth());
    let expected = |a: usize, b: usize| 4.0 * white.get(a, b) + if a == b { 0.5 } else { 0.0 };
    assert_eq!((sum.get(3, 5), sum.get(4, 4)), (expected(3, 5), expected(4, 4)));
    assert_identity(&whitened(&sum.cholesky().unwrap(), expected), 1e-11);
}

#[test]
fn singular_and_misshapen_covariances_are_typed_errors() {
    let functional = Functional { first: 0, weights: vec![1.0, 2.0] };
    let twice = SymmetricBanded::covariance(&[functional.clone(), functional.clone()]).unwrap();
    assert!(matches!(twice.cholesky(), Err(WhiteningError::NotPositiveDefinite { index: 1, .. })));
    // The relative ridge of `of_functionals` makes the same pair factorable.
    assert!(BandedCholesky::of_functionals(&[functional.clone(), functional.clone()]).is_ok());
    let zero = Functional { first: 0, weights: vec![0.0] };
    let error = BandedCholesky::of_functionals(&[zero]).unwrap_err();
    assert_eq!(error, WhiteningError::NotPositiveDefinite { index: 0, pivot: 0.0 });
    let later = Functional { first: 3, weights: vec![1.0] };
    let error = SymmetricBanded::covariance(&[later, functional.clone()]).unwrap_err();
    assert_eq!(error, WhiteningError::NotSorted { index: 1 });
    let factor = BandedCholesky::of_functionals(&[functional]).unwrap();
    let error = factor.solve_lower_in_place(&mut [1.0, 2.0]).unwrap_err();
    assert_eq!(error, WhiteningError::Size { expected: 1, found: 2 });
}

proptest! {
    /// L L^T of the factor is the matrix, for diagonally dominant banded matrices.
    #[test]
    fn the_factor_reproduces_the_matrix(
        size in 1..12usize,
        bandwidth in 0..5usize,
        entries in prop::collection::vec(-1.0..1.0f64, 60),
    ) {
        // A banded matrix as the covariance of functionals of `bandwidth + 1` samples each, and a diagonal.
        let functionals: Vec<Functional> = (0..size)
            .map(|a| Functional { first: a, weights: entries[a * 5..=a * 5 + bandwidth].to_vec() })
            .collect();
        let mut matrix = SymmetricBanded::covariance(&functionals).unwrap();
        matrix.add_diagonal(0.1);
        let factor = matrix.clone().cholesky().unwrap();
        for a in 0..size {
            for b in 0..size {
                let product: f64 = (0..size).map(|k| factor.get(a, k) * factor.get(b, k)).sum();
                prop_assert!((product - matrix.get(a, b)).abs() < 1e-13);
            }
        }
    }
}
