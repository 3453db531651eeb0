//! What a robot is made of, or how it stands, as small forces on all of its joints.
//!
//! With the numbers s of its structure ([`lacuna_effects::StructureLaw`]), the equations of motion
//! `M(q; s) q'' = F(q, q', u; s)` change along a motion by
//!
//! ```text
//! sum_k s_k d(F - M q'')/ds_k
//! ```
//!
//! a force on each coordinate that is linear in s. So are the normal equations of the screening: those of the
//! numbers are found once, and those of a law with any shape, `s = T a`, follow.

use super::columns::centred;
use super::local::Along;
use super::{Amplitudes, Posterior, Scored, Screen};
use crate::candidates::{Candidate, Term};
use crate::likelihood::lanes::Lanes;
use crate::likelihood::maps::{Drive, Driven};
use crate::trajectories::SmoothedRecording;
use lacuna_effects::{AnyStructureLaw, Law, Prior};
use lacuna_numbers::{Dual, LANES, Linear, Number};
use lacuna_plants::Model;
use lacuna_plants::model::ModelEffect;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

impl Screen<'_> {
    /// Normal equations of the numbers that a candidate changes, summed over all recordings; none where they
    /// are not finite.
    pub(super) fn numbers(&self, candidate: &Candidate) -> Option<Amplitudes> {
        let places = self.problem.model.structure_of(candidate.effect.acts, candidate.channel);
        let parts = self.recordings.iter().map(|along| {
            let firsts = places.clone().step_by(LANES);
            let driven: Vec<Driven> =
                firsts.map(|first| self.group(first, &places, along)).collect();
            self.sums(places.len(), true, &driven, along).of(0, places.len())
        });
        parts.reduce(Amplitudes::plus).filter(Amplitudes::is_finite)
    }

    /// A term of structure with the shape near its own that is most probable: shapes that are tried stand
    /// further apart than the recordings can tell, and from the best of them a fit has a long way. None for
    /// other terms.
    pub(super) fn refined(&self, term: &Term) -> Option<Scored> {
        const BEGIN: f64 = 0.25;
        const END: f64 = 1e-3;
        let Law::Structure(law) = term.candidate.effect.law else { return None };
        let c = &term.candidate;
        let priors = (c.effect.priors)(&self.problem.scales(c.effect, c.channel, c.other));
        let shape = &priors[law.amplitudes()..];
        let numbers = self.numbers(c)?;
        let alone = self.beside_theta(&numbers)?;
        let sd = super::priors(self.problem, c).0;
        let log_probability = |at: &[f64]| {
            let off: f64 = at.iter().map(|x| x * x).sum();
            let own = alone.through(&slopes(law, &plain(shape, at)));
            Some(of_amplitudes(&own, &sd)? - 0.5 * off)
        };
        let mut at: Vec<f64> =
            shape.iter().zip(&term.shape).map(|(p, s)| standing(p, *s)).collect();
        let mut best = log_probability(&at)?;
        let mut step = BEGIN;
        while step > END {
            let before = best;
            for k in 0..at.len() {
                for by in [-step, step] {
                    let mut moved = at.clone();
                    moved[k] += by;
                    if let Some(there) = log_probability(&moved).filter(|there| *there > best) {
                        (best, at) = (there, moved);
                    }
                }
            }
            if best <= before {
                step *= 0.5;
            }
        }
        let refined = Term { shape: plain(shape, &at), ..term.clone() };
        self.scored(&refined, &numbers.through(&slopes(law, &refined.shape)))
    }

    /// Normal equations of amplitudes with theta eliminated, in units of the noise.
    fn beside_theta(&self, a: &Amplitudes) -> Option<Amplitudes> {
        let free = &self.fit.hypothesis.free;
        let cross = DMatrix::from_fn(a.theta.nrows(), free.len(), |i, j| {
            a.theta[(i, j)] * free[j].sd / self.inflation
        });
        let factor = self.theta.clone().cholesky()?;
        Some(Amplitudes {
            own: &a.own / self.inflation - &cross * factor.solve(&cross.transpose()),
            theta: DMatrix::zeros(a.own.nrows(), 0),
            gradient: &a.gradient / self.inflation - &cross * factor.solve(&self.gradient),
        })
    }

    /// The numbers from the `first` on among some, one a lane.
    fn group(&self, first: usize, numbers: &Range<usize>, along: &Along) -> Driven {
        let n = self.problem.model.coordinates.len();
        let lanes = LANES.min(numbers.end - first);
        let mut apart = vec![vec![Lanes::ZERO; along.motion.len()]; n];
        let (model, h) = (self.problem.model, &self.fit.hypothesis);
        let known = (&h.parameters[..], &h.effects[..]);
        for (coordinate, lane, series) in forces(model, known, (first, lanes), &along.motion) {
            let series = centred(&series);
            apart[coordinate].iter_mut().zip(series).for_each(|(to, from)| to.0[lane] = from);
        }
        Driven {
            series: vec![],
            at_once: vec![],
            places: (0..n).map(|c| (Drive::Force(c), Lanes([1.0; LANES]))).collect(),
            apart,
            seen: vec![],
        }
    }
}

