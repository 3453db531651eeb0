//! Kernel values, Gram matrices and fits.

use divan::{Bencher, black_box, counter::ItemsCount};
use lacuna_occupation::{
    ExponentialDotProduct, Gaussian, InitialDerivative, Kernel, KernelSpec, Matern, Quadrature,
    Regression, Smoothness, TestFunction, TrajectoryData, gram_matrix,
};

fn main() {
    divan::main();
}

/// Values from -2 to 2 without a period.
fn value(k: usize) -> f64 {
    4.0 * (k as f64 * 0.618_033_988_749_894_9).fract() - 2.0
}

/// Trajectories of so many samples, with four states and two inputs.
fn trajectories(count: usize, samples: usize) -> Vec<TrajectoryData> {
    let one = |k: usize| {
        let times = (0..samples).map(|l| 0.05 * l as f64).collect();
        let column = |from: usize, columns: usize| -> Vec<f64> {
            let at = |l: usize, i: usize| {
                value(k * 11 + from + i) + 0.3 * (0.05 * l as f64 * (1 + i) as f64).sin()
            };
            (0..samples).flat_map(|l| (0..columns).map(move |i| at(l, i))).collect()
        };
        let states = column(0, 4);
        TrajectoryData::new(times, states.clone(), column(7, 2), states).expect("it has a shape")
    };
    (0..count).map(one).collect()
}

fn regression(kernel: KernelSpec, test_function: TestFunction) -> Regression {
    Regression {
        kernel,
        order: 1,
        test_function,
        quadrature: Quadrature::Trapezoid,
        lambda: 1e-3,
        initial_derivative: InitialDerivative::default(),
        whiten: false,
    }
}

const ENDPOINT: TestFunction = TestFunction::Endpoint { order: 1 };

fn row(bencher: Bencher, kernel: &dyn Kernel) {
    const COUNT: usize = 2048;
    let points: Vec<f64> = (0..4 * COUNT).map(value).collect();
    let mut values = vec![0.0; COUNT];
    bencher.counter(ItemsCount::new(COUNT)).bench_local(|| {
        kernel.evaluate_row(black_box(&[0.1, -0.2, 0.3, 0.7]), &points, &mut values);
    });
}

#[divan::bench]
fn gaussian_row(bencher: Bencher) {
    row(bencher, &Gaussian { widths: vec![1.0] });
}

#[divan::bench]
fn exponential_row(bencher: Bencher) {
    row(bencher, &ExponentialDotProduct { mu: 5.0 });
}

#[divan::bench]
fn matern_row(bencher: Bencher) {
    row(bencher, &Matern { smoothness: Smoothness::FiveHalves, widths: vec![1.0] });
}

/// 400 trajectories of 21 samples: kernel values a second, of half of the pairs.
#[divan::bench(args = ["endpoint", "compact"], sample_count = 20)]
fn gram(bencher: Bencher, functions: &str) {
    let (count, samples) = (400, 21);
    let test_function = match functions {
        "endpoint" => ENDPOINT,
        _ => TestFunction::Compact { exponent: 4, width: 0.6, stride: 1 },
    };
    let regression = regression(ExponentialDotProduct { mu: 5.0 }.into(), test_function);
    let system = regression.assemble(&trajectories(count, samples)).expect("the data are regular");
    let pairs = (count * samples).pow(2) / 2;
    bencher
        .counter(ItemsCount::new(pairs))
        .bench_local(|| gram_matrix(&regression.kernel, black_box(&system.occupation)));
}

/// Exact features (one argument) are another matter.
#[divan::bench(sample_count = 20)]
fn fit_400_x_21(bencher: Bencher) {
    let data = trajectories(400, 21);
    let regression = regression(Gaussian { widths: vec![2.0] }.into(), ENDPOINT);
    bencher.bench_local(|| regression.fit(black_box(&data)));
}
