//! One machine given in every way in which dynamics can be given, and what is asked of each.

use lacuna_numbers::{Dual, LANES, Number};
use lacuna_plants::dynamics::{Dynamics, Exact, GenericSimulator, Mass, Point, Sizes};
use lacuna_plants::model::{
    Augmentation, BuildError, Builder, NameError, NewEffect, StepInput, Uncertainty,
    UncertaintyError,
};
use lacuna_plants::{Model, Substeps, System};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A motor on an elastic shaft with a hanging load, and the temperature of its winding.
const TEXT: &str = r#"
name = "shaft"
[parameters]
J1 = { value = 0.9, unit = "kg m^2", tolerance = 0.1 }
J2 = { value = 0.3, unit = "kg m^2" }
k = { value = 12, unit = "N m/rad", tolerance = 0.2 }
g = { value = 2.5, unit = "N m" }
c = { value = 0.4, unit = "degC/(A^2 s)" }
[[input]]
name = "i"
unit = "A"
[[coordinate]]
name = "a"
velocity = "da"
unit = "rad"
[[coordinate]]
name = "b"
velocity = "db"
unit = "rad"
[mechanics]
mass = [["J1 + J2*cos(b)*cos(b)", "0.1*cos(b)"], ["0.1*cos(b)", "J2"]]
force = ["2*i - 0.01*T*i - k*(a - b) - 0.3*da", "k*(a - b) - g*sin(b) - 0.2*db + 0.1*sin(3*t)"]
[[state]]
name = "T"
unit = "degC"
derivative = "c*i*i - 0.05*T"
"#;

fn forces(at: &Point<'_>) -> [f64; 3] {
    let [_, _, k, g, c] = *at.parameters else { panic!("five parameters") };
    let ([a, b], [da, db]) = (pair(at.coordinates), pair(at.velocities));
    let (temperature, current) = (at.states[0], at.inputs[0]);
    [
        2.0 * current - 0.01 * temperature * current - k * (a - b) - 0.3 * da,
        k * (a - b) - g * b.sin() - 0.2 * db + 0.1 * (3.0 * at.time).sin(),
        c * current * current - 0.05 * temperature,
    ]
}

fn masses(at: &Point<'_>) -> Vec<f64> {
    let cos = at.coordinates[1].cos();
    vec![at.parameters[0] + at.parameters[1] * cos * cos, 0.1 * cos, 0.1 * cos, at.parameters[1]]
}

/// The same as accelerations.
fn rates(at: &Point<'_>) -> [f64; 3] {
    let (m, [f, g, heat]) = (masses(at), forces(at));
    let determinant = m[0] * m[3] - m[1] * m[2];
    [(m[3] * f - m[1] * g) / determinant, (m[0] * g - m[2] * f) / determinant, heat]
}

fn pair(of: &[f64]) -> [f64; 2] {
    [of[0], of[1]]
}

fn described() -> Builder {
    Model::builder("shaft")
        .parameter("J1", 0.9, "kg m^2", 0.1)
        .parameter("J2", 0.3, "kg m^2", 0.0)
        .parameter("k", 12.0, "N m/rad", 0.2)
        .parameter("g", 2.5, "N m", 0.0)
        .parameter("c", 0.4, "degC/(A^2 s)", 0.0)
        .input("i", "A")
        .coordinate("a", "da", "rad")
        .coordinate("b", "db", "rad")
        .state("T", "degC")
}

fn text() -> Model {
    Model::from_text(TEXT, "shaft.toml").unwrap_or_else(|e| panic!("{e}"))
}

fn mechanics() -> Model {
    described().mechanics(masses, forces).build().expect("a model")
}

fn accelerations() -> Model {
    described().rates(rates).build().expect("a model")
}

/// The whole state after two seconds of a current.
fn rollout(model: &Model) -> Vec<f64> {
    let system = System::new(model);
    let mut x = system.at_rest(&[0.4, -0.3, 0.0, 0.7, 5.0]);
    let mut room = system.workspace();
    for k in 0..200 {
        let t = 0.01 * f64::from(k);
        let u = [3.0 * (4.0 * t).sin()];
        system.advance(
            &mut room,
            (t, t + 0.01),
            StepInput::Line(&u, &u),
            Substeps::even(2),
            &mut x,
        );
    }
    x
}

