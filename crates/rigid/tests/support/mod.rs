//! Robots that are drawn.
#![allow(dead_code)]

pub mod every_joint;
pub mod mjcf;
pub mod oracle;

use lacuna_excitation::rng;
use lacuna_rigid::{Dynamics, Robot, RobotError, Room, Tree};
use rand::{Rng, RngExt};
use std::fmt::Write;

/// A tree of so many moving joints of every kind, with fixed ones between: links hang from any that is there.
pub fn drawn_urdf(joints: usize, seed: u64) -> String {
    let mut rng = rng(seed, 0);
    let mut text = String::from("<robot name=\"drawn\">\n");
    let total = joints + joints / 2;
    for link in 0..=total {
        writeln!(text, "{}", drawn_link(link, &mut rng)).expect("text");
    }
    for k in 0..total {
        let fixed = k % 3 == 2;
        let kind = match (fixed, k % 4) {
            (true, _) => "fixed",
            (_, 0) => "revolute",
            (_, 1) => "continuous",
            _ => "prismatic",
        };
        let parent = if k < 2 { k } else { rng.random_range(k / 2..=k) };
        let mut number = || rng.random_range(-1.0..1.0);
        let (place, turn) = ([number(), number(), number()], [number(), number(), number()]);
        let axis = [number(), number(), number()];
        writeln!(
            text,
            "<joint name=\"j{k}\" type=\"{kind}\"><parent link=\"l{parent}\"/><child link=\"l{}\"/>\
             <origin xyz=\"{}\" rpy=\"{}\"/><axis xyz=\"{}\"/>\
             <limit lower=\"-9\" upper=\"9\" effort=\"9\" velocity=\"9\"/></joint>",
            k + 1,
            spaced(&place),
            spaced(&turn),
            spaced(&axis)
        )
        .expect("text");
    }
    text + "</robot>\n"
}

pub fn drawn_link(link: usize, rng: &mut impl Rng) -> String {
    let mut number = |from: f64, to: f64| rng.random_range(from..to);
    let (place, turn) = (
        [number(-0.3, 0.3), number(-0.3, 0.3), number(-0.3, 0.3)],
        [number(-3.0, 3.0), number(-3.0, 3.0), number(-3.0, 3.0)],
    );
    let (x, y, z) = (number(0.01, 0.1), number(0.01, 0.1), number(0.01, 0.1));
    format!(
        "<link name=\"l{link}\"><inertial><origin xyz=\"{}\" rpy=\"{}\"/><mass value=\"{}\"/>\
         <inertia ixx=\"{}\" ixy=\"0.001\" ixz=\"-0.002\" iyy=\"{}\" iyz=\"0.0015\" izz=\"{}\"/>\
         </inertial></link>",
        spaced(&place),
        spaced(&turn),
        number(0.2, 5.0),
        y + z,
        x + z,
        x + y
    )
}

pub fn spaced(numbers: &[f64]) -> String {
    let all: Vec<String> = numbers.iter().map(f64::to_string).collect();
    all.join(" ")
}

/// Coordinates, then velocities.
pub fn drawn_states(n: usize, count: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut rng = rng(seed, 1);
    let mut state = || (0..2 * n).map(|_| rng.random_range(-3.0..3.0)).collect();
    (0..count).map(|_| state()).collect()
}

/// A text in which something is replaced, the line of what is wrong then, and words that are said of it.
pub type Wrong<'a> = (&'a str, &'a str, u32, &'a [&'a str]);

pub fn assert_refused(read: fn(&str) -> Result<Robot, RobotError>, text: &str, cases: &[Wrong]) {
    for (from, to, line, words) in cases {
        assert!(text.contains(from), "{from}");
        let RobotError { line: found, message } = read(&text.replace(from, to)).expect_err(to);
        assert_eq!(found, Some(*line), "{from} -> {to}: {message}");
        for word in *words {
            assert!(message.contains(word), "{from} -> {to}: {message}");
        }
    }
}

/// M and h of a tree whose bodies are as its file says.
pub fn mass_and_bias(tree: &Tree, state: &[f64], gravity: [f64; 3]) -> (Vec<f64>, Vec<f64>) {
    let n = tree.coordinates();
    let (inertia, (q, v)) = (tree.inertia(), state.split_at(n));
    let dynamics = Dynamics::new(tree, &inertia, gravity);
    let room = Room::new(tree.bodies.len());
    let (mut room, mut mass, mut bias) = (room, vec![0.0; n * n], vec![0.0; n]);
    dynamics.place(&mut room, q);
    dynamics.mass_matrix(&mut room, &mut mass);
    dynamics.inverse(&mut room, (v, &vec![0.0; n]), &mut bias);
    (mass, bias)
}
