//! Programs that others wrote and that know how robots move.

use super::drawn_states;
use lacuna_rigid::Tree;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The Python that knows of a package; none where there is none, which is said.
pub fn python(package: &str, installed: &str) -> Option<String> {
    let python = std::env::var("LACUNA_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let knows = Command::new(&python).args(["-c", &format!("import {package}")]).output();
    if knows.is_ok_and(|o| o.status.success()) {
        return Some(python);
    }
    eprintln!(
        "skipped: {python} does not know {package} (pip install {installed}; LACUNA_PYTHON=...)"
    );
    None
}

/// The robots' own files that others published, of this name in each case; said where there are none.
pub fn published(name: &str) -> Vec<PathBuf> {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    let cases = std::fs::read_dir(shared.join("blind_robots/cases")).into_iter().flatten();
    let mut files: Vec<PathBuf> = cases.filter_map(|c| Some(c.ok()?.path().join(name))).collect();
    files.retain(|f| f.is_file());
    if files.is_empty() {
        eprintln!("skipped: no published robots in {}", shared.display());
    }
    files
}

/// Greatest difference of what is computed of states (coordinates, then velocities) from what a
/// script of `tests/oracle` says of them, as a share of the largest entry of the same kind.
pub fn difference(
    (python, script): (&str, &str),
    (file, tree): (&Path, &Tree),
    seed: u64,
    ours: impl Fn(&[f64]) -> Vec<Vec<f64>>,
) -> f64 {
    let mut states = drawn_states(tree.coordinates(), 20, seed);
    // A right angle is singular: accelerations near it hold the rounding of both.
    for (k, _) in
        tree.joints().enumerate().filter(|(_, j)| j.of != j.name && j.name.ends_with("_pitch"))
    {
        states.iter_mut().for_each(|state| state[k] /= 3.0);
    }
    let names: Vec<&str> = tree.joints().map(|j| j.name.as_str()).collect();
    let mut asked = names.join(" ");
    for state in &states {
        let line: Vec<String> = state.iter().map(|x| format!("{x:e}")).collect();
        asked += &format!("\n{}", line.join(" "));
    }
    let mut child = Command::new(python)
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/oracle").join(script))
        .arg(file)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("python starts");
    child.stdin.take().expect("a pipe").write_all(asked.as_bytes()).expect("it listens");
    let said = child.wait_with_output().expect("it answers");
    assert!(said.status.success(), "{}", file.display());
    let said = String::from_utf8(said.stdout).expect("text");
    assert_eq!(said.lines().count(), states.len());
    let mut worst = 0.0f64;
    for (state, line) in states.iter().zip(said.lines()) {
        let oracle: Vec<f64> = line.split(' ').map(|x| x.parse().expect("a number")).collect();
        let mut oracle = oracle.as_slice();
        for ours in ours(state) {
            let (theirs, rest) = oracle.split_at(ours.len());
            let size = theirs.iter().fold(f64::MIN_POSITIVE, |a, x| a.max(x.abs()));
            for (a, b) in ours.iter().zip(theirs) {
                worst = worst.max((a - b).abs() / size);
            }
            oracle = rest;
        }
        assert!(oracle.is_empty());
    }
    worst
}
