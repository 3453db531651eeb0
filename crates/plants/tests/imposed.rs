//! Imposed motion: what moves a coordinate along its path, and what that says of the others.

mod support;

use lacuna_numbers::{Dual, Number};
use lacuna_plants::model::{Direction, Measured, ModelEffect, Observation};
use lacuna_plants::{Model, Plant, System};
use support::{error, read};

/// A rod that a rig moves, with a mass on a spring hung on it.
const RIG: &str = r#"
name = "rig"
[parameters]
m = { value = 2, unit = "kg" }
M = { value = 0.7, unit = "kg" }
c = { value = 30, unit = "N s/m" }
k = { value = 500, unit = "N/m" }
[[input]]
name = "u"
unit = "N"
[[coordinate]]
name = "x"
velocity = "dx"
unit = "m"
imposed = true
[[coordinate]]
name = "y"
velocity = "dy"
unit = "m"
[mechanics]
mass = [["m", "0.2*M"], ["0.2*M", "M"]]
force = ["u - c*dx - k*(x - y)", "k*(x - y) - 0.1*c*dy"]
[[measurement]]
column = "F"
of = "force on x"
unit = "kN"
[[measurement]]
column = "pull"
of = "3 - 2*force on x + y"
unit = "N"
"#;

const EFFECTS: &str = r#"
[[effect]]
class = "coulomb_friction"
channel = "x"
magnitude = 11
smoothing_velocity = 0.02
[[effect]]
class = "hysteresis"
channel = "x"
stiffness = 900
beta = 40
gamma = 15
[[effect]]
class = "added_inertia"
channel = "x"
inertia = 0.3
[[effect]]
class = "coupling_stiffness"
channel = "y"
other = "x"
stiffness = 70
"#;

fn measured(model: &Model) -> Vec<Measured> {
    model.measurements.iter().map(|m| m.of).collect()
}

/// Input, position, velocity, acceleration.
const ROW: [f64; 4] = [4.0, 0.03, -0.21, 5.0];

#[test]
fn the_force_on_an_imposed_coordinate_is_what_its_equation_lacks() {
    let model = read(&format!("{RIG}{EFFECTS}"));
    let system = System::new(&model);
    assert_eq!((model.input_width(), system.inputs()), (4, 4));
    // The state's own entries of x do not count: its motion is that of the inputs.
    let (y, dy, z) = (0.012, 0.4, 0.007);
    let mut state = [9.0, y, 9.0, dy, z];
    let mut rates = [0.0; 5];
    system.derivative(0.0, &state, &ROW, &mut rates);

    let [u, x, dx, ddx] = ROW;
    let spring = 570.0 * (x - y);
    let ddy = (spring - 0.1 * 30.0 * dy - 0.2 * 0.7 * ddx) / 0.7;
    let friction = 11.0 * f64::tanh(dx / 0.02);
    let force = (2.0 + 0.3) * ddx + 0.2 * 0.7 * ddy - u + 30.0 * dx + spring + friction + 900.0 * z;
    let slip = dx - 40.0 * dx.abs() * z - 15.0 * dx * z.abs();
    for (found, expected) in rates.iter().zip([dx, dy, ddx, ddy, slip]) {
        assert!((found - expected).abs() < 1e-11 * (1.0 + expected.abs()), "{rates:?}");
    }
    system.impose(&ROW, &mut state);
    assert_eq!(state, [x, y, dx, dy, z]);
    let mut out = [0.0; 2];
    Observation::of(&model, &measured(&model)).evaluate(&system, 0.0, &state, &ROW, &mut out);
    assert!((out[0] - force).abs() < 1e-10, "{out:?} {force}");
    assert!((out[1] - (3.0 - 2.0 * force + y)).abs() < 1e-10, "{out:?} {force}");
}

