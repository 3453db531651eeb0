//! Inputs as functions of time, and how sampled ones are held between samples.

use crate::substeps::Place;
use lacuna_numbers::{Linear, Number, copy};
use serde::Deserialize;
use std::borrow::Cow;
use std::ops::Range;

/// How a sampled input behaves between its samples.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Hold {
    /// The last sample is kept until the next one.
    #[default]
    ZeroOrder,
    /// Straight lines between samples.
    Linear,
    /// The smooth signal that has no more in it than its samples tell: what a filter before the
    /// converter, or a generator that knows its signal between the samples, lets through.
    BandLimited,
}

impl Hold {
    /// A sampled input, rows of `m`, along the steps between the samples of a range, each taken in
    /// `substeps` Runge-Kutta steps.
    #[must_use]
    pub fn along<'s, T: Linear>(
        self,
        (times, values): (&[f64], &'s [T]),
        range: Range<usize>,
        m: usize,
        substeps: usize,
    ) -> InputPath<'s, T> {
        let range = range.start..range.end.min(times.len());
        let line = |between| {
            let rows = Cow::Borrowed(&values[range.start * m..range.end * m]);
            InputPath { between, inputs: m, rows_a_sample: 1, rows }
        };
        match self {
            Self::ZeroOrder => line(Between::Held),
            Self::Linear => line(Between::Line),
            Self::BandLimited => {
                let parts = 2 * substeps;
                let rows = Cow::Owned(between((times, values), range.clone(), m, parts));
                InputPath { between: Between::Stages(parts), inputs: m, rows_a_sample: parts, rows }
            }
        }
    }

    /// Sampled inputs and imposed motion along the same steps: rows hold `inputs.0` inputs, which
    /// this says of, then the [`MOTION`] of each of `inputs.1` coordinates. Between two samples a
    /// coordinate moves on the quintic that has the position, velocity and acceleration of both,
    /// which is how the path runs that a smoother of white jerk finds.
    #[must_use]
    pub fn along_motion<'s, T: Number>(
        self,
        (times, values): (&[f64], &'s [T]),
        range: Range<usize>,
        (inputs, coordinates): (usize, usize),
        substeps: usize,
    ) -> InputPath<'s, T> {
        let width = inputs + MOTION * coordinates;
        if coordinates == 0 {
            return self.along((times, values), range, width, substeps);
        }
        let range = range.start..range.end.min(times.len());
        let commands = values.chunks_exact(width).flat_map(|row| &row[..inputs]).copied();
        let commands: Vec<T> = commands.collect();
        let commands = self.along((times, &commands), range.clone(), inputs, substeps);
        let parts = 2 * substeps;
        let row = |k: usize| &values[k * width..(k + 1) * width];
        let mut rows = Vec::with_capacity(range.len() * (parts + 1) * width);
        let mut u = vec![T::ZERO; inputs];
        for (at, k) in range.clone().enumerate().take(range.len().saturating_sub(1)) {
            let (here, next, h) = (row(k), row(k + 1), times[k + 1] - times[k]);
            let command = commands.step(at);
            for part in 0..=parts {
                command.at(Place::of(part, parts), &mut u);
                rows.extend_from_slice(&u);
                let share = part as f64 / parts as f64;
                let ends =
                    here[inputs..].chunks_exact(MOTION).zip(next[inputs..].chunks_exact(MOTION));
                rows.extend(ends.flat_map(|(a, b)| quintic((a, b), h, share)));
            }
        }
        rows.extend(range.last().into_iter().flat_map(row).copied());
        let (between, rows) = (Between::Stages(parts), Cow::Owned(rows));
        InputPath { between, inputs: width, rows_a_sample: parts + 1, rows }
    }
}

/// Entries of a row of inputs that an imposed coordinate has: position, velocity, acceleration.
pub const MOTION: usize = 3;

/// Position, velocity and acceleration after a share of the way of `h` seconds between two of
/// them, on the polynomial of degree five that has both.
fn quintic<T: Linear>((a, b): (&[T], &[T]), h: f64, share: f64) -> [T; MOTION] {
    let less = |x: T, y: T| x + y * -1.0;
    let (q, v, w) = (a[0], a[1] * h, a[2] * (h * h));
    // What is left at the other end of position, velocity and acceleration, in units of the way.
    let d = less(b[0], q + v + w * 0.5);
    let e = less(b[1] * h, v + w);
    let f = less(b[2] * (h * h), w);
    let third = d * 10.0 + e * -4.0 + f * 0.5;
    let fourth = d * -15.0 + e * 7.0 + f * -1.0;
    let fifth = d * 6.0 + e * -3.0 + f * 0.5;
    let [s, s2, s3] = [1, 2, 3].map(|power| share.powi(power));
    let position = q + v * s + w * (0.5 * s2) + (third + fourth * s + fifth * s2) * s3;
    let velocity = v + w * s + (third * 3.0 + fourth * (4.0 * s) + fifth * (5.0 * s2)) * s2;
    let acceleration = w + (third * 6.0 + fourth * (12.0 * s) + fifth * (20.0 * s2)) * s;
    [position, velocity * (1.0 / h), acceleration * (1.0 / (h * h))]
}

