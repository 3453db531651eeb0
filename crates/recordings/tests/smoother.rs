//! The smoother against closed forms, a dense solution of the same prior, and noisy sines.

use std::time::Instant;

use lacuna_recordings::{Prior, SignalError, Smoother};
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

fn noise(seed: u64, count: usize) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..count).map(|_| StandardNormal.sample(&mut rng)).collect()
}

#[test]
fn polynomials_below_the_order_are_reproduced() {
    let time: Vec<f64> = (0..400).map(|k| 0.01 * k as f64 + 0.003 * (k as f64).sin()).collect();
    let quadratic: Vec<f64> = time.iter().map(|t| 1.0 - 2.0 * t + 3.0 * t * t).collect();
    let cubic: Vec<f64> = time.iter().map(|t| t * t * t - t).collect();
    let query = [-0.5, 0.0, 1.2345, 3.9, 4.5];
    let smoothed = Smoother::fit(&time, &quadratic, 1e-3).unwrap().at(&query);
    let snap = Smoother::new(Prior::WhiteSnap).smooth(&time, &cubic, 1e-3).unwrap().at(&query);
    for (k, t) in query.iter().enumerate() {
        assert!((smoothed.value[k] - (1.0 - 2.0 * t + 3.0 * t * t)).abs() < 1e-9);
        assert!((smoothed.first[k] - (-2.0 + 6.0 * t)).abs() < 1e-9);
        assert!((smoothed.second[k] - 6.0).abs() < 1e-8);
        assert!((snap.value[k] - (t * t * t - t)).abs() < 1e-9);
        assert!((snap.first[k] - (3.0 * t * t - 1.0)).abs() < 1e-8);
        assert!((snap.second[k] - 6.0 * t).abs() < 1e-7);
    }
}

#[test]
fn a_cubic_is_reproduced_within_its_bands() {
    let time: Vec<f64> = (0..400).map(|k| 0.01 * k as f64).collect();
    let cubic: Vec<f64> = time.iter().map(|t| t * t * t - t).collect();
    let smoothed = Smoother::fit(&time, &cubic, 1e-3).unwrap().at(&time);
    for (k, t) in time.iter().enumerate() {
        assert!((smoothed.value[k] - (t * t * t - t)).abs() < smoothed.value_sd[k]);
        assert!((smoothed.first[k] - (3.0 * t * t - 1.0)).abs() < 2.0 * smoothed.first_sd[k]);
    }
}

/// Covariance of the derivatives `dt` at `t` and `ds` at `s` of the prior that starts from
/// zero at time 0: the integral over u of (t - u)^a (s - u)^b / (a! b!) up to min(t, s),
/// with a = order - 1 - dt, b = order - 1 - ds.
fn kernel(order: usize, t: f64, s: f64, dt: usize, ds: usize) -> f64 {
    let end = t.min(s);
    let power = |x: f64, n: usize| x.powi(n as i32) / (1..=n).product::<usize>() as f64;
    let f = |u: f64| power(t - u, order - 1 - dt) * power(s - u, order - 1 - ds);
    // Gauss-Legendre with four nodes: exact to degree seven.
    let nodes = [0.339981043584856, 0.861136311594053];
    let weights = [0.652145154862546, 0.347854845137454];
    let pair = |k: usize| f(0.5 * end * (1.0 - nodes[k])) + f(0.5 * end * (1.0 + nodes[k]));
    0.5 * end * (weights[0] * pair(0) + weights[1] * pair(1))
}

/// The posterior of derivative `of` at `query` by dense linear algebra: polynomial part with
/// flat prior (generalised least squares), integrated white noise on top.
struct Dense<'a> {
    order: usize,
    density: f64,
    /// (time, derivative measured, value, sd)
    data: &'a [(f64, usize, f64, f64)],
}

