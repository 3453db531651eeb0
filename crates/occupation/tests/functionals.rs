//! Weights of the functionals against exact integrals of polynomials.

use lacuna_occupation::{
    InitialDerivative, Quadrature, QuadratureError, TestFunction, TestFunctionError,
};
use proptest::prelude::*;

fn even_times(samples: usize, step: f64) -> Vec<f64> {
    (0..samples).map(|k| k as f64 * step).collect()
}

/// Uneven times: steps between 0.5 and 1.5 times the mean.
fn uneven_times(samples: usize) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(0.01..0.03f64, samples - 1).prop_map(|steps| {
        let mut times = vec![0.3];
        steps.iter().for_each(|step| times.push(times[times.len() - 1] + step));
        times
    })
}

fn polynomial(coefficients: &[f64], t: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * t + coefficient)
}

fn derivative(coefficients: &[f64]) -> Vec<f64> {
    coefficients.iter().enumerate().skip(1).map(|(j, coefficient)| j as f64 * coefficient).collect()
}

/// int_a^b of a polynomial.
fn integral(coefficients: &[f64], a: f64, b: f64) -> f64 {
    let antiderivative = |t: f64| -> f64 {
        coefficients
            .iter()
            .enumerate()
            .map(|(j, c)| c * t.powi(j as i32 + 1) / (j + 1) as f64)
            .sum()
    };
    antiderivative(b) - antiderivative(a)
}

fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut result = vec![0.0; a.len() + b.len()];
    for (i, x) in a.iter().enumerate() {
        b.iter().enumerate().for_each(|(j, y)| result[i + j] += x * y);
    }
    result
}

/// Exact int_{start}^{end} phi y^(k) dt (times (-1)^k: int phi^(k) y dt), in the variable t - centre, for y given there.
fn exact_compact(exponent: usize, half_width: f64, order: usize, y: &[f64]) -> f64 {
    let bump = [1.0, 0.0, -1.0 / (half_width * half_width)];
    let phi = (0..exponent).fold(vec![1.0], |power, _| product(&power, &bump));
    let differentiated = (0..order).fold(y.to_vec(), |y, _| derivative(&y));
    let sign = if order % 2 == 1 { -1.0 } else { 1.0 };
    sign * integral(&product(&phi, &differentiated), -half_width, half_width)
}

proptest! {
    #[test]
    fn compact_weights_integrate_polynomials_exactly_on_uneven_times(
        times in uneven_times(60),
        exponent in 3..7u32,
        order in 0..3usize,
        all in prop::collection::vec(-1.0..1.0f64, 6),
    ) {
        let test_function = TestFunction::Compact { exponent, width: 0.6, stride: 7 };
        let functionals = test_function.functionals(&times, Quadrature::Trapezoid, order).unwrap();
        let coefficients = &all[..=order + 3];
        for functional in &functionals {
            let (start, end) = (times[functional.first], times[functional.end() - 1]);
            let (centre, half_width) = (0.5 * (start + end), 0.5 * (end - start));
            let y: Vec<f64> = times.iter().map(|t| polynomial(coefficients, t - centre)).collect();
            let expected = exact_compact(exponent as usize, half_width, order, coefficients);
            // A window of 0.6 s, second derivatives: int |phi''| is some 10 / 0.3.
            prop_assert!((functional.apply(&y) - expected).abs() < 1e-11, "{} {expected}", functional.apply(&y));
        }
    }

    #[test]
    fn endpoint_simpson_weights_are_exact_for_cubics(
        samples in 3..30usize,
        order in 1..4usize,
        all in prop::collection::vec(-1.0..1.0f64, 4),
    ) {
        let times = even_times(samples, 0.05);
        let end = times[samples - 1];
        let functional = &TestFunction::Endpoint { order }.functionals(&times, Quadrature::Simpson, 0).unwrap()[0];
        // phi y is a cubic where y has the degree 4 - order.
        let coefficients = &all[..=4 - order];
        let y: Vec<f64> = times.iter().map(|&t| polynomial(coefficients, t)).collect();
        let phi = (1..order).fold(vec![1.0], |phi, k| product(&phi, &[end / k as f64, -1.0 / k as f64]));
        let expected = integral(&product(&phi, coefficients), 0.0, end);
        prop_assert!((functional.apply(&y) - expected).abs() < 1e-13);
    }

    #[test]
    fn trapezoid_weights_are_exact_for_straight_lines(times in uneven_times(9), a in -5.0..5.0f64, b in -5.0..5.0f64) {
        let weights = Quadrature::Trapezoid.weights(&times).unwrap();
        let sum: f64 = weights.iter().zip(&times).map(|(w, t)| w * (a + b * t)).sum();
        prop_assert!((sum - integral(&[a, b], times[0], times[8])).abs() < 1e-13);
    }

    /// For a polynomial y of degree s the endpoint right-hand side is int phi y^(s) dt = y^(s) T^s / s!, and the
    /// polynomial through the first samples gives its derivatives exactly.
    #[test]
    fn endpoint_right_hand_sides_are_exact_for_polynomials(
        times in uneven_times(20),
        order in 1..4usize,
        all in prop::collection::vec(-1.0..1.0f64, 4),
    ) {
        let coefficients = &all[..=order];
        let y: Vec<f64> = times.iter().map(|t| polynomial(coefficients, t - times[0])).collect();
        let initial = InitialDerivative::LocalPolynomial { samples: 12, degree: order };
        let right = &TestFunction::Endpoint { order }.right_hand_sides(&times, Quadrature::Trapezoid, order, initial).unwrap()[0];
        let expected = coefficients[order] * (times[19] - times[0]).powi(order as i32);
        prop_assert!((right.apply(&y) - expected).abs() < 1e-10);
    }
}