/// A sampled input along the steps between some samples. Where nothing is computed between them
/// the samples are those that were given.
#[derive(Clone, Debug)]
pub struct InputPath<'s, T: Clone> {
    between: Between,
    inputs: usize,
    /// The sample itself and those between it and the next.
    rows_a_sample: usize,
    rows: Cow<'s, [T]>,
}

/// What rows say of the way between two samples.
#[derive(Clone, Copy, Debug)]
enum Between {
    /// The first is kept.
    Held,
    /// A straight line.
    Line,
    /// So many parts of it have a row each, and its end.
    Stages(usize),
}

impl<'s, T: Clone> InputPath<'s, T> {
    /// The input at a sample, counted from the first of the range.
    #[inline(always)]
    #[must_use]
    pub fn sample(&self, at: usize) -> &[T] {
        let from = at * self.rows_a_sample * self.inputs;
        &self.rows[from..from + self.inputs]
    }

    /// Along the step from that sample to the next.
    #[inline(always)]
    #[must_use]
    pub fn step(&self, at: usize) -> StepInput<'_, T> {
        match self.between {
            Between::Held => StepInput::Line(self.sample(at), self.sample(at)),
            Between::Line => StepInput::Line(self.sample(at), self.sample(at + 1)),
            Between::Stages(parts) => StepInput::Stages(self.stages(at, parts)),
        }
    }

    #[inline(always)]
    fn stages(&self, at: usize, parts: usize) -> &[T] {
        let from = at * self.rows_a_sample * self.inputs;
        &self.rows[from..from + (parts + 1) * self.inputs]
    }

    /// The numbers that were computed between the samples; 0 where the samples are all there is.
    #[must_use]
    pub fn computed(&self) -> usize {
        if matches!(self.rows, Cow::Owned(_)) { self.rows.len() } else { 0 }
    }

    /// A path of its own, whatever becomes of the samples.
    #[must_use]
    pub fn into_owned(self) -> InputPath<'static, T> {
        let Self { between, inputs, rows_a_sample, rows } = self;
        InputPath { between, inputs, rows_a_sample, rows: Cow::Owned(rows.into_owned()) }
    }
}

impl InputPath<'_, f64> {
    /// The input at a sample as numbers that carry no derivatives.
    #[inline(always)]
    pub fn sample_in<T: Number>(&self, at: usize, u: &mut [T]) {
        constants(self.sample(at), u);
    }

    /// Along the step from a sample to the next, as numbers that carry no derivatives.
    #[inline(always)]
    #[must_use]
    pub fn step_in<T: Number>(&self, at: usize) -> StepInput<'_, T> {
        match self.between {
            Between::Held => StepInput::PlainLine(self.sample(at), self.sample(at)),
            Between::Line => StepInput::PlainLine(self.sample(at), self.sample(at + 1)),
            Between::Stages(parts) => StepInput::PlainStages(self.stages(at, parts)),
        }
    }
}

/// The inputs along a step from sample to sample.
#[derive(Clone, Copy, Debug)]
pub enum StepInput<'a, T> {
    /// On a straight line from the first row to the second.
    Line(&'a [T], &'a [T]),
    /// At the beginning, the middle and the end of each of the Runge-Kutta steps, row by row.
    Stages(&'a [T]),
    /// On a straight line, carrying no derivatives.
    PlainLine(&'a [f64], &'a [f64]),
    /// At the stages, row by row, carrying no derivatives.
    PlainStages(&'a [f64]),
}

impl<T: Number> StepInput<'_, T> {
    /// At a place on the way; parts of it are as many as there are between the rows.
    #[inline(always)]
    pub(crate) fn at(self, place: Place, u: &mut [T]) {
        match self {
            Self::Line(here, next) => {
                let share = place.share();
                for (u, (a, b)) in u.iter_mut().zip(here.iter().zip(next)) {
                    T::by_itself();
                    *u = between_samples(*a, *b, share);
                }
            }
            Self::PlainLine(here, next) => {
                let share = place.share();
                for (u, (a, b)) in u.iter_mut().zip(here.iter().zip(next)) {
                    *u = T::constant(between_samples(*a, *b, share));
                }
            }
            Self::Stages(rows) => match Among::of(u.len(), place) {
                Among::Row(from) => copy(&rows[from..from + u.len()], u),
                Among::Three(from, weights) => weigh(&weights, &rows[from..], u),
            },
            Self::PlainStages(rows) => match Among::of(u.len(), place) {
                Among::Row(from) => constants(&rows[from..from + u.len()], u),
                Among::Three(from, weights) => {
                    let rows = rows[from..from + 3 * u.len()].chunks_exact(u.len());
                    u.fill(T::constant(0.0));
                    for (weight, row) in weights.into_iter().zip(rows) {
                        u.iter_mut().zip(row).for_each(|(u, x)| *u = *u + T::constant(weight * x));
                    }
                }
            },
        }
    }
}

