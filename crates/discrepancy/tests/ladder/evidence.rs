//! Evidence by Laplace's method against the integral that it stands for, sampled over all that is fitted: parameters of
//! the model and of the effect within their bounds, and the state that the recording begins in.

use crate::machines::{Bench, ON_CARRIAGE, ON_PENDULUM, ON_SERVO, ON_TANKS};
use lacuna_discrepancy::Dataset;
use lacuna_discrepancy::likelihood::{Effort, Fit, Hypothesis, Problem};
use lacuna_excitation::rng;
use lacuna_plants::{SampledInput, System, rk4};
use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_distr::{ChiSquared, Distribution, StandardNormal};
use rayon::prelude::*;

/// Draws of a posterior.
const DRAWS: u64 = 3000;
/// Degrees of freedom of the proposal: wide tails, so that no weight runs away.
const TAILS: f64 = 6.0;
/// To the optimum.
const EFFORT: Effort = Effort { steps: 60, least: 1e-8, undamped: false };

/// A hypothesis about a problem of one recording, judged by a simulation of its own.
struct Posterior<'p> {
    problem: &'p Problem<'p>,
    hypothesis: Hypothesis,
}

impl Posterior<'_> {
    /// What is fitted: theta, then the state at the beginning.
    fn residuals(&self, all: &[f64]) -> Option<Vec<f64>> {
        let (theta, start) = all.split_at(self.hypothesis.free.len());
        let mut h = self.hypothesis.clone();
        h.set(theta);
        let (model, o) = (self.problem.model, &self.problem.dataset.recordings[0]);
        let inputs = model.effective_inputs(&o.times, &o.commands);
        let input = SampledInput { times: &o.times, values: &inputs, hold: model.hold };
        let system = System::with(model, &h.parameters, &h.effects);
        let begin = system.at_rest(start);
        let step = (o.times[1] - o.times[0]) / 4.0;
        let motion = rk4(&system, &begin, &input, &o.times, step).ok()?;
        let mut residuals = vec![];
        for (k, weight) in self.problem.weights.iter().enumerate() {
            let state = model.coordinate_index(k);
            let series = o.outputs[k].iter().enumerate().filter(|(_, y)| y.is_finite());
            residuals.extend(series.map(|(s, y)| (y - motion.state(s)[state]) * weight));
        }
        Some(residuals)
    }

    /// Logarithm of likelihood times prior, up to what all hypotheses share; none out of bounds.
    fn log_density(&self, all: &[f64]) -> Option<f64> {
        let h = &self.hypothesis;
        if !h.free.iter().zip(all).all(|(f, x)| (f.bounds.0..=f.bounds.1).contains(x)) {
            return None;
        }
        let chi2: f64 = self.residuals(all)?.iter().map(|e| e * e).sum();
        let widths: f64 = h.free.iter().map(|f| (f.sd * std::f64::consts::TAU.sqrt()).ln()).sum();
        Some(-0.5 * (chi2 + h.penalty(all)) - widths - h.log_prior_mass())
    }

    /// Precision of all that is fitted at a point, by differences.
    fn precision(&self, at: &[f64], widths: &[f64]) -> DMatrix<f64> {
        let columns: Vec<DVector<f64>> = (0..at.len())
            .map(|i| {
                let moved = |by: f64| {
                    let mut x = at.to_vec();
                    x[i] += by;
                    DVector::from_vec(self.residuals(&x).expect("it runs"))
                };
                let h = 0.01 * widths[i];
                (moved(h) - moved(-h)) / (2.0 * h)
            })
            .collect();
        let jacobian = DMatrix::from_columns(&columns);
        let mut precision = jacobian.transpose() * jacobian;
        for (i, f) in self.hypothesis.free.iter().enumerate() {
            precision[(i, i)] += 1.0 / (f.sd * f.sd);
        }
        precision
    }

    /// Log of the integral over all that is fitted, with its standard error: importance sampling from Student's
    /// distribution about `at`.
    fn log_integral(&self, at: &[f64], widths: &[f64], seed: u64) -> (f64, f64) {
        let n = at.len();
        let factor = self.precision(at, widths).cholesky().expect("it is definite").l();
        let log_determinant: f64 = factor.diagonal().iter().map(|d| d.ln()).sum();
        let draw = |k: u64| {
            let mut rng = rng(seed, k);
            let z = DVector::from_fn(n, |_, _| rng.sample::<f64, _>(StandardNormal));
            let scale = TAILS / ChiSquared::new(TAILS).expect("degrees").sample(&mut rng);
            let z = z * scale.sqrt();
            let moved = factor.tr_solve_lower_triangular(&z).expect("it is regular");
            let x: Vec<f64> = at.iter().zip(&moved).map(|(a, d)| a + d).collect();
            let proposed = -0.5 * (TAILS + n as f64) * (z.norm_squared() / TAILS).ln_1p();
            self.log_density(&x).map(|log| log - proposed)
        };
        let logs: Vec<f64> = (0..DRAWS).into_par_iter().filter_map(draw).collect();
        let top = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let weights: Vec<f64> = logs.iter().map(|l| (l - top).exp()).collect();
        let mean = weights.iter().sum::<f64>() / DRAWS as f64;
        let square = weights.iter().map(|w| w * w).sum::<f64>() / DRAWS as f64;
        let error = (square / (mean * mean) - 1.0).max(0.0).sqrt() / (DRAWS as f64).sqrt();
        // The proposal's own normalisation.
        let n = n as f64;
        let norm = libm::lgamma(0.5 * TAILS) + 0.5 * n * (TAILS * std::f64::consts::PI).ln()
            - libm::lgamma(0.5 * (TAILS + n))
            - log_determinant;
        (top + mean.ln() + norm, error)
    }
}

