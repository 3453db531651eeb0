//! How large the noise is that drives the machine: the intensities that make the innovations along
//! a fit most likely. Where something drives it, outputs may be noisier than their samples show, too.
//!
//! The fit's own run is the trajectory that is linearised about. Let it have been corrected by
//! G z; a filter of other intensities then knows of the deviation delta from it
//!
//! ```text
//! z'_k = W'_k (nu_k - C_k delta_k),    delta_{k+1} = A_k (delta_k + G'_k z'_k - G_k z_k)
//! ```
//!
//! so that nothing is simulated again.

use super::coloured::{self, Colour};
use super::covariance::{Covariance, weighted};
use super::lanes::Lanes;
use super::maps::Maps;
use super::sweep::Run;
use super::{Filter, Fit, FitError, Problem, ProcessNoise, Window};
use lacuna_numbers::{LANES, Linear};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use std::array::from_fn;

/// Samples along which intensities are sought: the error of a variance from so many is 2 %.
const ENOUGH: usize = 4_000;
/// Intensities that are tried, as shares of the channel's own magnitude.
const LEAST: f64 = 1e-4;
const MOST: f64 = 10.0;
/// Noise of an output, over what its samples show.
pub const LARGEST: f64 = 1e4;
/// Noise on an input, over what the input shows: estimates of either are good to a few percent.
const SHOWN: f64 = 1.2;
/// By which factor an intensity moves at most where another comes beside it.
const REACH: f64 = 4.0;
/// How near it sources are compared: the best are then told from the others, and sought once more in the end.
pub const ROUGH: f64 = 1.1;
/// How near the best of them the search ends: two sources that are the same then differ by less
/// than a nat in thousands of samples.
const NEAR: f64 = 1.005;

/// The most likely intensities along a fit, and by how many nats they are ahead of none. A source
/// of noise must gain `worth` nats beside the others; what the model states of an input stands. Where
/// intensities are known already that are nearly those, they are sought from there.
///
/// # Errors
/// [`FitError::Diverged`].
pub fn most_likely(
    fit: &Fit,
    worth: f64,
    near: Option<&ProcessNoise>,
) -> Result<(ProcessNoise, f64), FitError> {
    let problem = fit.problem;
    let none = ProcessNoise::none(problem);
    let all = maps(fit, fit.noise.as_deref().unwrap_or(&none))?;
    let along = Along::new(problem, fit, &all, ENOUGH);
    let sources = Source::all(&none);
    let begin = along.log_likelihood(&none);
    let is_stated =
        |s: &Source| matches!(*s, Source::Input(j) if problem.model.inputs[j].noise.is_some());
    let mut used: Vec<Source> = sources.iter().copied().filter(is_stated).collect();
    let stated = used.len();
    let mut here = near.cloned().unwrap_or_else(|| ProcessNoise::stated(problem));
    let known = |s: &Source| !is_stated(s) && *s.of(&mut here.clone()) != *s.of(&mut none.clone());
    used.extend(sources.iter().copied().filter(known));
    let mut best = if here.is_none() { begin } else { along.log_likelihood(&here) };
    for &source in used[stated..].iter().rev() {
        (best, here) = along.refined(&here, along.scan(&here, source), ROUGH);
    }
    let unused = sources.iter().copied().filter(|s| !used.contains(s));
    let mut left: Vec<Left> = unused.map(|source| Left { source, hope: f64::INFINITY }).collect();
    while let Some(((gained, noise), source)) = along.further(&here, (best, worth), &mut left) {
        (best, here) = (gained, noise);
        // Those before it have shared its work.
        along.share_out(&used[stated..], (&mut best, &mut here), ROUGH);
        used.push(source);
    }
    along.share_out(&used[stated..], (&mut best, &mut here), NEAR);
    along.exchange(&mut best, &mut here, worth);
    Ok((here, best - begin))
}

/// The noise of each output along a fit that nothing drives, if it is correlated in time.
///
/// # Errors
/// [`FitError::Diverged`].
pub fn coloured(fit: &Fit) -> Result<Vec<Colour>, FitError> {
    let problem = fit.problem;
    let all = maps(fit, &ProcessNoise::none(problem))?;
    let along = Along::new(problem, fit, &all, usize::MAX);
    let of_output = |output: usize| {
        let series = along.windows.iter().map(|w| residual(problem, w, output));
        coloured::most_likely(&series.collect::<Vec<_>>(), problem.sample)
    };
    Ok((0..problem.dataset.outputs.len()).into_par_iter().map(of_output).collect())
}

