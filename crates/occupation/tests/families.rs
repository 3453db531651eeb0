//! Which kernels are chosen where nothing is given.

use lacuna_occupation::{Arguments, Family, Identification, InputPath, Motion};
use lacuna_plants::{InputFn, Plant, rk4};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

const STEP: f64 = 0.004;
const SAMPLES: usize = 2000;
const START: [f64; 3] = [-8.0, 8.0, 27.0];

fn input(t: f64) -> [f64; 2] {
    [30.0 * (2.0 * t).sin(), 30.0 * (0.9 * t).cos()]
}

/// The Lorenz system; one input drives the first row, the other the last.
struct Lorenz;

impl Plant for Lorenz {
    fn order(&self) -> usize {
        1
    }

    fn dimension(&self) -> usize {
        3
    }

    fn inputs(&self) -> usize {
        2
    }

    fn derivative(&self, _: f64, state: &[f64], u: &[f64], derivative: &mut [f64]) {
        let (x, y, z) = (state[0], state[1], state[2]);
        derivative[0] = 10.0 * (y - x) + u[0];
        derivative[1] = x * (28.0 - z) - y;
        derivative[2] = x * y - 8.0 / 3.0 * z - u[1];
    }
}

/// States without noise, and those that are identified, whose noise is a hundredth of their spread.
fn motion() -> (Vec<f64>, Motion) {
    let times: Vec<f64> = (0..SAMPLES).map(|k| STEP * k as f64).collect();
    let drive = InputFn(|t: f64, u: &mut [f64]| u.copy_from_slice(&input(t)));
    let exact = rk4(&Lorenz, &START, &drive, &times, STEP / 4.0).unwrap().states;
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let normal = Normal::new(0.0, 0.08).unwrap();
    let noisy = exact.iter().map(|x| x + normal.sample(&mut rng)).collect();
    let inputs = times.iter().flat_map(|&t| input(t)).collect();
    (exact, Motion::new(times, noisy, inputs).unwrap())
}

/// Gaussians come first and reach any function; where a system is quadratic, a few monomials say it better. What the
/// Gaussians are at their best with, an amplitude hundreds of times that of the function, must not keep them from it.
#[test]
fn a_quadratic_system_is_told_in_polynomials() {
    let (exact, motion) = motion();
    let identification = Identification::new(1, Arguments::State, InputPath::Smooth);
    let found = identification.identify(&[motion]).unwrap();
    for row in &found.report.rows {
        let family = row.blocks[0].choice.kernel.family;
        assert!(matches!(family, Family::Polynomial(1 | 2)), "{family}");
    }
    let (mut off, mut all) = (0.0, 0.0);
    let (mut f, mut g) = ([0.0; 3], [0.0; 6]);
    let mut rates = [0.0; 3];
    for (k, x) in exact.chunks_exact(3).enumerate() {
        let u = input(STEP * k as f64);
        found.model.evaluate(x, &mut f, &mut g).unwrap();
        Lorenz.derivative(0.0, x, &u, &mut rates);
        for (i, rate) in rates.into_iter().enumerate() {
            off += (f[i] + g[2 * i] * u[0] + g[2 * i + 1] * u[1] - rate).powi(2);
            all += rate * rate;
        }
    }
    let error = (off / all).sqrt();
    assert!(error < 2e-3, "{error}");
}
