//! Screening: which effects of the catalogue does the weak residual ask for?
//!
//! Forward selection by evidence. At each step every candidate is tried over its grid of
//! shapes with the noise as it is; the best few are refined (shape by a simplex search, the
//! white force that stands for the unexplained re-estimated) and compared by log evidence.
//! Afterwards each effect is dropped in turn.

use crate::DiagnoseError;
use crate::candidates::{Candidate, Term, candidates, deviation};
use crate::evidence::{Evidence, Normal, colour, regress};
use crate::trajectories::SmoothedRecording;
use crate::weak::{Column, WeakForm, Whitener};
use lacuna_effects::{Law, Range, Variable};
use rayon::prelude::*;

/// Nats by which an effect must beat the model without it.
const THRESHOLD: f64 = 10.0;
/// Share of the first effect's gain that later ones must reach: formulas are never exact,
/// and what a slightly wrong one leaves behind is no second effect.
const SHARE_OF_FIRST: f64 = 0.01;
/// Candidates that are refined at each step, from each of two scans.
const REFINED: usize = 6;
/// Share of the white force at which candidates are screened a second time.
const SMALLER_TAU: f64 = 0.2;
/// Most effects that are added.
const MOST_EFFECTS: usize = 3;
/// Parameters may move this many tolerances.
const MOST_TOLERANCES: f64 = 4.0;

/// A set of effects, fitted.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// The effects.
    pub terms: Vec<Term>,
    /// Standard deviation of the white force on each used channel, in units of its noise.
    pub tau: Vec<f64>,
    /// The fit: parameters with a tolerance first, then the amplitudes of each term.
    pub evidence: Evidence,
    /// How much more slowly than white noise the whitened residual varies (1 is white):
    /// evidence counts this many times less.
    pub colour: f64,
}

/// What the screening found.
#[derive(Clone, Debug)]
pub struct Screening {
    /// The model with calibrated parameters and no effect.
    pub calibrated: Hypothesis,
    /// The model at its nominal parameters.
    pub nominal: Hypothesis,
    /// The chosen effects.
    pub chosen: Hypothesis,
    /// For each chosen effect, rivals and the nats they lie behind it.
    pub rivals: Vec<Vec<(Term, f64)>>,
    /// For each chosen effect, the nats it gains over leaving it out.
    pub gains: Vec<f64>,
}

/// The variable that a learned force depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// The channel's coordinate or first-order state.
    Coordinate,
    /// The channel's velocity.
    Velocity,
    /// Time.
    Time,
}

impl Over {
    fn of(self, s: &SmoothedRecording, channel: usize, k: usize) -> f64 {
        let at = s.local(channel, None, k);
        match self {
            Self::Coordinate => at.q,
            Self::Velocity => at.v,
            Self::Time => at.t,
        }
    }
}

/// A force learned without a formula.
#[derive(Clone, Debug)]
pub struct Learned {
    /// Values of the variable.
    pub at: Vec<f64>,
    /// The force there.
    pub force: Vec<f64>,
    /// Its standard deviation.
    pub std: Vec<f64>,
    /// Log evidence (nats) that it gains.
    pub gain: f64,
}

/// The range that holds all but a thousandth of the values at each end.
fn central_range(values: &[f64]) -> (f64, f64) {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let cut = sorted.len() / 1000;
    (sorted[cut], sorted[sorted.len() - 1 - cut])
}

/// The regression at one point of the parameters.
pub struct Screen<'w> {
    weak: &'w WeakForm<'w>,
    /// Point about which parameters are linear.
    pub point: Vec<f64>,
    target: Column,
    parameters: Vec<(usize, Column)>,
    /// Force scale of each channel's rows: what amplitudes are expected to explain.
    scale: f64,
}

impl<'w> Screen<'w> {
    /// The smoothed recordings.
    pub fn smoothed(&self) -> impl Iterator<Item = &SmoothedRecording> {
        self.weak.smoothed()
    }

    /// Set up the regression at `point`.
    #[must_use]
    pub fn new(weak: &'w WeakForm<'w>, point: Vec<f64>) -> Self {
        let target = weak.residual(&point);
        let parameters = weak.parameter_columns(&point);
        let scale = rms(&target);
        Self { weak, point, target, parameters, scale }
    }

