//! Cost of one right-hand side: a two-link arm from a model file beside the same arm in Rust.

use divan::{Bencher, black_box};
use lacuna_plants::{Model, Plant, System, TwoLinkArm};

fn main() {
    divan::main();
}

const MODEL: &str = include_str!("../../../examples/two_link/model.toml");

fn bench(bencher: Bencher, plant: &dyn Plant) {
    let (state, u) = ([0.3, -0.4, 1.1, 0.7], [1.0, -2.0]);
    let mut derivative = [0.0; 4];
    bencher
        .bench_local(|| plant.derivative(0.0, black_box(&state), black_box(&u), &mut derivative));
}

#[divan::bench(sample_size = 10_000)]
fn model_file(bencher: Bencher) {
    let model = Model::from_text(MODEL, "model.toml").expect("the example is valid");
    bench(bencher, &System::new(&model));
}

#[divan::bench(sample_size = 10_000)]
fn native(bencher: Bencher) {
    bench(bencher, &TwoLinkArm::default());
}