/// The windows of a fit, linearised.
fn maps(fit: &Fit, noise: &ProcessNoise) -> Result<Vec<Maps>, FitError> {
    let along = |run: &Run| Maps::along(run, Some(noise)).map_err(FitError::from);
    fit.runs().par_iter().map(along).collect()
}

/// A window with its maps, its filter and the rows of its outputs.
type Linearised<'a> = (&'a Window, &'a Maps, &'a Filter, Vec<f64>);

/// The innovations of an output in a window, with their times.
fn residual(problem: &Problem, w: &Linearised, output: usize) -> coloured::Series {
    let (w, _, filter, _) = w;
    let times = &problem.dataset.recordings[w.recording].times[w.range.clone()];
    let measured = times.iter().enumerate().filter(|(at, _)| filter.measured(*at, output));
    measured.map(|(at, t)| (*t, filter.innovations(at)[output])).collect()
}

/// The most likely intensity of a source beside others: the log likelihood with all of them; and which it is.
type Tried = ((f64, ProcessNoise), Source);

/// A source of noise.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Source {
    Input(usize),
    Force(usize),
    Output(usize),
}

impl Source {
    /// All of them.
    fn all(noise: &ProcessNoise) -> Vec<Self> {
        let inputs = (0..noise.inputs.len()).map(Self::Input);
        let forces = (0..noise.forces.len()).map(Self::Force);
        inputs.chain(forces).chain((0..noise.outputs.len()).map(Self::Output)).collect()
    }

    /// Its intensity.
    fn of(self, noise: &mut ProcessNoise) -> &mut f64 {
        match self {
            Self::Input(j) => &mut noise.inputs[j],
            Self::Force(c) => &mut noise.forces[c],
            Self::Output(o) => &mut noise.outputs[o],
        }
    }
}

/// A source that is not among those that drive, and the nats that it might gain beside them.
struct Left {
    source: Source,
    hope: f64,
}

/// Intensities of a source that were tried.
#[derive(Clone, Copy)]
struct Scan {
    source: Source,
    /// The best of them: log likelihood, share.
    best: (f64, f64),
    /// The factor from each to the next.
    step: f64,
    /// What may be found between them.
    hope: f64,
}

/// Some windows of a fit, linearised.
struct Along<'a> {
    problem: &'a Problem<'a>,
    windows: Vec<Linearised<'a>>,
}

impl<'a> Along<'a> {
    fn new(problem: &'a Problem<'a>, fit: &'a Fit, maps: &'a [Maps], enough: usize) -> Self {
        let all: Vec<_> = (fit.windowed.windows.iter().zip(maps))
            .flat_map(|(windows, maps)| windows.iter().zip(&maps.filters).map(move |w| (w, maps)))
            .collect();
        let total: usize = all.iter().map(|((w, _), _)| w.range.len()).sum();
        let every = total.div_ceil(enough).max(1);
        let some = all.into_iter().step_by(every);
        let windows = some.map(|((w, f), maps)| (w, maps, f, maps.all_rows(&w.range))).collect();
        Self { problem, windows }
    }

    /// The most likely intensities of some sources, one after the other from the last, each within a
    /// factor of [`REACH`] of what it is, as near the best as `until`.
    fn share_out(
        &self,
        sources: &[Source],
        (best, here): (&mut f64, &mut ProcessNoise),
        until: f64,
    ) {
        for &source in sources.iter().rev() {
            let share = *source.of(here) / self.unit(source);
            let scan = Scan { source, best: (*best, share), step: REACH, hope: *best };
            let (gained, noise) = self.refined(here, scan, until);
            if gained > *best {
                (*best, *here) = (gained, noise);
            }
        }
    }

    /// Noise on an input in the place of a force that it drives and that does no better, whichever came first: which
    /// of the two is ahead along a fit that is far from its optimum hangs on how finely each is sought.
    fn exchange(&self, best: &mut f64, here: &mut ProcessNoise, worth: f64) {
        let model = self.problem.model;
        for c in (0..here.forces.len()).filter(|c| here.forces[*c] > 0.0).collect::<Vec<_>>() {
            let mut others = here.clone();
            others.forces[c] = 0.0;
            for j in model.inputs_about(c) {
                if model.inputs[j].noise.is_some() {
                    continue;
                }
                let (gained, noise) =
                    self.refined(&others, self.scan(&others, Source::Input(j)), NEAR);
                if gained + worth > *best {
                    (*best, *here) = (gained, noise);
                    break;
                }
            }
        }
    }