    fn parameter_priors(&self) -> Vec<Normal> {
        let prior = |&(k, _): &(usize, Column)| {
            let p = &self.weak.model().parameters[k];
            Normal { mean: p.value - self.point[k], sd: p.std() }
        };
        self.parameters.iter().map(prior).collect()
    }

    /// Target and columns of a set of terms before whitening.
    fn system(&self, terms: &[Term]) -> System {
        let mut target = self.target.clone();
        if terms.iter().any(|t| matches!(t.candidate.effect.law, Law::Input(_))) {
            let change = self.input_change(terms);
            target.iter_mut().zip(&change).for_each(|(t, c)| *t -= c);
        }
        let mut columns: Vec<Column> = self.parameters.iter().map(|(_, c)| c.clone()).collect();
        let mut priors = self.parameter_priors();
        for term in terms {
            for column in term.columns(self.weak, &self.point) {
                priors.push(Normal { mean: 0.0, sd: amplitude_sd(self.scale, &column) });
                columns.push(column);
            }
        }
        System { target, columns, priors }
    }

    /// What the input effects among `terms` change in the explained force.
    fn input_change(&self, terms: &[Term]) -> Column {
        let m = self.weak.model().inputs.len();
        self.weak.input_column(&self.point, |s| {
            let mut inputs = self.weak.model().effective_inputs(&s.times, &s.commands);
            terms.iter().for_each(|t| t.transform(&s.times, &mut inputs, m));
            inputs
        })
    }

    /// Fit a set of terms with the white forces `tau`.
    fn fit(&self, system: &System, tau: &[f64]) -> Result<Option<Evidence>, DiagnoseError> {
        let whitener = self.weak.whitener(tau)?;
        Ok(system.whitened(&whitener).regress())
    }

    /// Fit a set of terms, the white forces chosen by evidence, beginning from `tau`.
    ///
    /// # Errors
    /// [`DiagnoseError`] when the noise covariance cannot be factored or nothing is finite.
    pub fn hypothesis(&self, terms: &[Term], tau: &[f64]) -> Result<Hypothesis, DiagnoseError> {
        let mut system = self.system(terms);
        let (tau, evidence) = self.choose_tau(&system, tau)?;
        let whitener = self.weak.whitener(&tau)?;
        let colour = self.colour(&system.whitened(&whitener).residual(&evidence));
        // Data of which only one in `colour` counts move a prior that much less.
        system.priors.iter_mut().for_each(|p| p.sd /= colour.sqrt());
        let evidence = self.within_bounds(&mut system, &whitener)?;
        Ok(Hypothesis { terms: terms.to_vec(), tau, evidence, colour })
    }

    /// Fit, and hold parameters that leave their bounds there.
    fn within_bounds(
        &self,
        system: &mut System,
        whitener: &Whitener,
    ) -> Result<Evidence, DiagnoseError> {
        let failed = || DiagnoseError::Weak { reason: "the regression is not finite".into() };
        let mut held = vec![false; self.parameters.len()];
        loop {
            let fit = system.whitened(whitener).regress().ok_or_else(failed)?;
            let outside = (0..held.len()).find_map(|k| {
                let p = &self.weak.model().parameters[self.parameters[k].0];
                let value = self.point[self.parameters[k].0] + fit.coefficients[k];
                let shift = (value - p.value) / p.std();
                (!held[k] && shift.abs() > MOST_TOLERANCES).then_some((k, shift, p))
            });
            let Some((k, shift, p)) = outside else { return Ok(fit) };
            let bound = p.value + MOST_TOLERANCES * shift.signum() * p.std();
            system.priors[k] =
                Normal { mean: bound - self.point[self.parameters[k].0], sd: 1e-6 * p.std() };
            held[k] = true;
        }
    }

    /// Evidence maximised over the white forces: one channel after the other, in steps of a
    /// factor that shrinks.
    fn choose_tau(
        &self,
        system: &System,
        start: &[f64],
    ) -> Result<(Vec<f64>, Evidence), DiagnoseError> {
        let failed = || DiagnoseError::Weak { reason: "the regression is not finite".into() };
        let mut tau = start.to_vec();
        let mut best = self.fit(system, &tau)?.ok_or_else(failed)?;
        for factor in [4.0, 2.0, 1.3] {
            for c in 0..tau.len() {
                for direction in [1.0 / factor, factor] {
                    loop {
                        let mut trial = tau.clone();
                        trial[c] *= direction;
                        let Some(fit) = self.fit(system, &trial)? else { break };
                        if fit.log <= best.log + 1e-3 || trial[c] < 1e-9 * self.scale {
                            break;
                        }
                        (tau, best) = (trial, fit);
                    }
                }
            }
        }
        Ok((tau, best))
    }

