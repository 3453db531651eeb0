//! Inputs between their samples.

use super::motion::{InputPath, Motion};

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
