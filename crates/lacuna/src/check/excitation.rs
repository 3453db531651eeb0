//! How rich an input is.
//!
//! A signal is persistently exciting of order n when the covariance matrix of n delayed copies
//! of it,
//!
//! ```text
//! R_ij = mean over t of u(t - i d) u(t - j d),   i, j = 0 ... n-1
//! ```
//!
//! is positive definite (L. Ljung, System Identification, 2nd ed., section 13.2); a sum of k
//! sinusoids has order 2k. Here the rank of R for [`DELAYS`] copies is counted, the mean of the
//! input taken off (less than whole periods leave a constant, which adds one) and eigenvalues below [`SMALLEST`] of the largest held for zero.

use nalgebra::{DMatrix, SymmetricEigen};

/// Number of delayed copies; an order of so many means "that or more".
pub const DELAYS: usize = 20;
/// Eigenvalues smaller than this share of the largest do not count: 3 % in amplitude.
const SMALLEST: f64 = 1e-3;
/// An input that varies less than this share of its size never changes.
const NEVER: f64 = 1e-9;

/// One input over all recordings.
pub struct Excitation {
    /// Root mean square.
    pub rms: f64,
    /// Standard deviation.
    pub sd: f64,
    /// Order of persistent excitation, from 0 (never changes) to [`DELAYS`] (or more).
    pub order: usize,
}

/// The excitation by one input: its series, one a recording.
pub fn excitation(series: &[Vec<f64>]) -> Excitation {
    let count: usize = series.iter().map(Vec::len).sum();
    let all = || series.iter().flatten();
    let mean = all().sum::<f64>() / count as f64;
    let rms = (all().map(|u| u * u).sum::<f64>() / count as f64).sqrt();
    let sd = (all().map(|u| (u - mean).powi(2)).sum::<f64>() / count as f64).sqrt();
    if sd <= NEVER * rms {
        return Excitation { rms, sd, order: 0 };
    }
    let centred: Vec<Vec<f64>> =
        series.iter().map(|s| s.iter().map(|u| u - mean).collect()).collect();
    Excitation { rms, sd, order: order(&centred) }
}

fn order(series: &[Vec<f64>]) -> usize {
    let shortest = series.iter().map(Vec::len).min().unwrap_or(0);
    let delay = delay(series, (shortest / (2 * DELAYS)).max(1));
    let mut covariance = DMatrix::<f64>::zeros(DELAYS, DELAYS);
    for s in series {
        for t in (DELAYS - 1) * delay..s.len() {
            for i in 0..DELAYS {
                for j in 0..=i {
                    covariance[(i, j)] += s[t - i * delay] * s[t - j * delay];
                }
            }
        }
    }
    covariance.fill_upper_triangle_with_lower_triangle();
    let eigenvalues = SymmetricEigen::new(covariance).eigenvalues;
    let largest = eigenvalues.max();
    eigenvalues.iter().filter(|&&e| e > SMALLEST * largest && e > 0.0).count()
}

/// Samples after which the input has half forgotten itself, at most `longest`: shorter delays
/// would make copies of any smooth input look alike.
fn delay(series: &[Vec<f64>], longest: usize) -> usize {
    let correlation = |d: usize| -> f64 {
        let pairs =
            |s: &Vec<f64>| -> f64 { s.iter().zip(s.iter().skip(d)).map(|(a, b)| a * b).sum() };
        series.iter().map(pairs).sum()
    };
    let whole = correlation(0);
    (1..longest).find(|&d| correlation(d) < 0.5 * whole).unwrap_or(longest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::{add_gaussian_noise, rng};

    fn sines(frequencies: &[f64]) -> Vec<f64> {
        // Whole periods of every integer frequency.
        let time = |k: i32| std::f64::consts::TAU * f64::from(k) / 500.0;
        let value = |k: i32| frequencies.iter().map(|w| (w * time(k)).sin()).sum();
        (0..4000).map(value).collect()
    }

    #[test]
    fn each_sinusoid_adds_two() {
        assert_eq!(excitation(&[sines(&[2.0])]).order, 2);
        assert_eq!(excitation(&[sines(&[1.0, 4.0])]).order, 4);
        assert_eq!(excitation(&[sines(&[1.0, 3.0, 5.0])]).order, 6);
        // Two recordings with a frequency each are as good as one with both.
        assert_eq!(excitation(&[sines(&[1.0]), sines(&[4.0])]).order, 4);
    }

    #[test]
    fn constants_excite_nothing_and_noise_excites_all() {
        assert_eq!(excitation(&[vec![3.0; 500]]).order, 0);
        assert_eq!(excitation(&[vec![0.0; 500]]).order, 0);
        let mut noise = vec![0.0; 3000];
        add_gaussian_noise(&mut noise, 1.0, &mut rng(1, 0)).unwrap();
        assert_eq!(excitation(&[noise]).order, DELAYS);
    }
}