/// Derivatives of `F - M q''` by the numbers from `first` on, as many as `lanes`, at every sample of a motion:
/// coordinate, lane, series.
pub(crate) fn forces(
    model: &Model,
    (parameters, effects): (&[f64], &[ModelEffect]),
    (first, lanes): (usize, usize),
    motion: &SmoothedRecording,
) -> impl Iterator<Item = (usize, usize, Vec<f64>)> {
    let n = model.coordinates.len();
    let mut parameters = model.with_structure(parameters, effects);
    parameters.resize(model.structure_end(), 0.0);
    let bound = model.dynamics().bind_along(&parameters, first);
    let sizes = model.dynamics().sizes();
    let (mut room, zero) = (bound.room(), Dual::constant(0.0));
    let (mut variables, mut rates) = (vec![zero; sizes.variables()], vec![zero; sizes.rates()]);
    let mut series = vec![vec![0.0; motion.len()]; n * lanes];
    for k in 0..motion.len() {
        // What inputs do has nothing to do with the structure.
        let state = motion.state(k).iter().map(|x| Dual::constant(*x));
        variables.iter_mut().zip(state).for_each(|(to, from)| *to = from);
        bound.evaluate(&mut room, &variables, &mut rates);
        let (mass, force) = rates.split_at(n * n);
        for (at, series) in series.iter_mut().enumerate() {
            let (c, lane) = (at / lanes, at % lanes);
            let inertia = (0..n).map(|j| mass[c * n + j].tangent[lane] * motion.rate(k, n + j));
            series[k] = force[c].tangent[lane] - inertia.sum::<f64>();
        }
    }
    series.into_iter().enumerate().map(move |(at, s)| (at / lanes, at % lanes, s))
}

/// Nats that amplitudes with these prior standard deviations gain.
fn of_amplitudes(a: &Amplitudes, sd: &[f64]) -> Option<f64> {
    let sd = DMatrix::from_diagonal(&DVector::from_row_slice(sd));
    let h = &sd * &a.own * &sd + DMatrix::identity(sd.nrows(), sd.nrows());
    Some(Posterior::of(h, &(&sd * &a.gradient))?.gain)
}

/// Where a parameter stands in its prior, in standard deviations from the middle.
fn standing(prior: &Prior, value: f64) -> f64 {
    match *prior {
        Prior::Fixed => 0.0,
        Prior::Normal { mean, sd, .. } => (value - mean) / sd,
        Prior::LogNormal { median, factor, .. } => (value / median).ln() / factor.ln(),
    }
}

/// Parameters that stand so in their priors.
fn plain(priors: &[Prior], at: &[f64]) -> Vec<f64> {
    let value = |(prior, x): (&Prior, &f64)| match *prior {
        Prior::Fixed => 0.0,
        Prior::Normal { mean, sd, low, high } => (mean + sd * x).clamp(low, high),
        Prior::LogNormal { median, factor, low, high } => {
            (median * factor.powf(*x)).clamp(low, high)
        }
    };
    priors.iter().zip(at).map(value).collect()
}

/// Derivatives of a law's numbers by its amplitudes, where these are 0.
pub(crate) fn slopes(law: &dyn AnyStructureLaw, shape: &[f64]) -> DMatrix<f64> {
    let amplitudes = law.amplitudes();
    let parameters: Vec<Dual> = (0..amplitudes)
        .map(|lane| Dual::direction(0.0, lane))
        .chain(shape.iter().map(|s| Dual::constant(*s)))
        .collect();
    let numbers = law.dual().numbers(&parameters);
    DMatrix::from_fn(numbers.len(), amplitudes, |i, lane| numbers[i].tangent[lane])
}
