//! Outliers against drawn signals whose outliers are known, and motion that has none.

use lacuna_recordings::{find_outliers, unwrap_turns};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::{PI, TAU};

const STEP: f64 = 0.005;
const SD: f64 = 0.003;

fn noise(rng: &mut impl Rng) -> f64 {
    StandardNormal.sample(rng)
}

fn times(count: usize) -> Vec<f64> {
    (0..count).map(|k| STEP * k as f64).collect()
}

/// A motion on these times with white noise.
fn noisy(time: &[f64], seed: u64, sd: f64, motion: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    time.iter().map(|&t| motion(t) + sd * noise(&mut rng)).collect()
}

fn swing(t: f64) -> f64 {
    (2.0 * t).sin() + 0.5 * (7.3 * t).cos()
}

/// Samples moved by 15 to 60 sd, and their rows: single ones by chance, and a pair.
fn with_glitches(values: &mut [f64], seed: u64, share: f64, sd: f64) -> Vec<usize> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut rows = vec![];
    for (row, value) in values.iter_mut().enumerate().skip(3) {
        let glitch = rng.random_bool(share) || row == 1001 || row == 1002;
        if glitch {
            let sign = if rng.random_bool(0.5) || row == 1002 { 1.0 } else { -1.0 };
            *value += sign * sd * rng.random_range(15.0..60.0);
            rows.push(row);
        }
    }
    rows
}

fn marked(time: &[f64], values: &[f64]) -> Vec<usize> {
    find_outliers(&[(time, values)]).unwrap().rows.remove(0)
}

#[test]
fn glitches_are_found_and_nothing_else() {
    let time = times(20_000);
    let mut values = noisy(&time, 1, SD, swing);
    let rows = with_glitches(&mut values[..19_990], 2, 0.004, SD);
    let found = find_outliers(&[(&time, &values)]).unwrap();
    let missed = rows.iter().filter(|row| !found.rows[0].contains(row)).count();
    let wrong: Vec<_> = found.rows[0].iter().filter(|row| !rows.contains(row)).collect();
    assert!(wrong.is_empty(), "{wrong:?}");
    assert!(rows.len() > 60 && missed <= rows.len() / 50, "{missed} of {}", rows.len());
    assert!((found.noise.sd / SD - 1.0).abs() < 0.02, "{}", found.noise.sd);
}

#[test]
fn uneven_sampling_and_dropped_rows_hide_no_glitch() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let time: Vec<f64> = times(6000)
        .into_iter()
        .enumerate()
        .filter(|(k, _)| k % 97 > 2)
        .map(|(_, t)| t + 0.4 * STEP * noise(&mut rng).tanh())
        .collect();
    let mut values = noisy(&time, 4, SD, swing);
    values.iter_mut().step_by(61).for_each(|value| *value = f64::NAN);
    values[2000] += 30.0 * SD;
    values[4001] -= 30.0 * SD;
    assert_eq!(marked(&time, &values), [2000, 4001]);
}

/// Motions without outliers that are hard on whoever looks for them.
#[test]
fn fast_motion_is_not_marked() {
    let time = times(8000);
    let period = |t: f64, every: f64| t - every * (t / every).floor();
    type OfSize = fn(f64, f64) -> f64;
    let motions: [(&str, OfSize); 8] = [
        // A mass that bounces: the position has corners.
        ("impacts", |x, _| 4.0 * x * (0.37 - x)),
        ("corners", |x, size| size * 60.0 * (x - 0.18).abs()),
        // The same as a velocity: steps.
        ("steps of a velocity", |x, size| size * (x - 0.2).signum()),
        ("stop", |x, size| size * 20.0 * (x - 0.2).min(0.0)),
        // Friction at a reversal: corners of the acceleration.
        ("reversal", |x, size| 30.0 * size * (x - 0.18) * (x - 0.18).abs()),
        // A held command that a drive follows within four samples.
        ("held", |x, size| size * (1.0 - (-x / 0.01).exp())),
        // What an impact excites, seven samples a period.
        ("ringing", |x, size| size * (-x / 0.03).exp() * (180.0 * x).sin()),
        ("near half the sampling frequency", |x, size| size * (500.0 * x).sin()),
    ];
    for (name, motion) in motions {
        for (seed, size) in [(10, 2.0), (11, 6.0), (12, 15.0), (13, 60.0), (14, 1000.0)] {
            let values = noisy(&time, seed, SD, |t| motion(period(t, 0.37), size * SD));
            let rows = marked(&time, &values);
            assert!(rows.is_empty(), "{name} of {size} sd: {rows:?}");
        }
    }
}