#[test]
fn closures_move_as_the_text_does() {
    let expected = rollout(&text());
    assert!(expected.iter().all(|x| x.abs() > 1e-3), "it moves: {expected:?}");
    for model in [mechanics(), accelerations()] {
        for (found, expected) in rollout(&model).iter().zip(&expected) {
            assert!(
                (found - expected).abs() < 1e-12 * (1.0 + expected.abs()),
                "{found} {expected}"
            );
        }
    }
}

#[test]
fn a_built_model_says_what_its_text_says() {
    let (text, built) = (text(), mechanics());
    assert_eq!(built.parameters, text.parameters);
    assert_eq!(built.inputs, text.inputs);
    assert_eq!(built.coordinates, text.coordinates);
    assert_eq!(built.states, text.states);
    assert_eq!((built.hold, &built.time_column), (text.hold, &text.time_column));
    for channel in 0..3 {
        assert_eq!(built.force_unit(channel), text.force_unit(channel));
    }
}

#[test]
fn without_a_mass_matrix_effects_are_accelerations() {
    let mut model = accelerations();
    assert_eq!(model.dynamics().mass(), Mass::Unit);
    assert_eq!(model.force_unit(0), "rad/s^2");
    assert_eq!(model.force_unit(2), "degC/s");
    let friction = lacuna_effects::find("viscous_friction").expect("in the catalogue");
    assert_eq!(model.effect_units(friction, 1, None), ["1/s"]);
    let rates_of = |model: &Model| {
        let system = System::new(model);
        let (mut rates, state) = ([0.0; 5], [0.1, 0.2, 0.5, -0.4, 1.0]);
        lacuna_plants::Plant::derivative(&system, 0.0, &state, &[1.0], &mut rates);
        rates
    };
    let before = rates_of(&model);
    let added = model.with_text(
        "name = \"x\"\n[[effect]]\nclass = \"viscous_friction\"\nchannel = \"b\"\ncoefficient = 3\n",
        "x.toml",
    );
    model = added.expect("an effect");
    let after = rates_of(&model);
    let changes: Vec<f64> = after.iter().zip(before).map(|(a, b)| a - b).collect();
    // -3 db on b alone: no inertia couples it to a.
    assert!((changes[3] - 1.2).abs() < 1e-12, "{changes:?}");
    assert!(changes[2].abs() < 1e-12, "{changes:?}");
}

/// The Jacobian of the rates, row by row, by variables and then by parameters, and the rates.
fn jacobian(model: &Model, variables: &[f64]) -> (Vec<Vec<f64>>, Vec<f64>) {
    let (values, dynamics) = (model.values(), model.dynamics());
    let entries = variables.len() + values.len();
    let width = dynamics.sizes().rates();
    let (mut rows, mut here) = (vec![vec![0.0; entries]; width], vec![]);
    for first in (0..entries).step_by(LANES) {
        let seed = |entry: usize, x: f64| match entry.checked_sub(first) {
            Some(lane) if lane < LANES => Dual::direction(x, lane),
            _ => Dual::constant(x),
        };
        let at: Vec<Dual> = variables.iter().enumerate().map(|(i, &x)| seed(i, x)).collect();
        let p: Vec<Dual> =
            values.iter().enumerate().map(|(i, &p)| seed(variables.len() + i, p)).collect();
        let bound = dynamics.bind_dual(&p);
        let mut out = vec![Dual::constant(0.0); width];
        bound.evaluate(&mut bound.room(), &at, &mut out);
        for (row, x) in rows.iter_mut().zip(&out) {
            let last = (first + LANES).min(entries);
            row[first..last].copy_from_slice(&x.tangent[..last - first]);
        }
        here = out.iter().map(|x| x.value).collect();
    }
    (rows, here)
}

/// Points of the shaft: q, v, x, u, t.
fn points() -> impl Iterator<Item = Vec<f64>> {
    (0..40).map(|k| {
        let s = |j: i32| (1.7 * f64::from(k * 5 + j)).sin();
        vec![
            2.0 * s(0),
            1.5 * s(1),
            3.0 * s(2),
            2.0 * s(3),
            20.0 * s(4),
            4.0 * s(5),
            0.1 * f64::from(k),
        ]
    })
}