    /// The source that gains most beside others, with its most likely intensity; none where none gains `worth`
    /// nats more than their `best`. Beside more noise a source hardly gains more than it did beside less: the most
    /// hopeful are tried first, and all of them where none of those is worth it.
    fn further(
        &self,
        others: &ProcessNoise,
        (best, worth): (f64, f64),
        left: &mut Vec<Left>,
    ) -> Option<Tried> {
        let scans = self.scan_hopeful(others, (best, worth), left);
        let top = scans.iter().map(|s| s.best.0 - best).fold(0.0, f64::max);
        let hopeful: Vec<Scan> = scans.into_iter().filter(|s| s.hope - best >= top).collect();
        let refined = hopeful.into_par_iter().map(|s| (self.refined(others, s, ROUGH), s.source));
        // Inputs come first: a force that does no better than noise on one of them is that.
        let better = |a: Tried, b: Tried| if b.0.0 > a.0.0 + worth { b } else { a };
        let tried = refined.collect::<Vec<_>>().into_iter().reduce(better)?;
        let found = tried.0.0 >= best + worth;
        left.retain(|l| !found || l.source != tried.1);
        found.then_some(tried)
    }

    /// The sources that are left, scanned as long as one may gain as much as the best of them did, or all; in their own
    /// order.
    fn scan_hopeful(
        &self,
        others: &ProcessNoise,
        (best, worth): (f64, f64),
        left: &mut [Left],
    ) -> Vec<Scan> {
        const BESIDE: usize = 4;
        // What nothing drives has the noise that it shows.
        let drives = |s: &Left| !others.is_none() || !matches!(s.source, Source::Output(_));
        let mut order: Vec<usize> = (0..left.len()).filter(|k| drives(&left[*k])).collect();
        order.sort_by(|a, b| left[*b].hope.total_cmp(&left[*a].hope));
        let (mut scans, mut top) = (vec![], 0.0f64);
        for some in order.chunks(BESIDE) {
            if top >= worth && left[some[0]].hope < top - worth {
                break;
            }
            let scanned = some.par_iter().map(|k| self.scan(others, left[*k].source));
            for (k, scan) in some.iter().zip(scanned.collect::<Vec<_>>()) {
                left[*k].hope = scan.hope - best;
                top = top.max(scan.best.0 - best);
                scans.push((*k, scan));
            }
        }
        scans.sort_by_key(|(k, _)| *k);
        scans.into_iter().map(|(_, scan)| scan).collect()
    }

    /// Beside the others, intensities of one source from the least to the most, as many as are tried at once.
    fn scan(&self, others: &ProcessNoise, source: Source) -> Scan {
        const COUNT: usize = LANES;
        let (least, most) = self.range(source);
        let step = (most / least).powf(1.0 / (COUNT - 1) as f64);
        let share = |k: usize| least * step.powi(k as i32);
        let all = self.try_all(others, source, from_fn(share)).0;
        let best = (0..COUNT).rev().max_by(|a, b| all[*a].total_cmp(&all[*b])).unwrap_or(0);
        let hope = match best {
            0 => 2.0 * all[0] - all[1],
            k if k + 1 == COUNT => 2.0 * all[k] - all[k - 1],
            // By as much again as a parabola through it and its neighbours is higher.
            k => {
                all[k]
                    + 0.25 * (all[k - 1] - all[k + 1]).powi(2)
                        / (2.0 * all[k] - all[k - 1] - all[k + 1])
            }
        };
        let hope = if hope.is_nan() { f64::INFINITY } else { hope };
        Scan { source, best: (all[best], share(best)), step, hope }
    }

    /// The most likely intensity of a source beside the others: the log likelihood with it, and all of
    /// them. About the best so far as many are tried between its neighbours as go at once, until those are
    /// as near as `until`.
    fn refined(&self, others: &ProcessNoise, scan: Scan, until: f64) -> (f64, ProcessNoise) {
        let Scan { source, mut best, mut step, .. } = scan;
        let (least, most) = self.range(source);
        while step > until {
            let begin = best.1 / step;
            step = step.powf(2.0 / (LANES + 1) as f64);
            let shares = from_fn(|k| (begin * step.powi(k as i32 + 1)).clamp(least, most));
            let all = self.try_all(others, source, shares).0;
            best = all.into_iter().zip(shares).fold(best, larger);
        }
        (best.0, self.with(others, source, best.1))
    }

    /// The log likelihoods of some shares of a source beside the others.
    fn try_all(&self, others: &ProcessNoise, source: Source, shares: [f64; LANES]) -> Lanes {
        self.log_likelihoods(&shares.map(|share| self.with(others, source, share)))
    }

    fn with(&self, others: &ProcessNoise, source: Source, share: f64) -> ProcessNoise {
        let mut noise = others.clone();
        *source.of(&mut noise) = share * self.unit(source);
        noise
    }