#[test]
fn the_forward_difference_is_the_papers() {
    let times = even_times(5, 0.1);
    let right_hand_side = TestFunction::Endpoint { order: 2 }
        .right_hand_sides(&times, Quadrature::Simpson, 2, InitialDerivative::ForwardDifference)
        .unwrap();
    // y_4 - y_0 - 0.4 (y_1 - y_0) / 0.1
    for (found, expected) in right_hand_side[0].weights.iter().zip([3.0, -4.0, 0.0, 0.0, 1.0]) {
        assert!((found - expected).abs() < 1e-13, "{found} {expected}");
    }
}

#[test]
fn compact_right_hand_sides_carry_the_sign_of_the_partial_integrations() {
    let times = even_times(101, 0.01);
    let test_function = TestFunction::Compact { exponent: 4, width: 1.0, stride: 1 };
    let sine: Vec<f64> = times.iter().map(|t| t.sin()).collect();
    let cosine: Vec<f64> = times.iter().map(|t| t.cos()).collect();
    let apply = |order: usize, y: &[f64]| {
        let initial = InitialDerivative::default();
        test_function.right_hand_sides(&times, Quadrature::Trapezoid, order, initial).unwrap()[0]
            .apply(y)
    };
    let integrate = |y: &[f64]| {
        test_function.functionals(&times, Quadrature::Trapezoid, 0).unwrap()[0].apply(y)
    };
    assert!((apply(1, &sine) - integrate(&cosine)).abs() < 1e-9);
    assert!((apply(2, &sine) + integrate(&sine)).abs() < 1e-9);
}

#[test]
fn windows_slide_by_the_stride_and_vanish_at_both_ends() {
    let times = even_times(51, 0.02);
    let test_function = TestFunction::Compact { exponent: 4, width: 0.8, stride: 3 };
    let functionals = test_function.functionals(&times, Quadrature::Trapezoid, 2).unwrap();
    let firsts: Vec<usize> = functionals.iter().map(|functional| functional.first).collect();
    assert_eq!(firsts, [0, 3, 6, 9]);
    for functional in &functionals {
        assert_eq!(functional.weights.len(), 41);
        assert_eq!((functional.weights[0], functional.weights[40]), (0.0, 0.0));
    }
}

#[test]
fn simpson_refuses_uneven_times_and_says_where() {
    let error = Quadrature::Simpson.weights(&[0.0, 0.1, 0.2, 0.35, 0.4]).unwrap_err();
    assert!(matches!(error, QuadratureError::Uneven { sample: 3, .. }), "{error}");
    let error = Quadrature::Simpson.weights(&[0.0, 0.1]).unwrap_err();
    assert_eq!(error, QuadratureError::TooFewSamples { expected: 3, found: 2 });
    let error = Quadrature::Trapezoid.weights(&[0.0, 0.1, 0.1]).unwrap_err();
    assert_eq!(error, QuadratureError::NotIncreasing { sample: 2, before: 0.1, found: 0.1 });
}

#[test]
fn unsuitable_test_functions_are_refused() {
    let times = even_times(51, 0.02);
    let compact = |exponent, width, stride, derivative| {
        TestFunction::Compact { exponent, width, stride }
            .functionals(&times, Quadrature::Trapezoid, derivative)
            .unwrap_err()
    };
    assert_eq!(
        compact(4, 1.5, 1, 0),
        TestFunctionError::WindowTooLong { width: 1.5, duration: 1.0 }
    );
    assert_eq!(compact(4, -0.5, 1, 0), TestFunctionError::Width { found: -0.5 });
    assert!(matches!(compact(4, f64::NAN, 1, 0), TestFunctionError::Width { .. }));
    assert_eq!(compact(4, 0.5, 0, 0), TestFunctionError::Zero { name: "the stride" });
    assert_eq!(compact(2, 0.5, 1, 2), TestFunctionError::Derivative { highest: 1, found: 2 });
    let few = compact(4, 0.06, 1, 2);
    assert!(matches!(few, TestFunctionError::TooFewSamples { expected: 8, found: 4, .. }), "{few}");
    let endpoint = TestFunction::Endpoint { order: 2 }
        .functionals(&times, Quadrature::Simpson, 2)
        .unwrap_err();
    assert_eq!(endpoint, TestFunctionError::Derivative { highest: 1, found: 2 });
    let initial = InitialDerivative::LocalPolynomial { samples: 3, degree: 3 };
    let local = TestFunction::Endpoint { order: 2 }.right_hand_sides(
        &times,
        Quadrature::Simpson,
        2,
        initial,
    );
    assert!(matches!(
        local.unwrap_err(),
        TestFunctionError::LocalPolynomial { degree: 3, samples: 3, .. }
    ));
}