#[test]
fn differences_are_as_right_as_they_say() {
    let (text, closure) = (text(), mechanics());
    let mut largest = 0.0f64;
    for variables in points() {
        let (exact, _) = jacobian(&text, &variables);
        let (found, rates) = jacobian(&closure, &variables);
        let stated = closure.dynamics().derivative_error().expect("they are differences");
        // By time nothing is differentiated: it carries no derivative in a simulation.
        let entries = (0..variables.len() - 1).chain(variables.len()..exact[0].len());
        for i in entries {
            let x = variables.get(i).copied().unwrap_or_else(|| text.values()[i - variables.len()]);
            for (j, rate) in rates.iter().enumerate() {
                let scale = 1.001 * found[j][i].abs() + 1.001 * rate.abs() / x.abs();
                let error = (found[j][i] - exact[j][i]).abs();
                assert!(
                    error <= stated * scale,
                    "rate {j} by {i}: {error} beside {}",
                    stated * scale
                );
                if scale > 0.0 {
                    largest = largest.max(error / scale);
                }
            }
        }
        assert!(stated < 1e-6, "{stated}");
    }
    // What is stated is no wild guess either.
    assert!(largest > 0.0);
    assert_eq!(text.dynamics().derivative_error(), None);
}

/// A pendulum whose forces a solver finds to so much.
fn solved_to(tolerance: f64, calls: &Arc<AtomicUsize>) -> Model {
    let calls = calls.clone();
    let solved =
        move |x: f64| if tolerance > 0.0 { (x / tolerance).round() * tolerance } else { x };
    Model::builder("pendulum")
        .parameter("g", 9.81, "m/s^2", 0.1)
        .coordinate("q", "v", "rad")
        .rates(move |at| {
            calls.fetch_add(1, Ordering::Relaxed);
            [solved(-at.parameters[0] * at.coordinates[0].sin() - 0.1 * at.velocities[0])]
        })
        .build()
        .expect("a model")
}

/// Largest share of error of its derivatives by q, v and g along a motion, whose points all are evaluated in
/// one room, and how often its function was called.
fn along_a_motion(tolerance: f64) -> (f64, f64, usize) {
    const POINTS: u32 = 400;
    let calls = Arc::default();
    let model = solved_to(tolerance, &calls);
    let bound = model.dynamics().bind_along(&[9.81], 0);
    let (mut room, mut worst) = (bound.room(), 0.0f64);
    for k in 0..POINTS {
        let at = 0.01 * f64::from(k);
        let (q, v) = (2.5 * (3.0 * at).cos(), 7.5 * (3.0 * at).sin());
        let variables = [Dual::among(q, 1, 0), Dual::among(v, 2, 0), Dual::constant(at)];
        let mut rates = [Dual::constant(0.0); 2];
        bound.evaluate(&mut room, &variables, &mut rates);
        let force = rates[1];
        for (found, exact, x) in [
            (force.tangent[0], -q.sin(), 9.81),
            (force.tangent[1], -9.81 * q.cos(), 2.5),
            (force.tangent[2], -0.1, 7.5),
        ] {
            worst = worst.max((found - exact).abs() / (exact.abs() + force.value.abs() / x));
        }
    }
    let stated = model.dynamics().derivative_error().expect("they are differences");
    (worst, stated, calls.load(Ordering::Relaxed) / POINTS as usize)
}

#[test]
fn along_a_motion_a_derivative_costs_one_evaluation_where_that_is_good_enough() {
    let (worst, stated, calls) = along_a_motion(0.0);
    // It is not measured at the worst point of all.
    assert!(worst > 1e-12 && worst <= 3.0 * stated && stated < 1e-6, "{worst:e} {stated:e}");
    // The point itself and one a derivative; six a derivative where they are measured.
    assert_eq!(calls, 4);
    // What a solver leaves of a step so small is measured, and larger ones are taken.
    for tolerance in [1e-8, 1e-9, 1e-10] {
        let (worst, stated, calls) = along_a_motion(tolerance);
        assert!(worst < 1e4 * tolerance && stated < 1e4 * tolerance, "{worst:e} {stated:e}");
        assert!(calls >= 16, "{calls}");
    }
}