    /// White forces that explain the whole residual: where the search for them begins.
    #[must_use]
    pub fn largest_tau(&self) -> Vec<f64> {
        vec![self.scale.max(f64::MIN_POSITIVE); self.weak.channels().len()]
    }

    fn colour(&self, residual: &[f64]) -> f64 {
        let segments = self.weak.segments();
        colour(segments.iter().map(|(_, rows)| &residual[rows.clone()]))
    }

    /// The candidates that are worth a closer look, each with its best shape: the first few at
    /// the noise of `base`, and the first few at a smaller white force. What is missing
    /// inflates the white force, behind which an effect that acts slowly or seldom hides.
    fn shortlist(&self, base: &Hypothesis, list: &[Candidate]) -> Result<Vec<Term>, DiagnoseError> {
        let tries: Vec<Term> = list
            .iter()
            .flat_map(|&candidate| {
                let shapes = candidate.shapes(&candidate.scales(self.weak));
                shapes.into_iter().map(move |shape| Term { candidate, shape })
            })
            .collect();
        let mut short: Vec<Term> = Vec::new();
        for share in [1.0, SMALLER_TAU] {
            let tau: Vec<f64> = base.tau.iter().map(|t| share * t).collect();
            for term in self.scan(base, &tau, &tries)?.into_iter().take(REFINED) {
                if !short.iter().any(|t| t.candidate == term.candidate) {
                    short.push(term);
                }
            }
        }
        Ok(short)
    }

    /// The best shape of every candidate, by its gain over `base` with white forces `tau`.
    fn scan(
        &self,
        base: &Hypothesis,
        tau: &[f64],
        tries: &[Term],
    ) -> Result<Vec<Term>, DiagnoseError> {
        let whitener = self.weak.whitener(tau)?;
        let system = self.system(&base.terms).whitened(&whitener);
        let failed = || DiagnoseError::Weak { reason: "the regression is not finite".into() };
        let fit = system.regress().ok_or_else(failed)?;
        let ground = Ground { residual: system.residual(&fit), system, fit, whitener };
        let gains: Vec<Option<f64>> =
            tries.par_iter().map(|term| self.quick_gain(&ground, &base.terms, term)).collect();
        let mut best: Vec<(f64, &Term)> = Vec::new();
        for (gain, term) in gains.into_iter().zip(tries) {
            let Some(gain) = gain else { continue };
            match best.iter_mut().find(|(_, t)| t.candidate == term.candidate) {
                Some(entry) if entry.0 >= gain => {}
                Some(entry) => *entry = (gain, term),
                None => best.push((gain, term)),
            }
        }
        best.sort_by(|a, b| b.0.total_cmp(&a.0));
        Ok(best.into_iter().map(|(_, term)| term.clone()).collect())
    }

    /// Gain of one term with the noise fixed: the target's projection on what the columns of
    /// the base leave of the new ones.
    fn quick_gain(&self, ground: &Ground, base: &[Term], term: &Term) -> Option<f64> {
        let Ground { system, fit, residual, whitener } = ground;
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        if let Law::Input(_) = term.candidate.effect.law {
            // The change is what it is: no amplitude to choose, only the base to refit.
            let mut terms = base.to_vec();
            terms.push(term.clone());
            let (with, without) = (self.input_change(&terms), self.input_change(base));
            let change: Column = with.iter().zip(&without).map(|(a, b)| a - b).collect();
            let mut change = whitener.whiten(&change);
            system.project_out(fit, &mut change);
            return Some(dot(residual, &change) - 0.5 * dot(&change, &change));
        }
        let columns: Vec<Column> = term.columns(self.weak, &self.point);
        let priors: Vec<Normal> =
            columns.iter().map(|c| Normal { mean: 0.0, sd: amplitude_sd(self.scale, c) }).collect();
        let projected: Vec<Column> = columns
            .iter()
            .map(|c| {
                let mut c = whitener.whiten(c);
                system.project_out(fit, &mut c);
                c
            })
            .collect();
        let refs: Vec<&[f64]> = projected.iter().map(Vec::as_slice).collect();
        let with = regress(residual, &refs, &priors, 0.0)?;
        let without = regress(residual, &[], &[], 0.0)?;
        sensible(term, &with.coefficients, |k| with.std(k)).then_some(with.log - without.log)
    }

