//! Simulation of one second of a two-link arm, from a model file and in Rust.

use divan::{Bencher, black_box};
use lacuna_plants::{InputFn, Model, Plant, System, TwoLinkArm, rk4};

fn main() {
    divan::main();
}

const MODEL: &str = include_str!("../../../examples/two_link/model.toml");

fn bench(bencher: Bencher, plant: &dyn Plant) {
    let times: Vec<f64> = (0..=20).map(|k| 0.05 * f64::from(k)).collect();
    let drive = InputFn(|t: f64, u: &mut [f64]| {
        u[0] = (2.0 * t).sin();
        u[1] = (3.0 * t).sin();
    });
    bencher.bench_local(|| rk4(plant, black_box(&[0.3, -0.4, 1.1, 0.7]), &drive, &times, 0.0025));
}

#[divan::bench]
fn model_file(bencher: Bencher) {
    let model = Model::from_text(MODEL, "model.toml").expect("the example is valid");
    bench(bencher, &System::new(&model));
}

#[divan::bench]
fn native(bencher: Bencher) {
    bench(bencher, &TwoLinkArm::default());
}
