//! Sensors at the end of their range, and what looks like one and is none.

use lacuna_recordings::{condition, estimate_noise, find_saturated};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const SD: f64 = 0.01;

fn times() -> Vec<f64> {
    (0..4000).map(|k| 0.005 * f64::from(k)).collect()
}

/// A motion with white noise.
fn noisy(seed: u64, sd: f64, motion: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
    times().into_iter().map(|t| motion(t) + sd * noise()).collect()
}

fn swing(t: f64) -> f64 {
    (2.0 * t).sin() + 0.3 * (5.1 * t).cos()
}

fn rounded(values: Vec<f64>, quantum: f64) -> Vec<f64> {
    values.into_iter().map(|v| quantum * (v / quantum).round()).collect()
}

fn marked(values: &[f64]) -> Vec<usize> {
    let (time, noise) = (times(), estimate_noise(&times(), values).unwrap());
    find_saturated(&[(&time, values)], &noise).remove(0)
}

/// Rows on which a sensor with limits shows one of them.
fn at(values: &[f64], limits: [f64; 2]) -> Vec<usize> {
    (0..values.len()).filter(|&k| limits.contains(&values[k])).collect()
}

#[test]
fn a_sensor_at_its_limits_is_found() {
    let one_side: Vec<f64> = noisy(1, SD, swing).into_iter().map(|v| v.min(0.9)).collect();
    let rows = at(&one_side, [0.9, 0.9]);
    assert!(rows.len() > 200);
    assert_eq!(marked(&one_side), rows);
    let both: Vec<f64> = noisy(2, SD, swing).into_iter().map(|v| v.clamp(-1.0, 0.8)).collect();
    assert_eq!(marked(&both), at(&both, [-1.0, 0.8]));
}

/// A converter at the end of its codes: its noise moves it from code to code elsewhere.
#[test]
fn a_converter_at_its_last_code_is_found() {
    let codes: Vec<f64> =
        rounded(noisy(3, SD, swing), SD).into_iter().map(|v| v.min(0.8)).collect();
    let largest = codes.iter().copied().fold(f64::MIN, f64::max);
    assert_eq!(marked(&codes), at(&codes, [largest, largest]));
    assert!(marked(&codes).len() > 300);
}

#[test]
fn peaks_and_rests_are_none() {
    assert!(marked(&noisy(4, SD, swing)).is_empty());
    // The peak of a sine that an encoder, or a fine converter, rounds.
    assert!(marked(&rounded(noisy(5, 0.0, swing), 0.02)).is_empty());
    assert!(marked(&rounded(noisy(6, SD, |t| (0.3 * t).sin()), SD)).is_empty());
    // A machine that rests at the end of its way, with noise and without.
    let stops = |t: f64| (0.2 * t).min(1.0);
    assert!(marked(&noisy(7, SD, stops)).is_empty());
    assert!(marked(&rounded(noisy(8, 0.0, stops), 1e-3)).is_empty());
    // A speed that is exactly 0 while the machine stands.
    let standing: Vec<f64> = noisy(9, SD, swing).into_iter().map(|v| v.max(0.0)).collect();
    assert!(marked(&standing).is_empty());
    // What never changes, and what has two values.
    assert!(marked(&[1.5; 4000]).is_empty());
    let switched: Vec<f64> = (0..4000).map(|k| if k / 300 % 2 == 0 { 1.0 } else { 5.0 }).collect();
    assert!(marked(&switched).is_empty());
}

/// A log that repeats each sample of a slow sensor does so everywhere.
#[test]
fn repeated_samples_are_none() {
    let slow = noisy(10, SD, swing);
    let held: Vec<f64> = (0..slow.len()).map(|k| slow[k - k % 8]).collect();
    assert!(marked(&held).is_empty());
}

/// Conditioning leaves them out, and the noise is that of the rest.
#[test]
fn conditioning_treats_them_as_not_measured() {
    let time = times();
    let mut values: Vec<f64> = noisy(11, SD, swing).into_iter().map(|v| v.min(0.7)).collect();
    let rows = at(&values, [0.7, 0.7]);
    let (cleaned, noise) = condition(&mut [(&time, &mut values)], "V").unwrap();
    assert_eq!(cleaned[0].saturated, rows);
    assert!(cleaned[0].outliers.is_empty() && cleaned[0].is_left_out(rows[0]));
    assert!((0..values.len()).all(|k| values[k].is_nan() == rows.contains(&k)));
    assert!((noise.sd / SD - 1.0).abs() < 0.06, "{}", noise.sd);
    let part = cleaned[0].part(&(rows[3]..rows[3] + 5));
    assert_eq!(part.saturated[0], 0);
}
