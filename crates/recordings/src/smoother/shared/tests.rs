//! Against the smoother of one series.

use super::super::{Smoother, log_likelihood, smooth_with};
use super::gain::Gain;
use super::*;

const NOISE: f64 = 0.02;
const RATE_NOISE: f64 = 0.1;

fn times(even: bool) -> Vec<f64> {
    let jitter = if even { 0.0 } else { 0.02 };
    (0..60).map(|k| 1.0 + 0.1 * f64::from(k) + jitter * f64::from(k % 3)).collect()
}

fn series(times: &[f64], phase: f64, missing: usize) -> [Vec<f64>; 2] {
    let kept = |k: usize, value: f64| if k % 7 < missing { f64::NAN } else { value };
    let noise = |k: usize| f64::from((k * 37 % 41) as u32) / 20.0 - 1.0;
    let value = |(k, t): (usize, &f64)| kept(k, (t + phase).sin() + NOISE * noise(k));
    let rate = |(k, t): (usize, &f64)| kept(k + 3, (t + phase).cos() + RATE_NOISE * noise(k));
    [times.iter().enumerate().map(value).collect(), times.iter().enumerate().map(rate).collect()]
}

/// Densities up to where rounding shows in either, for even and uneven times, with and without rates and gaps.
#[test]
fn shared_gains_do_what_the_filter_of_one_series_does() {
    for (even, rated, missing) in [(true, false, 0), (false, true, 2), (true, true, 0)] {
        let times = times(even);
        let all: Vec<[Vec<f64>; 2]> =
            (0..11).map(|s| series(&times, 0.3 * f64::from(s), missing)).collect();
        let samples = |[values, rates]: &'_ [Vec<f64>; 2]| -> (Vec<f64>, Vec<f64>) {
            (values.clone(), if rated { rates.clone() } else { Vec::new() })
        };
        let all: Vec<(Vec<f64>, Vec<f64>)> = all.iter().map(samples).collect();
        let shared: Vec<Samples<'_>> =
            all.iter().map(|(values, rates)| Samples { values, rates }).collect();
        let scale = NOISE / RATE_NOISE;
        let smoother = SharedSmoother::new(Prior::WhiteSnap, &times, shared[0], scale).unwrap();
        for k in (20..=160).step_by(20) {
            let density = (LOWEST + FINEST * k as f64).exp();
            let gain = Gain::<4, 6>::new(&smoother, density);
            let wanted: Vec<usize> = (3..11).collect();
            let squares = gain.filter(&smoother, &shared, &wanted, |_| {});
            let mut states = vec![None; shared.len()];
            gain.smooth(&smoother, &shared, &wanted, &mut states);
            for (&s, square) in wanted.iter().zip(squares) {
                let plain = Smoother::new(Prior::WhiteSnap);
                let plain =
                    if rated { plain.with_derivative(&all[s].1, RATE_NOISE) } else { plain };
                let scaled = plain.scaled(&times, &all[s].0, NOISE);
                let expected = log_likelihood::<4>(&scaled, density);
                let found = -0.5 * square / (NOISE * NOISE) - gain.log_determinant;
                assert!((found - expected).abs() < 1e-7 * expected.abs(), "{k} {found} {expected}");
                let path = smooth_with::<4>(&scaled, density);
                let found = states[s].as_ref().unwrap();
                for (row, posterior) in path.smoothed.iter().enumerate() {
                    for p in 0..3 {
                        let expected = posterior.mean[p] * NOISE / scaled.step.powi(p as i32);
                        let found = found[row * 4 + p];
                        assert!(
                            (found - expected).abs() < 1e-5 * (1.0 + expected.abs()),
                            "{k} {row} {p} {found} {expected}"
                        );
                    }
                }
            }
        }
    }
}

/// Between samples too, as near as its coarser grid of densities lets it.
#[test]
fn means_between_samples_are_those_of_the_smoother() {
    let times = times(false);
    let [values, _] = series(&times, 0.0, 0);
    let inner: Vec<f64> = times.windows(2).map(|t| 0.3 * t[0] + 0.7 * t[1]).collect();
    for prior in [Prior::WhiteJerk, Prior::WhiteSnap] {
        let like = Samples { values: &values, rates: &[] };
        let shared = SharedSmoother::new(prior, &times, like, 0.0).unwrap();
        let path = shared.smooth(&[(&times, like)], NOISE).unwrap().remove(0).unwrap();
        let plain = Smoother::new(prior).smooth(&times, &values, NOISE).unwrap();
        let likelihood = shared.log_likelihoods(&[like], NOISE).unwrap()[0];
        let expected = plain.log_likelihood();
        assert!((likelihood - expected).abs() < 0.1, "{likelihood} {expected}");
        let expected = plain.at(&inner);
        for (k, [value, rate]) in path.at(&inner).into_iter().enumerate() {
            assert!((value - expected.value[k]).abs() < 0.1 * expected.value_sd[k]);
            assert!((rate - expected.first[k]).abs() < 0.1 * expected.first_sd[k]);
        }
        let exact = plain.at(&times);
        for (k, second) in path.at_samples(2).enumerate() {
            assert!((second - exact.second[k]).abs() < 0.1 * exact.second_sd[k]);
        }
    }
}
