//! Steps that are cut where slopes jump are as exact as many steps everywhere, and hardly more than few.

mod support;

use lacuna_numbers::{Dual, Number};
use lacuna_plants::model::{Direction, Strand, advance_together};
use lacuna_plants::{Hold, Model, Substeps, System};
use support::{read, states};

/// A light slider in dry friction, and a pendulum beside it that feels nothing of it.
const MODEL: &str = r#"
name = "slider"
[parameters]
friction = { value = 0.4, unit = "N", tolerance = 0.1 }
[[input]]
name = "u"
unit = "N"
[[coordinate]]
name = "s"
velocity = "ds"
unit = "m"
[[coordinate]]
name = "a"
velocity = "da"
unit = "rad"
[recordings]
input_hold = "zero-order"
[mechanics]
mass = [["0.02", "0"], ["0", "1"]]
force = ["u - friction*tanh(ds/0.001) - 3*s", "-4*sin(a)"]
"#;

const STEP: f64 = 0.01;
const SAMPLES: usize = 400;

fn model() -> Model {
    read(MODEL)
}

/// The states at all samples, with derivatives by the friction, and how many steps they took.
fn run(model: &Model, hold: Hold, substeps: Substeps) -> (Vec<Dual>, usize) {
    let time = (0..SAMPLES).map(|k| STEP * k as f64);
    let inputs: Vec<f64> = time.map(|t| (2.1 * t).sin() + 0.3 * (5.3 * t).cos()).collect();
    let driven = (STEP, &inputs[..], hold);
    states(model, Direction::Parameter(0), driven, &[0.0, 0.5, 0.0, 0.0], substeps)
}

fn apart(a: &[Dual], b: &[Dual], of: impl Fn(&Dual) -> f64) -> f64 {
    a.iter().zip(b).map(|(a, b)| (of(a) - of(b)).abs()).fold(0.0, f64::max)
}

#[test]
fn kinks_are_cut_and_nothing_else() {
    let model = model();
    for hold in [Hold::ZeroOrder, Hold::Linear, Hold::BandLimited] {
        let (fine, _) = run(&model, hold, Substeps::even(256));
        let (plain, _) = run(&model, hold, Substeps::even(4));
        let (cut, steps) = run(&model, hold, Substeps::cut(4));
        let off = |states: &[Dual]| apart(states, &fine, |x| x.value);
        assert!(off(&cut) < 1e-4 && off(&plain) > 100.0 * off(&cut), "{hold:?}: {}", off(&cut));
        // Of 256 steps a sample, most where it sticks.
        assert!(steps < 64 * SAMPLES, "{hold:?}: {steps}");
        let slope = |states: &[Dual]| apart(states, &fine, |x| x.tangent[0]);
        assert!(slope(&cut) < 1e-2, "{hold:?}: {}", slope(&cut));
    }
}

/// Where nothing jumps, steps that may be cut are those that may not, to the last bit.
#[test]
fn smooth_motion_is_not_cut() {
    let smooth =
        MODEL.replace("tanh(ds/0.001)", "0.1*ds").replace("mass = [[\"0.02\"", "mass = [[\"2\"");
    let model = read(&smooth);
    let (plain, even) = run(&model, Hold::Linear, Substeps::even(1));
    let (cut, steps) = run(&model, Hold::Linear, Substeps::cut(1));
    assert_eq!((even, steps), (SAMPLES - 1, SAMPLES - 1));
    assert_eq!(apart(&plain, &cut, |x| x.value), 0.0);
    assert_eq!(apart(&plain, &cut, |x| x.tangent[0]), 0.0);
}

/// Masses and all forces scaled alike move no machine: its parameters' derivatives, each times its parameter, add up to
/// nothing, though they are carried by two systems.
#[test]
fn systems_side_by_side_cut_the_same_steps() {
    let scaled = MODEL
        .replace("[[input]]\nname = \"u\"\nunit = \"N\"\n", "")
        .replace("friction = {", "m = { value = 0.02, unit = \"kg\" }\nk = { value = 3.0, unit = \"N/m\" }\nfriction = {")
        .replace("\"0.02\"", "\"m\"")
        .replace("u - friction*tanh(ds/0.001) - 3*s", "-friction*tanh(ds/0.001) - k*(s - sin(3*t))");
    let model = read(&scaled);
    let along = |directions: &[(Direction, usize)]| {
        System::<Dual>::along(&model, &model.values(), &model.effects, directions, STEP)
    };
    let [m, k, friction] = [0, 1, 2].map(Direction::Parameter);
    let systems = [along(&[(m, 0)]), along(&[(k, 0), (friction, 1)])];
    let mut states = [[0.0, 0.5, 0.0, 0.0].map(Dual::constant); 2];
    let mut rooms = [systems[0].workspace(), systems[1].workspace()];
    let path = Hold::Linear.along((&[0.0, 10.0], &[] as &[f64]), 0..2, 0, 1);
    let (mut most, mut apart) = (0.0f64, 0.0f64);
    for sample in 0..SAMPLES {
        let times = (STEP * sample as f64, STEP * (sample + 1) as f64);
        let sides = systems.iter().zip(&mut rooms).zip(&mut states);
        let inputs = path.step_in(0);
        let mut strands: Vec<Strand<Dual>> = sides
            .map(|((system, workspace), state)| Strand { system, workspace, inputs, state })
            .collect();
        advance_together(&mut strands, times, Substeps::cut(1));
        let [first, second] = &states;
        for (a, b) in first.iter().zip(second) {
            let parts = [0.02 * a.tangent[0], 3.0 * b.tangent[0], 0.4 * b.tangent[1]];
            most = parts.iter().fold(most, |most, x| most.max(x.abs()));
            apart = apart.max(parts.iter().sum::<f64>().abs());
            assert_eq!(a.value, b.value);
        }
    }
    assert!(most > 0.1 && apart < 1e-9 * most, "{apart} of {most}");
    let steps = rooms[0].steps();
    assert!(steps > SAMPLES, "{steps}");
}