impl Dense<'_> {
    fn basis(&self, t: f64, d: usize) -> DVector<f64> {
        let factorial = |n: usize| (1..=n).product::<usize>() as f64;
        DVector::from_fn(self.order, |j, _| {
            if j < d { 0.0 } else { t.powi((j - d) as i32) / factorial(j - d) }
        })
    }

    fn posterior(&self, query: f64, of: usize) -> (f64, f64) {
        let n = self.data.len();
        let k = |a: (f64, usize), b: (f64, usize)| {
            self.density * kernel(self.order, a.0, b.0, a.1, b.1)
        };
        let at = |i: usize| (self.data[i].0, self.data[i].1);
        let mut c = DMatrix::from_fn(n, n, |i, j| k(at(i), at(j)));
        for i in 0..n {
            c[(i, i)] += self.data[i].3.powi(2);
        }
        let y = DVector::from_fn(n, |i, _| self.data[i].2);
        let h = DMatrix::from_fn(n, self.order, |i, j| self.basis(at(i).0, at(i).1)[j]);
        let q = DVector::from_fn(n, |i, _| k((query, of), at(i)));
        let c = c.cholesky().unwrap();
        let normal = (h.transpose() * c.solve(&h)).cholesky().unwrap();
        let beta = normal.solve(&(h.transpose() * c.solve(&y)));
        let r = self.basis(query, of) - h.transpose() * c.solve(&q);
        let mean = q.dot(&c.solve(&(&y - &h * &beta))) + self.basis(query, of).dot(&beta);
        let variance = k((query, of), (query, of)) - q.dot(&c.solve(&q)) + r.dot(&normal.solve(&r));
        (mean, variance.sqrt())
    }

    /// Restricted (diffuse) log likelihood up to a constant.
    fn log_likelihood(&self) -> f64 {
        let n = self.data.len();
        let at = |i: usize| (self.data[i].0, self.data[i].1);
        let mut c = DMatrix::from_fn(n, n, |i, j| {
            self.density * kernel(self.order, at(i).0, at(j).0, at(i).1, at(j).1)
        });
        for i in 0..n {
            c[(i, i)] += self.data[i].3.powi(2);
        }
        let y = DVector::from_fn(n, |i, _| self.data[i].2);
        let h = DMatrix::from_fn(n, self.order, |i, j| self.basis(at(i).0, at(i).1)[j]);
        let c = c.cholesky().unwrap();
        let normal = (h.transpose() * c.solve(&h)).cholesky().unwrap();
        let beta = normal.solve(&(h.transpose() * c.solve(&y)));
        let rest = &y - &h * beta;
        let log_det = |l: DMatrix<f64>| 2.0 * l.diagonal().map(f64::ln).sum();
        -0.5 * (rest.dot(&c.solve(&rest)) + log_det(c.l()) + log_det(normal.l()))
    }
}

fn close(found: f64, expected: f64, relative: f64, absolute: f64) {
    assert!((found - expected).abs() < relative * expected.abs() + absolute, "{found} {expected}");
}

