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
use super::covariance::Covariance;
use super::maps::Maps;
use super::sweep::Run;
use super::{Filter, Fit, FitError, Problem, ProcessNoise, Window};
use rayon::prelude::*;

/// Samples along which intensities are sought: the error of a variance from so many is 2 %.
const ENOUGH: usize = 4_000;
/// Intensities that are tried, as shares of the channel's own magnitude, by this factor.
const LEAST: f64 = 1e-4;
const MOST: f64 = 10.0;
const FACTOR: f64 = 4.0;
/// Noise of an output, over what its samples show.
const LARGEST: f64 = 1e4;
/// Noise on an input, over what the input shows: estimates of either are good to a few percent.
const SHOWN: f64 = 1.2;
/// Refinements of the best of them: to half a percent, so that two sources that are the same differ by
/// less than a nat in thousands of samples.
const REFINEMENTS: usize = 7;

/// The most likely intensities along a fit, and by how many nats they are ahead of none. A source
/// of noise must gain `worth` nats beside the others; what the model states of an input stands.
///
/// # Errors
/// [`FitError::Diverged`].
pub fn most_likely(fit: &Fit, worth: f64) -> Result<(ProcessNoise, f64), FitError> {
    let problem = fit.problem;
    let none = ProcessNoise::none(problem);
    let all = maps(fit, fit.noise.as_deref().unwrap_or(&none))?;
    let along = Along::new(problem, fit, &all, ENOUGH);
    let sources = Source::all(&none);
    let begin = along.log_likelihood(&none);
    let mut here = ProcessNoise::stated(problem);
    let mut best = if here.is_none() { begin } else { along.log_likelihood(&here) };
    let is_stated =
        |s: &Source| matches!(*s, Source::Input(j) if problem.model.inputs[j].noise.is_some());
    let mut used: Vec<Source> = sources.iter().copied().filter(is_stated).collect();
    let stated = used.len();
    loop {
        // What nothing drives has the noise that it shows.
        let drives = |s: &Source| !here.is_none() || !matches!(s, Source::Output(_));
        let left = sources.iter().copied().filter(|s| !used.contains(s) && drives(s));
        let tried = left.map(|s| (along.best_of(&here, s), s));
        // Inputs come first: a force that does no better than noise on one of them is that.
        let better = |a: Tried, b: Tried| if b.0.0 > a.0.0 + worth { b } else { a };
        let Some(((gained, noise), source)) = tried.reduce(better) else { break };
        if gained < best + worth {
            break;
        }
        (best, here) = (gained, noise);
        used.push(source);
        // Those before it have shared its work.
        for &source in used[stated..].iter().rev().skip(1) {
            let (gained, noise) = along.best_of(&here, source);
            if gained > best {
                (best, here) = (gained, noise);
            }
        }
    }
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

/// The most likely intensity of a source beside others, and which.
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

    /// The most likely intensity of one source beside the others: the log likelihood with it, and
    /// all of them.
    fn best_of(&self, others: &ProcessNoise, source: Source) -> (f64, ProcessNoise) {
        let unit = self.unit(source);
        let with = |share: f64| {
            let mut noise = others.clone();
            *source.of(&mut noise) = share * unit;
            noise
        };
        let (least, most) = self.range(source);
        let count = ((most / least).ln() / FACTOR.ln()).ceil() as i32;
        let shares: Vec<f64> = (0..=count).map(|k| (least * FACTOR.powi(k)).min(most)).collect();
        let at = |share: f64| (self.log_likelihood(&with(share)), share);
        let coarse: Vec<(f64, f64)> = shares.into_par_iter().map(at).collect();
        let mut best = coarse.into_iter().fold((f64::NEG_INFINITY, 0.0), larger);
        let mut step = FACTOR.sqrt();
        for _ in 0..REFINEMENTS {
            best =
                larger(larger(best, at((best.1 * step).min(most))), at((best.1 / step).max(least)));
            step = step.sqrt();
        }
        (best.0, with(best.1))
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
        let sum: f64 = self.windows.par_iter().map(|w| self.of_window(w, noise)).sum();
        if sum.is_finite() { sum } else { f64::NEG_INFINITY }
    }

    fn of_window(&self, (w, maps, filter, rows): &Linearised, noise: &ProcessNoise) -> f64 {
        let n = maps.width;
        let times = &self.problem.dataset.recordings[w.recording].times;
        let mut unknown = Covariance::known(n);
        let (mut delta, mut next, mut gain) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let mut sum = 0.0;
        let per_sample = rows.len() / w.range.len();
        for (at, k) in w.range.clone().enumerate() {
            let rows = &rows[at * per_sample..(at + 1) * per_sample];
            let innovations = filter.innovations(at);
            next.fill(0.0);
            filter.correct(at, innovations, &mut next);
            let rows = rows.chunks_exact(n).zip(&noise.outputs).enumerate();
            for (o, (c, r)) in rows.filter(|(o, _)| filter.measured(at, *o)) {
                let seen: f64 = c.iter().zip(&delta).map(|(c, d)| c * d).sum();
                let s = unknown.measure(c, r * r, &mut gain);
                let z = (innovations[o] - seen) / s.sqrt();
                delta.iter_mut().zip(&gain).for_each(|(d, g)| *d += g * z);
                sum -= 0.5 * (z * z + s.ln());
            }
            // What the fit's own filter has moved is no deviation from it.
            delta.iter_mut().zip(&next).for_each(|(d, moved)| *d -= moved);
            if k + 1 == times.len() {
                break;
            }
            let (map, stride) = (maps.step(k), maps.stride());
            for (i, next) in next.iter_mut().enumerate() {
                let row = &map[i * stride..i * stride + n];
                *next = row.iter().zip(&delta).map(|(a, d)| a * d).sum();
            }
            std::mem::swap(&mut delta, &mut next);
            unknown.step(map, stride, &noise.driven(n, times[k + 1] - times[k]));
        }
        sum
    }
}

fn larger(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    if b.0 > a.0 { b } else { a }
}
