//! What derivatives cost beside the plain simulation they belong to.

use divan::{Bencher, counter::ItemsCount};
use lacuna_plants::model::Direction;
use lacuna_plants::{Dual, Model, Number, System};

fn main() {
    divan::main();
}

const TWO_LINK: &str = include_str!("../../../examples/two_link/model.toml");
const SAMPLES: usize = 1000;

fn model() -> Model {
    Model::from_text(TWO_LINK, "model.toml").expect("a valid model")
}

#[divan::bench]
fn plain(bencher: Bencher) {
    let system = System::new(&model());
    let mut w = system.workspace();
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let mut x = vec![0.3, -0.4, 0.1, 0.5];
        for k in 0..SAMPLES {
            let t = 0.004 * k as f64;
            system.advance(&mut w, (t, t + 0.004), (&[0.5, 0.1], &[0.5, 0.1]), 1, &mut x);
        }
        x
    });
}

#[divan::bench]
fn eight_directions(bencher: Bencher) {
    let model = model();
    let directions =
        [(Direction::Parameter(0), 4), (Direction::Force(0), 5), (Direction::Force(1), 6)];
    let system = System::along(&model, &model.values(), &model.effects, &directions, 0.004);
    let mut w = system.workspace();
    let u = [0.5, 0.1].map(Dual::constant);
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let mut x: Vec<Dual> = [0.3, -0.4, 0.1, 0.5]
            .into_iter()
            .enumerate()
            .map(|(l, v)| Dual::direction(v, l))
            .collect();
        for k in 0..SAMPLES {
            let t = 0.004 * k as f64;
            system.advance(&mut w, (t, t + 0.004), (&u, &u), 1, &mut x);
        }
        x
    });
}