#[test]
fn steps_shrink_where_laws_are_sharp() {
    // A speed of 1 um/s beside a law that turns within 10 um/s, from rest: nothing says so.
    let model = Model::builder("sharp")
        .coordinate("x", "v", "m")
        .rates(|at| [-(at.velocities[0] / 1e-5).tanh()])
        .build()
        .expect("a model");
    for v in [0.0, 1e-6, -3e-6] {
        let (rows, _) = jacobian(&model, &[0.0, v, 0.0]);
        let exact = -(1.0 - (v / 1e-5).tanh().powi(2)) / 1e-5;
        let stated = model.dynamics().derivative_error().expect("differences");
        assert!(
            (rows[1][1] - exact).abs() <= stated * 1.001 * exact.abs().max(1e5),
            "{v}: {rows:?}"
        );
    }
    // A law that no step resolves is told, not hidden.
    let jump = Model::builder("jump")
        .coordinate("x", "v", "m")
        .rates(|at| [if at.velocities[0] > 0.0 { -1.0 } else { 1.0 }])
        .build()
        .expect("a model");
    jacobian(&jump, &[0.0, 0.0, 0.0]);
    assert!(jump.dynamics().derivative_error().expect("differences") > 0.1);
    // Where nothing is defined on one side, the error is infinite.
    let edge = Model::builder("edge")
        .state("h", "m")
        .rates(|at| [-at.states[0].sqrt()])
        .build()
        .expect("a model");
    jacobian(&edge, &[0.0, 0.0]);
    assert_eq!(edge.dynamics().derivative_error(), Some(f64::INFINITY));
}

#[derive(Debug)]
struct Cart;

impl GenericSimulator for Cart {
    fn evaluate<T: Number>(&self, at: &Point<'_, T>, mass: &mut [T], force: &mut [T]) {
        mass[0] = at.parameters[0];
        force[0] = at.inputs[0] - at.parameters[1] * at.velocities[0] * at.velocities[0];
    }
}

