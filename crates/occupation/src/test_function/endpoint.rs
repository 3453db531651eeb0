//! The paper's test function phi(t) = (T - t)^(s-1) / (s-1)!.

use super::{InitialDerivative, TestFunctionError};
use crate::functional::Functional;
use crate::quadrature::{Quadrature, QuadratureError, check_increasing};

/// x^k / k!
pub(super) fn taylor(x: f64, k: usize) -> f64 {
    (1..=k).fold(1.0, |product, factor| product * x / factor as f64)
}

/// int phi^(k) y dt, phi^(k) = (-1)^k (T - t)^(s-1-k) / (s-1-k)!
pub(super) fn functional(
    times: &[f64],
    quadrature: Quadrature,
    order: usize,
    derivative: usize,
) -> Result<Functional, TestFunctionError> {
    let highest = order.checked_sub(1).ok_or(TestFunctionError::Zero { name: "the order" })?;
    let power = highest
        .checked_sub(derivative)
        .ok_or(TestFunctionError::Derivative { highest, found: derivative })?;
    let mut weights = quadrature.weights(times)?;
    let sign = if derivative % 2 == 1 { -1.0 } else { 1.0 };
    let end = times[times.len() - 1];
    for (weight, time) in weights.iter_mut().zip(times) {
        *weight *= sign * taylor(end - time, power);
    }
    Ok(Functional { first: 0, weights })
}

/// y(T) - sum_{k < s} y^(k)(0) T^k / k!
pub(super) fn right_hand_side(
    times: &[f64],
    order: usize,
    initial: InitialDerivative,
) -> Result<Functional, TestFunctionError> {
    let highest = order.checked_sub(1).ok_or(TestFunctionError::Zero { name: "the order" })?;
    check_increasing(times)?;
    let [start, .., end] = times else {
        return Err(QuadratureError::TooFewSamples { expected: 2, found: times.len() }.into());
    };
    let mut weights = vec![0.0; times.len()];
    weights[0] = -1.0;
    weights[times.len() - 1] = 1.0;
    for derivative in 1..=highest {
        let Some(estimate) = initial.weights(times, derivative)? else { break };
        for (weight, contribution) in weights.iter_mut().zip(estimate) {
            *weight -= taylor(end - start, derivative) * contribution;
        }
    }
    Ok(Functional { first: 0, weights })
}
