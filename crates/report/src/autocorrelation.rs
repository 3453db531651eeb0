//! How far residuals are white.

/// Largest lag as a share of a series, and lags at least and at most.
const SHARE: usize = 20;
const LAGS: (usize, usize) = (20, 100);

/// Autocorrelation of a series at lags from zero on, in samples:
///
/// ```text
/// rho(k) = mean((e_i - m)(e_{i+k} - m)) / mean((e_i - m)^2),   m = mean(e),
/// ```
///
/// each mean over the samples where it is known. White noise of `n` samples stays within
/// +-1.96 / sqrt(n) at 95 % of the lags above zero.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Autocorrelation {
    /// Lag (samples) and correlation there.
    pub at: Vec<(usize, f64)>,
    /// Half width of the band of white noise.
    pub white: f64,
}

impl Autocorrelation {
    /// None for a series that is constant or too short.
    pub(crate) fn of(series: &[f64]) -> Option<Self> {
        let known = series.iter().filter(|v| v.is_finite());
        let n = known.clone().count();
        let mean = known.clone().sum::<f64>() / n.max(1) as f64;
        let variance = known.map(|v| (v - mean).powi(2)).sum::<f64>() / n.max(1) as f64;
        if n < 2 * LAGS.0 || variance <= 0.0 || !variance.is_finite() {
            return None;
        }
        let last = (n / SHARE).max(LAGS.0);
        let lags = (0..=last).step_by(last.div_ceil(LAGS.1));
        let at = lags.map(|k| (k, covariance(series, mean, k) / variance)).collect();
        Some(Self { at, white: 1.96 / (n as f64).sqrt() })
    }

    /// Share of the lags above zero that lie within the band.
    pub(crate) fn inside(&self) -> f64 {
        let above = &self.at[1..];
        let within = above.iter().filter(|(_, rho)| rho.abs() <= self.white).count();
        within as f64 / above.len().max(1) as f64
    }
}

fn covariance(series: &[f64], mean: f64, lag: usize) -> f64 {
    let pairs = series.iter().zip(series.iter().skip(lag));
    let products = pairs.map(|(a, b)| (a - mean) * (b - mean)).filter(|p| p.is_finite());
    let (sum, n) = products.fold((0.0, 0), |(s, n), p| (s + p, n + 1));
    if n == 0 { f64::NAN } else { sum / f64::from(n) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers without pattern from the linear congruential generator of Numerical Recipes, of
    /// which the high bits serve.
    fn noise(n: usize, mut state: u32) -> Vec<f64> {
        (0..n)
            .map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(state >> 8) / f64::from(1 << 24) - 0.5
            })
            .collect()
    }

    #[test]
    fn white_noise_is_within_the_band_at_most_lags() {
        for seed in 0..5 {
            let a = Autocorrelation::of(&noise(4000, seed)).unwrap();
            assert_eq!(a.at[0], (0, 1.0));
            assert_eq!(a.at.len(), 101);
            assert!(a.inside() > 0.85, "{seed}: {}", a.inside());
        }
    }

    #[test]
    fn a_filtered_noise_has_the_correlation_of_its_filter() {
        // x_k = 0.9 x_{k-1} + e_k correlates by 0.9^lag.
        let mut x = 0.0;
        let filtered: Vec<f64> = noise(40_000, 3)
            .iter()
            .map(|e| {
                x = 0.9 * x + e;
                x
            })
            .collect();
        let a = Autocorrelation::of(&filtered).unwrap();
        let step = a.at[1].0;
        let expected = 0.9_f64.powi(step as i32);
        // The standard deviation of rho is at most sqrt(19 / n) here.
        assert!((a.at[1].1 - expected).abs() < 4.0 * (19.0_f64 / 40_000.0).sqrt(), "{:?}", a.at[1]);
    }

    #[test]
    fn gaps_are_left_out_and_constants_have_none() {
        let mut series = noise(2000, 1);
        let whole = Autocorrelation::of(&series).unwrap();
        series.iter_mut().step_by(7).for_each(|v| *v = f64::NAN);
        let gaps = Autocorrelation::of(&series).unwrap();
        assert!(gaps.white > whole.white && gaps.at[3].1.abs() < 4.0 * gaps.white);
        assert_eq!(Autocorrelation::of(&[1.0; 100]), None);
        assert_eq!(Autocorrelation::of(&noise(10, 1)), None);
    }
}
