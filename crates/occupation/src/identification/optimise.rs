//! Minimising a smooth function of a few variables: BFGS with gradients by differences.

use rayon::prelude::*;

/// Step of the forward differences.
const DIFFERENCE: f64 = 1e-3;
/// Longest step of one iteration in any variable (all are logarithms).
const LONGEST: f64 = 1.5;
/// Sufficient decrease of a step (Armijo).
const ARMIJO: f64 = 1e-4;
/// Halvings of a step before the search gives up.
const HALVINGS: usize = 8;

/// Where the search ended.
#[derive(Debug, Clone)]
pub(crate) struct Minimum {
    pub at: Vec<f64>,
    pub value: f64,
}

/// Follows the function downhill until an iteration gains less than `tolerance`, for `most` iterations, or until it
/// would not come below `goal` if it went on gaining as it last did. Values that are not finite are walls. Differences
/// are taken in parallel; the result does not depend on the number of threads.
///
/// BFGS: J. Nocedal, S. J. Wright, Numerical Optimization (2006), algorithm 6.1.
pub(crate) fn minimise(
    start: Vec<f64>,
    tolerance: f64,
    most: usize,
    goal: f64,
    function: impl Fn(&[f64]) -> f64 + Sync,
) -> Minimum {
    let size = start.len();
    let mut value = function(&start);
    let mut at = start;
    let mut gradient = differences(&at, value, &function);
    let mut inverse = scaled_identity(size, &gradient);
    for iteration in 1..=most {
        let mut direction: Vec<f64> = inverse
            .iter()
            .map(|row| -row.iter().zip(&gradient).map(|(h, g)| h * g).sum::<f64>())
            .collect();
        if dot(&direction, &gradient) >= 0.0 {
            inverse = scaled_identity(size, &gradient);
            direction = gradient.iter().map(|g| -g).collect();
        }
        let longest = direction.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        if longest > LONGEST {
            direction.iter_mut().for_each(|v| *v *= LONGEST / longest);
        }
        let slope = dot(&direction, &gradient);
        let Some((next, found)) = line_search(&at, value, &direction, slope, &function) else {
            break;
        };
        let gain = value - found;
        let after = differences(&next, found, &function);
        let step: Vec<f64> = next.iter().zip(&at).map(|(a, b)| a - b).collect();
        let change: Vec<f64> = after.iter().zip(&gradient).map(|(a, b)| a - b).collect();
        update(&mut inverse, &step, &change);
        (at, value, gradient) = (next, found, after);
        let hopeless = value - gain * (most - iteration) as f64 > goal;
        if gain < tolerance || hopeless {
            break;
        }
    }
    Minimum { at, value }
}

fn line_search(
    at: &[f64],
    value: f64,
    direction: &[f64],
    slope: f64,
    function: &(impl Fn(&[f64]) -> f64 + Sync),
) -> Option<(Vec<f64>, f64)> {
    let mut length = 1.0;
    for _ in 0..HALVINGS {
        let next: Vec<f64> = at.iter().zip(direction).map(|(x, d)| x + length * d).collect();
        let found = function(&next);
        if found <= value + ARMIJO * length * slope {
            return Some((next, found));
        }
        length *= 0.5;
    }
    None
}

fn differences(at: &[f64], value: f64, function: &(impl Fn(&[f64]) -> f64 + Sync)) -> Vec<f64> {
    let one = |i: usize| {
        let mut shifted = at.to_vec();
        shifted[i] += DIFFERENCE;
        let slope = (function(&shifted) - value) / DIFFERENCE;
        if slope.is_finite() { slope } else { 0.0 }
    };
    (0..at.len()).into_par_iter().map(one).collect()
}

/// A first step of length one.
fn scaled_identity(size: usize, gradient: &[f64]) -> Vec<Vec<f64>> {
    let length = dot(gradient, gradient).sqrt().max(1.0);
    let row = |i: usize| (0..size).map(|j| if i == j { 1.0 / length } else { 0.0 }).collect();
    (0..size).map(row).collect()
}

/// H <- (I - s y^T / s.y) H (I - y s^T / s.y) + s s^T / s.y, left alone where the curvature is not positive.
fn update(inverse: &mut [Vec<f64>], step: &[f64], change: &[f64]) {
    let curvature = dot(step, change);
    if curvature <= 1e-10 * (dot(step, step) * dot(change, change)).sqrt() {
        return;
    }
    let product: Vec<f64> = inverse.iter().map(|row| dot(row, change)).collect();
    let scale = (1.0 + dot(change, &product) / curvature) / curvature;
    for (i, row) in inverse.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry += scale * step[i] * step[j]
                - (product[i] * step[j] + step[i] * product[j]) / curvature;
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_minimum_of_a_curved_valley_is_found() {
        let rosenbrock = |x: &[f64]| 10.0 * (x[1] - x[0] * x[0]).powi(2) + (1.0 - x[0]).powi(2);
        let found = minimise(vec![-1.0, 1.0], 1e-9, 200, f64::INFINITY, rosenbrock);
        // As near as differences of step 1e-3 tell: this valley is flat along its floor.
        assert!(found.value < 2e-3, "{found:?}");
        assert!((found.at[0] - 1.0).abs() < 0.05 && (found.at[1] - 1.0).abs() < 0.1);
    }

    #[test]
    fn walls_are_not_crossed() {
        let walled = |x: &[f64]| if x[0] > 2.0 { f64::NAN } else { (x[0] - 5.0).powi(2) };
        let found = minimise(vec![0.0], 1e-9, 50, f64::INFINITY, walled);
        assert!(found.at[0] <= 2.0 && found.at[0] > 1.5, "{found:?}");
    }
}
