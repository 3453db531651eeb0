//! What residuals that are not white are worth.

/// Blocks that estimate a variance well enough to decide by.
pub const RELIABLE: usize = 24;
/// Blocks that tell its order of magnitude.
pub const ROUGH: usize = 6;

/// How much more slowly than white noise residuals vary, at least 1: the variance of means
/// over blocks times the block's length, relative to that of single samples, at the block
/// length where it is largest. What is correlated over c samples is worth one in c of them,
/// so evidence is divided by this number. A series holds at least `fewest` of the longest blocks.
pub fn colour<'a>(series: impl Iterator<Item = &'a [f64]> + Clone, fewest: usize) -> f64 {
    let total: usize = series.clone().map(<[f64]>::len).sum();
    let squares: f64 = series.clone().flatten().map(|r| r * r).sum();
    if squares == 0.0 {
        return 1.0;
    }
    let variance = squares / total as f64;
    let mut largest = 1.0f64;
    let mut block = 8;
    while block * fewest <= total {
        let (mut sum, mut blocks) = (0.0, 0usize);
        for r in series.clone() {
            for b in r.chunks_exact(block) {
                sum += b.iter().sum::<f64>().powi(2) / block as f64;
                blocks += 1;
            }
        }
        if blocks >= fewest {
            largest = largest.max(sum / blocks as f64 / variance);
        }
        block *= 2;
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::{RELIABLE, colour};

    #[test]
    fn colour_counts_how_many_samples_are_worth_one() {
        // Runs of 32 equal values with random signs: one in 32 samples counts.
        let sign = |k: usize| if (k * k * 7919 + 31 * k) % 101 < 50 { 1.0 } else { -1.0 };
        let slow: Vec<f64> = (0..32 * 200).map(|k| sign(k / 32)).collect();
        let c = colour(std::iter::once(slow.as_slice()), RELIABLE);
        assert!((25.0..60.0).contains(&c), "{c}");
        let white: Vec<f64> = (0..6400).map(sign).collect();
        assert!(colour(std::iter::once(white.as_slice()), RELIABLE) < 3.0);
    }
}
