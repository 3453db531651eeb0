//! Lost counts and glitches: samples that neither noise nor motion explains.
//!
//! A sample is an outlier where its neighbours are one motion and it is not on it. Around the
//! sample at t_k stand ten neighbours on either side; a polynomial of degree five through them,
//! by least squares, predicts the sample with a standard deviation of sigma sqrt(1 + h):
//!
//! ```text
//! z_k = (y_k - p(t_k)) / (sigma sqrt(1 + h)),   h = a' (A'A)^-1 a
//! ```
//!
//! with A the powers of the neighbours' times and a those of t_k. It is marked where
//!
//! 1. noise cannot be it: |z_k| > sqrt(2 ln(N / alpha)), which less than alpha of N Gaussian
//!    samples exceed, since P(|e| > z) <= exp(-z^2 / 2); for a channel with a quantum, beyond one
//!    quantum more;
//! 2. its neighbours, at most two of them left out that are off as far, are a motion with that
//!    noise: the sum of their squared residuals is below the 99.9 % point of its chi-square
//!    distribution. After an impact or a stop they are not;
//! 3. no motion that ends or begins there passes through it: it lies on the same side of what
//!    either half of the neighbours alone extrapolates, at rest (the next sample itself), at its
//!    speed and at its acceleration. The corner of an impact, a step of a velocity and a sample
//!    that was taken early or late lie between these;
//! 4. it stands alone, or as one of two whose first and last step are larger than those of the
//!    motion: of all steps of the channel, less than one in a window is so large;
//! 5. where a recording or a piece of it begins or ends, with fewer than three neighbours on a side:
//!    its steps are more than five times as large as all those of the neighbours and of the channel
//!    away from its ends. There is one side only for 3. to ask, and the other may be a motion.
//!
//! A side with fewer than ten neighbours has the other one make up for them, so that the polynomial
//! is a prediction from within at the ends.
//!
//! sigma is the noise of the channel, at least the local scale (a normalised median) of the
//! deviations before the sample and after it: where the motion is too fast for the sampling, the
//! deviations are as large all around and nothing is marked. A side that is mostly the sample's own
//! neighbours says nothing: what predicts them is off where the sample is. Marked samples are left
//! out, noise and scale are computed again, until the marks stay the same.
//!
//! More than three in a window of 21 samples are no glitches and never marked; where more than one
//! sample in a window is off, on average, none is. A pulse of one or two samples that leaves no
//! trace before and after cannot be told from a glitch: a velocity that slips for less than two
//! samples is sampled too slowly. Nor can a beginning that is over after one or two samples, of a
//! channel that never moves as fast again: a lag begins so if it is shorter than 0.6 samples.
//!
//! | on paper | in code |
//! | --- | --- |
//! | rows of the outliers | [`Outliers::rows`] |
//! | noise standard deviation without them | [`Outliers::noise`] |

mod window;

use crate::noise::{GAUSSIAN_MEDIAN, NoiseEstimate, estimate_noise_pooled};
use crate::sampling::Sampling;
use crate::signal::SignalError;
use std::ops::Range;
use window::{Expected, Window};

