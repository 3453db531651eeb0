//! Spectral lines of what the measured motion needs beside the model: a disturbance that repeats shows as one, however
//! often it repeats while a recording lasts, and so does a force that repeats over the coordinate, however many turns
//! that makes.
//!
//! ```text
//! S(w) = |sum_k h_k r_k e^(-i w s_k)|^2,   r = a - f(x, u)
//! ```
//!
//! s being time or the coordinate, r the acceleration that the smoothed motion has beyond the model's, h a Hann window
//! over each recording. The sum goes over all recordings, in which what repeats has one phase. A line stands out of its
//! neighbours by the ratio of S to their mean: differences of what is smoothed grow with the frequency.

use super::Problem;
use crate::trajectories::SmoothedRecording;
use lacuna_effects::{GRID, LINES, PITCHES};
use lacuna_plants::model::System;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Periods in the recordings, or over the range of a coordinate, where they end at the latest: a budget.
const PERIODS: f64 = 640.0;
/// Samples of what is searched as a whole; of more, only a part is.
const SEARCHED: usize = 1 << 14;
/// Frequencies to either side that a line is compared with.
const BESIDE: usize = 20;
/// Samples over which a phase is turned on before it is computed anew.
const TURNED: usize = 64;

/// The lines of a channel, the strongest first; 0 where there are no more.
#[derive(Clone, Copy, Default)]
pub(super) struct Lines {
    /// Over time, rad/s.
    pub rates: [f64; LINES],
    /// Over the coordinate, per unit of it.
    pub pitches: [f64; LINES],
}

/// The lines of each channel, from where a grid of frequencies ends to a quarter of the sampling rate, at the usual speed
/// where they are over the coordinate; none of recordings of which only a part is searched, nor of what nobody measures,
/// which moves as the model says, or of levels and temperatures, which hardly move with what is fast.
pub(super) fn of_channels(problem: &Problem, (begin, end): (f64, f64)) -> Vec<Lines> {
    let (model, smoothed) = (problem.model, &problem.smoothed);
    let moves =
        |c: usize| model.is_coordinate(c) && !problem.hidden().contains(&model.coordinate_index(c));
    let mut lines = vec![Lines::default(); model.channels()];
    let samples: usize = smoothed.iter().map(SmoothedRecording::len).sum();
    if samples > SEARCHED {
        return lines;
    }
    let over_time = beyond(GRID, end - begin, 0.25 * TAU / problem.sample);
    let over_place: Vec<Vec<f64>> = (0..model.channels()).map(|c| pitches(problem, c)).collect();
    let channels = (0..model.channels()).filter(|c| moves(*c));
    let wanted: Vec<usize> =
        channels.filter(|c| !over_time.is_empty() || !over_place[*c].is_empty()).collect();
    if wanted.is_empty() {
        return lines;
    }
    let system = System::new(model);
    let missing: Vec<Vec<Vec<f64>>> = smoothed.iter().map(|s| missing(&system, s)).collect();
    for c in wanted {
        let place = model.place(c);
        let of = |(s, all): (_, &Vec<Vec<f64>>)| {
            let s: &SmoothedRecording = s;
            let rates: Vec<f64> = all.iter().map(|rates| rates[place.v]).collect();
            let places = (0..s.len()).map(|k| s.state(k)[place.q]).collect();
            Part { times: &s.times, places, series: tapered(&rates) }
        };
        let parts: Vec<Part> = smoothed.iter().zip(&missing).map(of).collect();
        lines[c] = Lines {
            rates: strongest(&parts, &over_time, along_times),
            pitches: strongest(&parts, &over_place[c], along_places),
        };
    }
    lines
}

/// Frequencies from so many periods over a span on, to where a budget or this one ends them. A spectral line is as wide as
/// two and a half of their distances.
fn beyond(periods: f64, span: f64, last: f64) -> Vec<f64> {
    let turn = TAU / span;
    let to = (PERIODS * turn).min(last);
    let frequency = |k: u32| periods * turn + 0.4 * turn * f64::from(k);
    if turn.is_finite() { (0..).map(frequency).take_while(|w| *w < to).collect() } else { vec![] }
}

