//! Friction that lets next to nothing creep: where a machine sticks few steps are enough, and where it turns they are
//! cut until they see it. What comes out is what friction that lets nothing creep makes of it.

mod support;

use lacuna_numbers::Dual;
use lacuna_plants::model::Direction;
use lacuna_plants::{Hold, Model, Substeps};
use support::{read, states};

const STEP: f64 = 0.004;
const SAMPLES: usize = 1000;
const MASS: f64 = 3.0;
const DAMPING: f64 = 8.0;

/// A stage pushed by a force that is held from sample to sample.
fn stage(smoothing_velocity: f64) -> Model {
    let text = format!(
        r#"
name = "stage"
[[input]]
name = "u"
unit = "N"
[[coordinate]]
name = "x"
velocity = "v"
unit = "m"
[recordings]
input_hold = "zero-order"
[mechanics]
mass = [["{MASS}"]]
force = ["u - {DAMPING}*v"]
[[effect]]
class = "coulomb_friction"
channel = "x"
magnitude = {{ value = 1.5, unit = "N" }}
smoothing_velocity = {{ value = {smoothing_velocity}, unit = "m/s" }}
"#
    );
    read(&text)
}

fn force(t: f64) -> f64 {
    2.0 * ((7.1 * t).sin() + 0.6 * (3.3 * t + 1.0).cos())
}

/// Positions at the samples behind the first with their derivatives by the friction, and how many steps they took.
fn run(model: &Model, substeps: Substeps) -> (Vec<Dual>, usize) {
    let inputs: Vec<f64> = (0..SAMPLES).map(|k| force(STEP * k as f64)).collect();
    let driven = (STEP, &inputs[..], Hold::ZeroOrder);
    let (states, steps) = states(model, Direction::Effect(0, 0), driven, &[0.0; 2], substeps);
    (states.into_iter().step_by(2).collect(), steps)
}

/// The same where nothing creeps, in closed form from one change of sign to the next; and how often it stood still at a
/// sample.
fn standing(friction: f64) -> (Vec<f64>, usize) {
    let (mut x, mut v, mut stood) = (0.0, 0.0f64, 0);
    let mut positions = vec![];
    for k in 0..SAMPLES - 1 {
        let (u, mut left) = (force(STEP * k as f64), STEP);
        while left > 0.0 {
            if v == 0.0 && u.abs() <= friction {
                stood += 1;
                break;
            }
            let sign = if v == 0.0 { u.signum() } else { v.signum() };
            // v = end + (v - end) e^(-rate t).
            let (rate, end) = (DAMPING / MASS, (u - sign * friction) / DAMPING);
            let turns = (v != 0.0 && end / v < 0.0).then(|| ((v - end) / -end).ln() / rate);
            let time = turns.map_or(left, |t| t.min(left));
            let passed = -(-rate * time).exp_m1();
            x += end * time + (v - end) * passed / rate;
            v = if turns.is_some_and(|t| t <= left) { 0.0 } else { v - (v - end) * passed };
            left -= time;
        }
        positions.push(x);
    }
    (positions, stood)
}

#[test]
fn few_steps_are_as_good_as_no_creeping() {
    let (exact, stood) = standing(1.5);
    let range = exact.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let (positions, steps) = run(&stage(3e-7), Substeps::cut(1));
    let off = exact.iter().zip(&positions).map(|(a, b)| (a - b.value).abs()).fold(0.0, f64::max);
    assert!(stood > SAMPLES / 4 && off < 1e-4 * range, "{stood}, {off} of {range}");
    // Steps of order four would have to be shorter than 2.8 m v_s / F: 2400 of them a sample.
    assert!(steps < 8 * SAMPLES, "{steps}");
    // Derivatives are those of what stands still, though nothing tells where it turns but the slopes themselves.
    let small = 1e-5;
    let (more, less) = (standing(1.5 + small).0, standing(1.5 - small).0);
    let slopes = || more.iter().zip(&less).map(|(a, b)| (a - b) / (2.0 * small));
    let steepest = slopes().fold(0.0f64, |most, s| most.max(s.abs()));
    let off = slopes().zip(&positions).map(|(a, b)| (a - b.tangent[0]).abs()).fold(0.0, f64::max);
    assert!(off < 1e-3 * steepest, "{off} of {steepest}");
}

/// Where friction lets the machine creep as fast as it moves, steps are of order four as they always are.
#[test]
fn halved_steps_err_a_sixteenth() {
    let model = stage(2e-3);
    let error = |count: usize| {
        let [(coarse, _), (fine, _)] = [count, 2 * count].map(|c| run(&model, Substeps::even(c)));
        coarse.iter().zip(&fine).map(|(a, b)| (a.value - b.value).abs()).fold(0.0, f64::max)
    };
    // A rate of 250 a second: at eight steps a sample the first are resolved by themselves.
    let errors = [1, 2, 4].map(error);
    assert!(errors[0] > 8.0 * errors[1] && errors[1] > 8.0 * errors[2], "{errors:?}");
}
