//! Counts out of counts, with their uncertainty.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Normal quantile of a two-sided interval of 95 %.
const Z: f64 = 1.959_963_984_540_054;

/// So many of so many, with Wilson's interval of 95 % (JASA 22, 1927).
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Proportion {
    /// How many.
    pub count: usize,
    /// Of how many.
    pub of: usize,
    /// Their ratio; none of none: none.
    pub share: Option<f64>,
    /// The interval.
    pub interval: Option<[f64; 2]>,
}

impl Proportion {
    /// `count` of `of`.
    pub fn new(count: usize, of: usize) -> Self {
        if of == 0 {
            return Self { count, of, share: None, interval: None };
        }
        let n = of as f64;
        let p = count as f64 / n;
        let scale = 1.0 + Z * Z / n;
        let centre = (p + Z * Z / (2.0 * n)) / scale;
        let half = Z / scale * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
        let interval = [(centre - half).max(0.0), (centre + half).min(1.0)];
        Self { count, of, share: Some(p), interval: Some(interval) }
    }
}

impl fmt::Display for Proportion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.interval {
            Some([low, high]) => {
                let text = format!("{}/{} ({:.2}-{:.2})", self.count, self.of, low, high);
                f.pad(&text)
            }
            None => f.pad("-"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The interval holds the shares p with `|count/n - p| <= z sqrt(p (1 - p)/n)`.
    #[test]
    fn intervals_are_wilsons() {
        for (count, of) in [(8, 10), (0, 20), (20, 20), (1, 3)] {
            let n = of as f64;
            for p in Proportion::new(count, of).interval.unwrap() {
                let off = (count as f64 / n - p).abs() - Z * (p * (1.0 - p) / n).sqrt();
                assert!(off.abs() < 1e-12, "{count} of {of}: {p}");
            }
        }
        let [low, high] = Proportion::new(8, 10).interval.unwrap();
        assert!(low < 0.8 && 0.8 < high);
        assert_eq!(Proportion::new(0, 0).share, None);
    }
}
