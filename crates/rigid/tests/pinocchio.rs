//! Side by side with Pinocchio: drawn trees, and what robots' makers publish where it is at hand.

mod support;

use lacuna_rigid::urdf;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use support::{drawn_states, drawn_urdf, mass_and_bias};

/// The Python that knows of Pinocchio; none where there is none, which is said.
fn python() -> Option<String> {
    let python = std::env::var("LACUNA_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let knows = Command::new(&python).args(["-c", "import pinocchio"]).output();
    if knows.is_ok_and(|o| o.status.success()) {
        return Some(python);
    }
    eprintln!("skipped: {python} does not know pinocchio (pip install pin; LACUNA_PYTHON=...)");
    None
}

/// Greatest difference from Pinocchio, as a share of the largest entry of the same kind.
fn difference(python: &str, file: &Path, seed: u64) -> f64 {
    let text = std::fs::read_to_string(file).expect("a file");
    let robot = urdf::read(&text).expect("a robot");
    let tree = robot.tree(&[]).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let n = tree.bodies.len();
    let states = drawn_states(n, 20, seed);
    let names: Vec<&str> = tree.bodies.iter().map(|b| b.joint.name.as_str()).collect();
    let mut asked = names.join(" ");
    for state in &states {
        let line: Vec<String> = state.iter().map(|x| format!("{x:e}")).collect();
        asked += &format!("\n{}", line.join(" "));
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/oracle/pinocchio_dynamics.py");
    let mut child = Command::new(python)
        .arg(script)
        .arg(file)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("python starts");
    child.stdin.take().expect("a pipe").write_all(asked.as_bytes()).expect("it listens");
    let said = child.wait_with_output().expect("it answers");
    assert!(said.status.success(), "{}", file.display());
    let said = String::from_utf8(said.stdout).expect("text");
    let mut worst = 0.0f64;
    let mut lines = 0;
    for (state, line) in states.iter().zip(said.lines()) {
        let oracle: Vec<f64> = line.split(' ').map(|x| x.parse().expect("a number")).collect();
        let (mass, bias) = mass_and_bias(&tree, state, [0.0, 0.0, -9.81]);
        let ours = [mass, bias];
        for (ours, theirs) in ours.iter().zip([&oracle[..n * n], &oracle[n * n..]]) {
            let size = theirs.iter().fold(0.0f64, |a, x| a.max(x.abs()));
            for (a, b) in ours.iter().zip(theirs) {
                worst = worst.max((a - b).abs() / size);
            }
        }
        lines += 1;
    }
    assert_eq!(lines, states.len());
    worst
}

#[test]
fn drawn_trees_move_as_pinocchio_says() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    for (joints, seed) in [(1, 1), (3, 2), (6, 3), (7, 4), (15, 5), (30, 6), (30, 7)] {
        let file = folder.path().join("robot.urdf");
        std::fs::write(&file, drawn_urdf(joints, seed)).expect("a file");
        let worst = difference(&python, &file, seed);
        assert!(worst < 1e-10, "{joints} joints, seed {seed}: {worst:e}");
    }
}

#[test]
fn published_robots_move_as_pinocchio_says() {
    let Some(python) = python() else { return };
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    let cases = std::fs::read_dir(shared.join("blind_robots/cases")).into_iter().flatten();
    let mut files: Vec<PathBuf> =
        cases.filter_map(|c| Some(c.ok()?.path().join("robot.urdf"))).collect();
    files.push(shared.join("real/staubli_tx40/tx40.urdf"));
    files.retain(|f| f.is_file());
    if files.is_empty() {
        eprintln!("skipped: no published robots in {}", shared.display());
    }
    for file in files {
        let worst = difference(&python, &file, 11);
        assert!(worst < 1e-10, "{}: {worst:e}", file.display());
    }
}
