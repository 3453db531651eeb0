//! Linear regression with Gaussian priors and its evidence in closed form.
//!
//! For a whitened target `y = X b + e`, `e ~ N(0, I)`, and `b ~ N(m, diag(s)^2)`,
//!
//! ```text
//! log p(y) = - |y - X b^|^2 / 2 - |(b^ - m)/s|^2 / 2 - log det(S H S) / 2 - log det(L L^T) / 2 - n log(2 pi) / 2
//! H = X^T X + S^-2,   b^ = H^-1 (X^T y + S^-2 m)
//! ```
//!
//! with L the factor that whitened y and X.

use nalgebra::{DMatrix, DVector};

/// Prior of one coefficient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normal {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub sd: f64,
}

/// A fitted linear model.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// Log evidence (nats).
    pub log: f64,
    /// Posterior means of the coefficients.
    pub coefficients: Vec<f64>,
    /// Posterior covariance of the coefficients.
    pub covariance: DMatrix<f64>,
    /// Sum of squares of the whitened residual.
    pub chi2: f64,
}

impl Evidence {
    /// Posterior standard deviation of a coefficient.
    #[must_use]
    pub fn std(&self, k: usize) -> f64 {
        self.covariance[(k, k)].max(0.0).sqrt()
    }
}

/// Fit whitened `columns` to the whitened `target`. `None` when the numbers are not finite.
#[must_use]
pub fn regress(
    target: &[f64],
    columns: &[&[f64]],
    priors: &[Normal],
    log_determinant: f64,
) -> Option<Evidence> {
    let n = target.len() as f64;
    let p = columns.len();
    // Coefficients in units of their prior: the matrices stay near one.
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let mut h = DMatrix::identity(p, p);
    let mut g = DVector::zeros(p);
    for i in 0..p {
        for j in 0..=i {
            let value = dot(columns[i], columns[j]) * priors[i].sd * priors[j].sd;
            h[(i, j)] += value;
            if i != j {
                h[(j, i)] += value;
            }
        }
        g[i] = dot(columns[i], target) * priors[i].sd + priors[i].mean / priors[i].sd;
    }
    let factor = h.cholesky()?;
    let scaled = factor.solve(&g);
    let coefficients: Vec<f64> = (0..p).map(|i| scaled[i] * priors[i].sd).collect();
    let mut residual = target.to_vec();
    for (column, b) in columns.iter().zip(&coefficients) {
        for (r, x) in residual.iter_mut().zip(*column) {
            *r -= b * x;
        }
    }
    let chi2 = dot(&residual, &residual);
    let pull = |i: usize| ((coefficients[i] - priors[i].mean) / priors[i].sd).powi(2);
    let penalty: f64 = (0..p).map(pull).sum();
    let log_h: f64 = 2.0 * factor.l().diagonal().iter().map(|d| d.ln()).sum::<f64>();
    let log = -0.5 * (chi2 + penalty + log_h + log_determinant + n * std::f64::consts::TAU.ln());
    let mut covariance = factor.inverse();
    for i in 0..p {
        for j in 0..p {
            covariance[(i, j)] *= priors[i].sd * priors[j].sd;
        }
    }
    log.is_finite().then_some(Evidence { log, coefficients, covariance, chi2 })
}

/// How much more slowly than white noise residuals vary, at least 1: the variance of means
/// over blocks times the block's length, relative to that of single samples, at the block
/// length where it is largest. What is correlated over c samples is worth one in c of them,
/// so evidence is divided by this number.
pub fn colour<'a>(series: impl Iterator<Item = &'a [f64]> + Clone) -> f64 {
    const FEWEST_BLOCKS: usize = 24;
    let total: usize = series.clone().map(<[f64]>::len).sum();
    let squares: f64 = series.clone().flatten().map(|r| r * r).sum();
    if squares == 0.0 {
        return 1.0;
    }
    let variance = squares / total as f64;
    let mut largest = 1.0f64;
    let mut block = 8;
    while block * FEWEST_BLOCKS <= total {
        let (mut sum, mut blocks) = (0.0, 0usize);
        for r in series.clone() {
            for b in r.chunks_exact(block) {
                sum += b.iter().sum::<f64>().powi(2) / block as f64;
                blocks += 1;
            }
        }
        if blocks >= FEWEST_BLOCKS {
            largest = largest.max(sum / blocks as f64 / variance);
        }
        block *= 2;
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::{Normal, colour, regress};

    #[test]
    fn colour_counts_how_many_samples_are_worth_one() {
        // Runs of 32 equal values with random signs: one in 32 samples counts.
        let sign = |k: usize| if (k * k * 7919 + 31 * k) % 101 < 50 { 1.0 } else { -1.0 };
        let slow: Vec<f64> = (0..32 * 200).map(|k| sign(k / 32)).collect();
        let c = colour(std::iter::once(slow.as_slice()));
        assert!((25.0..60.0).contains(&c), "{c}");
        let white: Vec<f64> = (0..6400).map(sign).collect();
        assert!(colour(std::iter::once(white.as_slice())) < 3.0);
    }

    /// Two data, one coefficient: the evidence is a bivariate normal density that can be
    /// written down.
    #[test]
    fn the_evidence_is_the_density_of_the_data() {
        let (x, y) = ([0.7, -1.1], [0.4, 0.9]);
        let prior = Normal { mean: 0.3, sd: 2.0 };
        let fit = regress(&y, &[&x], &[prior], 0.0).expect("finite");
        // y ~ N(m x, I + s^2 x x^T).
        let s2 = prior.sd * prior.sd;
        let (a, b, d) = (1.0 + s2 * x[0] * x[0], s2 * x[0] * x[1], 1.0 + s2 * x[1] * x[1]);
        let det = a * d - b * b;
        let r = [y[0] - prior.mean * x[0], y[1] - prior.mean * x[1]];
        let quad = (d * r[0] * r[0] - 2.0 * b * r[0] * r[1] + a * r[1] * r[1]) / det;
        let expected = -0.5 * (quad + det.ln()) - std::f64::consts::TAU.ln();
        assert!((fit.log - expected).abs() < 1e-12, "{} {expected}", fit.log);
    }
}