/// Neighbours on either side: in all more than three for each coefficient of the polynomial, so
/// that it cannot follow a motion that changes its way within the window.
const REACH: usize = 10;
/// Samples of a window.
const WINDOW: usize = 2 * REACH + 1;
/// Degree of the motion: as the differences of sixth order that the noise is estimated from.
const DEGREE: usize = 5;
/// Fewest neighbours: more than two for each coefficient of the polynomial.
const FEWEST: usize = FEWEST_BESIDE + REACH;
/// Fewest neighbours on a side: from fewer, it has no acceleration, and the sample is at an end.
const FEWEST_BESIDE: usize = 3;
/// Times by which the steps of an outlier at an end exceed all others. The steps of a lag of tau
/// samples fall by exp(1 / tau): one whose first step is so large is over before the next sample.
const LEAP_AT_END: f64 = 5.0;
/// Most outliers of a window: one sample in seven. With more, the rest is not most of a motion.
const MOST_TOGETHER: usize = 3;
/// Most outliers in a row. Independent ones hardly ever are three in a row; the answer of a drive
/// to a step, sampled slowly, often is three samples long.
const LONGEST_RUN: usize = 2;
/// Samples of pure noise that may be marked, of all samples of a channel.
const FALSE_MARKS: f64 = 0.01;
/// Standard deviations that one Gaussian value in a thousand exceeds on either side: samples
/// nearer to an extrapolated motion may belong to it.
const PLAUSIBLE_SD: f64 = 3.29;
/// Standard deviations that one Gaussian value in a thousand exceeds upwards: so many outliers
/// are overlooked since their neighbours, by chance, look like no motion.
const UPPER_SD: f64 = 3.09;
/// Samples on either side that the local scale is the median of: four windows on either side, so
/// that it takes several outliers to move it.
const SURROUNDINGS: usize = 4 * WINDOW;
/// Fewest of these for the scale of a side, where the other has more: at an end an outlier is a
/// neighbour of twice [`REACH`], and these must not be most of them.
const FEWEST_AROUND: usize = 2 * WINDOW;
/// Deviations below this share of the largest value are rounding of whoever computed them.
const ROUNDING: f64 = 1e-7;
/// Times that marks and noise are computed anew. Each time the noise is nearer the truth; marks
/// that alternate hang on a threshold, where either is right.
const ROUNDS: usize = 4;

/// The outliers of one channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Outliers {
    /// Their rows in each recording, in order.
    pub rows: Vec<Vec<usize>>,
    /// The noise without them.
    pub noise: NoiseEstimate,
}

/// The outliers of one channel over several recordings, each `(time, values)`, and the noise
/// without them; NaN values are missing samples. Module documentation tells how; the work is
/// linear in the number of samples.
///
/// # Errors
/// As [`estimate_noise_pooled`].
pub fn find_outliers(recordings: &[(&[f64], &[f64])]) -> Result<Outliers, SignalError> {
    let mut noise = estimate_noise_pooled(recordings)?;
    let mut all: Vec<_> =
        recordings.iter().map(|(time, values)| Series::new(time, values)).collect();
    let samples = recordings.iter().flat_map(|r| r.1).filter(|v| !v.is_nan()).count();
    let limit = (2.0 * (samples as f64 / FALSE_MARKS).ln()).sqrt();
    let (resolution, step) = (resolution(recordings), usual_step(recordings));
    for _ in 0..ROUNDS {
        let quantum = noise.quantum.unwrap_or(0.0).max(resolution);
        let largest = all.iter().map(Series::largest_step).fold(0.0, f64::max);
        let sd = least_sd(&all, noise.sd, quantum);
        let expected = Expected { sd, limit, quantum, step, largest };
        let mut rows: Vec<_> =
            all.iter().map(|series| isolated(series.outliers(expected))).collect();
        if rows.iter().map(Vec::len).sum::<usize>() * WINDOW > samples {
            rows = vec![vec![]; recordings.len()];
        }
        if rows.iter().zip(&all).all(|(rows, series)| *rows == series.marked) {
            break;
        }
        all.iter_mut().zip(rows).for_each(|(series, rows)| series.mark(rows));
        let pairs: Vec<_> = all.iter().map(|series| (series.time, &series.clean[..])).collect();
        noise = estimate_noise_pooled(&pairs)?;
    }
    Ok(Outliers { rows: all.into_iter().map(|series| series.marked).collect(), noise })
}

impl Outliers {
    /// Number of outliers in all recordings.
    #[must_use]
    pub fn count(&self) -> usize {
        self.rows.iter().map(Vec::len).sum()
    }
}