    /// The shares that are tried: noise on a recorded input shows in the recording itself, and an
    /// output is no quieter than its samples.
    fn range(&self, source: Source) -> (f64, f64) {
        match source {
            Source::Input(j) => {
                let most = SHOWN * self.problem.input_noise(j) / self.unit(source);
                (LEAST, most.clamp(LEAST, MOST))
            }
            Source::Force(_) => (LEAST, MOST),
            Source::Output(_) => (1.0, LARGEST),
        }
    }

    /// The magnitude that an intensity is measured by.
    fn unit(&self, source: Source) -> f64 {
        let unit = match source {
            Source::Input(j) => self.problem.input_deviation(j),
            Source::Force(c) => self.problem.force_scale(c) * self.problem.sample.sqrt(),
            Source::Output(_) => 1.0,
        };
        if unit > 0.0 { unit } else { 1.0 }
    }

    fn log_likelihood(&self, noise: &ProcessNoise) -> f64 {
        self.log_likelihoods(&from_fn(|_| noise.clone())).0[0]
    }

    /// The log likelihood with each of several noises.
    fn log_likelihoods(&self, noises: &[ProcessNoise; LANES]) -> Lanes {
        let of_window = |window| Arch::new().dispatch(Filtering { along: self, window, noises });
        let all: Vec<Lanes> = self.windows.par_iter().map(of_window).collect();
        // In order: sums do not depend on who is first.
        let sum = all.into_iter().fold(Lanes::ZERO, |sum, one| sum + one);
        sum.map(|sum| if sum.is_finite() { sum } else { f64::NEG_INFINITY })
    }
}

/// The log likelihood of a window with each of several noises, to be dispatched.
struct Filtering<'w, 'a> {
    along: &'w Along<'a>,
    window: &'w Linearised<'a>,
    noises: &'w [ProcessNoise; LANES],
}

impl WithSimd for Filtering<'_, '_> {
    type Output = Lanes;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Lanes {
        let Self { along, window: (w, maps, filter, rows), noises } = self;
        let n = maps.width;
        let times = &along.problem.dataset.recordings[w.recording].times;
        let mut unknown = Covariance::known(n);
        let mut delta = vec![Lanes::ZERO; n];
        let (mut next, mut gain, mut moved) = (delta.clone(), delta.clone(), vec![0.0; n]);
        let outputs: Vec<Lanes> = (0..noises[0].outputs.len())
            .map(|o| Lanes(from_fn(|l| noises[l].outputs[o].powi(2))))
            .collect();
        let mut sum = Lanes::ZERO;
        // What drives a step, and how long it lasts: mostly as long as the one before it.
        let (mut lasting, mut by) = (f64::NAN, vec![]);
        let per_sample = rows.len() / w.range.len();
        for (at, k) in w.range.clone().enumerate() {
            let rows = &rows[at * per_sample..(at + 1) * per_sample];
            let innovations = filter.innovations(at);
            moved.fill(0.0);
            filter.correct(at, innovations, &mut moved);
            let rows = rows.chunks_exact(n).zip(&outputs).enumerate();
            for (o, (c, r)) in rows.filter(|(o, _)| filter.measured(at, *o)) {
                let left = weighted(&delta, c).map(|seen| innovations[o] - seen);
                let (s, scale) = unknown.measure(c, *r, &mut gain);
                let z = left * scale;
                for (d, g) in delta.iter_mut().zip(&gain) {
                    Lanes::by_itself();
                    *d = *d + *g * z;
                }
                sum = sum + (z * z + s.map(f64::ln)) * -0.5;
            }
            // What the fit's own filter has moved is no deviation from it.
            for (d, moved) in delta.iter_mut().zip(&moved) {
                Lanes::by_itself();
                *d = d.map(|d| d - moved);
            }
            if k + 1 == times.len() {
                break;
            }
            let (map, stride) = (maps.step(k), maps.stride());
            for (i, next) in next.iter_mut().enumerate() {
                *next = weighted(&delta, &map[i * stride..i * stride + n]);
            }
            std::mem::swap(&mut delta, &mut next);
            let dt = times[k + 1] - times[k];
            if dt != lasting {
                (lasting, by) = (dt, driven(noises, n, dt));
            }
            unknown.step(map, stride, &by);
        }
        sum
    }
}

/// [`ProcessNoise::driven`] of several.
fn driven(noises: &[ProcessNoise; LANES], width: usize, dt: f64) -> Vec<(usize, Lanes)> {
    let of = |k: usize| Lanes(from_fn(|l| noises[l].variance(k, dt)));
    let all = (0..noises[0].drivers()).map(|k| (width + k, of(k)));
    all.filter(|(_, q)| q.0.iter().any(|q| *q > 0.0)).collect()
}

fn larger(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    if b.0 > a.0 { b } else { a }
}