/// Log of the integral of a fitted hypothesis, with its standard error.
fn sampled(problem: &Problem, fit: &Fit, seed: u64) -> (f64, f64) {
    let hypothesis = fit.hypothesis.clone();
    let start = fit.windowed.starts[0].machine[0].clone();
    let mut at = hypothesis.theta();
    let mut widths = fit.std(1.0);
    widths.extend(start.iter().map(|_| 1.0 / problem.weights[0]));
    at.extend(start);
    Posterior { problem, hypothesis }.log_integral(&at, &widths, seed)
}

/// Log Bayes factors (nats) of an effect that is there, by Laplace's method and sampled, with the standard error of
/// the latter.
fn bayes_factors(bench: Bench, effect: &str, seed: u64) -> (f64, f64, f64) {
    let (model, machine) = (bench.model(), bench.truth(effect));
    let dataset = Dataset::new(&model, &bench.record(&machine, seed, 1)).expect("a dataset");
    let problem = Problem::new(&model, &dataset).expect("a problem");
    let plain = Fit::begin(&problem, Hypothesis::of(&model), 0).expect("a fit");
    let plain = plain.refit(plain.hypothesis.clone(), EFFORT).expect("a fit");
    let effect = machine.effects[0].clone();
    let scales = problem.scales_of(&effect);
    let with = plain.refit(plain.hypothesis.clone().with(effect, &scales), EFFORT).expect("a fit");
    let laplace = with.log_evidence(1.0) - plain.log_evidence(1.0);
    let (a, da) = sampled(&problem, &with, seed);
    let (b, db) = sampled(&problem, &plain, seed);
    (laplace, a - b, da.hypot(db))
}

#[test]
fn evidence_is_what_sampling_says() {
    let short = |bench: Bench, samples, noise| Bench { samples, noise, ..bench };
    let pendulum = short(ON_PENDULUM, 300, 1e-2);
    let carriage = short(ON_CARRIAGE, 300, 3e-3);
    let tanks = short(ON_TANKS, 200, 1e-2);
    let servo = short(ON_SERVO, 200, 2e-3);
    let cases = [
        (pendulum, "cubic_stiffness", "stiffness = 0.1"),
        (pendulum, "quadratic_drag", "coefficient = 0.001"),
        (pendulum, "coulomb_friction", "magnitude = 0.012\nsmoothing_velocity = 0.05"),
        (pendulum, "constant_force", "force = 0.02"),
        (pendulum, "quadratic_stiffness", "stiffness = 0.05"),
        (carriage, "linear_stiffness", "stiffness = 0.3"),
        (carriage, "quadratic_drag", "coefficient = 0.3"),
        (tanks, "linear_loss", "rate = 0.002"),
        (servo, "constant_force", "force = 0.02"),
        (servo, "viscous_friction", "coefficient = 0.3"),
    ];
    let mut factors = vec![];
    for (k, (bench, class, values)) in cases.into_iter().enumerate() {
        let (machine, channel) = (bench.model().name, bench.model().channel_name(0).to_owned());
        let effect = format!("[[effect]]\nclass = \"{class}\"\nchannel = \"{channel}\"\n{values}");
        let (laplace, integral, error) = bayes_factors(bench, &effect, 200 + k as u64);
        let told = format!("{machine}, {class}: {laplace} nats, sampled {integral} +- {error}");
        assert!(error < 0.15 && (laplace - integral).abs() < 0.5, "{told}");
        factors.push(integral);
    }
    // Among them are effects that the recordings hardly show, and others that are beyond doubt.
    assert!(factors.iter().any(|f| *f < 1.0) && factors.iter().any(|f| *f > 100.0), "{factors:?}");
}
