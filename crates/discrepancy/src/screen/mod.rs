//! Screening: what every candidate would gain, judged by the likelihood linearised along the
//! fitted trajectory.
//!
//! A small force `sum_k a_k b_k(x(t))` changes the outputs by `sum_k a_k Gamma_k`, where
//!
//! ```text
//! Gamma_k(t) = int_0^t G(t, tau) b_k(x(tau)) dtau
//! ```
//!
//! is the occupation functional of the basis with the Green's function G of the linearised
//! equations as its test function ([`crate::likelihood::maps`]). The residual is regressed on Gamma, on the
//! derivatives by theta and on those by every window's states; the latter are eliminated, and
//! the evidence of the amplitudes `a ~ N(0, S^2)` follows in closed form:
//!
//! ```text
//! gain = g^T c / 2 - log det(H) / 2,   H = I + S G S / s,   c = H^-1 g
//! ```

mod columns;
mod curves;
mod local;
mod lost;
pub(crate) mod servo;
pub(crate) mod structure;
mod surface;

use crate::candidates::{Candidate, Term};
use crate::likelihood::{Fit, FitError, Problem};
use crate::probability::log_sum_exp;
pub(crate) use columns::sensed;
pub use curves::Over;
use lacuna_effects::{Law, Prior};
use local::{Along, along};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;
use structure::slopes;

/// A fit, linearised.
pub struct Screen<'p> {
    problem: &'p Problem<'p>,
    fit: &'p Fit<'p>,
    recordings: Vec<Along>,
    /// Normal equations of theta in units of its prior, states eliminated.
    theta: DMatrix<f64>,
    gradient: DVector<f64>,
    /// Evidence of theta alone; none where its normal equations are not positive.
    alone: Option<f64>,
    inflation: f64,
}

/// Normal equations of a term's amplitudes.
#[derive(Clone)]
pub struct Amplitudes {
    own: DMatrix<f64>,
    theta: DMatrix<f64>,
    gradient: DVector<f64>,
}

/// A term and what it would gain.
#[derive(Clone, Debug)]
pub struct Scored {
    /// The effect with its shape.
    pub term: Term,
    /// Nats.
    pub gain: f64,
    /// Amplitudes.
    pub amplitudes: Vec<f64>,
    /// Their standard deviations.
    pub std: Vec<f64>,
    /// The fitted values of theta beside them.
    pub theta: Vec<f64>,
}