/// Those over the coordinate of a channel.
fn pitches(problem: &Problem, channel: usize) -> Vec<f64> {
    let place = problem.model.place(channel);
    let (q, v) = (problem.series(|x| x[place.q]), problem.series(|x| x[place.v]));
    let low = q.iter().copied().fold(f64::INFINITY, f64::min);
    let high = q.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let usual = (v.iter().map(|v| v * v).sum::<f64>() / v.len().max(1) as f64).sqrt();
    beyond(PITCHES, high - low, 0.25 * TAU / (usual * problem.sample))
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

/// What is looked at of a recording, fading in and out, and when and where it is.
struct Part<'a> {
    times: &'a [f64],
    places: Vec<f64>,
    series: Vec<f64>,
}

/// `sum_k r_k e^(-i w s_k)`, real and imaginary part.
type Sum = fn(&Part, f64) -> (f64, f64);

/// The lines that stand out most of some frequencies at equal distances, zeros behind them.
fn strongest(parts: &[Part], frequencies: &[f64], sum: Sum) -> [f64; LINES] {
    let power = |w: &f64| {
        let sums = parts.iter().map(|part| sum(part, *w));
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

/// The sum along places.
fn along_places(Part { places, series, .. }: &Part, w: f64) -> (f64, f64) {
    places.iter().zip(series).fold((0.0, 0.0), |(re, im), (place, r)| {
        let (sine, cosine) = (w * place).sin_cos();
        (re + r * cosine, im - r * sine)
    })
}

/// The sum along times, which within a few samples are taken to be evenly spaced.
fn along_times(Part { times, series, .. }: &Part, w: f64) -> (f64, f64) {
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
    use super::{Part, along_places, along_times, strongest, tapered};

    /// What is neither slow nor a line.
    fn rough(k: usize) -> f64 {
        let at = |k: usize| [1.0, -1.0, 0.3, -0.4, 0.7, -0.9, 0.2][k * k % 7];
        0.05 * (at(k + 1) - at(k))
    }

    /// A sine of one part in ten of what moves slowly and of noise that grows with the frequency, in two recordings.
    #[test]
    fn a_line_stands_out_whatever_moves_beside_it() {
        let w = 83.7;
        let times: Vec<Vec<f64>> = [0.0, 3.0]
            .iter()
            .map(|t0| (0..2000).map(|k| t0 + 0.005 * f64::from(k)).collect())
            .collect();
        let of = |(k, t): (usize, &f64)| (1.3 * t).sin() + 0.1 * (w * t + 0.4).sin() + rough(k);
        let part = |times| {
            let series: Vec<f64> = <[f64]>::iter(times).enumerate().map(of).collect();
            Part { times, places: vec![], series: tapered(&series) }
        };
        let parts: Vec<Part> = times.iter().map(|times| part(&times[..])).collect();
        let frequencies: Vec<f64> = (0..600).map(|k| 20.0 + 0.2 * f64::from(k)).collect();
        let lines = strongest(&parts, &frequencies, along_times);
        assert!((lines[0] - w).abs() < 0.2, "{lines:?}");
        assert_eq!(strongest(&[], &[], along_times), [0.0; super::LINES]);
    }

    /// A motor that turns to and fro, fifteen turns in all, seven teeth a turn.
    #[test]
    fn so_does_one_over_the_coordinate() {
        let part = |begin: f64| {
            let times = (0..3000).map(|k| 0.002 * f64::from(k));
            let turned = |t: f64| begin + 40.0 * (0.9 * t).sin() + 9.0 * t;
            let places: Vec<f64> = times.map(turned).collect();
            let of =
                |(k, q): (usize, &f64)| (0.05 * q).sin() + 0.1 * (7.0 * q + 0.4).sin() + rough(k);
            let series: Vec<f64> = places.iter().enumerate().map(of).collect();
            Part { times: &[], places, series: tapered(&series) }
        };
        let parts = [part(0.0), part(-20.0)];
        let wavenumbers: Vec<f64> = (0..600).map(|k| 1.5 + 0.02 * f64::from(k)).collect();
        let lines = strongest(&parts, &wavenumbers, along_places);
        assert!((lines[0] - 7.0).abs() < 0.02, "{lines:?}");
    }
}
