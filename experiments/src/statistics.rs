//! Summaries of errors over trials and over evaluation points.

use serde::{Deserialize, Serialize};

/// Summary of a quantity over trials.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct OverTrials {
    /// Arithmetic mean.
    pub mean: f64,
    /// Sample standard deviation (divisor n - 1); 0 for a single trial.
    pub sd: f64,
    /// Median.
    pub median: f64,
}

impl OverTrials {
    /// Summarise one value a trial; all NaN when there is none.
    pub fn of(values: &[f64]) -> Self {
        let mean = mean(values);
        let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
        let sd = (squares / values.len().saturating_sub(1).max(1) as f64).sqrt();
        Self { mean, sd, median: quantile(values, 0.5) }
    }
}

/// Summary of an error over evaluation points.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct OverPoints {
    /// Greatest value.
    pub max: f64,
    /// Median.
    pub median: f64,
    /// Arithmetic mean.
    pub mean: f64,
}

impl OverPoints {
    /// Summarise one value a point; all NaN when there is none.
    pub fn of(values: &[f64]) -> Self {
        Self { max: quantile(values, 1.0), median: quantile(values, 0.5), mean: mean(values) }
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The `q`-quantile, `0 <= q <= 1`, with linear interpolation between the order statistics; NaN
/// when there are no values.
pub fn quantile(values: &[f64], q: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let place = q * last as f64;
    let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    below + (place - place.floor()) * (above - below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summaries_of_known_values() {
        let values = [4.0, 1.0, 2.0, 5.0];
        let trials = OverTrials::of(&values);
        assert_eq!((trials.mean, trials.median), (3.0, 3.0));
        // Squares 1 + 4 + 1 + 4 over n - 1 = 3.
        assert!((trials.sd - (10.0_f64 / 3.0).sqrt()).abs() < 1e-15);
        assert_eq!(OverPoints::of(&values), OverPoints { max: 5.0, median: 3.0, mean: 3.0 });
        assert_eq!(OverTrials::of(&[7.0]), OverTrials { mean: 7.0, sd: 0.0, median: 7.0 });
    }

    #[test]
    fn quantiles_interpolate() {
        let values = [3.0, 1.0, 2.0];
        assert_eq!(quantile(&values, 0.0), 1.0);
        assert_eq!(quantile(&values, 0.25), 1.5);
        assert_eq!(quantile(&values, 1.0), 3.0);
        assert!(quantile(&[], 0.5).is_nan());
    }
}
