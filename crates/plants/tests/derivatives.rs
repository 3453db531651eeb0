//! Derivatives of a simulation against differences of two simulations.

use lacuna_numbers::{Dual, Number};
use lacuna_plants::model::{Direction, StepInput};
use lacuna_plants::{Model, Substeps, System};

const ARM: &str = r#"
name = "arm"
[parameters]
p1 = { value = 3.473, unit = "kg m^2", tolerance = 0.1 }
p2 = { value = 0.196, unit = "kg m^2" }
p3 = { value = 0.242, unit = "kg m^2" }
fd1 = { value = 5.3, unit = "N m s" }
[[input]]
name = "tau1"
unit = "N m"
[[input]]
name = "tau2"
unit = "N m"
[[coordinate]]
name = "q1"
velocity = "dq1"
unit = "rad"
[[coordinate]]
name = "q2"
velocity = "dq2"
unit = "rad"
[mechanics]
mass = [["p1 + 2*p3*cos(q2)", "p2 + p3*cos(q2)"], ["p2 + p3*cos(q2)", "p2"]]
force = ["tau1 - fd1*dq1 + p3*sin(q2)*(2*dq1*dq2 + dq2^2)", "tau2 - 1.1*dq2 - p3*sin(q2)*dq1^2"]
[[effect]]
class = "stribeck_friction"
channel = "q1"
coulomb = { value = 2.0, unit = "N m" }
static = { value = 3.1, unit = "N m" }
stribeck_velocity = { value = 0.3, unit = "rad/s" }
smoothing_velocity = { value = 0.1, unit = "rad/s" }
[[effect]]
class = "hysteresis"
channel = "q2"
stiffness = { value = 0.4, unit = "N m/rad" }
beta = { value = 2.0, unit = "1/rad" }
gamma = { value = 1.5, unit = "1/rad" }
[recordings]
time = "t"
"#;

const SAMPLES: usize = 80;
const STEP: f64 = 0.01;

fn run(model: &Model, parameters: &[f64], effects: usize, moved: f64, start: &[f64]) -> Vec<f64> {
    let mut list = model.effects.clone();
    if effects > 0 {
        let mut internal = list[0].internal();
        internal[effects - 1] += moved;
        list[0].set_internal(&internal);
    }
    let system = System::with(model, parameters, &list);
    let (mut x, mut w) = (start.to_vec(), system.workspace());
    for k in 0..SAMPLES {
        let t = STEP * k as f64;
        let u = [3.0 * (4.0 * t).sin(), (7.0 * t).cos()];
        system.advance(&mut w, (t, t + STEP), StepInput::Line(&u, &u), Substeps::even(2), &mut x);
    }
    x
}

/// Inputs that carry their own derivatives, and plain ones beside a change of each: the same.
#[test]
fn a_change_of_an_input_is_a_direction() {
    let model = Model::from_text(ARM, "arm.toml").expect("valid");
    let run = |directions: &[(Direction, usize)], inputs: StepInput<Dual>| {
        let system = System::along(&model, &model.values(), &model.effects, directions, 0.0);
        let mut w = system.workspace();
        let mut x = [0.3, -0.4, 0.1, 0.5, 0.02].map(Dual::constant);
        system.advance(&mut w, (0.0, STEP), inputs, Substeps::even(2), &mut x);
        x
    };
    let changes = [(Direction::Input(0), 1), (Direction::Input(1), 4)];
    let seeded = |u: [f64; 2]| [Dual::direction(u[0], 1), Dual::direction(u[1], 4)];
    let (here, next) = ([0.3, -1.0], [0.5, 0.0]);
    let moved = run(&[], StepInput::Line(&seeded(here), &seeded(next)));
    assert_eq!(moved, run(&changes, StepInput::PlainLine(&here, &next)));
    assert!([1, 4].iter().all(|l| moved.iter().any(|x| x.tangent[*l].abs() > 1e-9)), "{moved:?}");
    let rows = [0.3, -1.0, 0.1, 0.7, -0.2, 0.4, 0.9, 0.0, 0.5, 0.0];
    let seeds: Vec<Dual> = rows.chunks_exact(2).flat_map(|row| seeded([row[0], row[1]])).collect();
    let moved = run(&[], StepInput::Stages(&seeds));
    assert_eq!(moved, run(&changes, StepInput::PlainStages(&rows)));
}

#[test]
fn a_simulation_carries_its_derivatives() {
    let model = Model::from_text(ARM, "arm.toml").expect("valid");
    let (p, start) = (model.values(), vec![0.3, -0.4, 0.1, 0.5, 0.02]);
    let directions = [
        (Direction::Parameter(0), 0),
        (Direction::Parameter(3), 1),
        (Direction::Effect(0, 0), 2),
        (Direction::Effect(0, 1), 3),
        (Direction::Effect(0, 2), 4),
        (Direction::Force(1), 7),
    ];
    let system = System::along(&model, &p, &model.effects, &directions, STEP);
    let mut x: Vec<Dual> = start.iter().map(|&v| Dual::constant(v)).collect();
    x[1] = Dual::direction(start[1], 5);
    x[4] = Dual::direction(start[4], 6);
    let mut w = system.workspace();
    for k in 0..SAMPLES {
        let t = STEP * k as f64;
        let u = [3.0 * (4.0 * t).sin(), (7.0 * t).cos()].map(Dual::constant);
        system.advance(&mut w, (t, t + STEP), StepInput::Line(&u, &u), Substeps::even(2), &mut x);
    }
    let base = run(&model, &p, 0, 0.0, &start);
    let h = 1e-6;
    let shifted = |k: usize, by: f64| {
        let mut p = p.to_vec();
        p[k] += by;
        run(&model, &p, 0, 0.0, &start)
    };
    let moved = |i: usize, by: f64| {
        let mut x0 = start.to_vec();
        x0[i] += by;
        run(&model, &p, 0, 0.0, &x0)
    };
    let central = |f: &dyn Fn(f64) -> Vec<f64>| -> Vec<f64> {
        f(h).iter().zip(f(-h)).map(|(a, b)| (a - b) / (2.0 * h)).collect()
    };
    let expected = [
        central(&|d| shifted(0, d)),
        central(&|d| shifted(3, d)),
        central(&|d| run(&model, &p, 1, d, &start)),
        central(&|d| run(&model, &p, 2, d, &start)),
        central(&|d| run(&model, &p, 3, d, &start)),
        central(&|d| moved(1, d)),
        central(&|d| moved(4, d)),
    ];
    for (i, x) in x.iter().enumerate() {
        assert!((x.value - base[i]).abs() < 1e-12, "value {i}");
        for (lane, e) in expected.iter().enumerate() {
            let error = (x.tangent[lane] - e[i]).abs();
            assert!(error < 1e-5 * (1.0 + e[i].abs()), "state {i} lane {lane}: {x:?} {}", e[i]);
        }
    }
    assert!(x[1].tangent[7] > 0.0, "a push on q2 moves q2");
}