#[test]
fn the_dense_solution_of_the_same_prior_agrees() {
    let jitter = noise(1, 40);
    let mut time: Vec<f64> = (0..40).map(|k| 0.1 * k as f64 + 0.02 * jitter[k].tanh()).collect();
    time.drain(11..17);
    let e = noise(2, 80);
    let mut values: Vec<f64> = (0..34).map(|k| time[k].sin() + 0.02 * e[k]).collect();
    let mut rates: Vec<f64> = (0..34).map(|k| time[k].cos() + 0.1 * e[40 + k]).collect();
    values[5] = f64::NAN;
    rates[0] = f64::NAN;
    for (prior, order) in [(Prior::WhiteJerk, 3), (Prior::WhiteSnap, 4)] {
        for fused in [false, true] {
            let smoother = Smoother::new(prior);
            let smoother = if fused { smoother.with_derivative(&rates, 0.1) } else { smoother };
            let smoothed = smoother.smooth(&time, &values, 0.02).unwrap();
            let origin = time[0];
            let position = (0..34).map(|k| (time[k] - origin, 0, values[k], 0.02));
            let rate = (0..34).map(|k| (time[k] - origin, 1, rates[k], 0.1));
            let data: Vec<_> =
                position.chain(rate.filter(|_| fused)).filter(|row| !row.2.is_nan()).collect();
            let dense = Dense { order, density: smoothed.density(), data: &data };
            let query = [time[0], time[5], 0.777, time[11] - 0.3, 2.5, time[33]];
            let found = smoothed.at(&query);
            for (k, t) in query.iter().enumerate() {
                let columns = [
                    (&found.value, &found.value_sd),
                    (&found.first, &found.first_sd),
                    (&found.second, &found.second_sd),
                ];
                for (d, (mean, sd)) in columns.into_iter().enumerate() {
                    let (dense_mean, dense_sd) = dense.posterior(t - origin, d);
                    close(mean[k], dense_mean, 1e-7, 1e-7 * dense_sd);
                    close(sd[k], dense_sd, 1e-6, 0.0);
                }
            }
            // The density is where the dense likelihood has its maximum too.
            let likelihood =
                |share: f64| Dense { density: dense.density * share, ..dense }.log_likelihood();
            assert!(likelihood(1.0) > likelihood(1.2) && likelihood(1.0) > likelihood(1.0 / 1.2));
        }
    }
}

#[test]
fn beyond_the_ends_the_bands_widen_as_the_dense_solution_says() {
    let time: Vec<f64> = (0..20).map(|k| 0.1 * k as f64).collect();
    let e = noise(3, 20);
    let values: Vec<f64> = (0..20).map(|k| (2.0 * time[k]).sin() + 0.01 * e[k]).collect();
    let smoothed = Smoother::fit(&time, &values, 0.01).unwrap();
    // The prior is the same from any origin, so the dense one may begin before the data.
    let data: Vec<_> = (0..20).map(|k| (time[k] + 0.5, 0, values[k], 0.01)).collect();
    let dense = Dense { order: 3, density: smoothed.density(), data: &data };
    let found = smoothed.at(&[-0.4, 2.5]);
    for (k, t) in [-0.4, 2.5].into_iter().enumerate() {
        let (mean, sd) = dense.posterior(t + 0.5, 0);
        close(found.value[k], mean, 1e-6, 0.0);
        close(found.value_sd[k], sd, 1e-6, 0.0);
    }
}

/// Share of errors within two standard deviations, and root mean square error.
fn score(found: &[f64], sd: &[f64], truth: impl Fn(usize) -> f64) -> (f64, f64) {
    let errors: Vec<f64> = (0..found.len()).map(|k| found[k] - truth(k)).collect();
    let inside = errors.iter().zip(sd).filter(|(e, sd)| e.abs() <= 2.0 * **sd).count();
    let mean_square = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
    (inside as f64 / errors.len() as f64, mean_square.sqrt())
}

#[test]
fn noisy_sines_are_cleaned_and_the_bands_hold() {
    let time: Vec<f64> = (0..2000).filter(|k| k % 23 != 5).map(|k| 0.01 * k as f64).collect();
    let mut all = [0.0; 3];
    for seed in 0..10 {
        let e = noise(100 + seed, time.len());
        let w = 1.0 + 0.4 * seed as f64;
        let values: Vec<f64> = time.iter().zip(e).map(|(t, e)| (w * t).sin() + 0.02 * e).collect();
        let found = Smoother::fit(&time, &values, 0.02).unwrap().at(&time);
        let value = score(&found.value, &found.value_sd, |k| (w * time[k]).sin());
        let first = score(&found.first, &found.first_sd, |k| w * (w * time[k]).cos());
        let second = score(&found.second, &found.second_sd, |k| -w * w * (w * time[k]).sin());
        println!("w {w:.1}: value {value:.3?} first {first:.3?} second {second:.3?}");
        assert!(value.1 < 0.4 * 0.02, "the error is well below the noise");
        for (sum, score) in all.iter_mut().zip([value, first, second]) {
            *sum += score.0 / 10.0;
        }
    }
    println!("coverage of 2 sd bands: {all:.3?}");
    assert!(all.iter().all(|share| (0.9..=1.0).contains(share)));
}