/// Sizes of the steps between consecutive samples.
fn steps<'a>(recordings: &'a [(&[f64], &[f64])]) -> impl Iterator<Item = f64> + 'a {
    let sizes = |values: &'a [f64]| values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    recordings.iter().flat_map(move |r| sizes(r.1)).filter(|size| !size.is_nan())
}

/// The smallest step that is one. Between values with continuous noise it is next to nothing;
/// between rounded ones it is a quantum, also where there are too few of them, or too long a rest,
/// for [`NoiseEstimate::quantum`] to be seen. Zero without any.
pub(crate) fn resolution(recordings: &[(&[f64], &[f64])]) -> f64 {
    let values = recordings.iter().flat_map(|r| r.1);
    let largest = values.fold(0.0, |m: f64, v| m.max(v.abs()));
    let smallest = steps(recordings).filter(|size| *size > 1e-9 * largest).reduce(f64::min);
    smallest.unwrap_or(0.0)
}

/// The step that less than one in a window exceeds: no more samples than that may be outliers.
fn usual_step(recordings: &[(&[f64], &[f64])]) -> f64 {
    let mut sizes: Vec<f64> = steps(recordings).collect();
    let rank = sizes.len() - sizes.len() / WINDOW;
    if rank == sizes.len() {
        return sizes.into_iter().fold(0.0, f64::max);
    }
    *sizes.select_nth_unstable_by(rank, f64::total_cmp).1
}

/// The standard deviation that samples are weighed with, where their surroundings have no larger.
fn least_sd(all: &[Series], noise_sd: f64, quantum: f64) -> f64 {
    let clean = all.iter().flat_map(|series| &series.clean);
    let largest = clean.fold(0.0, |m: f64, v| m.max(v.abs()));
    noise_sd.max(quantum / 12f64.sqrt()).max(ROUNDING * largest).max(f64::MIN_POSITIVE)
}

/// Rows of which no window holds more than [`MOST_TOGETHER`].
fn isolated(rows: Vec<usize>) -> Vec<usize> {
    let mut crowded = vec![false; rows.len()];
    for first in 0..rows.len().saturating_sub(MOST_TOGETHER) {
        if rows[first + MOST_TOGETHER] - rows[first] < WINDOW {
            crowded[first..=first + MOST_TOGETHER].fill(true);
        }
    }
    rows.into_iter().zip(crowded).filter(|(_, crowded)| !crowded).map(|(row, _)| row).collect()
}

/// One channel of one recording, and what is marked of it so far.
struct Series<'a> {
    time: &'a [f64],
    values: &'a [f64],
    /// Usual step (s).
    step: f64,
    /// The samples beside each, outliers among them.
    all: Neighbours,
    marked: Vec<usize>,
    /// Values without what is marked, and the samples beside each that are left.
    clean: Vec<f64>,
    left: Neighbours,
    /// How far each sample is from what the samples beside it that are left predict; NaN where too
    /// few are.
    deviations: Vec<f64>,
}

impl<'a> Series<'a> {
    fn new(time: &'a [f64], values: &'a [f64]) -> Self {
        let mut series = Self {
            time,
            values,
            step: Sampling::of(time).step,
            all: Neighbours::of(values),
            marked: vec![],
            clean: values.to_vec(),
            left: Neighbours::of(values),
            deviations: vec![],
        };
        series.deviations = (0..values.len()).map(|row| series.deviation(row)).collect();
        series
    }

    /// Marks these samples and no others. Deviations change only beside samples whose mark does.
    fn mark(&mut self, rows: Vec<usize>) {
        self.clean.copy_from_slice(self.values);
        rows.iter().for_each(|&row| self.clean[row] = f64::NAN);
        self.left = Neighbours::of(&self.clean);
        let before = std::mem::replace(&mut self.marked, rows);
        let differs = |row: &&usize| {
            before.binary_search(row).is_ok() != self.marked.binary_search(row).is_ok()
        };
        let changed: Vec<_> =
            before.iter().chain(&self.marked).filter(differs).map(|&row| self.near(row)).collect();
        for row in changed.into_iter().flatten() {
            self.deviations[row] = self.deviation(row);
        }
    }

