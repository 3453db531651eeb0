//! What derivatives cost beside the plain simulation they belong to, with effects and without.

use divan::{Bencher, counter::ItemsCount};
use lacuna_numbers::{Dual, Number};
use lacuna_plants::model::{Direction, StepInput};
use lacuna_plants::{Model, Substeps, System};

fn main() {
    divan::main();
}

const TWO_LINK: &str = include_str!("../../../examples/two_link/model.toml");
const SAMPLES: usize = 1000;

/// Laws of different prices: none, two without memory, one with memory, a learned curve.
const EFFECTS: [&str; 4] = ["none", "friction", "hysteresis", "curve"];

fn model(effects: &str) -> Model {
    let effects = match effects {
        "friction" => {
            "\n[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"q1\"\nmagnitude = 0.3\n\
             smoothing_velocity = 0.05\n[[effect]]\nclass = \"stribeck_friction\"\n\
             channel = \"q2\"\ncoulomb = 0.1\nstatic = 0.2\nstribeck_velocity = 0.1\n"
        }
        "hysteresis" => {
            "\n[[effect]]\nclass = \"hysteresis\"\nchannel = \"q1\"\nstiffness = 2\nbeta = 3\n\
             gamma = 2\n"
        }
        "curve" => {
            "\n[[effect]]\nclass = \"unknown_function\"\nchannel = \"q1\"\nover = \"dq1\"\n\
             from = -1\nto = 1\nforce = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 8, 7, 6, 5, 4, 3, 2, 1, \
             0, 1, 2, 3, 4, 5]\n"
        }
        _ => "",
    };
    Model::from_text(&format!("{TWO_LINK}{effects}"), "model.toml").expect("a valid model")
}

#[divan::bench(args = EFFECTS)]
fn plain(bencher: Bencher, effects: &str) {
    let system = System::new(&model(effects));
    let mut w = system.workspace();
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let mut x = system.at_rest(&[0.3, -0.4, 0.1, 0.5]);
        for k in 0..SAMPLES {
            let t = 0.004 * k as f64;
            system.advance(
                &mut w,
                (t, t + 0.004),
                StepInput::Line(&[0.5, 0.1], &[0.5, 0.1]),
                Substeps::even(1),
                &mut x,
            );
        }
        x
    });
}

#[divan::bench(args = EFFECTS)]
fn eight_directions(bencher: Bencher, effects: &str) {
    let model = model(effects);
    let mut directions =
        vec![(Direction::Parameter(0), 4), (Direction::Force(0), 5), (Direction::Force(1), 6)];
    if !model.effects.is_empty() {
        directions.push((Direction::Effect(0, 1), 7));
    }
    let system = System::along(&model, &model.values(), &model.effects, &directions, 0.004);
    let mut w = system.workspace();
    let u = [0.5, 0.1].map(Dual::constant);
    let start = system.at_rest(&[0.3, -0.4, 0.1, 0.5]);
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let seed = |(l, &v): (usize, &f64)| {
            if l < 4 { Dual::direction(v, l) } else { Dual::constant(v) }
        };
        let mut x: Vec<Dual> = start.iter().enumerate().map(seed).collect();
        for k in 0..SAMPLES {
            let t = 0.004 * k as f64;
            system.advance(
                &mut w,
                (t, t + 0.004),
                StepInput::Line(&u, &u),
                Substeps::even(1),
                &mut x,
            );
        }
        x
    });
}