/// Where the rows of a step say its input.
enum Among {
    /// In one of them, which begins there.
    Row(usize),
    /// On the parabola through the beginning, the middle and the end of the Runge-Kutta step about it, weighted.
    Three(usize, [f64; 3]),
}

impl Among {
    /// At a place, of rows of `m`.
    #[inline(always)]
    fn of(m: usize, place: Place) -> Self {
        let (whole, rest) = place.parts();
        if rest == 0.0 {
            return Self::Row(whole * m);
        }
        let first = whole - whole % 2;
        let x = (whole - first) as f64 + rest;
        let weights = [0.5 * (x - 1.0) * (x - 2.0), x * (2.0 - x), 0.5 * x * (x - 1.0)];
        Self::Three(first * m, weights)
    }
}

/// A share of the way from one to another.
#[inline(always)]
fn between_samples<T: Linear>(here: T, next: T, share: f64) -> T {
    here + (next + here * -1.0) * share
}

/// Plain numbers in another kind, without derivatives.
#[inline(always)]
fn constants<T: Number>(plain: &[f64], u: &mut [T]) {
    for (u, value) in u.iter_mut().zip(plain) {
        *u = T::constant(*value);
    }
}

/// Of a band-limited series with rows of `m`: `parts` rows a sample of a range, the sample itself
/// and those between it and the next, and the last sample.
fn between<T: Linear>(
    (times, values): (&[f64], &[T]),
    range: Range<usize>,
    m: usize,
    parts: usize,
) -> Vec<T> {
    let mut rows = Vec::with_capacity((range.len() * parts + 1) * m);
    let Some(last) = range.clone().last() else { return rows };
    // The same for every step far from the ends and evenly sampled.
    let mut usual: Vec<Vec<f64>> = vec![];
    for k in range.start..last {
        rows.extend_from_slice(&values[k * m..(k + 1) * m]);
        let near = Near::of(times, k);
        let weights = |part| {
            let t = times[k] + (times[k + 1] - times[k]) * part as f64 / parts as f64;
            weights(&times[near.samples.clone()], t)
        };
        let is_usual = near.even && near.samples.len() == 2 * REACH;
        if is_usual && usual.is_empty() {
            usual = (1..parts).map(weights).collect();
        }
        for part in 1..parts {
            let from = rows.len();
            rows.resize(from + m, T::ZERO);
            let about = &values[near.samples.start * m..near.samples.end * m];
            if is_usual {
                weigh(&usual[part - 1], about, &mut rows[from..]);
            } else {
                weigh(&weights(part), about, &mut rows[from..]);
            }
        }
    }
    rows.extend_from_slice(&values[last * m..(last + 1) * m]);
    rows
}

/// Samples on either side whose polynomial is as good as band-limited up to two thirds of the
/// highest frequency that samples tell of (to 3e-3, and up to a half to 3e-6).
const REACH: usize = 16;
/// Where samples are not evenly spaced, polynomials through many of them go astray.
const UNEVEN_REACH: usize = 2;

/// The samples about a step whose polynomial is the band-limited signal there.
struct Near {
    /// As many before as after, fewer near the ends.
    samples: Range<usize>,
    /// Whether they are evenly spaced.
    even: bool,
}

impl Near {
    /// Those about the step from sample `k` to the next.
    fn of(times: &[f64], k: usize) -> Self {
        let about = |reach: usize| k + 1 - reach..k + 1 + reach;
        let reach = REACH.min(k + 1).min(times.len() - 1 - k);
        let near = &times[about(reach)];
        let step = (near[near.len() - 1] - near[0]) / (near.len() - 1) as f64;
        let even = near.windows(2).all(|p| (p[1] - p[0] - step).abs() < 1e-3 * step);
        Self { samples: about(if even { reach } else { reach.min(UNEVEN_REACH) }), even }
    }
}