    /// The rows that a sample may be a neighbour of.
    fn near(&self, row: usize) -> Range<usize> {
        let reach = (2 * REACH) as f64 * self.step;
        let (time, here) = (self.time, self.time[row]);
        let first = time[..row].partition_point(|t| (t - here).abs() > reach);
        first..row + time[row..].partition_point(|t| (t - here).abs() <= reach)
    }

    fn deviation(&self, row: usize) -> f64 {
        self.around(&self.left, row).map_or(f64::NAN, |window| window.deviation())
    }

    fn outliers(&self, expected: Expected) -> Vec<usize> {
        let Expected { sd, limit, .. } = expected;
        let beyond_noise = |row: &usize| self.deviations[*row].abs() > limit * sd;
        let candidates: Vec<usize> = (0..self.deviations.len()).filter(beyond_noise).collect();
        if candidates.is_empty() {
            return candidates;
        }
        let scales = self.local_scales();
        let scale = |row: usize| scales[row].max(sd);
        let beyond = |row: &usize| self.deviations[*row].abs() > limit * scale(*row);
        // An outlier beside a larger one may deviate less.
        let near = |row: usize| {
            let reach = LONGEST_RUN - 1;
            row.saturating_sub(reach)..(row + reach + 1).min(self.deviations.len())
        };
        let mut suspects: Vec<usize> =
            candidates.into_iter().filter(beyond).flat_map(near).collect();
        suspects.sort_unstable();
        suspects.dedup();
        let is_outlier = |row: &usize| {
            let expected = Expected { sd: scale(*row), ..expected };
            self.around(&self.all, *row).is_some_and(|w| w.is_outlier(expected))
        };
        suspects.into_iter().filter(is_outlier).collect()
    }

    /// The largest step of what is left between samples that are at no end.
    fn largest_step(&self) -> f64 {
        let inner: Vec<bool> = (0..self.values.len()).map(|row| !self.is_at_end(row)).collect();
        let steps = self.clean.windows(2).zip(inner.windows(2));
        let steps = steps.filter(|(_, inner)| inner[0] && inner[1]);
        steps.map(|(pair, _)| (pair[1] - pair[0]).abs()).fold(0.0, f64::max)
    }

    fn is_at_end(&self, row: usize) -> bool {
        let (before, after) = self.beside(&self.left, row);
        before.len().min(after.len()) < FEWEST_BESIDE
    }

    /// Standard deviation of the deviations before each row or after it, by their median: the
    /// larger one, since noise and motion may begin or end there.
    fn local_scales(&self) -> Vec<f64> {
        let size = |(deviation, clean): (&f64, &f64)| {
            if clean.is_nan() { f64::NAN } else { deviation.abs() }
        };
        let sizes: Vec<f64> = self.deviations.iter().zip(&self.clean).map(size).collect();
        let medians = running_medians(&sizes, SURROUNDINGS);
        let scale = |row: usize| {
            let sides = [medians[row], medians[row + 1 + SURROUNDINGS]];
            let most = sides[0].1.max(sides[1].1);
            // A side without any has NaN, which is not the larger one.
            let told = sides.iter().filter(|(_, count)| *count >= FEWEST_AROUND.min(most));
            told.fold(f64::NAN, |larger, (median, _)| larger.max(*median))
        };
        (0..sizes.len()).map(|row| scale(row) / GAUSSIAN_MEDIAN).collect()
    }

    /// A sample with its neighbours; none if it is missing or has too few.
    fn around(&self, neighbours: &Neighbours, row: usize) -> Option<Window> {
        let Self { time, values, step, .. } = *self;
        if values[row].is_nan() {
            return None;
        }
        let from_here = |&r: &usize| ((time[r] - time[row]) / step, values[r] - values[row]);
        let (before, after) = self.beside(neighbours, row);
        Window::of(before.iter().map(from_here), after.iter().map(from_here))
    }

