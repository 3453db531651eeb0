//! Spectral lines of what the measured motion needs beside the model: a disturbance that repeats shows as one, however
//! often it repeats while a recording lasts.
//!
//! ```text
//! S(w) = |sum_k h_k r_k e^(-i w t_k)|^2,   r = a - f(x, u)
//! ```
//!
//! r being the acceleration that the smoothed motion has beyond the model's, h a Hann window over each recording. The sum
//! goes over all recordings, whose disturbance has one phase. A line stands out of its neighbours by the ratio of S to
//! their mean: differences of what is smoothed grow with the frequency.

use super::Problem;
use crate::trajectories::SmoothedRecording;
use lacuna_effects::{GRID, LINES};
use lacuna_plants::model::System;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Periods in the recordings where they end at the latest: a budget.
const PERIODS: f64 = 640.0;
/// Samples of what is searched as a whole; of more, only a part is.
const SEARCHED: usize = 1 << 14;
/// Frequencies to either side that a line is compared with.
const BESIDE: usize = 20;
/// Samples over which a phase is turned on before it is computed anew.
const TURNED: usize = 64;

/// The lines of each channel, from where a grid of frequencies ends to a quarter of the sampling rate; none of recordings of
/// which only a part is searched, nor of what nobody measures, which moves as the model says, or of levels and
/// temperatures, which hardly move with what is fast.
pub(super) fn of_channels(problem: &Problem, (begin, end): (f64, f64)) -> Vec<[f64; LINES]> {
    let (model, smoothed) = (problem.model, &problem.smoothed);
    let moves =
        |c: usize| model.is_coordinate(c) && !problem.hidden().contains(&model.coordinate_index(c));
    let turn = TAU / (end - begin);
    let to = (PERIODS * turn).min(0.25 * TAU / problem.sample);
    // A spectral line is as wide as two and a half of these.
    let frequency = |k: u32| GRID * turn + 0.4 * turn * f64::from(k);
    let frequencies: Vec<f64> = (0..).map(frequency).take_while(|w| *w < to).collect();
    let mut lines = vec![[0.0; LINES]; model.channels()];
    let samples: usize = smoothed.iter().map(SmoothedRecording::len).sum();
    if frequencies.is_empty() || samples > SEARCHED {
        return lines;
    }
    let system = System::new(model);
    let missing: Vec<Vec<Vec<f64>>> = smoothed.iter().map(|s| missing(&system, s)).collect();
    for c in (0..model.channels()).filter(|c| moves(*c)) {
        let v = model.place(c).v;
        let of = |(s, all): (_, &Vec<Vec<f64>>)| {
            let s: &SmoothedRecording = s;
            (&s.times[..], all.iter().map(|rates| rates[v]).collect())
        };
        let parts: Vec<Part> = smoothed.iter().zip(&missing).map(of).collect();
        lines[c] = strongest(&parts, &frequencies);
    }
    lines
}

/// Rates of the machine's state along a motion beside those that the model has there, sample by sample; 0 where it has none.
fn missing(system: &System, s: &SmoothedRecording) -> Vec<Vec<f64>> {
    let mut all = s.rates_of(system);
    for (k, rates) in all.iter_mut().enumerate() {
        for (i, rate) in rates.iter_mut().enumerate() {
            let beside = s.rate(k, i) - *rate;
            *rate = if beside.is_finite() { beside } else { 0.0 };
        }
    }
    all
}

/// Times of a recording, and what is looked at there.
type Part<'a> = (&'a [f64], Vec<f64>);

/// The lines that stand out most of some frequencies at equal distances (rad/s), zeros behind them.
fn strongest(parts: &[Part], frequencies: &[f64]) -> [f64; LINES] {
    let tapered: Vec<Part> = parts.iter().map(|(times, r)| (*times, tapered(r))).collect();
    let power = |w: &f64| {
        let sums = tapered.iter().map(|(times, r)| turned(times, r, *w));
        let (re, im) = sums.fold((0.0, 0.0), |(a, b), (re, im)| (a + re, b + im));
        re * re + im * im
    };
    let powers: Vec<f64> = frequencies.par_iter().map(power).collect();
    let last = powers.len().saturating_sub(1);
    let is_peak = |k: &usize| powers[*k] > powers[k - 1] && powers[*k] >= powers[k + 1];
    let stands_out = |k: usize| {
        let around = &powers[k.saturating_sub(BESIDE)..(k + BESIDE + 1).min(powers.len())];
        (powers[k] / (around.iter().sum::<f64>() / around.len() as f64), frequencies[k])
    };
    let mut peaks: Vec<(f64, f64)> = (1..last).filter(is_peak).map(stands_out).collect();
    peaks.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut strongest = [0.0; LINES];
    strongest.iter_mut().zip(&peaks).for_each(|(line, peak)| *line = peak.1);
    strongest
}

/// A series without its mean, fading in and out.
fn tapered(series: &[f64]) -> Vec<f64> {
    let mean = series.iter().sum::<f64>() / series.len().max(1) as f64;
    let turn = TAU / (series.len() + 1) as f64;
    let window = |k: usize| 0.5 - 0.5 * (turn * (k + 1) as f64).cos();
    series.iter().enumerate().map(|(k, r)| window(k) * (r - mean)).collect()
}

/// `sum_k r_k e^(-i w t_k)`, real and imaginary part; within a few samples times are taken to be evenly spaced.
fn turned(times: &[f64], series: &[f64], w: f64) -> (f64, f64) {
    let (mut re, mut im) = (0.0, 0.0);
    for (times, series) in times.chunks(TURNED).zip(series.chunks(TURNED)) {
        let step = (times[times.len() - 1] - times[0]) / (times.len() - 1).max(1) as f64;
        let (mut sine, mut cosine) = (w * times[0]).sin_cos();
        let (turn_sine, turn_cosine) = (w * step).sin_cos();
        for r in series {
            re += r * cosine;
            im -= r * sine;
            (sine, cosine) =
                (sine * turn_cosine + cosine * turn_sine, cosine * turn_cosine - sine * turn_sine);
        }
    }
    (re, im)
}

#[cfg(test)]
mod tests {
    use super::strongest;

    /// A sine of one part in ten of what moves slowly and of noise that grows with the frequency, in two recordings.
    #[test]
    fn a_line_stands_out_whatever_moves_beside_it() {
        let w = 83.7;
        let times: Vec<Vec<f64>> = [0.0, 3.0]
            .iter()
            .map(|t0| (0..2000).map(|k| t0 + 0.005 * f64::from(k)).collect())
            .collect();
        let rough = |k: usize| [1.0, -1.0, 0.3, -0.4, 0.7, -0.9, 0.2][k * k % 7];
        let of = |t: &f64, k: usize| {
            (1.3 * t).sin() + 0.1 * (w * t + 0.4).sin() + 0.05 * (rough(k + 1) - rough(k))
        };
        let parts: Vec<_> = times
            .iter()
            .map(|times| (&times[..], times.iter().enumerate().map(|(k, t)| of(t, k)).collect()))
            .collect();
        let frequencies: Vec<f64> = (0..600).map(|k| 20.0 + 0.2 * f64::from(k)).collect();
        let lines = strongest(&parts, &frequencies);
        assert!((lines[0] - w).abs() < 0.2, "{lines:?}");
        assert_eq!(strongest(&[], &[]), [0.0; super::LINES]);
    }
}
