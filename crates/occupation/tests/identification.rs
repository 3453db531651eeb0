//! Identification in one call: from noisy samples to f and g with standard deviations.

use lacuna_occupation::{
    Arguments, Family, Identification, IdentificationError, IdentifiedModel, InputPath, Motion,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

const STEP: f64 = 0.02;
const SAMPLES: usize = 101;

fn drift(x: f64, v: f64) -> f64 {
    -4.0 * x.sin() - 0.5 * v
}

fn effectiveness(x: f64) -> f64 {
    2.0 + 0.5 * x
}

/// A pendulum with drag and a torque, by small Runge-Kutta steps; positions with noise.
fn swing(start: [f64; 2], phase: f64, noise: f64, rng: &mut ChaCha8Rng) -> Motion {
    let input = |t: f64| (3.0 * t + phase).sin();
    let slope = |t: f64, [x, v]: [f64; 2]| [v, drift(x, v) + effectiveness(x) * input(t)];
    let add = |z: [f64; 2], d: [f64; 2], h: f64| [z[0] + h * d[0], z[1] + h * d[1]];
    let normal = Normal::new(0.0, noise).unwrap();
    let times: Vec<f64> = (0..SAMPLES).map(|k| STEP * k as f64).collect();
    let (mut z, mut positions) = (start, Vec::new());
    for &t in &times {
        positions.push(z[0] + normal.sample(rng));
        let a = slope(t, z);
        let b = slope(t + 0.5 * STEP, add(z, a, 0.5 * STEP));
        let c = slope(t + 0.5 * STEP, add(z, b, 0.5 * STEP));
        let d = slope(t + STEP, add(z, c, STEP));
        for i in 0..2 {
            z[i] += STEP / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]);
        }
    }
    let inputs = times.iter().map(|&t| input(t)).collect();
    Motion::new(times, positions, inputs).unwrap()
}

fn swings(noise: f64) -> Vec<Motion> {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let start = |k: usize| [-1.5 + 0.6 * (k % 6) as f64, -2.0 + 0.8 * (k / 6) as f64];
    (0..36).map(|k| swing(start(k), k as f64, noise, &mut rng)).collect()
}

fn settings() -> Identification {
    Identification::new(2, Arguments::State, InputPath::Smooth)
}

/// Points inside the data: x, v.
fn points() -> Vec<[f64; 2]> {
    (0..25).map(|k| [-1.2 + 0.6 * (k % 5) as f64, -1.6 + 0.8 * (k / 5) as f64]).collect()
}

#[test]
fn drift_and_effectiveness_are_found_within_their_standard_deviations() {
    let found = settings().identify(&swings(1e-3)).unwrap();
    let (mut within, mut entries) = (0, 0);
    for x in points() {
        let (mut f, mut g) = ([0.0], [0.0]);
        found.model.evaluate(&x, &mut f, &mut g).unwrap();
        let sd = found.model.standard_deviations(&x).unwrap().unwrap();
        let errors = [f[0] - drift(x[0], x[1]), g[0] - effectiveness(x[0])];
        assert!(errors[0].abs() < 0.05 && errors[1].abs() < 0.05, "{x:?} {errors:?}");
        for (error, sd) in errors.iter().zip([sd.f[0], sd.g[0]]) {
            within += usize::from(error.abs() < 3.0 * sd);
            entries += 1;
        }
    }
    assert!(within * 10 >= entries * 9, "{within} of {entries} within three standard deviations");
    let noise = found.report.noise_sd[0];
    assert!((noise / 1e-3 - 1.0).abs() < 0.1, "noise {noise}");
}

#[test]
fn results_do_not_depend_on_the_number_of_threads_and_survive_saving() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let data = swings(1e-3);
        pool.install(|| settings().identify(&data[..12])).unwrap().model
    };
    let model = run(1);
    assert_eq!(model, run(2));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.json");
    model.save(&path).unwrap();
    let back = IdentifiedModel::load(&path).unwrap();
    let (a, b) = (model.standard_deviations(&[0.3, 0.1]), back.standard_deviations(&[0.3, 0.1]));
    let (a, b) = (a.unwrap().unwrap(), b.unwrap().unwrap());
    assert!((a.f[0] / b.f[0] - 1.0).abs() < 1e-6 && (a.g[0] / b.g[0] - 1.0).abs() < 1e-6);
}

#[test]
fn far_from_all_data_the_prior_returns() {
    let mut gaussian = settings();
    gaussian.families = vec![Family::Gaussian];
    let model = gaussian.identify(&swings(1e-3)[..12]).unwrap().model;
    let far = model.standard_deviations(&[40.0, 90.0]).unwrap().unwrap();
    assert!(far.f[0] > 0.9 * far.f_prior[0], "{far:?}");
    let near = model.standard_deviations(&[0.3, 0.5]).unwrap().unwrap();
    assert!(near.f[0] < 0.1 * near.f_prior[0], "{near:?}");
}