    /// Refine a term's shape by a simplex search on the evidence with the noise of `base`.
    fn refine(&self, base: &Hypothesis, term: &Term) -> Result<Term, DiagnoseError> {
        let d = term.shape.len();
        if d == 0 {
            return Ok(term.clone());
        }
        let whitener = self.weak.whitener(&base.tau)?;
        let system = self.system(&base.terms).whitened(&whitener);
        let residual = system.residual(&base.evidence);
        let ground = Ground { system, fit: base.evidence.clone(), residual, whitener };
        let scales = term.candidate.scales(self.weak);
        let bounds = Bounds::of(&term.candidate.shapes(&scales));
        let cost = |x: &[f64]| {
            let trial = Term { candidate: term.candidate, shape: bounds.shape(x) };
            self.quick_gain(&ground, &base.terms, &trial).map_or(1e30, |g| -g)
        };
        let x = simplex(&cost, &bounds.coordinates(&term.shape), &bounds.steps(), 25 * d);
        Ok(Term { candidate: term.candidate, shape: bounds.shape(&x) })
    }

    /// The whole search.
    ///
    /// # Errors
    /// [`DiagnoseError`] when the weak form breaks down numerically.
    pub fn search(&self, progress: &dyn Fn(&str)) -> Result<Screening, DiagnoseError> {
        let calibrated = self.hypothesis(&[], &self.largest_tau())?;
        let nominal = self.nominal(&calibrated)?;
        let list = candidates(self.weak.model(), self.weak.channels());
        let mut chosen = calibrated.clone();
        let mut rivals: Vec<Vec<(Term, f64)>> = Vec::new();
        let mut first_gain = None;
        while chosen.terms.len() < MOST_EFFECTS {
            progress(&format!("screening {} candidates", list.len()));
            let taken = |c: &Candidate| chosen.terms.iter().any(|t| t.candidate.excludes(c));
            let free: Vec<_> = list.iter().filter(|c| !taken(c)).copied().collect();
            let shortlist = self.shortlist(&chosen, &free)?;
            let fits = shortlist
                .par_iter()
                .map(|term| {
                    let mut terms = chosen.terms.clone();
                    terms.push(self.refine(&chosen, term)?);
                    self.hypothesis(&terms, &chosen.tau)
                })
                .collect::<Result<Vec<_>, _>>()?;
            let mut fits: Vec<_> = fits.into_iter().filter(|h| self.is_sensible(h)).collect();
            fits.sort_by(|a, b| b.evidence.log.total_cmp(&a.evidence.log));
            let mut kept = Vec::new();
            for h in fits {
                if self.is_told_apart_from_motion(&h)
                    && (chosen.terms.is_empty() || self.generalises(&chosen, &h)?)
                {
                    kept.push(h);
                }
            }
            fits = kept;
            let Some(best) = fits.first() else { break };
            let gain = (best.evidence.log - chosen.evidence.log) / best.colour;
            let needed = THRESHOLD.max(SHARE_OF_FIRST * first_gain.unwrap_or(0.0));
            if gain < needed || !self.beats_a_remainder(&chosen, best, gain)? {
                break;
            }
            first_gain.get_or_insert(gain);
            let behind = |h: &Hypothesis| (best.evidence.log - h.evidence.log) / best.colour;
            let last = |h: &Hypothesis| h.terms[h.terms.len() - 1].clone();
            rivals.push(fits.iter().skip(1).map(|h| (last(h), behind(h))).collect());
            chosen = best.clone();
        }
        let gains = self.prune(&mut chosen, &mut rivals)?;
        Ok(Screening { calibrated, nominal, chosen, rivals, gains })
    }