/// Weights of samples in the polynomial through them, at time `t`.
fn weights(times: &[f64], t: f64) -> Vec<f64> {
    let weight = |(l, here): (usize, &f64)| {
        let others = times.iter().enumerate().filter(|(k, _)| *k != l);
        others.map(|(_, other)| (t - other) / (here - other)).product()
    };
    times.iter().enumerate().map(weight).collect()
}

/// The weighted sum of rows.
fn weigh<T: Linear>(weights: &[f64], rows: &[T], u: &mut [T]) {
    u.fill(T::ZERO);
    for (weight, row) in weights.iter().zip(rows.chunks_exact(u.len().max(1))) {
        u.iter_mut().zip(row).for_each(|(u, value)| *u = *u + *value * *weight);
    }
}

/// An input signal `u(t)`.
pub trait Input: Sync {
    /// Value at time `t` within the integration step that began at `start <= t`, into `u`.
    ///
    /// A held input jumps at its samples; a step that ends on a sample must still see
    /// the value from before the jump, which is why the step's beginning is given.
    fn value(&self, start: f64, t: f64, u: &mut [f64]);

    /// Times at which the signal may jump, in increasing order. Integration steps do not
    /// reach across them.
    fn breakpoints(&self) -> &[f64] {
        &[]
    }
}

/// A smooth input given as a function of time.
pub struct InputFn<F: Fn(f64, &mut [f64]) + Sync>(pub F);

impl<F: Fn(f64, &mut [f64]) + Sync> Input for InputFn<F> {
    fn value(&self, _start: f64, t: f64, u: &mut [f64]) {
        (self.0)(t, u);
    }
}

/// A sampled input: `values[k * m + j]` is channel `j` at `times[k]`.
#[derive(Clone, Debug)]
pub struct SampledInput<'a> {
    /// Sample times, strictly increasing.
    pub times: &'a [f64],
    /// Samples, row-major `times.len() x m`.
    pub values: &'a [f64],
    /// What happens between the samples.
    pub hold: Hold,
}

impl SampledInput<'_> {
    fn channels(&self) -> usize {
        self.values.len() / self.times.len().max(1)
    }
}

/// Index of the last sample at or before `t` (0 before the first one).
fn last_sample(times: &[f64], t: f64) -> usize {
    // Times computed as k * dt may fall short of a sample by rounding.
    let slack = 1e-9 * (1.0 + t.abs());
    times.partition_point(|&s| s <= t + slack).saturating_sub(1)
}

impl Input for SampledInput<'_> {
    fn value(&self, start: f64, t: f64, u: &mut [f64]) {
        let m = self.channels();
        let k = last_sample(self.times, start);
        let here = &self.values[k * m..(k + 1) * m];
        if self.hold == Hold::ZeroOrder || k + 1 == self.times.len() {
            u.copy_from_slice(here);
            return;
        }
        if self.hold == Hold::BandLimited {
            let near = Near::of(self.times, k).samples;
            let rows = &self.values[near.start * m..near.end * m];
            weigh(&weights(&self.times[near], t), rows, u);
            return;
        }
        let next = &self.values[(k + 1) * m..(k + 2) * m];
        let share = (t - self.times[k]) / (self.times[k + 1] - self.times[k]);
        for ((u, a), b) in u.iter_mut().zip(here).zip(next) {
            *u = a + share * (b - a);
        }
    }

    fn breakpoints(&self) -> &[f64] {
        self.times
    }
}

/// Samples of a smooth input, joined by cubics through four neighbouring samples (a polynomial
/// through all where there are fewer): `values[k * m + j]` is channel `j` at `times[k]`.
#[derive(Clone, Debug)]
pub struct SmoothInput<'a> {
    /// Sample times, strictly increasing.
    pub times: &'a [f64],
    /// Samples, row-major `times.len() x m`.
    pub values: &'a [f64],
}

impl Input for SmoothInput<'_> {
    fn value(&self, start: f64, t: f64, u: &mut [f64]) {
        let (samples, m) = (self.times.len(), u.len());
        let count = samples.min(4);
        let first = last_sample(self.times, start).saturating_sub(1).min(samples - count);
        let rows = &self.values[first * m..(first + count) * m];
        weigh(&weights(&self.times[first..first + count], t), rows, u);
    }
}

