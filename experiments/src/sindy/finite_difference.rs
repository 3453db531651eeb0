//! Numerical differentiation of samples.

use super::SparseRegressionError;

/// Samples of a centred difference of first or second order.
const CENTRED: usize = 3;

/// The derivative of order 1 or 2 of each column of `rows` (samples x `columns`) at all `times`.
///
/// Centred differences of three samples inside; at both ends one-sided differences of the same
/// order of accuracy, that is of `order + 2` samples: PySINDy's `FiniteDifference(d=order)`. White
/// noise of standard deviation s becomes s / (sqrt(2) dt) inside for order 1, sqrt(6) s / dt^2 for
/// order 2, and about three times as much at the ends.
///
/// # Errors
/// [`SparseRegressionError::TooFewSamples`] below `order + 2` samples.
pub fn finite_difference(
    times: &[f64],
    rows: &[f64],
    columns: usize,
    order: usize,
) -> Result<Vec<f64>, SparseRegressionError> {
    let one_sided = order + 2;
    let samples = times.len();
    if samples < one_sided {
        return Err(SparseRegressionError::TooFewSamples {
            order,
            expected: one_sided,
            found: samples,
        });
    }
    let mut derivative = Vec::with_capacity(rows.len());
    for k in 0..samples {
        let stencil = match k {
            0 => 0..one_sided,
            k if k + 1 == samples => samples - one_sided..samples,
            k => k - 1..k - 1 + CENTRED,
        };
        let weights = weights(&times[stencil.clone()], times[k], order);
        let samples = || weights.iter().zip(stencil.clone());
        derivative.extend(
            (0..columns).map(|i| samples().map(|(w, l)| w * rows[l * columns + i]).sum::<f64>()),
        );
    }
    Ok(derivative)
}

/// Weights with which the samples at `nodes` give the derivative at `at`: that of the polynomial
/// through them.
fn weights(nodes: &[f64], at: f64, order: usize) -> Vec<f64> {
    let factorial: f64 = (1..=order).map(|k| k as f64).product();
    let weight = |i: usize| {
        // Lagrange's polynomial of node i in powers of t - at, lowest first.
        let others = nodes.iter().enumerate().filter(|&(j, _)| j != i);
        let polynomial = others.fold(vec![1.0], |polynomial, (_, node)| {
            times_linear(&polynomial, at - node, nodes[i] - node)
        });
        factorial * polynomial[order]
    };
    (0..nodes.len()).map(weight).collect()
}

/// The product of a polynomial in s and `(s + offset) / scale`.
fn times_linear(polynomial: &[f64], offset: f64, scale: f64) -> Vec<f64> {
    let mut product = vec![0.0; polynomial.len() + 1];
    for (k, coefficient) in polynomial.iter().enumerate() {
        product[k] += coefficient * offset / scale;
        product[k + 1] += coefficient / scale;
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_those_of_the_tables() {
        let close = |a: Vec<f64>, b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(close(weights(&[-1.0, 0.0, 1.0], 0.0, 1), &[-0.5, 0.0, 0.5]));
        assert!(close(weights(&[0.0, 1.0, 2.0], 0.0, 1), &[-1.5, 2.0, -0.5]));
        assert!(close(weights(&[-1.0, 0.0, 1.0], 0.0, 2), &[1.0, -2.0, 1.0]));
        assert!(close(weights(&[0.0, 1.0, 2.0, 3.0], 0.0, 2), &[2.0, -5.0, 4.0, -1.0]));
    }

    /// A parabola and a line on uneven times, as two columns.
    #[test]
    fn parabolas_are_differentiated_exactly() {
        let times = [0.0, 0.1, 0.25, 0.3, 0.5];
        let rows: Vec<f64> = times.iter().flat_map(|t| [1.0 + 3.0 * t * t, 2.0 - t]).collect();
        let first = finite_difference(&times, &rows, 2, 1).unwrap();
        let second = finite_difference(&times, &rows, 2, 2).unwrap();
        for (k, t) in times.iter().enumerate() {
            assert!(
                (first[2 * k] - 6.0 * t).abs() < 1e-12 && (first[2 * k + 1] + 1.0).abs() < 1e-12
            );
            assert!((second[2 * k] - 6.0).abs() < 1e-10 && second[2 * k + 1].abs() < 1e-10);
        }
    }

    #[test]
    fn too_few_samples_are_refused() {
        let refused = finite_difference(&[0.0, 1.0, 2.0], &[0.0; 3], 1, 2);
        let expected = SparseRegressionError::TooFewSamples { order: 2, expected: 4, found: 3 };
        assert_eq!(refused, Err(expected));
    }
}