    /// Whether a further effect says more than a force without a name would: a smooth curve
    /// over the coordinate or the velocity of the same channel. If the curve gains more, what
    /// is left is the remainder of formulas that are not exact, and no further law.
    fn beats_a_remainder(
        &self,
        chosen: &Hypothesis,
        with: &Hypothesis,
        gain: f64,
    ) -> Result<bool, DiagnoseError> {
        let Some(added) = with.terms.last().filter(|_| !chosen.terms.is_empty()) else {
            return Ok(true);
        };
        let Law::Force(_) = added.candidate.effect.law else { return Ok(true) };
        for over in [Over::Coordinate, Over::Velocity] {
            let curve = self.learn(&chosen.terms, &chosen.tau, added.candidate.channel, over)?;
            if curve.gain > gain {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Whether the last effect, if it depends on time, does something that the motion does not
    /// do as well: where the motion is periodic, a force that returns with it may as well be
    /// one of the state, and these recordings cannot tell.
    fn is_told_apart_from_motion(&self, h: &Hypothesis) -> bool {
        const MOST_EXPLAINED: f64 = 0.5;
        let Some(Term { candidate, shape }) = h.terms.last() else { return true };
        let Law::Force(law) = candidate.effect.law else { return true };
        if !candidate.effect.depends_on.contains(&Variable::Time) {
            return true;
        }
        let (mut features, mut basis) = (Vec::new(), vec![Vec::new(); law.amplitudes()]);
        for s in self.weak.smoothed() {
            let series = s.basis(law, shape, candidate.channel, candidate.other);
            for k in (0..s.len()).step_by(s.len().div_ceil(2000)) {
                let at = s.local(candidate.channel, None, k);
                features.push((at.q, at.v));
                basis.iter_mut().zip(&series).for_each(|(b, x)| b.push(x[k]));
            }
        }
        let explained = basis.iter().map(|b| share_explained_by_motion(&features, b));
        explained.fold(0.0, f64::max) < MOST_EXPLAINED
    }

    /// Whether what `with` adds to `without` is learned from one half of the recordings and
    /// found again in the other, both ways: a formula that is only slightly wrong leaves
    /// remainders that a further law can fit, but seldom the same ones everywhere.
    fn generalises(&self, without: &Hypothesis, with: &Hypothesis) -> Result<bool, DiagnoseError> {
        let whitener = self.weak.whitener(&with.tau)?;
        let systems =
            [&without.terms, &with.terms].map(|terms| self.system(terms).whitened(&whitener));
        let halves = self.halves();
        let mut gains = [0.0; 2];
        for (gain, learn) in gains.iter_mut().zip(0..2) {
            let errors = systems.each_ref().map(|system| {
                let part = system.rows(&halves[learn]);
                let fit = part.regress()?;
                let residual = system.rows(&halves[1 - learn]).residual(&fit);
                Some(residual.iter().map(|r| r * r).sum::<f64>())
            });
            let [Some(without), Some(with)] = errors else { return Ok(false) };
            *gain = 0.5 * (without - with);
        }
        let total = (gains[0] + gains[1]) / with.colour;
        Ok(gains.iter().all(|&g| g > 0.0) && total > THRESHOLD)
    }

    /// Rows of two halves: every other recording, or the first and second half of a single
    /// one.
    fn halves(&self) -> [Vec<std::ops::Range<usize>>; 2] {
        let mut halves = [vec![], vec![]];
        let used = self.weak.channels().len();
        let segments = self.weak.segments();
        let single = segments.len() == used;
        for (k, (_, rows)) in segments.into_iter().enumerate() {
            if single {
                let middle = rows.start + rows.len() / 2;
                halves[0].push(rows.start..middle);
                halves[1].push(middle..rows.end);
            } else {
                halves[(k / used) % 2].push(rows);
            }
        }
        halves
    }

    /// Drop effects that later ones made superfluous; the gains of those that stay.
    fn prune(
        &self,
        chosen: &mut Hypothesis,
        rivals: &mut Vec<Vec<(Term, f64)>>,
    ) -> Result<Vec<f64>, DiagnoseError> {
        loop {
            let mut gains = Vec::new();
            for k in 0..chosen.terms.len() {
                let mut terms = chosen.terms.clone();
                terms.remove(k);
                let without = self.hypothesis(&terms, &chosen.tau)?;
                gains.push((chosen.evidence.log - without.evidence.log) / chosen.colour);
            }
            let weakest = gains.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
            match weakest {
                Some((k, &gain)) if gain < THRESHOLD => {
                    chosen.terms.remove(k);
                    rivals.remove(k);
                    *chosen = self.hypothesis(&chosen.terms, &chosen.tau)?;
                }
                _ => return Ok(gains),
            }
        }
    }

    /// The model as it stands: parameters at their nominal values.
    fn nominal(&self, calibrated: &Hypothesis) -> Result<Hypothesis, DiagnoseError> {
        let mut system = self.system(&[]);
        for prior in &mut system.priors {
            // A prior too narrow to move.
            prior.sd *= 1e-6;
        }
        let (tau, evidence) = self.choose_tau(&system, &calibrated.tau)?;
        let residual = system.whitened(&self.weak.whitener(&tau)?).residual(&evidence);
        Ok(Hypothesis { terms: vec![], tau, evidence, colour: self.colour(&residual) })
    }

    /// Amplitudes that make physical sense.
    fn is_sensible(&self, h: &Hypothesis) -> bool {
        let mut at = self.parameters.len();
        h.terms.iter().all(|term| {
            let count = term.amplitudes();
            let range = at..at + count;
            at += count;
            sensible(term, &h.evidence.coefficients[range.clone()], |k| {
                h.evidence.std(range.start + k)
            })
        })
    }

    /// What the residual shows of a force on `channel` that depends on one variable alone, in
    /// addition to `terms`: bumps over the variable's range with a Gaussian prior, so that the
    /// result is a smooth curve with its uncertainty.
    ///
    /// # Errors
    /// [`DiagnoseError`] when the weak form breaks down numerically.
    pub fn learn(
        &self,
        terms: &[Term],
        tau: &[f64],
        channel: usize,
        over: Over,
    ) -> Result<Learned, DiagnoseError> {
        const BUMPS: usize = 24;
        let values: Vec<f64> = self
            .weak
            .smoothed()
            .flat_map(|s| (0..s.len()).map(move |k| over.of(s, channel, k)))
            .collect();
        let (low, high) = central_range(&values);
        let spacing = (high - low) / (BUMPS - 1) as f64;
        let bump = |j: usize, x: f64| {
            let z = (x - low - j as f64 * spacing) / (1.3 * spacing);
            (-0.5 * z * z).exp()
        };
        let mut system = self.system(terms);
        let known = system.columns.len();
        for j in 0..BUMPS {
            let column = self.weak.force_column(&self.point, channel, None, |s| {
                (0..s.len()).map(|k| bump(j, over.of(s, channel, k).clamp(low, high))).collect()
            });
            system.priors.push(Normal { mean: 0.0, sd: amplitude_sd(self.scale, &column) });
            system.columns.push(column);
        }
        let whitener = self.weak.whitener(tau)?;
        let failed = || DiagnoseError::Weak { reason: "the regression is not finite".into() };
        let with = system.whitened(&whitener);
        let fit = with.regress().ok_or_else(failed)?;
        let without = self.fit(&self.system(terms), tau)?.ok_or_else(failed)?;
        let colour = self.colour(&with.residual(&fit));
        let at: Vec<f64> = (0..4 * BUMPS)
            .map(|k| low + (high - low) * k as f64 / (4 * BUMPS - 1) as f64)
            .collect();
        let (mut force, mut std) = (vec![], vec![]);
        for &x in &at {
            let b: Vec<f64> = (0..BUMPS).map(|j| bump(j, x)).collect();
            force.push((0..BUMPS).map(|j| b[j] * fit.coefficients[known + j]).sum());
            let variance: f64 = (0..BUMPS)
                .flat_map(|i| (0..BUMPS).map(move |j| (i, j)))
                .map(|(i, j)| b[i] * b[j] * fit.covariance[(known + i, known + j)])
                .sum();
            std.push((variance * colour).max(0.0).sqrt());
        }
        Ok(Learned { at, force, std, gain: (fit.log - without.log) / colour })
    }

    /// Indices of the model's parameters that are regressed.
    #[must_use]
    pub fn free_parameters(&self) -> Vec<usize> {
        self.parameters.iter().map(|(k, _)| *k).collect()
    }
}

impl Term {
    /// Number of amplitudes in the regression.
    #[must_use]
    pub fn amplitudes(&self) -> usize {
        match self.candidate.effect.law {
            Law::Force(law) => law.amplitudes(),
            _ => 0,
        }
    }
}

/// Prior of an amplitude: its column may explain as much as the residual holds.
fn amplitude_sd(scale: f64, column: &[f64]) -> f64 {
    let size = rms(column);
    if size > 0.0 && scale > 0.0 { 2.0 * scale / size } else { 1.0 }
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Whether amplitudes whose range is one-sided are on their side (two standard deviations
/// of doubt allowed), and at least one is.
fn sensible(term: &Term, amplitudes: &[f64], std: impl Fn(usize) -> f64) -> bool {
    let Law::Force(law) = term.candidate.effect.law else { return true };
    let internal: Vec<f64> = amplitudes.iter().chain(&term.shape).copied().collect();
    let physical = law.physical(&internal);
    let one_sided = |k: usize| term.candidate.effect.parameters[k].range == Range::NonNegative;
    (0..amplitudes.len()).all(|k| !one_sided(k) || physical[k] > -2.0 * std(k))
        && (0..amplitudes.len()).any(|k| !one_sided(k) || physical[k] > 0.0)
}

/// Share of a series' variance that a cubic polynomial of coordinate and velocity explains.
fn share_explained_by_motion(motion: &[(f64, f64)], series: &[f64]) -> f64 {
    let standard = |values: Vec<f64>| -> Vec<f64> {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let sd = deviation(&values).max(f64::MIN_POSITIVE);
        values.iter().map(|v| (v - mean) / sd).collect()
    };
    let q = standard(motion.iter().map(|m| m.0).collect());
    let v = standard(motion.iter().map(|m| m.1).collect());
    let powers: Vec<(i32, i32)> = (0..4).flat_map(|i| (0..4 - i).map(move |j| (i, j))).collect();
    let columns: Vec<Vec<f64>> = powers
        .iter()
        .map(|&(i, j)| q.iter().zip(&v).map(|(q, v)| q.powi(i) * v.powi(j)).collect())
        .collect();
    let target = standard(series.to_vec());
    let refs: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let wide = vec![Normal { mean: 0.0, sd: 1e3 }; columns.len()];
    let Some(fit) = regress(&target, &refs, &wide, 0.0) else { return 0.0 };
    1.0 - fit.chi2 / target.iter().map(|t| t * t).sum::<f64>().max(f64::MIN_POSITIVE)
}

/// Target, columns and priors of a regression.
struct System {
    target: Column,
    columns: Vec<Column>,
    priors: Vec<Normal>,
}

impl System {
    fn whitened(&self, whitener: &Whitener) -> WhitenedSystem {
        WhitenedSystem {
            target: whitener.whiten(&self.target),
            columns: self.columns.iter().map(|c| whitener.whiten(c)).collect(),
            priors: self.priors.clone(),
            log_determinant: whitener.log_determinant(),
        }
    }
}

/// A whitened base with its fit: what further terms are tried on.
struct Ground {
    system: WhitenedSystem,
    fit: Evidence,
    residual: Column,
    whitener: Whitener,
}

struct WhitenedSystem {
    target: Column,
    columns: Vec<Column>,
    priors: Vec<Normal>,
    log_determinant: f64,
}

impl WhitenedSystem {
    /// The same regression on some of the rows.
    fn rows(&self, ranges: &[std::ops::Range<usize>]) -> Self {
        let pick = |c: &Column| ranges.iter().flat_map(|r| c[r.clone()].iter().copied()).collect();
        Self {
            target: pick(&self.target),
            columns: self.columns.iter().map(pick).collect(),
            priors: self.priors.clone(),
            log_determinant: 0.0,
        }
    }

    fn refs(&self) -> Vec<&[f64]> {
        self.columns.iter().map(Vec::as_slice).collect()
    }

    fn regress(&self) -> Option<Evidence> {
        regress(&self.target, &self.refs(), &self.priors, self.log_determinant)
    }

    fn residual(&self, fit: &Evidence) -> Column {
        let mut residual = self.target.clone();
        for (column, b) in self.columns.iter().zip(&fit.coefficients) {
            residual.iter_mut().zip(column).for_each(|(r, x)| *r -= b * x);
        }
        residual
    }

    /// Take from a column what the base would explain of it: `c - X H^-1 X^T c`.
    fn project_out(&self, fit: &Evidence, column: &mut [f64]) {
        let dots: Vec<f64> =
            self.columns.iter().map(|x| x.iter().zip(&*column).map(|(a, b)| a * b).sum()).collect();
        for (i, x) in self.columns.iter().enumerate() {
            let b: f64 = (0..dots.len()).map(|j| fit.covariance[(i, j)] * dots[j]).sum();
            column.iter_mut().zip(x).for_each(|(c, x)| *c -= b * x);
        }
    }
}

/// The box in which shapes are refined, from the grid that was screened: logarithmic where
/// all values are positive.
struct Bounds {
    low: Vec<f64>,
    high: Vec<f64>,
    logarithmic: Vec<bool>,
    step: Vec<f64>,
    fixed: Vec<bool>,
}

impl Bounds {
    fn of(grid: &[Vec<f64>]) -> Self {
        let d = grid.first().map_or(0, Vec::len);
        let mut this =
            Self { low: vec![], high: vec![], logarithmic: vec![], step: vec![], fixed: vec![] };
        for k in 0..d {
            let mut values: Vec<f64> = grid.iter().map(|s| s[k]).collect();
            values.sort_by(f64::total_cmp);
            values.dedup();
            let positive = values[0] > 0.0;
            let map = |v: f64| if positive { v.ln() } else { v };
            let (low, high) = (map(values[0]), map(values[values.len() - 1]));
            // A sign (of an end stop's side) is no magnitude to refine.
            let fixed = values.iter().all(|v| v.abs() == 1.0) || values.len() == 1;
            let step = (high - low) / values.len() as f64;
            // One step of the grid beyond its ends: further off a law is another law.
            let room = (high - low) / (values.len().max(2) - 1) as f64;
            this.low.push(low - room);
            this.high.push(high + room);
            this.logarithmic.push(positive);
            this.step.push(0.5 * step);
            this.fixed.push(fixed);
        }
        this
    }

    fn coordinates(&self, shape: &[f64]) -> Vec<f64> {
        (0..shape.len())
            .map(|k| if self.logarithmic[k] { shape[k].ln() } else { shape[k] })
            .collect()
    }

    fn shape(&self, x: &[f64]) -> Vec<f64> {
        (0..x.len())
            .map(|k| {
                let v = x[k].clamp(self.low[k], self.high[k]);
                if self.logarithmic[k] { v.exp() } else { v }
            })
            .collect()
    }

    fn steps(&self) -> Vec<f64> {
        (0..self.step.len()).map(|k| if self.fixed[k] { 0.0 } else { self.step[k] }).collect()
    }
}

/// Nelder and Mead's simplex search; coordinates with a step of 0 stay.
fn simplex(cost: &dyn Fn(&[f64]) -> f64, start: &[f64], steps: &[f64], most: usize) -> Vec<f64> {
    let mut points = vec![(cost(start), start.to_vec())];
    for k in (0..start.len()).filter(|&k| steps[k] != 0.0) {
        let mut x = start.to_vec();
        x[k] += steps[k];
        points.push((cost(&x), x));
    }
    let d = points.len() - 1;
    if d == 0 {
        return start.to_vec();
    }
    for _ in 0..most {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        if points[d].0 - points[0].0 < 0.05 {
            break;
        }
        let centre: Vec<f64> = (0..start.len())
            .map(|k| points[..d].iter().map(|p| p.1[k]).sum::<f64>() / d as f64)
            .collect();
        let worst = points[d].1.clone();
        let at = |share: f64| -> Vec<f64> {
            centre.iter().zip(&worst).map(|(c, w)| c + share * (c - w)).collect()
        };
        let try_at = |share: f64| {
            let x = at(share);
            (cost(&x), x)
        };
        let reflected = try_at(1.0);
        points[d] = if reflected.0 < points[0].0 {
            let expanded = try_at(2.0);
            if expanded.0 < reflected.0 { expanded } else { reflected }
        } else if reflected.0 < points[d - 1].0 {
            reflected
        } else {
            let contracted = try_at(if reflected.0 < points[d].0 { 0.5 } else { -0.5 });
            if contracted.0 < points[d].0.min(reflected.0) {
                contracted
            } else {
                let best = points[0].1.clone();
                for p in &mut points[1..] {
                    let x: Vec<f64> = p.1.iter().zip(&best).map(|(x, b)| 0.5 * (x + b)).collect();
                    *p = (cost(&x), x);
                }
                continue;
            }
        };
    }
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points.swap_remove(0).1
}