/// A coordinate that is imposed needs no inertia; one that is free does.
#[test]
fn what_is_imposed_may_be_without_mass() {
    let light = RIG.replace(r#"[["m", "0.2*M"], ["0.2*M", "M"]]"#, r#"[["0", "0"], ["0", "M"]]"#);
    assert!(System::new(&read(&light)).mass_determinant(&[0.0; 4], &[]) > 0.0);
    let said = error(&light.replace("imposed = true\n", "").replace("force on x", "x"));
    assert!(said.contains("singular"), "{said}");
}

#[test]
fn derivatives_of_the_force_agree_with_differences() {
    let model = read(&format!("{RIG}{EFFECTS}"));
    let observation = Observation::of(&model, &measured(&model));
    let state = [ROW[1], 0.012, ROW[2], 0.4, 0.007];
    let force = |parameters: &[f64], effects: &[ModelEffect], state: &[f64]| {
        let system = System::with(&model, parameters, effects);
        let mut out = [0.0; 2];
        observation.evaluate(&system, 0.0, state, &ROW, &mut out);
        out
    };
    let values = model.values();
    let parameters = (0..values.len()).map(Direction::Parameter);
    let effects = (0..4)
        .flat_map(|e| (0..model.effects[e].internal().len()).map(move |j| Direction::Effect(e, j)));
    let forces = (0..2).map(Direction::Force);
    for direction in parameters.chain(effects).chain(forces) {
        let system = System::along(&model, &values, &model.effects, &[(direction, 3)], 0.0);
        let constants = |x: &[f64]| x.iter().map(|&x| Dual::constant(x)).collect::<Vec<_>>();
        let mut out = [Dual::constant(0.0); 2];
        observation.evaluate(&system, 0.0, &constants(&state), &constants(&ROW), &mut out);
        let moved = |by: f64| match direction {
            Direction::Parameter(k) => {
                let mut p = values.clone();
                p[k] += by;
                force(&p, &model.effects, &state)
            }
            Direction::Effect(e, j) => {
                let mut effects = model.effects.clone();
                let mut internal = effects[e].internal();
                internal[j] += by;
                effects[e].set_internal(&internal);
                force(&values, &effects, &state)
            }
            Direction::Force(c) => {
                // On x a force takes its own part off what must be applied; on y its share of
                // the inertia does.
                let on_x = [-1.0, 0.2][c] * by;
                let here = force(&values, &model.effects, &state);
                [here[0] + on_x, here[1] - 2.0 * on_x]
            }
            Direction::Input(_) => unreachable!("an observation is given its inputs"),
        };
        let step = 1e-6;
        let (there, back) = (moved(step), moved(-step));
        for (out, (there, back)) in out.iter().zip(there.iter().zip(back)) {
            let difference = (there - back) / (2.0 * step);
            let off = (out.tangent[3] - difference).abs();
            assert!(off < 1e-5 * (1.0 + difference.abs()), "{direction:?}: {out:?} {difference}");
        }
    }
    // By the state, memory among it.
    for entry in [1, 3, 4] {
        let system = System::along(&model, &values, &model.effects, &[], 0.0);
        let seed = |(i, &x): (usize, &f64)| Dual::among(x, i, entry);
        let along: Vec<Dual> = state.iter().enumerate().map(seed).collect();
        let row: Vec<Dual> = ROW.iter().map(|&u| Dual::constant(u)).collect();
        let mut out = [Dual::constant(0.0); 2];
        observation.evaluate(&system, 0.0, &along, &row, &mut out);
        let moved = |by: f64| {
            let mut state = state;
            state[entry] += by;
            force(&values, &model.effects, &state)[0]
        };
        let difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
        assert!((out[0].tangent[0] - difference).abs() < 1e-5 * (1.0 + difference.abs()));
    }
}

#[test]
fn a_model_that_is_built_says_the_same() {
    let built = Model::builder("rod")
        .parameter("c", 30.0, "N s/m", 0.1)
        .coordinate("x", "dx", "m")
        .imposed()
        .mechanics(|_| [2.0], |at| [-at.parameters[0] * at.velocities[0]])
        .measurement("F", "force on x", "N")
        .build()
        .expect("the model is right");
    assert_eq!(measured(&built), [Measured::Force(0)]);
    let mut out = [0.0];
    let observation = Observation::of(&built, &measured(&built));
    observation.evaluate(&System::new(&built), 0.0, &[0.1, 0.5], &[0.1, 0.5, 3.0], &mut out);
    assert_eq!(out, [2.0 * 3.0 + 30.0 * 0.5]);
    let free = Model::builder("rod")
        .coordinate("x", "dx", "m")
        .rates(|_| [0.0])
        .measurement("F", "force on x", "N")
        .build();
    let said = free.expect_err("x is free").to_string();
    assert!(said.contains("'force on x'") && said.contains("x, dx"), "{said}");
}

#[test]
fn mistakes_are_told_with_their_place() {
    let table = [
        (
            ("of = \"force on x\"", "of = \"force on z\""),
            &["25:16", "'force on z'", "there are x"][..],
        ),
        (("- 2*force on x", "- 2*force on y"), &["29:22", "'force on y'", "there are x"]),
        (
            ("\"u - c*dx", "\"u - force on x"),
            &["mechanics", "in an expression", "'force on x'"][1..],
        ),
        (("of = \"force on x\"", "of = \"dx\""), &["25:6", "'dx'", "measurement of 'x'"]),
        (("imposed = true", "imposed = 3"), &["15:11", "bool"]),
    ];
    for ((from, to), parts) in table {
        let said = error(&RIG.replacen(from, to, 1));
        for part in parts {
            assert!(said.contains(part), "{to}: {said}");
        }
    }
    // Nothing that the model says is measured.
    let alone = "name = \"rod\"\n[[coordinate]]\nname = \"x\"\nvelocity = \"dx\"\nimposed = true\n\
                 [mechanics]\nmass = [[\"1\"]]\nforce = [\"-dx\"]\n";
    let said = error(alone);
    assert!(said.contains("5:11") && said.contains("force on"), "{said}");
    // The sensor of a motion that is taken as it is.
    let sensor = "[[effect]]\nclass = \"sensor_bias\"\nchannel = \"x\"\nbias = 0.1\n";
    let said = error(&format!("{RIG}{sensor}"));
    assert!(said.contains("sensor_bias") && said.contains("imposed"), "{said}");
}
