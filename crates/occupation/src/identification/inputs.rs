//! Inputs between their samples.

use super::motion::{InputPath, Motion};
use super::weak::GAUSS;

/// Writes u(t) for a time in interval k, `times[k] <= t <= times[k + 1]`.
pub(super) fn input_at(motion: &Motion, path: InputPath, k: usize, t: f64, u: &mut [f64]) {
    let (times, m) = (motion.times(), motion.input_count());
    let row = |k: usize| &motion.inputs()[k * m..(k + 1) * m];
    match path {
        InputPath::Held => u.copy_from_slice(row(k)),
        InputPath::Linear => {
            let share = (t - times[k]) / (times[k + 1] - times[k]);
            let ends = row(k).iter().zip(row(k + 1));
            u.iter_mut().zip(ends).for_each(|(u, (a, b))| *u = a + share * (b - a));
        }
        InputPath::Smooth => {
            let first = first_of_four(k, times.len());
            let weights = lagrange(&times[first..first + 4], t);
            u.fill(0.0);
            for (l, weight) in weights.iter().enumerate() {
                u.iter_mut().zip(row(first + l)).for_each(|(u, value)| *u += weight * value);
            }
        }
    }
}

/// Inputs v, N x m, with which sums over samples are integrals along the path: sum_k w_k p(t_k) v_k is int p u dt for
/// functions p that cubics through four samples follow, and quadrature weights w. Inputs that jump at the samples are
/// otherwise half a step late.
pub(super) fn at_samples(motion: &Motion, path: InputPath) -> Vec<f64> {
    let (times, m) = (motion.times(), motion.input_count());
    if path == InputPath::Smooth {
        return motion.inputs().to_vec();
    }
    let mut cubic = Means::new(times.len(), m);
    let mut linear = Means::new(times.len(), m);
    let mut u = vec![0.0; m];
    for (k, pair) in times.windows(2).enumerate() {
        let (step, first) = (pair[1] - pair[0], first_of_four(k, times.len()));
        for (node, weight) in GAUSS {
            let t = pair[0] + node * step;
            input_at(motion, path, k, t, &mut u);
            for (l, share) in lagrange(&times[first..first + 4], t).into_iter().enumerate() {
                cubic.add(first + l, weight * step * share, &u);
            }
            linear.add(k, weight * step * (1.0 - node), &u);
            linear.add(k + 1, weight * step * node, &u);
        }
    }
    // Where steps are very unequal a cubic's weights may cancel.
    let means = |k: usize| {
        if cubic.weights[k] > 0.5 * linear.weights[k] { cubic.row(k) } else { linear.row(k) }
    };
    (0..times.len()).flat_map(means).collect()
}

/// Weighted means of inputs at samples.
struct Means {
    weights: Vec<f64>,
    /// N x m.
    sums: Vec<f64>,
}

impl Means {
    fn new(samples: usize, inputs: usize) -> Self {
        Self { weights: vec![0.0; samples], sums: vec![0.0; samples * inputs] }
    }

    fn add(&mut self, k: usize, weight: f64, u: &[f64]) {
        self.weights[k] += weight;
        let sums = &mut self.sums[k * u.len()..(k + 1) * u.len()];
        sums.iter_mut().zip(u).for_each(|(sum, u)| *sum += weight * u);
    }

    fn row(&self, k: usize) -> Vec<f64> {
        let m = self.sums.len() / self.weights.len();
        self.sums[k * m..(k + 1) * m].iter().map(|sum| sum / self.weights[k]).collect()
    }
}

/// First of the four samples whose cubic stands for interval k of N samples.
pub(super) fn first_of_four(k: usize, samples: usize) -> usize {
    k.saturating_sub(1).min(samples - 4)
}

/// Weights of four samples in the value at t of the cubic through them.
pub(super) fn lagrange(times: &[f64], t: f64) -> [f64; 4] {
    let from = |l: usize| t - times[l];
    let [a, b, c, d] = [from(0), from(1), from(2), from(3)];
    let (ab, cd) = (a * b, c * d);
    let apart = |l: usize, j: usize| times[l] - times[j];
    let [p, q, r] = [apart(0, 1), apart(0, 2), apart(0, 3)];
    let [v, w, x] = [apart(1, 2), apart(1, 3), apart(2, 3)];
    [b * cd / (p * q * r), -a * cd / (p * v * w), d * ab / (q * v * x), -c * ab / (r * w * x)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(path: InputPath, t: f64) -> f64 {
        let times: Vec<f64> = (0..6).map(|k| 0.5 * f64::from(k)).collect();
        let inputs: Vec<f64> = times.iter().map(|t| t * t * t - t).collect();
        let motion = Motion::new(times, vec![0.0; 6], inputs).unwrap();
        let mut u = [0.0];
        input_at(&motion, path, (t / 0.5) as usize, t, &mut u);
        u[0]
    }

    /// int p u dt over steps of u, for a p that is zero at both ends with its slope.
    #[test]
    fn sums_over_samples_integrate_held_and_straight_inputs() {
        let times: Vec<f64> = (0..41).map(|k| 0.05 * f64::from(k)).collect();
        let inputs: Vec<f64> = (0..41).map(|k| f64::from(k * 7 % 5) - 2.0).collect();
        let motion = Motion::new(times.clone(), vec![0.0; 41], inputs).unwrap();
        let p = |t: f64| (t * (2.0 - t)).powi(4);
        for path in [InputPath::Held, InputPath::Linear] {
            let of_sums: f64 =
                at_samples(&motion, path).iter().zip(&times).map(|(v, t)| 0.05 * v * p(*t)).sum();
            let mut exact = 0.0;
            for (k, begin) in times[..40].iter().enumerate() {
                for part in 0..100 {
                    let t = begin + 0.05 * (f64::from(part) + 0.5) / 100.0;
                    let mut u = [0.0];
                    input_at(&motion, path, k, t, &mut u);
                    exact += 0.05 / 100.0 * u[0] * p(t);
                }
            }
            assert!((of_sums - exact).abs() < 2e-4, "{path:?}: {of_sums} {exact}");
        }
    }

    #[test]
    fn inputs_follow_their_path() {
        let cubic = |t: f64| t * t * t - t;
        assert_eq!(value(InputPath::Held, 0.7), cubic(0.5));
        let line = cubic(0.5) + 0.4 * (cubic(1.0) - cubic(0.5));
        assert!((value(InputPath::Linear, 0.7) - line).abs() < 1e-14);
        for t in [0.1, 0.7, 2.4] {
            assert!((value(InputPath::Smooth, t) - cubic(t)).abs() < 1e-13);
        }
    }
}