#[test]
fn a_recorded_velocity_helps() {
    let time: Vec<f64> = (0..1000).map(|k| 0.01 * k as f64).collect();
    let (e, f) = (noise(7, 1000), noise(8, 1000));
    let values: Vec<f64> = (0..1000).map(|k| (3.0 * time[k]).sin() + 0.02 * e[k]).collect();
    let rates: Vec<f64> = (0..1000).map(|k| 3.0 * (3.0 * time[k]).cos() + 0.05 * f[k]).collect();
    let truth = |k: usize| 3.0 * (3.0 * time[k]).cos();
    let alone = Smoother::fit(&time, &values, 0.02).unwrap().at(&time);
    let smoother = Smoother::default().with_derivative(&rates, 0.05);
    let fused = smoother.smooth(&time, &values, 0.02).unwrap().at(&time);
    let alone = score(&alone.first, &alone.first_sd, truth);
    let fused = score(&fused.first, &fused.first_sd, truth);
    assert!(fused.1 < 0.6 * alone.1, "{alone:?} {fused:?}");
    assert!(fused.0 > 0.9);
}

#[test]
fn long_and_nearly_noise_free_series_keep_their_digits() {
    let time: Vec<f64> = (0..25_000).map(|k| 0.001 * k as f64).collect();
    let e = noise(9, 25_000);
    for sd in [1e-8, 1e-3] {
        let values: Vec<f64> = time.iter().zip(&e).map(|(t, e)| (2.0 * t).sin() + sd * e).collect();
        let start = Instant::now();
        let smoothed = Smoother::fit(&time, &values, sd).unwrap();
        println!("25 000 samples, noise {sd:e}: {:.0} ms", 1e3 * start.elapsed().as_secs_f64());
        let found = smoothed.at(&time);
        let value = score(&found.value, &found.value_sd, |k| (2.0 * time[k]).sin());
        let first = score(&found.first, &found.first_sd, |k| 2.0 * (2.0 * time[k]).cos());
        println!("value {value:?} first {first:?}");
        assert!(value.1 < 0.6 * sd && value.0 > 0.9 && first.0 > 0.9);
    }
}

#[test]
fn impossible_series_are_refused() {
    let time: Vec<f64> = (0..10).map(f64::from).collect();
    let values = [1.0; 10];
    let refused = |values: &[f64], sd| Smoother::fit(&time, values, sd).unwrap_err();
    assert_eq!(refused(&values[1..], 1.0), SignalError::LengthMismatch { expected: 10, found: 9 });
    assert_eq!(refused(&values, 0.0), SignalError::NoiseNotPositive { found: 0.0 });
    assert_eq!(
        refused(&values, f64::INFINITY),
        SignalError::NoiseNotPositive { found: f64::INFINITY }
    );
    let mut few = [f64::NAN; 10];
    few[2..5].fill(1.0);
    assert_eq!(refused(&few, 1.0), SignalError::TooFewSamples { needed: 4, found: 3 });
    let wild: Vec<f64> = (0..10).map(|k| 1e300 * f64::from(k % 2)).collect();
    assert_eq!(refused(&wild, 1e-300), SignalError::OutOfRange);
    let twice = Smoother::fit(&[0.0, 1.0, 1.0], &[0.0; 3], 1.0).unwrap_err();
    assert_eq!(twice, SignalError::TimeNotIncreasing { row: 2, before: 1.0, found: 1.0 });
}