impl<'p> Screen<'p> {
    /// Linearise a fit.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn new(fit: &'p Fit<'p>) -> Result<Self, FitError> {
        Self::of(fit, false)
    }

    /// The same, with forces along the measured motion: where the fit's own is far from it, as that of a model which
    /// does not stick where the machine does, a force along it says little of the machine's.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn along_measured(fit: &'p Fit<'p>) -> Result<Self, FitError> {
        Self::of(fit, true)
    }

    fn of(fit: &'p Fit<'p>, measured: bool) -> Result<Self, FitError> {
        let (problem, runs) = (fit.problem, fit.runs());
        let recordings: Result<Vec<Along>, FitError> =
            runs.par_iter().enumerate().map(|(r, run)| along(fit, r, run, measured)).collect();
        let recordings = recordings?;
        let free = &fit.hypothesis.free;
        let p = free.len();
        let (mut theta, mut gradient) = (DMatrix::zeros(p, p), DVector::zeros(p));
        for local in recordings.iter().flat_map(|a| &a.windows) {
            theta += &local.eliminated.theta;
            gradient += &local.eliminated.gradient;
        }
        let inflation = fit.inflation();
        let values = fit.hypothesis.theta();
        for i in 0..p {
            gradient[i] =
                gradient[i] * free[i].sd / inflation - (values[i] - free[i].mean) / free[i].sd;
            for j in 0..p {
                theta[(i, j)] *= free[i].sd * free[j].sd / inflation;
            }
            theta[(i, i)] += 1.0;
        }
        let alone = Posterior::of(theta.clone(), &gradient).map(|posterior| posterior.gain);
        Ok(Self { problem, fit, recordings, theta, gradient, alone, inflation })
    }

    /// Every candidate with its best shape, the one that gains most first. What a candidate gains
    /// is summed over its shapes, each of which is as likely as the others before any data:
    /// `log mean exp gain`. Those that nobody waits for any more are left out.
    #[must_use]
    pub fn score(&self, candidates: &[Candidate]) -> Vec<Scored> {
        let mut best: Vec<Scored> = candidates
            .par_iter()
            .filter_map(|c| {
                if self.problem.is_cancelled() {
                    return None;
                }
                let scales = self.problem.scales(c.effect, c.channel, c.other);
                let shapes = c.shapes(&scales);
                let count = shapes.len() as f64;
                let terms: Vec<Term> =
                    shapes.into_iter().map(|shape| Term { candidate: *c, shape }).collect();
                let tried =
                    terms.par_chunks(c.at_once(terms.len())).flat_map_iter(|some| self.gains(some));
                let tried: Vec<Scored> = tried.filter(|s| s.gain.is_finite()).collect();
                let gain = log_sum_exp(tried.iter().map(|s| s.gain)) - count.ln();
                let best = tried.into_iter().max_by(|a, b| a.gain.total_cmp(&b.gain))?;
                let best = self.refined(&best.term).unwrap_or(best);
                Some(Scored { gain, ..best })
            })
            .collect();
        best.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        best
    }

    /// What one term gains.
    #[must_use]
    pub fn gain(&self, term: Term) -> Option<Scored> {
        self.gains(&[term]).pop()
    }

    /// What each of several terms of one candidate gains; those that cannot be are left out.
    fn gains(&self, terms: &[Term]) -> Vec<Scored> {
        let all = terms.iter().zip(self.amplitudes(terms));
        all.filter_map(|(term, normal)| self.scored(term, &normal?)).collect()
    }

    fn scored(&self, term: &Term, normal: &Amplitudes) -> Option<Scored> {
        let (sd, magnitude) = priors(self.problem, &term.candidate);
        let Solved { gain, amplitudes, covariance, theta } = self.solve(normal, &sd)?;
        let std = (0..amplitudes.len()).map(|i| covariance[(i, i)].max(0.0).sqrt()).collect();
        let wrong = magnitude && amplitudes.iter().sum::<f64>() < 0.0;
        // The prior of a magnitude has its mass on one side.
        let sides = if magnitude { amplitudes.len() as f64 } else { 0.0 };
        let gain = gain + sides * std::f64::consts::LN_2;
        (!wrong).then(|| Scored { term: term.clone(), gain, amplitudes, std, theta })
    }

    fn solve(&self, a: &Amplitudes, sd: &[f64]) -> Option<Solved> {
        let (p, c) = (self.theta.nrows(), sd.len());
        let Posterior { gain, mean, factor } = self.posterior(a, sd)?;
        let inverse = factor.inverse();
        let amplitudes = (0..c).map(|i| mean[p + i] * sd[i]).collect();
        let covariance = DMatrix::from_fn(c, c, |i, j| inverse[(p + i, p + j)] * sd[i] * sd[j]);
        let h = &self.fit.hypothesis;
        let moved = h.free.iter().zip(h.theta()).zip(mean.iter());
        let theta = moved
            .map(|((f, value), step)| (value + step * f.sd).clamp(f.bounds.0, f.bounds.1))
            .collect();
        Some(Solved { gain, amplitudes, covariance, theta })
    }

    /// Of parameters and amplitudes with these prior standard deviations; the gain is that of the
    /// amplitudes.
    fn posterior(&self, a: &Amplitudes, sd: &[f64]) -> Option<Posterior> {
        let (p, c) = (self.theta.nrows(), sd.len());
        let free = &self.fit.hypothesis.free;
        let mut h = DMatrix::identity(p + c, p + c);
        h.view_mut((0, 0), (p, p)).copy_from(&self.theta);
        let mut g = DVector::zeros(p + c);
        g.rows_mut(0, p).copy_from(&self.gradient);
        for i in 0..c {
            g[p + i] = a.gradient[i] * sd[i] / self.inflation;
            for j in 0..c {
                h[(p + i, p + j)] += a.own[(i, j)] * sd[i] * sd[j] / self.inflation;
            }
            for j in 0..p {
                let value = a.theta[(i, j)] * sd[i] * free[j].sd / self.inflation;
                h[(p + i, j)] = value;
                h[(j, p + i)] = value;
            }
        }
        let with = Posterior::of(h, &g)?;
        Some(Posterior { gain: with.gain - self.alone?, ..with })
    }

    /// Normal equations of the amplitudes of several terms of one candidate, summed over all
    /// recordings; none for a term that changes what is not finite.
    fn amplitudes(&self, terms: &[Term]) -> Vec<Option<Amplitudes>> {
        if let Law::Structure(law) = terms[0].candidate.effect.law {
            let numbers = self.numbers(&terms[0].candidate);
            let of = |t: &Term| Some(numbers.as_ref()?.through(&slopes(law, &t.shape)));
            return terms.iter().map(of).collect();
        }
        let along = self.recordings.par_iter().map(|along| self.amplitudes_along(terms, along));
        let parts: Vec<Vec<Amplitudes>> = along.collect();
        let plus = |a: Vec<Amplitudes>, b| a.into_iter().zip(b).map(|(a, b)| a.plus(b)).collect();
        let sums = parts.into_iter().reduce(plus).unwrap_or_default();
        sums.into_iter().map(|a| a.is_finite().then_some(a)).collect()
    }
}

