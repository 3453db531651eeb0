//! A system with a known answer: x^(s) = x - x^3 + (2 + sin x) u for s = 1, 2.

use lacuna_occupation::{IdentifiedModel, TrajectoryData};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

pub fn drift(x: f64) -> f64 {
    x - x.powi(3)
}

pub fn control_effectiveness(x: f64) -> f64 {
    2.0 + x.sin()
}

/// Three sinusoids with random coefficients in [-1, 1] and angular frequencies in [1, 3] rad/s.
fn random_input(generator: &mut ChaCha8Rng) -> impl Fn(f64) -> f64 + use<> {
    let terms: [(f64, f64, f64); 3] = std::array::from_fn(|_| {
        (
            generator.random_range(-1.0..1.0),
            generator.random_range(1.0..3.0),
            generator.random_range(0.0..6.3),
        )
    });
    move |t| {
        terms
            .iter()
            .map(|(amplitude, frequency, phase)| amplitude * (frequency * t + phase).sin())
            .sum()
    }
}

/// Positions on the sample times by RK4 with ten steps a sample.
fn positions(
    order: usize,
    initial: [f64; 2],
    input: &impl Fn(f64) -> f64,
    step: f64,
    samples: usize,
) -> Vec<f64> {
    let rate = |t: f64, [x, v]: [f64; 2]| {
        let right = drift(x) + control_effectiveness(x) * input(t);
        if order == 1 { [right, 0.0] } else { [v, right] }
    };
    let moved = |state: [f64; 2], k: [f64; 2], h: f64| [state[0] + h * k[0], state[1] + h * k[1]];
    let h = step / 10.0;
    let (mut state, mut result) = (initial, vec![initial[0]]);
    for sample in 1..samples {
        for sub_step in 0..10 {
            let t = step * (sample - 1) as f64 + h * f64::from(sub_step);
            let k1 = rate(t, state);
            let k2 = rate(t + h / 2.0, moved(state, k1, h / 2.0));
            let k3 = rate(t + h / 2.0, moved(state, k2, h / 2.0));
            let k4 = rate(t + h, moved(state, k3, h));
            state = std::array::from_fn(|i| {
                state[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
            });
        }
        result.push(state[0]);
    }
    result
}

/// Trajectories of 1 s from a 13 x 9 grid of initial states (positions in [-3, 3], velocities in [-2, 2], which order 1
/// ignores), each with an input of its own; Gaussian noise on the positions, and the true initial velocities. Order 2
/// is sampled every 0.02 s, order 1 every 0.01 s: its transients from x = 3, where x' = -24, are faster.
pub fn trajectories(order: usize, noise: f64, seed: u64) -> Vec<TrajectoryData> {
    let velocities = 9;
    let (step, samples) = if order == 1 { (0.01, 101) } else { (0.02, 51) };
    let times: Vec<f64> = (0..samples).map(|k| step * k as f64).collect();
    let make = |index: usize| {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(index as u64);
        let position = -3.0 + 6.0 * (index / velocities) as f64 / 12.0;
        let velocity = -2.0 + 4.0 * (index % velocities) as f64 / (velocities - 1) as f64;
        let input = random_input(&mut generator);
        let mut x = positions(order, [position, velocity], &input, step, samples);
        let normal = Normal::new(0.0, noise).unwrap();
        x.iter_mut().for_each(|x| *x += normal.sample(&mut generator));
        let data = TrajectoryData::new(
            times.clone(),
            x.clone(),
            times.iter().map(|&t| input(t)).collect(),
            x,
        )
        .unwrap();
        data.with_initial_derivatives(vec![velocity; order - 1]).unwrap()
    };
    (0..13 * velocities).map(make).collect()
}

/// Largest errors of f and g on [-2, 2].
pub fn largest_errors(model: &IdentifiedModel) -> (f64, f64) {
    let (mut f, mut g) = ([0.0], [0.0]);
    (0..=40).map(|k| -2.0 + 0.1 * f64::from(k)).fold(
        (0.0, 0.0),
        |(f_error, g_error): (f64, f64), x| {
            model.evaluate(&[x], &mut f, &mut g).unwrap();
            (
                f_error.max((f[0] - drift(x)).abs()),
                g_error.max((g[0] - control_effectiveness(x)).abs()),
            )
        },
    )
}
