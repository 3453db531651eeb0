//! Side by side with MuJoCo: drawn files that say things in every way, and robots that others made where
//! they are at hand.

mod support;

use lacuna_rigid::mjcf;
use std::path::Path;
use support::mass_and_bias;
use support::mjcf::drawn_mjcf;
use support::oracle::{difference, published, python};

fn from_mujoco(python: &str, file: &Path, seed: u64) -> f64 {
    let text = std::fs::read_to_string(file).expect("a file");
    let robot = mjcf::read(&text).unwrap_or_else(|e| panic!("{}: {e}\n{text}", file.display()));
    let tree = robot.tree(&[]).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let n = tree.coordinates();
    difference((python, "mujoco_dynamics.py"), (file, &tree), seed, |state| {
        let (mut mass, bias) = mass_and_bias(&tree, state, robot.gravity.expect("MJCF says it"));
        let joints = tree.joints();
        joints.clone().enumerate().for_each(|(i, joint)| mass[i * n + i] += joint.armature);
        let passive = joints.zip(state).zip(&state[n..]).map(|((joint, q), v)| {
            -joint.stiffness * (q - joint.spring_reference) - joint.damping * v
        });
        vec![mass, bias, passive.collect()]
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