/// Prior standard deviations of a candidate's amplitudes, and whether they are magnitudes, which cannot
/// be negative.
pub(crate) fn priors(problem: &Problem, candidate: &Candidate) -> (Vec<f64>, bool) {
    let &Candidate { effect, channel, other } = candidate;
    let priors = (effect.priors)(&problem.scales(effect, channel, other));
    let sd = |p: &Prior| match *p {
        Prior::Normal { sd, .. } => sd,
        Prior::LogNormal { .. } | Prior::Fixed => 1.0,
    };
    match effect.law {
        Law::Force(_) | Law::Structure(_) => {
            let own = &priors[..candidate.amplitudes()];
            let positive =
                own.iter().all(|p| matches!(p, Prior::Normal { low, .. } if *low >= 0.0));
            (own.iter().map(sd).collect(), positive)
        }
        // How much of the law acts: none at 0, all at 1.
        Law::Input(_) => (vec![1.0], true),
        Law::Sensor(_) => {
            let positive = matches!(priors[0], Prior::Normal { low, .. } if low == 0.0);
            (vec![sd(&priors[0])], positive)
        }
    }
}

impl Amplitudes {
    /// Those of both of two recordings.
    fn plus(mut self, other: Self) -> Self {
        self.own += other.own;
        self.theta += other.theta;
        self.gradient += other.gradient;
        self
    }

    /// Those of `z`, where the amplitudes are `root z`.
    fn through(&self, root: &DMatrix<f64>) -> Self {
        Self {
            own: root.tr_mul(&(&self.own * root)),
            theta: root.tr_mul(&self.theta),
            gradient: root.tr_mul(&self.gradient),
        }
    }

    fn is_finite(&self) -> bool {
        self.own.iter().chain(&self.theta).all(|x| x.is_finite())
    }
}

/// What a term's amplitudes are, and theta beside them.
struct Solved {
    gain: f64,
    amplitudes: Vec<f64>,
    covariance: DMatrix<f64>,
    theta: Vec<f64>,
}

/// Belief about parameters and amplitudes in units of their priors.
struct Posterior {
    /// Nats of evidence.
    gain: f64,
    mean: DVector<f64>,
    factor: Cholesky<f64, Dyn>,
}

impl Posterior {
    /// From normal equations: none where they are not positive.
    fn of(h: DMatrix<f64>, g: &DVector<f64>) -> Option<Self> {
        let factor = h.cholesky()?;
        let mean = factor.solve(g);
        let log: f64 = factor.l_dirty().diagonal().map(f64::ln).sum();
        Some(Self { gain: 0.5 * mean.dot(g) - log, mean, factor })
    }
}