#[cfg(test)]
mod tests {
    use super::{Hold, Input, Place, SampledInput, SmoothInput};

    /// A sum of sines up to two thirds of the highest frequency, seen between its samples.
    #[test]
    fn a_band_limited_input_is_what_was_sampled() {
        let step = 0.01;
        let signal = |t: f64| {
            let part = |share: f64| (share * std::f64::consts::PI / step * t + share).sin();
            part(0.1) + part(0.4) + part(0.66)
        };
        let times: Vec<f64> = (0..200).map(|k| step * f64::from(k)).collect();
        let values: Vec<f64> = times.iter().map(|&t| signal(t)).collect();
        let hold = Hold::BandLimited;
        let input = SampledInput { times: &times, values: &values, hold };
        let stages = |range| hold.along((&times, &values), range, 1, 2).rows.into_owned();
        let part = stages(50..61);
        let stages = stages(0..200);
        assert_eq!((stages.len(), part.len()), (199 * 4 + 1, 41));
        for (k, &t) in times[..199].iter().enumerate() {
            for part in 0..4 {
                let at = t + step * f64::from(part) / 4.0;
                let mut u = [f64::NAN];
                input.value(t, at, &mut u);
                assert!((u[0] - stages[4 * k + part as usize]).abs() < 1e-9);
                // Near the ends fewer samples tell of it.
                let far = (super::REACH..times.len() - super::REACH).contains(&(k + 1));
                let off = (u[0] - signal(at)).abs();
                assert!(off < 3e-3 || !far, "{at}: {} {}", u[0], signal(at));
            }
        }
        assert!(part.iter().zip(&stages[200..]).all(|(a, b)| (a - b).abs() < 1e-9));
    }

    /// Beside a held command, which jumps at samples, a quintic motion is met exactly.
    #[test]
    fn imposed_motion_runs_on_between_samples() {
        let motion = |t: f64| {
            let p = |c: [f64; 6]| (0..6).map(|k| c[k] * t.powi(k as i32)).sum::<f64>();
            let q = [0.3, -1.0, 2.0, 0.5, -0.7, 0.2];
            let rate = |c: [f64; 6]| {
                std::array::from_fn(|k| c.get(k + 1).map_or(0.0, |c| c * (k + 1) as f64))
            };
            [p(q), p(rate(q)), p(rate(rate(q)))]
        };
        let times = [0.0, 0.3, 0.5, 1.1];
        let held = [5.0, -1.0, 2.0, 7.0];
        let values: Vec<f64> = times
            .iter()
            .zip(held)
            .flat_map(|(&t, u)| std::iter::once(u).chain(motion(t)))
            .collect();
        let path = Hold::ZeroOrder.along_motion((&times, &values), 1..9, (1, 1), 2);
        for (at, pair) in times[1..].windows(2).enumerate() {
            let mut samples = path.sample(at).iter().zip(&values[4 * (at + 1)..4 * (at + 2)]);
            assert!(samples.all(|(a, b)| (a - b).abs() < 1e-14), "{at}");
            for part in 0..=4 {
                let mut u = [f64::NAN; 4];
                path.step(at).at(Place::of(part, 4), &mut u);
                assert_eq!(u[0], held[at + 1]);
                let t = pair[0] + (pair[1] - pair[0]) * part as f64 / 4.0;
                for (found, expected) in u[1..].iter().zip(motion(t)) {
                    assert!((found - expected).abs() < 1e-10, "{t}: {found} {expected}");
                }
            }
        }
        assert_eq!(path.sample(2), &values[12..]);
    }

    #[test]
    fn a_smooth_input_runs_along_cubics() {
        let times = [0.0, 0.4, 1.0, 1.5, 2.0, 2.6];
        let cubic = |t: f64| [t * t * t - t, 2.0 - t * t];
        let values: Vec<f64> = times.iter().flat_map(|&t| cubic(t)).collect();
        let at = |samples: usize, start: f64, t: f64| {
            let input = SmoothInput { times: &times[..samples], values: &values[..2 * samples] };
            let mut u = [f64::NAN; 2];
            input.value(start, t, &mut u);
            u
        };
        for (start, t) in [(0.0, 0.1), (0.4, 0.9), (1.0, 1.5), (2.0, 2.5), (2.6, 2.6)] {
            for (found, expected) in at(6, start, t).into_iter().zip(cubic(t)) {
                assert!((found - expected).abs() < 1e-12, "{t}: {found} {expected}");
            }
        }
        // Two samples: a line.
        assert!((at(2, 0.0, 0.2)[1] - 1.92).abs() < 1e-12);
    }
}