#[test]
fn what_is_given_is_kept() {
    let mut fixed = settings();
    fixed.families = vec![Family::Matern];
    fixed.widths = Some(vec![2.0, 5.0]);
    fixed.lambda = Some(1e-6);
    let report = fixed.identify(&swings(1e-3)[..12]).unwrap().report;
    for block in &report.rows[0].blocks {
        assert_eq!(block.choice.kernel.family, Family::Matern);
        assert_eq!(block.choice.kernel.widths, [2.0, 5.0]);
        assert!((block.lambda / 1e-6 - 1.0).abs() < 1e-6, "{}", block.lambda);
    }
}

#[test]
fn data_without_information_are_refused_by_name() {
    let times: Vec<f64> = (0..50).map(|k| 0.1 * f64::from(k)).collect();
    let still = Motion::new(times.clone(), vec![0.0; 50], vec![1.0; 50]).unwrap();
    let error = settings().identify(&[still]).unwrap_err();
    assert_eq!(error, IdentificationError::Still { coordinate: 0 });
    assert_eq!(settings().identify(&[]).unwrap_err(), IdentificationError::NoMotion);
    let mut nan = vec![0.0; 50];
    nan[7] = f64::NAN;
    let error = Motion::new(times, vec![0.0; 50], nan).unwrap_err();
    assert!(error.to_string().contains("row 7"), "{error}");
    let wrong = Identification { order: 3, ..settings() };
    assert!(wrong.identify(&swings(1e-3)[..2]).unwrap_err().to_string().contains("found 3"));
}

/// Within the data a cubic follows a sine as well as anything, with the fewest terms; but of the highest degree that there is.
#[test]
fn what_may_be_the_beginning_of_a_series_is_left_to_a_general_drift() {
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let start = |k: usize| [-0.5 + 0.2 * (k % 6) as f64, -1.0 + 2.0 * (k / 6) as f64];
    let swings: Vec<Motion> = (0..12).map(|k| swing(start(k), k as f64, 1e-3, &mut rng)).collect();
    let model = settings().identify(&swings).unwrap().model;
    // The data end at 1.04.
    for x in [[1.0, 1.0], [-1.0, 1.0], [1.5, 2.0], [-1.5, 2.0]] {
        let (mut f, mut g) = ([0.0], [0.0]);
        model.evaluate(&x, &mut f, &mut g).unwrap();
        let (off, sd) = (f[0] - drift(x[0], x[1]), model.standard_deviations(&x).unwrap().unwrap());
        assert!(off.abs() < 3.0 * sd.f[0], "{x:?}: {off}, standard deviation {}", sd.f[0]);
    }
}

/// x' = -x + 2 x y - u, y' = 1 - x^2 + noise of 1 %: one trajectory.
fn quadratic(noise: f64) -> Motion {
    let input = |t: f64| (0.7 * t).sin() + (2.3 * t).cos();
    let slope = |t: f64, [x, y]: [f64; 2]| [-x + 2.0 * x * y - input(t), 1.0 - x * x - 0.5 * y];
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let normal = Normal::new(0.0, noise).unwrap();
    let (mut z, mut samples, mut inputs) = ([0.5, 0.2], Vec::new(), Vec::new());
    let times: Vec<f64> = (0..1000).map(|k| STEP * f64::from(k)).collect();
    for &t in &times {
        samples.extend(z.map(|value| value + normal.sample(&mut rng)));
        inputs.push(input(t));
        let add = |d: [f64; 2], h: f64| [z[0] + h * d[0], z[1] + h * d[1]];
        let a = slope(t, z);
        let b = slope(t + 0.5 * STEP, add(a, 0.5 * STEP));
        let c = slope(t + 0.5 * STEP, add(b, 0.5 * STEP));
        let d = slope(t + STEP, add(c, STEP));
        z = [0, 1].map(|i| z[i] + STEP / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]));
    }
    Motion::new(times, samples, inputs).unwrap()
}

#[test]
fn a_polynomial_has_the_monomials_that_the_data_ask_for_and_no_other() {
    let settings = Identification::new(1, Arguments::State, InputPath::Smooth);
    let model = settings.identify(&[quadratic(0.01)]).unwrap().model;
    // Far from the data, where each term that is not there would show.
    for x in [[4.0, -5.0], [-6.0, 3.0], [0.0, 8.0]] {
        let (mut f, mut g) = ([0.0; 2], [0.0; 2]);
        model.evaluate(&x, &mut f, &mut g).unwrap();
        let truth = [-x[0] + 2.0 * x[0] * x[1], 1.0 - x[0] * x[0] - 0.5 * x[1]];
        let sd = model.standard_deviations(&x).unwrap().unwrap();
        for i in 0..2 {
            let off = (f[i] - truth[i]).abs();
            let size = 1.0 + x[0].abs() + x[0] * x[0] + (x[0] * x[1]).abs() + x[1].abs();
            assert!(off < 0.02 * size, "f {i} at {x:?}: {} for {}", f[i], truth[i]);
            assert!(off < 4.0 * sd.f[i], "f {i} at {x:?}: {off}, standard deviation {}", sd.f[i]);
        }
        assert!((g[0] + 1.0).abs() < 0.02 && g[1] == 0.0, "{g:?}");
    }
}