#[test]
fn what_computes_in_any_number_has_exact_derivatives() {
    let cart = Model::builder("cart")
        .parameter("m", 2.0, "kg", 0.1)
        .parameter("c", 0.5, "kg/m", 0.1)
        .input("f", "N")
        .coordinate("x", "v", "m")
        .exact(Cart)
        .build()
        .expect("a model");
    let (rows, rates) = jacobian(&cart, &[0.1, 3.0, 7.0, 0.0]);
    assert_eq!(rates, [2.0, 7.0 - 0.5 * 9.0]);
    // By x, v, f, t, m, c.
    assert_eq!(rows[0], [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    assert_eq!(rows[1], [0.0, -2.0 * 0.5 * 3.0, 1.0, 0.0, 0.0, -9.0]);
    assert_eq!(cart.dynamics().derivative_error(), None);
    assert_eq!(cart.force_unit(0), "N");
}

#[test]
fn a_simulation_along_closures_carries_the_derivatives_of_the_text() {
    use lacuna_plants::model::Direction;
    let after = |model: &Model| {
        let directions =
            [(Direction::Parameter(2), 0), (Direction::Force(1), 1), (Direction::Force(2), 2)];
        let system = System::along(model, &model.values(), &[], &directions, 0.01);
        let mut x: Vec<Dual> = [0.4, -0.3, 0.0, 0.7, 5.0].map(Dual::constant).to_vec();
        x[3] = Dual::direction(0.7, 3);
        let mut room = system.workspace();
        for k in 0..100 {
            let t = 0.01 * f64::from(k);
            let u = [Dual::constant(3.0 * (4.0 * t).sin())];
            system.advance(
                &mut room,
                (t, t + 0.01),
                StepInput::Line(&u, &u),
                Substeps::even(1),
                &mut x,
            );
        }
        x
    };
    for (found, exact) in after(&mechanics()).iter().zip(after(&text())) {
        for lane in [0, 1, 2, 3] {
            let (found, exact) = (found.tangent[lane], exact.tangent[lane]);
            assert!((found - exact).abs() < 1e-9 * (1.0 + exact.abs()), "{found} {exact}");
        }
    }
}

#[test]
fn mistakes_of_builders_are_typed() {
    let rest = |_: &Point<'_>| [0.0];
    let error = |builder: Builder| builder.build().expect_err("a mistake");
    let cart = || Model::builder("cart").coordinate("x", "v", "m");
    let twice = |name: &str| BuildError::Name(NameError::Twice { name: name.into() });
    assert_eq!(error(cart().state("v", "m").rates(rest)), twice("v"));
    assert_eq!(error(cart().parameter("x", 1.0, "", 0.0).rates(rest)), twice("x"));
    assert_eq!(error(cart().input("pi", "V").rates(rest)), BuildError::Name(NameError::Number));
    let characters = NameError::Characters { name: "a b".into() };
    assert_eq!(error(cart().input("a b", "V").rates(rest)), BuildError::Name(characters));
    // A parameter may be that of a part, and no more.
    assert!(cart().parameter("x.damping", 1.0, "N s/m", 0.0).rates(rest).build().is_ok());
    let characters = NameError::Characters { name: "x.a.b".into() };
    let two = cart().parameter("x.a.b", 1.0, "", 0.0).rates(rest);
    assert_eq!(error(two), BuildError::Name(characters));
    assert_eq!(error(cart()), BuildError::NoDynamics { model: "cart".into() });
    let nothing = BuildError::NothingMoves { model: "still".into() };
    assert_eq!(error(Model::builder("still").rates(rest)), nothing);
    let length = |what, expected, found| BuildError::Length { what, expected, found };
    assert_eq!(error(cart().state("h", "m").rates(rest)), length("rates", 2, 1));
    assert_eq!(
        error(cart().mechanics(|_| [1.0; 4], rest)),
        length("entries of the mass matrix", 1, 4)
    );
    assert_eq!(error(cart().mechanics(|_| [0.0], rest)), BuildError::SingularMass);
    let value = error(cart().parameter("m", f64::NAN, "kg", 0.0).rates(rest));
    assert!(matches!(value, BuildError::Value { name, .. } if name == "m"));
    let tolerance = BuildError::from(UncertaintyError::Tolerance { name: "m".into(), found: -0.1 });
    assert_eq!(error(cart().parameter("m", 1.0, "kg", -0.1).rates(rest)), tolerance);
    let std = BuildError::from(UncertaintyError::Std { name: "m".into(), found: f64::INFINITY });
    let endless = cart().parameter_with_std("m", 1.0, "kg", f64::INFINITY);
    assert_eq!(error(endless.rates(rest)), std);
    let noise = BuildError::InputNoise { name: "u".into(), found: -1.0 };
    assert_eq!(error(cart().input("u", "N").input_noise(-1.0).rates(rest)), noise);
    let nothing = BuildError::from(UncertaintyError::OfZero { name: "load".into(), found: 0.2 });
    assert_eq!(error(cart().parameter("load", 0.0, "kg", 0.2).rates(rest)), nothing);
    let measured = error(cart().measurement("enc", "y", "mm").rates(rest));
    let known = vec!["x".to_owned(), "v".to_owned()];
    assert_eq!(measured, BuildError::Measured { column: "enc".into(), of: "y".into(), known });
    let found = Sizes { coordinates: 2, ..Sizes::default() };
    let expected = Sizes { coordinates: 1, ..Sizes::default() };
    let other: Arc<dyn Dynamics> = Arc::new(Exact::new(Cart, found));
    assert_eq!(error(cart().dynamics(other)), BuildError::Sizes { expected, found });
}

#[test]
fn a_closure_of_changing_length_diverges() {
    let model = Model::builder("odd")
        .coordinate("x", "v", "m")
        .rates(|at| vec![0.0; if at.time > 0.5 { 2 } else { 1 }])
        .build()
        .expect("right at rest");
    let system = System::new(&model);
    let (mut x, mut room) = (vec![0.0, 1.0], system.workspace());
    system.advance(&mut room, (0.0, 0.1), StepInput::Line(&[], &[]), Substeps::even(1), &mut x);
    assert!((x[0] - 0.1).abs() < 1e-15);
    system.advance(&mut room, (1.0, 1.1), StepInput::Line(&[], &[]), Substeps::even(1), &mut x);
    assert!(x[1].is_nan());
}

#[test]
fn what_is_found_of_a_closure_is_written_and_read_again() {
    let model = mechanics();
    let effect = lacuna_effects::find("coulomb_friction").expect("in the catalogue");
    let parameters = vec![(0.25, Some(0.01), "N m".to_owned()), (0.002, None, "rad/s".to_owned())];
    let new = NewEffect { effect, channel: "b".into(), other: None, parameters };
    let augmentation =
        Augmentation { parameters: vec![("k".into(), 11.5, 0.05)], effects: vec![new] };
    let text = model.augmented_text(&augmentation).expect("written");
    assert!(text.starts_with("# The equations of 'shaft' are code"), "{text}");
    let again = model.with_text(&text, "augmented.toml").expect("read");
    assert_eq!(again.values(), [0.9, 0.3, 11.5, 2.5, 0.4]);
    assert_eq!(again.parameters[2].uncertainty, Uncertainty::Relative(0.2));
    let found = &again.effects[0];
    assert_eq!((found.effect.class, found.channel), ("coulomb_friction", 1));
    assert_eq!((&*found.parameters, &*found.std), (&[0.25, 0.002][..], &[Some(0.01), None][..]));
    // Once more: what it has stays, and nothing is added.
    let twice = again.augmented_text(&Augmentation::default()).expect("written");
    let twice = model.with_text(&twice, "twice.toml").expect("read");
    assert_eq!((twice.effects.len(), twice.values()), (1, again.values()));
    // It moves with its friction, and as its text moves with the same.
    let by_text = self::text().with_text(&text, "augmented.toml").expect("read");
    for (found, expected) in rollout(&again).iter().zip(rollout(&by_text)) {
        assert!((found - expected).abs() < 1e-11 * (1.0 + expected.abs()));
    }
    assert!((rollout(&again)[1] - rollout(&model)[1]).abs() > 1e-3);
    // Alone the text is no model.
    let alone = Model::from_text(&text, "augmented.toml").expect_err("no equations");
    assert!(alone.to_string().contains("nothing moves"), "{alone}");
    let stranger = model.with_text("name = \"x\"\n[parameters]\nz = { value = 1 }\n", "x.toml");
    let said = stranger.expect_err("no such parameter").to_string();
    assert!(said.starts_with("x.toml:3:1: 'shaft' has no parameter 'z'"), "{said}");
}

#[test]
fn how_sure_a_model_was_stays_when_its_values_are_calibrated() {
    let model = Model::builder("lift")
        .parameter_with_std("load", 0.0, "kg", 0.5)
        .parameter("k", 2.0, "N/m", 0.25)
        .coordinate("z", "vz", "m")
        .rates(|at| [-at.parameters[1] * at.coordinates[0] / (3.0 + at.parameters[0])])
        .build()
        .expect("right");
    let parameters = vec![("load".into(), 0.8, 0.02), ("k".into(), 0.0, 0.1)];
    let text = model.augmented_text(&Augmentation { parameters, effects: vec![] });
    let text = text.expect("written");
    let again = model.with_text(&text, "augmented.toml").expect("read");
    assert_eq!(again.values(), [0.8, 0.0], "{text}");
    // Relative to 0 nothing could be said.
    let expected = [0.5, 0.5].map(Uncertainty::Absolute);
    assert_eq!([0, 1].map(|k| again.parameters[k].uncertainty), expected, "{text}");
    assert_eq!([0, 1].map(|k| again.parameters[k].std()), [0.5, 0.5]);
    assert!(text.contains("calibrated_std = 0.02"), "{text}");
}

#[test]
fn a_text_is_augmented_as_it_was_read() {
    let folder = std::env::temp_dir().join(format!("lacuna-reread-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join("shaft.toml");
    std::fs::write(&path, TEXT).expect("written");
    let model = Model::read(&path).expect("read");
    std::fs::write(&path, "edited meanwhile").expect("written");
    let augmentation = Augmentation { parameters: vec![("k".into(), 11.5, 0.05)], effects: vec![] };
    let text = model.augmented_text(&augmentation).expect("written");
    std::fs::remove_dir_all(&folder).expect("removed");
    assert_eq!(
        text,
        TEXT.replace("value = 12,", "value = 11.5,")
            .replace("tolerance = 0.2 }", "tolerance = 0.2 , calibrated_std = 0.05 }")
    );
}
