//! Side by side with MuJoCo: drawn files that say things in every way, and robots that others made where
//! they are at hand.

mod support;

use lacuna_rigid::mjcf;
use nalgebra::{DMatrix, DVector};
use std::path::Path;
use support::mass_and_bias;
use support::mjcf::{drawn_every_joint, drawn_mjcf};
use support::oracle::{difference, published, python};

fn from_mujoco(python: &str, file: &Path, seed: u64) -> f64 {
    let text = std::fs::read_to_string(file).expect("a file");
    let robot = mjcf::read(&text).unwrap_or_else(|e| panic!("{}: {e}\n{text}", file.display()));
    let tree = robot.tree(&[]).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let n = tree.coordinates();
    difference((python, "mujoco_dynamics.py"), (file, &tree), seed, |state| {
        let (mut mass, bias) = mass_and_bias(&tree, state, robot.gravity.expect("MJCF says it"));
        let (mut passive, (q, v)) = (vec![0.0; n], state.split_at(n));
        for joint in tree.bodies.iter().map(|body| &body.joint) {
            let c = joint.coordinate;
            mass[c * n + c] += joint.felt(joint.felt(joint.armature));
            let stretched = joint.at(q) - joint.spring_reference;
            let force = -joint.stiffness * stretched - joint.damping * joint.rate(v);
            passive[c] += joint.felt(force);
        }
        let moving = DVector::from_vec(passive.clone()) - DVector::from_vec(bias.clone());
        let factor = DMatrix::from_row_slice(n, n, &mass).cholesky().expect("it has mass");
        let accelerations = factor.solve(&moving).as_slice().to_vec();
        vec![mass, bias, passive, accelerations]
    })
}

#[test]
fn drawn_trees_move_as_mujoco_says() {
    let Some(python) = python("mujoco", "mujoco") else { return };
    let folder = tempfile::tempdir().expect("a folder");
    for seed in 0..16 {
        let file = folder.path().join("robot.xml");
        let bodies = 2 + seed as usize;
        std::fs::write(&file, drawn_mjcf(bodies, seed)).expect("a file");
        let worst = from_mujoco(&python, &file, seed);
        assert!(worst < 1e-9, "{bodies} bodies, seed {seed}: {worst:e}");
    }
}

#[test]
fn published_robots_move_as_mujoco_says() {
    let Some(python) = python("mujoco", "mujoco") else { return };
    for file in published("robot.xml") {
        let worst = from_mujoco(&python, &file, 11);
        assert!(worst < 1e-9, "{}: {worst:e}", file.display());
    }
}

/// Free bodies, balls, hinges and slides, and hinges and slides that an `<equality>` has follow others.
#[test]
fn drawn_trees_of_every_joint_move_as_mujoco_says() {
    let Some(python) = python("mujoco", "mujoco") else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let (mut several, mut following) = (0, 0);
    for seed in 0..10 {
        let file = folder.path().join("robot.xml");
        let (bodies, text) = (3 + seed as usize, drawn_every_joint(3 + seed as usize, seed));
        several += text.matches("<freejoint").count() + text.matches("type=\"ball\"").count();
        following += text.matches("joint1=").count();
        std::fs::write(&file, text).expect("a file");
        let worst = from_mujoco(&python, &file, seed);
        assert!(worst < 1e-9, "{bodies} bodies, seed {seed}: {worst:e}");
    }
    assert!(several > 15 && following > 15, "{several}, {following}");
}
