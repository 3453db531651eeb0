//! An added inertia is part of the mass matrix: a machine with it moves as one of larger mass.

use lacuna_numbers::{Dual, Number};
use lacuna_plants::model::{Direction, StepInput};
use lacuna_plants::{Model, Plant, Substeps, System};

/// Two joints that pull at each other, and three, whose mass matrix is solved by elimination.
fn model(joints: usize, inertia: &str, added: &str) -> Model {
    let (mut text, names) = (String::from("name = \"chain\"\n[parameters]\n"), ["q1", "q2", "q3"]);
    text += &format!("m = {{ value = {inertia}, unit = \"kg m^2\", tolerance = 0.1 }}\n");
    text += "[[input]]\nname = \"tau\"\nunit = \"N m\"\n";
    for name in &names[..joints] {
        text +=
            &format!("[[coordinate]]\nname = \"{name}\"\nvelocity = \"d{name}\"\nunit = \"rad\"\n");
    }
    let rows: Vec<String> = (0..joints)
        .map(|i| {
            let entry = |j: usize| match (i, j) {
                (1, 1) => "\"m\"".to_owned(),
                _ if i == j => "\"1.5\"".to_owned(),
                _ => "\"0.2*cos(q2)\"".to_owned(),
            };
            format!("[{}]", (0..joints).map(entry).collect::<Vec<_>>().join(", "))
        })
        .collect();
    let force = |k: usize| format!("\"tau - 0.4*d{0} - {1}*{0} + dq2^2\"", names[k], k + 2);
    let forces: Vec<String> = (0..joints).map(force).collect();
    text +=
        &format!("[mechanics]\nmass = [{}]\nforce = [{}]\n", rows.join(", "), forces.join(", "));
    if !added.is_empty() {
        text += &format!(
            "[[effect]]\nclass = \"added_inertia\"\nchannel = \"q2\"\ninertia = {added}\n"
        );
    }
    Model::from_text(&text, "chain.toml").unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn it_moves_as_a_larger_mass_does() {
    for joints in [2, 3] {
        let (added, larger) = (model(joints, "0.7", "0.45"), model(joints, "1.15", ""));
        let state: Vec<f64> = (0..2 * joints).map(|k| 0.3 - 0.2 * k as f64).collect();
        let rates = [&added, &larger].map(|m| {
            let mut rate = vec![0.0; 2 * joints];
            System::new(m).derivative(0.0, &state, &[0.8], &mut rate);
            rate
        });
        for (a, b) in rates[0].iter().zip(&rates[1]) {
            assert!((a - b).abs() < 1e-14, "{rates:?}");
        }
        let ends = [&added, &larger].map(|m| {
            let (system, mut x) = (System::new(m), state.clone());
            let mut w = system.workspace();
            for k in 0..500 {
                let t = 0.01 * f64::from(k);
                let u = [(3.0 * t).sin()];
                system.advance(
                    &mut w,
                    (t, t + 0.01),
                    StepInput::Line(&u, &u),
                    Substeps::even(2),
                    &mut x,
                );
            }
            x
        });
        for (a, b) in ends[0].iter().zip(&ends[1]) {
            assert!((a - b).abs() < 1e-10, "{ends:?}");
        }
    }
}

/// Its derivative is that by the mass parameter it adds to.
#[test]
fn its_derivative_is_that_of_the_mass() {
    for joints in [2, 3] {
        let model = model(joints, "0.7", "0.45");
        let directions = [(Direction::Effect(0, 0), 1), (Direction::Parameter(0), 2)];
        let p = model.values();
        let system = System::along(&model, &p, &model.effects, &directions, 0.01);
        let mut w = system.workspace();
        let mut x: Vec<Dual> = (0..2 * joints).map(|k| Dual::constant(0.1 * k as f64)).collect();
        for k in 0..200 {
            let t = 0.01 * f64::from(k);
            let u = [Dual::constant((3.0 * t).sin())];
            system.advance(
                &mut w,
                (t, t + 0.01),
                StepInput::Line(&u, &u),
                Substeps::even(1),
                &mut x,
            );
        }
        for x in &x {
            assert!((x.tangent[1] - x.tangent[2]).abs() < 1e-12 * (1.0 + x.tangent[1].abs()));
        }
        assert!(x[1].tangent[1].abs() > 1e-3, "more inertia, another motion");
    }
}