    /// The neighbours before a row and after it: [`REACH`] on either side, more where the other has
    /// fewer, and none farther than twice as many steps.
    fn beside<'n>(&self, neighbours: &'n Neighbours, row: usize) -> (&'n [usize], &'n [usize]) {
        let Self { time, step, .. } = *self;
        let near = |r: &usize| (time[*r] - time[row]).abs() <= (2 * REACH) as f64 * step;
        let (before, after) = neighbours.beside(row);
        let before = &before[before.partition_point(|r| !near(r))..];
        let after = &after[..after.partition_point(near)];
        let most = |other: &[usize]| 2 * REACH - other.len().min(REACH);
        let (left, right) = (before.len().min(most(after)), after.len().min(most(before)));
        (&before[before.len() - left..], &after[..right])
    }
}

/// The samples of a series that are there.
struct Neighbours {
    /// Their rows, in order.
    rows: Vec<usize>,
    /// Number of those that come before each row.
    before: Vec<usize>,
}

impl Neighbours {
    /// Those that are not NaN.
    fn of(values: &[f64]) -> Self {
        let rows: Vec<usize> = (0..values.len()).filter(|&row| !values[row].is_nan()).collect();
        let mut before = Vec::with_capacity(values.len() + 1);
        before.push(0);
        for value in values {
            before.push(before[before.len() - 1] + usize::from(!value.is_nan()));
        }
        Self { rows, before }
    }

    /// Up to twice [`REACH`] before a row, and up to as many after it.
    fn beside(&self, row: usize) -> (&[usize], &[usize]) {
        let (own, after) = (self.before[row], self.before[row + 1]);
        let before = &self.rows[own.saturating_sub(2 * REACH)..own];
        (before, &self.rows[after..(after + 2 * REACH).min(self.rows.len())])
    }
}

/// Medians of the `width` values before each row, from 0 to `values.len() + width`; beyond either
/// end there are none, and NaN is none. Each with the number of values it is of. Sorted values are kept
/// from row to row: the work is linear.
fn running_medians(values: &[f64], width: usize) -> Vec<(f64, usize)> {
    let present = |row: usize| values.get(row).copied().filter(|value| !value.is_nan());
    let mut sorted: Vec<f64> = Vec::with_capacity(width + 1);
    let mut medians = vec![(f64::NAN, 0)];
    for row in 0..values.len() + width {
        let place = |sorted: &[f64], value: f64| sorted.partition_point(|other| *other < value);
        if let Some(gone) = row.checked_sub(width).and_then(present) {
            sorted.remove(place(&sorted, gone));
        }
        if let Some(new) = present(row) {
            sorted.insert(place(&sorted, new), new);
        }
        let (count, half) = (sorted.len(), sorted.len() / 2);
        let median = match count % 2 {
            _ if count == 0 => f64::NAN,
            1 => sorted[half],
            _ => 0.5 * (sorted[half - 1] + sorted[half]),
        };
        medians.push((median, count));
    }
    medians
}

#[cfg(test)]
mod tests {
    use super::running_medians;
    use crate::signal::median;

    #[test]
    fn running_medians_are_medians() {
        let values: Vec<f64> = (0..300)
            .map(|k| {
                if k % 11 == 3 || (100..140).contains(&k) {
                    f64::NAN
                } else {
                    f64::from((k * k) % 37)
                }
            })
            .collect();
        let width = 12;
        let found = running_medians(&values, width);
        assert_eq!(found.len(), values.len() + width + 1);
        for (row, (found, count)) in found.iter().enumerate() {
            let within = row.saturating_sub(width)..row.min(values.len());
            let mut present: Vec<f64> =
                values[within].iter().copied().filter(|v| !v.is_nan()).collect();
            let expected = median(&mut present);
            assert!(*found == expected || found.is_nan() && expected.is_nan(), "{row}");
            assert_eq!(*count, present.len(), "{row}");
        }
    }
}
