//! Commands that are interrupted, and commands that nobody reads to the end.
#![cfg(unix)]

#[expect(dead_code, reason = "shared with the tests of other commands")]
#[path = "cli_check_identify/bench.rs"]
mod bench;

use bench::{Bench, arguments};
use std::fmt::Display;
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Instant;

const LACUNA: &str = env!("CARGO_BIN_EXE_lacuna");
/// Exit code of what was interrupted.
const INTERRUPTED: i32 = 130;

/// Signals, a bit each.
const SIGHUP: u64 = 1;
const SIGINT: u64 = 1 << 1;
const SIGTERM: u64 = 1 << 14;

/// Start a command with its output in pipes.
fn start(bench: &Bench, arguments: &[&str]) -> Child {
    spawn(Command::new(LACUNA).args(arguments), bench)
}

fn spawn(command: &mut Command, bench: &Bench) -> Child {
    command
        .current_dir(bench.path(""))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// A set of a process's signals, a bit each from the first (proc(5)); none where that is not told.
fn signals(process: impl Display, set: &str) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix(set))?;
    u64::from_str_radix(line.trim(), 16).ok()
}

/// What tests ignore that a shell without job control runs in the background, and the commands that they start.
fn ignored() -> u64 {
    signals("self", "SigIgn:").unwrap_or(0)
}

/// What interrupts a command.
fn interruption() -> &'static str {
    if ignored() & SIGINT == 0 { "-INT" } else { "-TERM" }
}

fn interrupt(child: &Child, signal: &str) {
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    assert!(sent.success(), "{signal}");
}

/// Exit code, and what was said on standard error.
fn end(mut child: Child) -> (Option<i32>, String) {
    drop(child.stdout.take());
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    (child.wait().unwrap().code(), said)
}

/// Names of the files in a folder, hidden ones too; none where there is no folder.
fn files(folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return vec![] };
    let mut names: Vec<String> =
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_diagnosis_that_is_interrupted_leaves_nothing() {
    let (bench, runs) = Bench::with_runs(1..=4);
    let before = files(&bench.path(""));
    let diagnose = arguments(&["diagnose", "model.toml", "--out", "found"], &runs);
    let begin = Instant::now();
    assert_eq!(end(start(&bench, &diagnose)), (Some(0), String::new()));
    let whole = begin.elapsed();
    std::fs::remove_dir_all(bench.path("found")).unwrap();
    let signal = interruption();
    for (signal, share) in [(signal, 0.05), (signal, 0.3), (signal, 0.6), ("-TERM", 0.4)] {
        let child = start(&bench, &diagnose);
        std::thread::sleep(whole.mul_f64(share));
        interrupt(&child, signal);
        let (code, said) = end(child);
        // Before the handler is there the signal itself ends the process.
        assert!(code.is_none_or(|c| c == INTERRUPTED), "after {share} of {whole:?}: {code:?}");
        assert_eq!(said, "", "after {share} of {whole:?}");
        assert_eq!(files(&bench.path("")), before, "after {share} of {whole:?}");
    }
}

fn compare<'a>(runs: &'a [String], out: &'a str) -> Vec<&'a str> {
    arguments(&["compare", "model.toml", "model.toml", "--out", out], runs)
}

/// Whenever it is interrupted, all files of a command are there or none, and nothing temporary.
#[test]
fn files_are_written_together_or_not_at_all() {
    let (bench, runs) = Bench::with_runs(1..=2);
    let all = ["compare.html", "compare.json"].map(str::to_owned);
    let begin = Instant::now();
    assert_eq!(end(start(&bench, &compare(&runs, "found"))), (Some(0), String::new()));
    let whole = begin.elapsed();
    assert_eq!(files(&bench.path("found")), all);
    const ROUNDS: u32 = 24;
    let signal = interruption();
    let mut counts = [0, 0];
    for round in 0..ROUNDS {
        let out = format!("found{round}");
        let child = start(&bench, &compare(&runs, &out));
        std::thread::sleep(whole * round / ROUNDS);
        // The command may have ended before the signal comes.
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).output();
        assert!(sent.is_ok());
        let (code, said) = end(child);
        assert!(code.is_none_or(|c| c == 0 || c == INTERRUPTED), "{code:?} {said}");
        let written = files(&bench.path(&out));
        assert!(written.is_empty() || written == all, "round {round}, {code:?}: {written:?}");
        counts[usize::from(written == all)] += 1;
    }
    let [none, whole] = counts;
    eprintln!("of {ROUNDS} runs {none} wrote nothing, {whole} wrote everything");
    assert!(none > 0, "no run was interrupted in time");
}

/// `nohup` ignores SIGHUP, and that alone: what else comes is heard.
#[test]
#[cfg(target_os = "linux")]
fn under_nohup_a_hangup_is_ignored_and_an_interrupt_is_heard() {
    let (bench, runs) = Bench::with_runs(1..=4);
    let diagnose = arguments(&["diagnose", "model.toml", "--out", "found"], &runs);
    // Of a terminal as its input it would say that it ignores it.
    let mut nohup = Command::new("nohup");
    let child = spawn(nohup.arg(LACUNA).args(&diagnose).stdin(Stdio::null()), &bench);
    let heard = |bits: u64| signals(child.id(), "SigCgt:").unwrap() & bits == bits;
    let begin = Instant::now();
    while !heard((SIGINT | SIGTERM) & !ignored()) {
        assert!(begin.elapsed().as_secs() < 10, "no handler");
        std::thread::yield_now();
    }
    assert!(!heard(SIGHUP), "the hangup is heard");
    interrupt(&child, "-HUP");
    interrupt(&child, interruption());
    assert_eq!(end(child), (Some(INTERRUPTED), String::new()));
    assert!(!bench.path("found").exists());
}

#[test]
fn a_reader_that_goes_is_no_error() {
    let (bench, runs) = Bench::with_runs(1..=2);
    bench.write("lines.toml", bench::MODEL);
    for command in [
        &["check", "model.toml"][..],
        &["check", "model.toml", "--json"],
        &["compare", "model.toml", "lines.toml", "--out", "found"],
        &["diagnose", "model.toml", "--out", "found"],
        &["diagnose", "model.toml", "--json"],
    ] {
        let mut child = start(&bench, &arguments(command, &runs));
        // Nobody reads a single sign.
        drop(child.stdout.take());
        let (code, said) = end(child);
        assert_eq!((code, said.as_str()), (Some(0), ""), "{command:?}");
    }
    for file in ["compare.html", "compare.json", "diagnosis.json", "report.html"] {
        assert!(bench.path("found").join(file).is_file(), "{file}");
    }
}

/// An error that nobody hears is in the exit code.
#[test]
fn an_error_that_nobody_hears_is_told_by_the_exit_code() {
    let (bench, _) = Bench::with_runs(1..=1);
    let mut child = start(&bench, &["check", "model.toml", "absent.csv"]);
    drop(child.stderr.take());
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(2));
}

/// Output that cannot be written for another reason is an error with that reason.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_told() {
    let (bench, runs) = Bench::with_runs(1..=1);
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = Command::new(LACUNA)
        .args(arguments(&["check", "model.toml"], &runs))
        .current_dir(bench.path(""))
        .stdout(full)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.starts_with("lacuna: standard output: ") && !said.contains("panicked"), "{said}");
}
