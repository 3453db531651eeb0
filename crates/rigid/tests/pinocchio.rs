//! Side by side with Pinocchio: drawn trees, and what robots' makers publish where it is at hand.

mod support;

use lacuna_rigid::{GRAVITY, urdf};
use std::path::Path;
use support::every_joint::{drawn_every_joint, drawn_followers};
use support::oracle::{difference, published, python};
use support::{drawn_urdf, mass_and_bias};

/// All joints are free in Pinocchio's model; the script has those that follow do so.
const FREE: &str = "pinocchio_dynamics.py";
/// Pinocchio's own joints that follow.
const FOLLOWING: &str = "pinocchio_followers.py";

fn from_pinocchio((python, script): (&str, &str), file: &Path, seed: u64) -> f64 {
    let text = std::fs::read_to_string(file).expect("a file");
    let robot = urdf::read(&text).expect("a robot");
    let tree = robot.tree(&[]).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    difference((python, script), (file, &tree), seed, |state| {
        let (mass, bias) = mass_and_bias(&tree, state, GRAVITY);
        vec![mass, bias]
    })
}

/// Trees that are drawn with so many joints from a seed.
fn all_as_pinocchio_says(draw: fn(usize, u64) -> String, script: &str, drawn: &[(usize, u64)]) {
    let Some(python) = python("pinocchio", "pin") else { return };
    let folder = tempfile::tempdir().expect("a folder");
    for &(joints, seed) in drawn {
        let file = folder.path().join("robot.urdf");
        std::fs::write(&file, draw(joints, seed)).expect("a file");
        let worst = from_pinocchio((&python, script), &file, seed);
        assert!(worst < 1e-10, "{joints} joints, seed {seed}: {worst:e}");
    }
}

#[test]
fn drawn_trees_move_as_pinocchio_says() {
    let drawn = [(1, 1), (3, 2), (6, 3), (7, 4), (15, 5), (30, 6), (30, 7)];
    all_as_pinocchio_says(drawn_urdf, FREE, &drawn);
}

#[test]
fn published_robots_move_as_pinocchio_says() {
    let Some(python) = python("pinocchio", "pin") else { return };
    let mut files = published("robot.urdf");
    let other = "../../../shared/real/staubli_tx40/tx40.urdf";
    files.push(Path::new(env!("CARGO_MANIFEST_DIR")).join(other));
    for file in files.into_iter().filter(|f| f.is_file()) {
        let worst = from_pinocchio((&python, FREE), &file, 11);
        assert!(worst < 1e-10, "{}: {worst:e}", file.display());
    }
}

/// Every type of joint, joints that follow others among them, in trees of up to 30 joints.
#[test]
fn drawn_trees_of_every_joint_move_as_pinocchio_says() {
    let drawn = [(5, 1), (8, 2), (12, 3), (20, 4), (30, 5), (30, 6)];
    all_as_pinocchio_says(drawn_every_joint, FREE, &drawn);
}

#[test]
fn followers_move_as_those_of_pinocchio() {
    let drawn = [(4, 1), (8, 2), (12, 3), (20, 4), (30, 5)];
    all_as_pinocchio_says(drawn_followers, FOLLOWING, &drawn);
}