/// Wherever a recording or a piece of it begins and ends, and however many of its samples are there.
#[test]
fn glitches_at_the_ends_are_found() {
    let time = times(1500);
    let clean = noisy(&time, 60, SD, swing);
    for row in [0, 1, 2, 7, 12, 40, 1460, 1495, 1498, 1499] {
        for size in [300.0 * SD, -999.0] {
            let mut values = clean.clone();
            values[row] += size;
            assert_eq!(marked(&time, &values), [row], "row {row}, {size}");
            // The same where a piece begins with the sample, or with the one before it.
            for first in [row, row.saturating_sub(1)].into_iter().filter(|_| row < 1480) {
                values[row.saturating_sub(60)..first].fill(f64::NAN);
                values[first] = if first == row { values[row] } else { clean[first] };
                assert_eq!(marked(&time, &values), [row], "row {row} of a piece from {first}");
            }
        }
    }
    for rows in [[0, 1], [1, 2], [1498, 1499]] {
        let mut values = clean.clone();
        rows.iter().for_each(|&row| values[row] = -999.0);
        assert_eq!(marked(&time, &values), rows);
    }
    // A logger that begins each of its recordings so.
    let runs = [61, 62, 63].map(|seed| {
        let mut values = noisy(&time, seed, SD, swing);
        values[0] = -999.0;
        values
    });
    let runs = runs.each_ref().map(|values| (&time[..], &values[..]));
    assert_eq!(find_outliers(&runs).unwrap().rows, [[0]; 3]);
}

#[test]
fn a_fast_beginning_is_not_marked() {
    let time = times(1500);
    type Motion = fn(f64) -> f64;
    let motions: [(&str, Motion); 7] = [
        ("lag of two samples", |x| 1.0 - (-x / 0.01).exp()),
        ("lag of a sample", |x| 1.0 - (-x / 0.005).exp()),
        ("oscillation", |x| 1.0 - (-x / 0.03).exp() * (180.0 * x).cos()),
        ("decay", |x| (-x / 0.006).exp()),
        ("speed of a drive", |x| 1.0 - (1.0 + x / 0.01) * (-x / 0.01).exp()),
        ("ramp", |x| 200.0 * x),
        ("steep, then at a stop", |x| (200.0 * x).min(3.1)),
    ];
    for (name, motion) in motions {
        // From the first sample, from one before it, and from between samples.
        for begin in [0.0, 0.5, 1.0, 1.5, 2.0, 3.0] {
            for size in [10.0, 100.0, 3000.0] {
                let from = |t: f64| size * SD * motion((t - begin * STEP).max(0.0));
                let values = noisy(&time, 70, SD, from);
                assert_eq!(marked(&time, &values), [0; 0], "{name} of {size} sd from {begin}");
                let end = time[time.len() - 1];
                let values = noisy(&time, 71, SD, |t| from(end - t));
                assert_eq!(marked(&time, &values), [0; 0], "{name} of {size} sd to {begin}");
            }
        }
    }
}

#[test]
fn what_a_sensor_at_its_limit_leaves_is_not_marked() {
    let time = times(6000);
    for limit in [0.3, 0.9, 1.2] {
        let seen = |v: f64| if v.abs() > limit { f64::NAN } else { v };
        let values: Vec<f64> = noisy(&time, 72, SD, swing).into_iter().map(seen).collect();
        assert_eq!(marked(&time, &values), [0; 0], "limit {limit}");
    }
}

#[test]
fn a_clean_simulation_has_no_outliers() {
    let time = times(8000);
    let values: Vec<f64> = time.iter().map(|&t| swing(t) + (t - 11.0).max(0.0)).collect();
    assert_eq!(marked(&time, &values), [0; 0]);
    assert_eq!(marked(&time, &vec![2.5; 8000]), [0; 0]);
}

