//! Topics of several clocks on the times of one of them.
//!
//! A message is stamped by the machine and logged later. Where the stamps' clock is that of the log,
//! the difference is a delay, and the stamp is the time of measurement. Where it is another one,
//! the difference is that of the clocks and the delay: the least difference is taken for that of the
//! clocks, since some message was hardly delayed. Topics whose least differences are near have one clock.

use crate::log::Clock;
use crate::signal::median;

/// Clocks that differ by less (s) are one clock, and their difference a delay.
const SAME_CLOCK: f64 = 0.1;
/// A pause of this many steps is a gap, which nothing is drawn across.
const PAUSE: f64 = 4.0;

/// Times of a topic: stamps and times of logging, in ns.
pub(super) struct Times<'t> {
    pub topic: &'t str,
    pub stamped: bool,
    pub stamps: &'t [i64],
    pub logged: &'t [i64],
}

/// A topic's times (s) in order, the samples that they belong to, and what is said of them.
pub(super) struct Ordered {
    pub times: Vec<f64>,
    pub samples: Vec<usize>,
    pub clock: Clock,
}

impl Ordered {
    /// Values of the topic's samples, as they came, at the times `at`.
    pub fn at_times(&self, values: &[f64], at: &[f64], held: bool) -> Vec<f64> {
        let values: Vec<f64> = self.samples.iter().map(|&s| values[s]).collect();
        if values.iter().any(|v| v.is_nan()) {
            let present = self.times.iter().zip(&values).filter(|(_, v)| !v.is_nan());
            let (times, values): (Vec<f64>, Vec<f64>) = present.map(|(t, v)| (*t, *v)).unzip();
            return at_times((&times, usual_step(&times)), &values, at, held);
        }
        at_times((&self.times, self.clock.step), &values, at, held)
    }
}

fn seconds(nanoseconds: i128) -> f64 {
    nanoseconds as f64 / 1e9
}

/// Brings all topics onto the clock of the log, counted from `zero`.
pub(super) fn ordered(all: &[Times], zero: i64) -> Vec<Ordered> {
    let least = |t: &Times| {
        let differences =
            t.stamps.iter().zip(t.logged).map(|(s, l)| i128::from(*l) - i128::from(*s));
        differences.min().unwrap_or(0)
    };
    let least: Vec<i128> = all.iter().map(least).collect();
    let offset = |k: usize| -> i128 {
        let own = least[k];
        if !all[k].stamped || seconds(own.abs()) < SAME_CLOCK {
            return 0;
        }
        let near = |other: &&i128| seconds((**other - own).abs()) < SAME_CLOCK;
        least.iter().filter(near).min().copied().unwrap_or(own)
    };
    all.iter().enumerate().map(|(k, times)| order(times, offset(k), zero)).collect()
}

fn order(of: &Times, offset: i128, zero: i64) -> Ordered {
    let mut samples: Vec<usize> = (0..of.stamps.len()).collect();
    samples.sort_by_key(|&k| of.stamps[k]);
    let all = samples.len();
    // The last message of one time is kept: the sort keeps their order.
    samples = (0..all)
        .filter(|&k| k + 1 == all || of.stamps[samples[k]] != of.stamps[samples[k + 1]])
        .map(|k| samples[k])
        .collect();
    let time = |&k: &usize| seconds(i128::from(of.stamps[k]) + offset - i128::from(zero));
    let times: Vec<f64> = samples.iter().map(time).collect();
    let delay = |&k: &usize| seconds(i128::from(of.logged[k]) - i128::from(of.stamps[k]) - offset);
    let clock = Clock {
        topic: of.topic.into(),
        stamped: of.stamped,
        samples: times.len(),
        step: usual_step(&times),
        offset: seconds(offset),
        delay: median(&mut samples.iter().map(delay).collect::<Vec<_>>()),
        repeated: all - times.len(),
    };
    Ordered { times, samples, clock }
}

fn usual_step(times: &[f64]) -> f64 {
    median(&mut times.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<_>>())
}

/// Values at `times`, of the usual step beside them, brought to the times `at`: between samples along a straight line, or
/// the last one where they are `held`; NaN before the first, after the last and in gaps.
fn at_times((times, step): (&[f64], f64), values: &[f64], at: &[f64], held: bool) -> Vec<f64> {
    let longest = PAUSE * step;
    let mut next = 0;
    let value = |&t: &f64| {
        while times.get(next).is_some_and(|time| *time <= t) {
            next += 1;
        }
        let Some(before) = next.checked_sub(1) else { return f64::NAN };
        let (from, value) = (times[before], values[before]);
        if from == t {
            return value;
        }
        match times.get(next) {
            // A held sample counts for a step after the last one.
            None if held && t - from <= step => value,
            None => f64::NAN,
            Some(to) if to - from > longest => f64::NAN,
            Some(_) if held => value,
            Some(to) => value + (values[next] - value) * ((t - from) / (to - from)),
        }
    };
    at.iter().map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_drawn_across_gaps_nor_beyond_the_ends() {
        let stamps = [0, 1, 2, 3, 13, 14].map(|s| s * 1_000_000_000);
        let topic = Times { topic: "/a", stamped: false, stamps: &stamps, logged: &stamps };
        let topic = &ordered(&[topic], 0)[0];
        let values = [0.0, 10.0, f64::NAN, 30.0, 5.0, 6.0];
        let at = [-0.5, 0.0, 0.25, 2.0, 3.0, 4.0, 12.9, 13.5, 14.0, 14.5, 16.5];
        let shown = |held| {
            let found = topic.at_times(&values, &at, held);
            found.iter().map(|v| if v.is_nan() { -1.0 } else { *v }).collect::<Vec<f64>>()
        };
        assert_eq!(shown(false), [-1.0, 0.0, 2.5, 20.0, 30.0, -1.0, -1.0, 5.5, 6.0, -1.0, -1.0]);
        assert_eq!(shown(true), [-1.0, 0.0, 0.0, 10.0, 30.0, -1.0, -1.0, 5.0, 6.0, 6.0, -1.0]);
    }
}
