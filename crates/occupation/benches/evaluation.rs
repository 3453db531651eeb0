//! One evaluation of f (4) and g (4 x 2) of the identified two-link arm: its own sum over 21 000 samples, and compiled on
//! \[-2, 2\]^4 to relative errors of 1e-3 and 1e-6.
//!
//! `cargo bench -p lacuna-occupation --bench evaluation`

use std::sync::LazyLock;

use divan::{Bencher, black_box};
use lacuna_excitation::{SinusoidRanges, SumOfSinusoids, halton_cube, rng};
use lacuna_occupation::compile::{Compiled, Domain, compile};
use lacuna_occupation::{
    ExponentialDotProduct, IdentifiedModel, InitialDerivative, Quadrature, Regression,
    TestFunction, TrajectoryData,
};
use lacuna_plants::{InputFn, TwoLinkArm, rk4};

fn main() {
    // Made before the clock runs.
    LazyLock::force(&MODEL);
    divan::main();
}

/// The paper's settings: 1000 trajectories of 21 samples from a cube of side 6, exponential kernel with mu = 5.
static MODEL: LazyLock<IdentifiedModel> = LazyLock::new(|| {
    let ranges =
        SinusoidRanges { amplitude: -1.5..=1.5, angular_frequency: 1.0..=3.0, phase: 0.0..=0.0 };
    let times: Vec<f64> = (0..21).map(|k| 0.05 * f64::from(k)).collect();
    let data: Vec<TrajectoryData> = halton_cube(1000, 6.0, &[0.0; 4])
        .expect("a cube of side 6")
        .iter()
        .zip(0..)
        .map(|(x0, k)| {
            let input = SumOfSinusoids::random(&mut rng(1, k), 2, 3, &ranges).expect("ranges");
            let drive = InputFn(|t, u: &mut [f64]| input.value(t, u));
            let states = rk4(&TwoLinkArm::default(), x0, &drive, &times, 0.0025)
                .expect("a stable arm")
                .states;
            TrajectoryData::new(times.clone(), states.clone(), input.sample(&times), states)
                .expect("as many samples of each")
        })
        .collect();
    let regression = Regression {
        kernel: ExponentialDotProduct { mu: 5.0 }.into(),
        order: 1,
        test_function: TestFunction::Endpoint { order: 1 },
        quadrature: Quadrature::Simpson,
        lambda: 1e-3,
        initial_derivative: InitialDerivative::ForwardDifference,
        whiten: false,
    };
    regression.fit(&data).expect("enough data")
});

/// Points of the box, not in a row.
fn points() -> Vec<[f64; 4]> {
    let part = |k: usize| -2.0 + 4.0 * (k % 64) as f64 / 63.0;
    (0..64).map(|k| [part(k), part(5 * k), part(11 * k), part(23 * k)]).collect()
}

#[divan::bench(sample_size = 64)]
fn direct(bencher: Bencher<'_, '_>) {
    let (mut f, mut g) = ([0.0; 4], [0.0; 8]);
    let mut points = points().into_iter().cycle();
    bencher.bench_local(|| {
        let x = points.next().unwrap_or_default();
        MODEL.evaluate(black_box(&x), &mut f, &mut g).map(|()| black_box(f[3] + g[7]))
    });
}

#[divan::bench(args = [1e-3, 1e-6], sample_size = 64)]
fn compiled(bencher: Bencher<'_, '_>, tolerance: f64) {
    let domain = Domain::new(vec![-2.0; 4], vec![2.0; 4]).expect("a box");
    let compiled: Compiled = compile(&MODEL, &domain, tolerance).expect("a finite model");
    assert!(compiled.relative_error() <= tolerance);
    let evaluator = compiled.evaluator();
    let (mut f, mut g) = ([0.0; 4], [0.0; 8]);
    let mut points = points().into_iter().cycle();
    bencher.bench_local(|| {
        let x = points.next().unwrap_or_default();
        evaluator.evaluate(black_box(&x), &mut f, &mut g).map(|_| black_box(f[3] + g[7]))
    });
}