#[test]
fn rounding_is_not_marked_and_lost_counts_are() {
    let (time, quantum) = (times(8000), 0.002);
    let round = |v: f64| quantum * (v / quantum).round();
    // At rest for most of the time: few levels, and differences that are zero.
    type Motion = fn(f64) -> f64;
    let motions: [(&str, Motion); 3] = [
        ("swings", swing),
        ("rests, moves, rests", |t| 0.05 * (t - 20.0).clamp(0.0, 0.4)),
        ("creeps", |t| 0.001 * t),
    ];
    for (name, motion) in motions {
        for sd in [0.0, 0.2 * quantum] {
            let mut values: Vec<f64> =
                noisy(&time, 20, sd, motion).into_iter().map(round).collect();
            assert_eq!(marked(&time, &values), [0; 0], "{name}, noise {sd}");
            values[3000] += 16.0 * quantum;
            values[7000] -= 16.0 * quantum;
            assert_eq!(marked(&time, &values), [3000, 7000], "{name}, noise {sd}");
        }
    }
}

#[test]
fn what_is_often_or_lasts_is_no_outlier() {
    let time = times(4000);
    let mut often = noisy(&time, 30, SD, swing);
    often.iter_mut().step_by(16).for_each(|v| *v += 40.0 * SD);
    assert_eq!(marked(&time, &often), [0; 0]);
    let mut lasts = noisy(&time, 31, SD, swing);
    lasts[2000..2003].iter_mut().for_each(|v| *v += 40.0 * SD);
    lasts[3000..3012].iter_mut().for_each(|v| *v += 40.0 * SD);
    assert_eq!(marked(&time, &lasts), [0; 0]);
}

#[test]
fn noise_alone_is_marked_less_than_once_in_many_recordings() {
    let time = times(5000);
    let count: usize =
        (100..140).map(|seed| marked(&time, &noisy(&time, seed, SD, swing)).len()).sum();
    assert_eq!(count, 0, "expected 0.01 for each of 40 recordings at most");
}

/// An angle with noise, as a sensor of this range shows it.
fn wrapped(angle: &[f64], low: f64, turn: f64) -> Vec<f64> {
    angle.iter().map(|a| a - turn * ((a - low) / turn).floor()).collect()
}

#[test]
fn wrapped_angles_become_continuous() {
    let time = times(6000);
    for (unit, turn, low) in [("rad", TAU, -PI), ("rad", TAU, 0.0), ("deg", 360.0, -180.0)] {
        let angle = noisy(&time, 40, 0.001 * turn, |t| turn * (0.9 * (0.7 * t).sin() + 0.3 * t));
        let mut values = wrapped(&angle, low, turn);
        values[700] = f64::NAN;
        values[1500..1503].fill(f64::NAN);
        let offset = values[0] - angle[0];
        let leaps = unwrap_turns(&time, &mut values, turn).len();
        assert!(leaps > 10, "{unit}: {leaps}");
        for (found, true_angle) in values.iter().zip(&angle).filter(|(v, _)| !v.is_nan()) {
            assert!((found - true_angle - offset).abs() < 1e-9 * turn, "{unit}");
        }
    }
}

#[test]
fn glitches_and_motion_of_many_turns_are_not_unwrapped() {
    let time = times(6000);
    let mut glitches = noisy(&time, 50, SD, swing);
    glitches[2000] += 4.0;
    glitches[3000] -= 5.0;
    let before = glitches.clone();
    assert_eq!(unwrap_turns(&time, &mut glitches, TAU), [0; 0]);
    assert_eq!(glitches, before);
    let mut many = noisy(&time, 51, SD, |t| 9.0 * t + if t > 15.0 { TAU } else { 0.0 });
    assert_eq!(unwrap_turns(&time, &mut many, TAU), [0; 0]);
    // A third of a turn each sample: a step and its way round are much the same.
    let mut fast = wrapped(&noisy(&time, 52, SD, |t| 0.35 * TAU * t / STEP), -PI, TAU);
    assert_eq!(unwrap_turns(&time, &mut fast, TAU), [0; 0]);
}
