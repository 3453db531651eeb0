//! Cost of looking for outliers in a million samples: of a slow motion, of one as fast as its
//! sampling allows, and of one that was sampled unevenly; each with glitches.

use divan::{Bencher, black_box};
use lacuna_recordings::find_outliers;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

fn main() {
    divan::main();
}

const SAMPLES: usize = 1_000_000;
const STEP: f64 = 0.001;
const SD: f64 = 0.003;

/// A sinusoid of this angular frequency, its times off by this share of a step, every thousandth
/// sample a glitch.
fn bench(bencher: Bencher, frequency: f64, jitter: f64) {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
    let time: Vec<f64> =
        (0..SAMPLES).map(|k| STEP * (k as f64 + jitter * noise().tanh())).collect();
    let mut values: Vec<f64> = time.iter().map(|t| (frequency * t).sin() + SD * noise()).collect();
    for value in values.iter_mut().step_by(1000) {
        *value += SD * rng.random_range(15.0..60.0);
    }
    bencher.bench_local(|| find_outliers(black_box(&[(&time, &values)])));
}

#[divan::bench(sample_count = 3)]
fn slow_motion(bencher: Bencher) {
    bench(bencher, 7.0, 0.0);
}

#[divan::bench(sample_count = 3)]
fn fast_motion(bencher: Bencher) {
    bench(bencher, 2000.0, 0.0);
}

#[divan::bench(sample_count = 3)]
fn uneven_sampling(bencher: Bencher) {
    bench(bencher, 7.0, 0.4);
}
