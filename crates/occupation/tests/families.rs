//! Which kernels are chosen where nothing is given.

use lacuna_occupation::{Arguments, Family, Identification, InputPath, Motion};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

const STEP: f64 = 0.004;
const SAMPLES: usize = 2000;
/// Steps of integration between samples.
const SUBSTEPS: usize = 4;

fn input(t: f64) -> [f64; 2] {
    [30.0 * (2.0 * t).sin(), 30.0 * (0.9 * t).cos()]
}

/// The Lorenz system; one input drives the first row, the other the last.
fn lorenz([x, y, z]: [f64; 3], [a, b]: [f64; 2]) -> [f64; 3] {
    [10.0 * (y - x) + a, x * (28.0 - z) - y, x * y - 8.0 / 3.0 * z - b]
}

/// Samples without noise, and those that are identified, whose noise is a hundredth of their spread.
fn motion() -> (Vec<[f64; 3]>, Motion) {
    let h = STEP / SUBSTEPS as f64;
    let add = |z: [f64; 3], d: [f64; 3], h: f64| [0, 1, 2].map(|i| z[i] + h * d[i]);
    let (mut z, mut exact) = ([-8.0, 8.0, 27.0], vec![]);
    for k in 0..SAMPLES {
        exact.push(z);
        for s in 0..SUBSTEPS {
            let t = STEP * k as f64 + h * s as f64;
            let a = lorenz(z, input(t));
            let b = lorenz(add(z, a, 0.5 * h), input(t + 0.5 * h));
            let c = lorenz(add(z, b, 0.5 * h), input(t + 0.5 * h));
            let d = lorenz(add(z, c, h), input(t + h));
            z = [0, 1, 2].map(|i| z[i] + h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]));
        }
    }
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let normal = Normal::new(0.0, 0.08).unwrap();
    let noisy = exact.iter().flatten().map(|x| x + normal.sample(&mut rng)).collect();
    let times: Vec<f64> = (0..SAMPLES).map(|k| STEP * k as f64).collect();
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
    for (k, x) in exact.iter().enumerate() {
        let u = input(STEP * k as f64);
        found.model.evaluate(x, &mut f, &mut g).unwrap();
        for (i, rate) in lorenz(*x, u).into_iter().enumerate() {
            off += (f[i] + g[2 * i] * u[0] + g[2 * i + 1] * u[1] - rate).powi(2);
            all += rate * rate;
        }
    }
    let error = (off / all).sqrt();
    assert!(error < 2e-3, "{error}");
}
