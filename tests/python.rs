//! The Python package, built and installed as its users do it, and its own tests.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// What the package's tests import, and what builds it.
const NEEDED: [&str; 6] = ["maturin", "pytest", "pandas", "polars", "pyarrow", "scikit-learn"];

/// What some of them need beside: without these they skip themselves.
const WELCOME: [&str; 5] = ["mujoco", "dask[distributed]", "matplotlib", "nbclient", "ipykernel"];

fn run(program: &Path, arguments: &[&str]) -> Option<Output> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    Command::new(program)
        .args(arguments)
        .current_dir(root)
        // What was built for the tests of Rust is not built again.
        .env("CARGO_TARGET_DIR", target())
        .env("MATURIN_PEP517_ARGS", "--profile dev")
        .env("LACUNA", env!("CARGO_BIN_EXE_lacuna"))
        .output()
        .ok()
}

/// The folder of what is built.
fn target() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("..")
}

fn succeeds(program: &Path, arguments: &[&str]) -> bool {
    run(program, arguments).is_some_and(|output| output.status.success())
}

/// What must succeed.
fn must(program: &Path, arguments: &[&str]) -> String {
    let output = run(program, arguments).expect("it was run before");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}:\n{said}\n{errors}");
    said
}

#[test]
fn the_package_installs_and_passes_its_tests() {
    let folder = tempfile::tempdir().unwrap();
    let environment = folder.path().join("venv");
    if !succeeds(Path::new("python3"), &["-m", "venv", &environment.to_string_lossy()]) {
        eprintln!("skipped: no python3 with venv");
        return;
    }
    let binaries = if cfg!(windows) { "Scripts" } else { "bin" };
    let python = environment.join(binaries).join("python");
    let install = ["-m", "pip", "install", "-q", "--only-binary", ":all:"];
    if !succeeds(&python, &[&install[..], &NEEDED].concat()) {
        eprintln!("skipped: pip cannot install {}", NEEDED.join(", "));
        return;
    }
    let missing: Vec<&str> = WELCOME
        .into_iter()
        .filter(|package| !succeeds(&python, &[&install[..], &[package]].concat()))
        .collect();
    for package in &missing {
        // What a test that passes prints is kept from its reader; this is not.
        let told =
            format!("without {package}: pip cannot install it, and its tests skip themselves\n");
        std::io::stderr().write_all(told.as_bytes()).unwrap();
    }
    must(&python, &["-m", "pip", "install", "-q", "./python"]);
    let pytest = ["-m", "pytest", "-q", "-rs", "--durations=12", "-p", "no:cacheprovider"];
    let said = must(&python, &[&pytest[..], &["python/tests"]].concat());
    println!("{said}");
    // Nothing that is there is passed over.
    let passed_over =
        said.lines().find(|l| l.starts_with("SKIPPED") && l.contains("is not installed"));
    assert!(!missing.is_empty() || passed_over.is_none(), "{passed_over:?}");
}
