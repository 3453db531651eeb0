//! Noise of the outputs that is correlated from sample to sample: the rival of what drives the
//! machine. Of a residual r in units of its noise,
//!
//! ```text
//! r_k = c_k + w_k,   c: E c(t) c(t') = s^2 exp(-|t - t'| / tau),   w_k ~ N(0, kappa s^2)
//! ```
//!
//! whose likelihood is that of a filter of one state, c. The scale s is at its most likely value,
//! tau and kappa are sought. Noise that came through a machine has the machine's own motion; a
//! filter, a power line or the clock of an encoder has not.

/// Noise of an output that is correlated in time.
#[derive(Clone, Copy, Debug)]
pub struct Colour {
    /// By how many nats it is ahead of white noise of the size that the samples show.
    pub gain: f64,
    /// Its deviation, in units of what the samples show.
    pub deviation: f64,
    /// Its correlation time tau, s.
    pub time: f64,
}

/// Correlation times that are tried, in sample periods.
const TIMES: [f64; 8] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 64.0, 256.0];
/// Shares kappa of white noise that are tried.
const WHITE: [f64; 4] = [1e-3, 0.03, 0.3, 3.0];
/// Refinements of the best of them: by this factor, and each by the root of the one before it.
const FACTOR: f64 = 2.0;
const REFINEMENTS: usize = 7;

/// The residual of one output along one window: times, and values in units of the noise.
pub(super) type Series = Vec<(f64, f64)>;

/// The most likely noise of an output.
pub(super) fn most_likely(series: &[Series], sample: f64) -> Colour {
    let white: f64 = series.iter().flatten().map(|(_, r)| -0.5 * r * r).sum();
    let at = |time: f64, kappa: f64| {
        let (log_likelihood, variance) = log_likelihood(series, time, kappa);
        let deviation = (variance * (1.0 + kappa)).sqrt();
        (Colour { gain: log_likelihood - white, deviation, time }, kappa)
    };
    let mut best = at(sample, 1.0);
    let better = |a: (Colour, f64), b: (Colour, f64)| if b.0.gain > a.0.gain { b } else { a };
    for time in TIMES {
        best = WHITE.iter().fold(best, |best, kappa| better(best, at(time * sample, *kappa)));
    }
    let mut step = FACTOR;
    for _ in 0..REFINEMENTS {
        let (Colour { time, .. }, kappa) = best;
        for by in [step, step.recip()] {
            best = better(better(best, at(time * by, kappa)), at(time, kappa * by));
        }
        step = step.sqrt();
    }
    best.0
}

/// Log likelihood at the most likely scale s, and s^2.
fn log_likelihood(series: &[Series], time: f64, kappa: f64) -> (f64, f64) {
    let (mut squares, mut logs, mut count) = (0.0, 0.0, 0usize);
    for window in series {
        let (mut mean, mut variance, mut last) = (0.0, 1.0, f64::NEG_INFINITY);
        for &(t, r) in window {
            let kept = (-(t - last) / time).exp();
            (mean, variance) = (kept * mean, kept * kept * (variance - 1.0) + 1.0);
            let (s, nu) = (variance + kappa, r - mean);
            mean += variance / s * nu;
            variance *= kappa / s;
            squares += nu * nu / s;
            logs += s.ln();
            (last, count) = (t, count + 1);
        }
    }
    let (n, scale) = (count as f64, squares / count.max(1) as f64);
    if scale > 0.0 { (-0.5 * (logs + n * scale.ln() + n), scale) } else { (0.0, 0.0) }
}

#[cfg(test)]
mod tests {
    use super::{Series, most_likely};
    use lacuna_excitation::{add_gaussian_noise, rng};

    /// c_{k+1} = a c_k + e_k, of unit variance.
    fn drawn(a: f64, count: usize) -> Series {
        let mut white = vec![0.0; count];
        add_gaussian_noise(&mut white, 1.0, &mut rng(7, 0)).expect("a deviation");
        let mut c = 0.0;
        let next = |(k, e): (usize, &f64)| {
            c = if k == 0 { *e } else { a * c + (1.0 - a * a).sqrt() * e };
            (k as f64 * 0.01, c)
        };
        white.iter().enumerate().map(next).collect()
    }

    /// Of an autoregression the innovations have a variance of 1 - a^2: so many nats a sample.
    #[test]
    fn an_autoregression_gains_what_its_innovations_are_smaller_by() {
        let found = most_likely(&[drawn(0.9, 4000)], 0.01);
        let expected = -0.5 * 4000.0 * (1.0f64 - 0.81).ln();
        assert!((found.gain / expected - 1.0).abs() < 0.03, "{found:?} {expected}");
        let time = -0.01 / 0.9f64.ln();
        assert!((found.time / time - 1.0).abs() < 0.15, "{found:?} {time}");
        assert!((found.deviation - 1.0).abs() < 0.1, "{found:?}");
    }

    #[test]
    fn white_noise_gains_nothing() {
        let found = most_likely(&[drawn(0.0, 4000)], 0.01);
        assert!((0.0..4.0).contains(&found.gain), "{found:?}");
    }
}
