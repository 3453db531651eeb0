//! Whether a function differs, and over which variables.

use super::functions::{Entry, rms};
use serde::Serialize;

/// Differences below this share of what moves the channel are no matter: identification from few samples is no better.
pub const FLOOR: f64 = 0.01;
/// A function differs where its difference is this many times its standard deviation, root mean square.
const DIFFERS: f64 = 3.0;
/// Bins of a variable, each of as many states.
const BINS: usize = 12;
/// Share of the difference that a variable must tell to be named.
const TOLD: f64 = 0.5;

/// Where a difference is.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Place {
    /// Root mean square of the difference over its standard deviation.
    pub significance: f64,
    /// Whether that is more than chance.
    pub differs: bool,
    /// Root mean square of what was simulated.
    pub simulated_rms: f64,
    /// Root mean square of the difference.
    pub difference_rms: f64,
    /// Root mean square of its standard deviation.
    pub std_rms: f64,
    /// Share of the difference that a constant tells.
    pub constant: f64,
    /// Share that a function of one variable alone tells, the largest first.
    pub explained_by: Vec<Share>,
    /// The variables that tell it: none where a constant does, or where it takes several at once.
    pub depends_on: Vec<String>,
}

/// What one variable tells.
#[derive(Clone, Debug, Serialize)]
pub struct Share {
    /// The variable.
    pub variable: String,
    /// Share of the difference.
    pub share: f64,
}

/// Weights of the states: inverse variances, with the floor.
pub fn weights(entry: &Entry) -> Vec<f64> {
    let floor = (FLOOR * entry.scale).powi(2).max(f64::MIN_POSITIVE);
    entry.std.iter().map(|s| 1.0 / (s * s + floor)).collect()
}

impl Place {
    /// Of a function at these states, whose variables have these names.
    #[must_use]
    pub fn of(entry: &Entry, states: &[Vec<f64>], variables: &[String]) -> Self {
        let (difference, weights) = (entry.difference(), weights(entry));
        let squares = |about: &dyn Fn(usize) -> f64| -> f64 {
            (0..difference.len()).map(|k| weights[k] * (difference[k] - about(k)).powi(2)).sum()
        };
        let whole = squares(&|_| 0.0);
        let significance = (whole / difference.len() as f64).sqrt();
        let told = |groups: Vec<usize>| {
            let means = means(&groups, &difference, &weights);
            1.0 - squares(&|k| means[groups[k]]) / whole.max(f64::MIN_POSITIVE)
        };
        let constant = told(vec![0; states.len()]);
        let share = |(i, name): (usize, &String)| Share {
            variable: name.clone(),
            share: told(bins(states, i)),
        };
        let mut explained_by: Vec<Share> = variables.iter().enumerate().map(share).collect();
        explained_by.sort_by(|a, b| b.share.total_cmp(&a.share));
        // A constant is a function of every variable: what counts is what it leaves.
        let beyond = |s: &Share| s.share - constant > TOLD * (1.0 - constant);
        let depends_on = match constant > 1.0 - 0.5 * (1.0 - TOLD) {
            true => vec![],
            false => {
                let best = explained_by.first().filter(|s| beyond(s));
                best.map(|s| s.variable.clone()).into_iter().collect()
            }
        };
        Self {
            significance,
            differs: significance > DIFFERS,
            simulated_rms: rms(&entry.simulated),
            difference_rms: rms(&difference),
            std_rms: rms(&entry.std),
            constant,
            explained_by,
            depends_on,
        }
    }
}

/// The bin of every state along a variable, of equally many states each.
fn bins(states: &[Vec<f64>], variable: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..states.len()).collect();
    order.sort_by(|&a, &b| states[a][variable].total_cmp(&states[b][variable]));
    let mut bin = vec![0; states.len()];
    order.iter().enumerate().for_each(|(rank, &k)| bin[k] = rank * BINS / states.len());
    bin
}

/// Weighted mean of every group.
fn means(groups: &[usize], values: &[f64], weights: &[f64]) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); BINS];
    for ((&group, value), weight) in groups.iter().zip(values).zip(weights) {
        sums[group].0 += weight * value;
        sums[group].1 += weight;
    }
    sums.into_iter().map(|(sum, weight)| sum / weight.max(f64::MIN_POSITIVE)).collect()
}
