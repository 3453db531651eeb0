//! What drives the machine beside what was recorded.
//!
//! The machine got `u_k + n_k` where `u_k` was recorded, and a random force w(t) pushed each
//! channel:
//!
//! ```text
//! n_k ~ N(0, sigma_u^2) each sample,     E w(t) w(t') = sigma_w^2 delta(t - t')
//! ```
//!
//! Beside that, what an output shows may be further from the truth than its noise from sample to
//! sample tells: a filter before the log takes away what is fast, and leaves the rest.

use super::Problem;

/// How large the noise is that drives the machine.
#[derive(Clone, Debug, PartialEq)]
pub struct ProcessNoise {
    /// Standard deviation sigma_u of each input, in its unit.
    pub inputs: Vec<f64>,
    /// Intensity sigma_w of the force on each channel, in its unit times the root of a second.
    pub forces: Vec<f64>,
    /// Standard deviation of each output's noise, in units of what its samples show.
    pub outputs: Vec<f64>,
}

impl ProcessNoise {
    /// None at all.
    #[must_use]
    pub fn none(problem: &Problem) -> Self {
        let model = problem.model;
        Self {
            inputs: vec![0.0; model.inputs.len()],
            forces: vec![0.0; model.channels()],
            outputs: vec![1.0; problem.dataset.outputs.len()],
        }
    }

    /// What the model states of its inputs alone.
    #[must_use]
    pub fn stated(problem: &Problem) -> Self {
        let stated = problem.model.inputs.iter().map(|input| input.noise.unwrap_or(0.0));
        Self { inputs: stated.collect(), ..Self::none(problem) }
    }

    /// What drives the machine, so many times as large.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        let all = |of: &[f64]| of.iter().map(|s| s * factor).collect();
        Self { inputs: all(&self.inputs), forces: all(&self.forces), outputs: self.outputs.clone() }
    }

    /// Whether nothing drives the machine.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.inputs.iter().chain(&self.forces).all(|s| *s == 0.0)
    }

    /// Whether no random force pushes a channel.
    #[must_use]
    pub fn pushes_nothing(&self) -> bool {
        self.forces.iter().all(|force| *force == 0.0)
    }

    /// Whether it is the same to a few hundredths, as far as a likelihood can tell.
    #[must_use]
    pub fn is_near(&self, other: &Self) -> bool {
        const NEAR: f64 = 0.05;
        let near = |(a, b): (&f64, &f64)| (a - b).abs() <= NEAR * a.max(*b);
        self.inputs.iter().zip(&other.inputs).all(near)
            && self.forces.iter().zip(&other.forces).all(near)
            && self.outputs.iter().zip(&other.outputs).all(near)
    }

    /// The columns of a map of `width` states, forces and inputs that are driven over a step of
    /// `dt`, each with its variance there.
    pub(super) fn driven(&self, width: usize, dt: f64) -> Vec<(usize, f64)> {
        let all = (0..self.drivers()).map(|k| (width + k, self.variance(k, dt)));
        all.filter(|(_, q)| *q > 0.0).collect()
    }

    /// Number of forces and inputs.
    pub(super) fn drivers(&self) -> usize {
        self.forces.len() + self.inputs.len()
    }

    /// Variance of a force, or, after all of those, of an input, over a step of `dt`.
    pub(super) fn variance(&self, driver: usize, dt: f64) -> f64 {
        match driver.checked_sub(self.forces.len()) {
            None => self.forces[driver].powi(2) / dt,
            Some(j) => self.inputs[j].powi(2),
        }
    }
}
