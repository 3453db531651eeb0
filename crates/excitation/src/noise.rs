//! Measurement noise.

use rand::Rng;
use rand_distr::{Distribution, Normal};
use thiserror::Error;

/// Why no noise could be drawn.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum NoiseError {
    /// A standard deviation must be finite and not negative.
    #[error("a noise standard deviation must be finite and not negative, found {found}")]
    BadDeviation {
        /// The standard deviation given.
        found: f64,
    },
}

/// Add independent Gaussian noise of standard deviation `sd` (in the unit of the values) to
/// each of `values`.
///
/// # Errors
/// [`NoiseError::BadDeviation`] when `sd` is negative or not finite.
pub fn add_gaussian_noise(
    values: &mut [f64],
    sd: f64,
    rng: &mut impl Rng,
) -> Result<(), NoiseError> {
    let bad = NoiseError::BadDeviation { found: sd };
    if sd < 0.0 {
        return Err(bad);
    }
    let normal = Normal::new(0.0, sd).map_err(|_| bad)?;
    for v in values {
        *v += normal.sample(rng);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng;

    #[test]
    fn mean_and_deviation_are_as_asked() {
        let n = 40_000.0;
        let mut values = vec![5.0; n as usize];
        add_gaussian_noise(&mut values, 0.3, &mut rng(11, 0)).unwrap();
        let mean = values.iter().sum::<f64>() / n;
        let sd = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
        // Five standard errors of each: 0.3 / sqrt(n) and 0.3 / sqrt(2 n).
        assert!((mean - 5.0).abs() < 5.0 * 0.3 / n.sqrt(), "{mean}");
        assert!((sd - 0.3).abs() < 5.0 * 0.3 / (2.0 * n).sqrt(), "{sd}");
    }

    #[test]
    fn no_deviation_is_no_noise() {
        let mut values = [1.0, 2.0];
        add_gaussian_noise(&mut values, 0.0, &mut rng(1, 0)).unwrap();
        assert_eq!(values, [1.0, 2.0]);
    }

    #[test]
    fn impossible_deviations_are_errors() {
        for sd in [-1.0, f64::INFINITY, f64::NAN] {
            assert!(add_gaussian_noise(&mut [0.0], sd, &mut rng(1, 0)).is_err());
        }
    }
}
