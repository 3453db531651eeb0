//! Minimising a smooth function of a few variables: BFGS with gradients by differences.

/// Step of the forward differences.
const DIFFERENCE: f64 = 1e-3;
/// Longest step of one iteration in any variable (all are logarithms).
const LONGEST: f64 = 1.5;
/// Sufficient decrease of a step (Armijo).
const ARMIJO: f64 = 1e-4;
/// Halvings of a step before the search gives up.
const HALVINGS: usize = 8;

/// Where the search ended.
pub(crate) struct Minimum<K> {
    pub at: Vec<f64>,
    pub value: f64,
    /// What the function kept there.
    pub kept: K,
}

/// Follows the function downhill until an iteration gains less than `tolerance`, for `most` iterations, or until it
/// would not come below `goal` if it went on gaining as it last did. Values that are not finite are walls. `function`
/// may keep what it worked out at a point, and `gradient` use that at the same point ([`difference`] helps).
///
/// BFGS: J. Nocedal, S. J. Wright, Numerical Optimization (2006), algorithm 6.1.
pub(crate) fn minimise<K>(
    start: Vec<f64>,
    tolerance: f64,
    most: usize,
    goal: f64,
    function: impl Fn(&[f64]) -> (f64, K),
    gradient_at: impl Fn(&[f64], f64, &K) -> Vec<f64>,
) -> Minimum<K> {
    let size = start.len();
    let (mut value, mut kept) = function(&start);
    let mut at = start;
    let mut gradient = gradient_at(&at, value, &kept);
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
        let Some((next, (found, there))) = line_search(&at, value, &direction, slope, &function)
        else {
            break;
        };
        let gain = value - found;
        let hopeless = found - gain * (most - iteration) as f64 > goal;
        let last = gain < tolerance || hopeless || iteration == most;
        (value, kept) = (found, there);
        if last {
            at = next;
            break;
        }
        let after = gradient_at(&next, value, &kept);
        let step: Vec<f64> = next.iter().zip(&at).map(|(a, b)| a - b).collect();
        let change: Vec<f64> = after.iter().zip(&gradient).map(|(a, b)| a - b).collect();
        update(&mut inverse, &step, &change);
        (at, gradient) = (next, after);
    }
    Minimum { at, value, kept }
}

fn line_search<K>(
    at: &[f64],
    value: f64,
    direction: &[f64],
    slope: f64,
    function: &impl Fn(&[f64]) -> (f64, K),
) -> Option<(Vec<f64>, (f64, K))> {
    let mut length = 1.0;
    for _ in 0..HALVINGS {
        let next: Vec<f64> = at.iter().zip(direction).map(|(x, d)| x + length * d).collect();
        let found = function(&next);
        if found.0 <= value + ARMIJO * length * slope {
            return Some((next, found));
        }
        length *= 0.5;
    }
    None
}

/// Slope in variable i by a forward difference, zero at a wall.
pub(crate) fn difference(
    at: &[f64],
    i: usize,
    value: f64,
    function: impl Fn(&[f64]) -> f64,
) -> f64 {
    let mut shifted = at.to_vec();
    shifted[i] += DIFFERENCE;
    let slope = (function(&shifted) - value) / DIFFERENCE;
    if slope.is_finite() { slope } else { 0.0 }
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

    fn minimum(start: Vec<f64>, most: usize, function: impl Fn(&[f64]) -> f64) -> Minimum<()> {
        let gradient = |at: &[f64], value: f64, (): &()| -> Vec<f64> {
            (0..at.len()).map(|i| difference(at, i, value, &function)).collect()
        };
        minimise(start, 1e-9, most, f64::INFINITY, |at| (function(at), ()), gradient)
    }

    #[test]
    fn the_minimum_of_a_curved_valley_is_found() {
        let rosenbrock = |x: &[f64]| 10.0 * (x[1] - x[0] * x[0]).powi(2) + (1.0 - x[0]).powi(2);
        let found = minimum(vec![-1.0, 1.0], 200, rosenbrock);
        // As near as differences of step 1e-3 tell: this valley is flat along its floor.
        assert!(found.value < 2e-3, "{}", found.value);
        assert!((found.at[0] - 1.0).abs() < 0.05 && (found.at[1] - 1.0).abs() < 0.1);
    }

    #[test]
    fn walls_are_not_crossed() {
        let walled = |x: &[f64]| if x[0] > 2.0 { f64::NAN } else { (x[0] - 5.0).powi(2) };
        let found = minimum(vec![0.0], 50, walled);
        assert!(found.at[0] <= 2.0 && found.at[0] > 1.5, "{:?}", found.at);
    }
}
