//! Faults around the command: disks that are full, folders that cannot be written or go away, processes that are
//! killed, recordings that change while they are read or come from other programs.
#![cfg(unix)]

#[expect(dead_code, reason = "shared with the tests of other commands")]
#[path = "cli_check_identify/bench.rs"]
mod bench;

use bench::{Bench, Run, arguments, stderr};
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Names of the files in a folder, hidden ones too; none where there is no folder.
fn files(folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return vec![] };
    let mut names: Vec<String> =
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn compare<'a>(runs: &'a [String], out: &'a str) -> Vec<&'a str> {
    arguments(&["compare", "model.toml", "model.toml", "--out", out], runs)
}

const WRITTEN: [&str; 2] = ["compare.html", "compare.json"];

fn works(output: &Output) {
    assert!(output.status.success(), "{}", stderr(output));
}

/// A disk of a few kilobytes, taken down in the end.
struct SmallDisk(PathBuf);

impl SmallDisk {
    /// None where nobody may mount one.
    fn new(folder: PathBuf) -> Option<Self> {
        std::fs::create_dir(&folder).unwrap();
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", "size=16k", "tmpfs"])
            .arg(&folder)
            .stderr(Stdio::null())
            .status();
        mounted.is_ok_and(|s| s.success()).then_some(Self(folder))
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        // Nothing is lost where it stays: the folder is temporary.
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

#[test]
fn a_full_disk_leaves_the_old_results_and_nothing_else() {
    let (bench, runs) = Bench::with_runs(1..=2);
    let Some(disk) = SmallDisk::new(bench.path("disk")) else {
        eprintln!("skipped: no small disk can be mounted here");
        return;
    };
    std::fs::write(disk.0.join("compare.json"), "old").unwrap();
    for command in
        [compare(&runs, "disk"), arguments(&["diagnose", "model.toml", "--out", "disk"], &runs)]
    {
        let said = bench.error(&command);
        assert!(said.contains("disk/") && said.contains("No space left"), "{said}");
        assert_eq!(files(&disk.0), ["compare.json"]);
        assert_eq!(std::fs::read_to_string(disk.0.join("compare.json")).unwrap(), "old");
    }
    drop(disk);
    // With room it works.
    works(&bench.lacuna(&compare(&runs, "disk")));
    assert_eq!(files(&bench.path("disk")), WRITTEN);
}

#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let (bench, runs) = Bench::with_runs(1..=2);
    bench.write("file", "");
    let said = bench.error(&compare(&runs, "file/found"));
    assert!(said.contains("file/found"), "{said}");
    // A file is no folder: told before anything is computed, so that no recording is looked for.
    for command in ["compare model.toml model.toml", "diagnose model.toml"] {
        let words: Vec<&str> = command.split(' ').chain(["absent.csv", "--out"]).collect();
        for folder in ["file", "file/found"] {
            let said = bench.error(&[&words[..], &[folder]].concat());
            let told = format!("cannot write to the folder {folder}: file is a file");
            assert!(said.contains(&told), "{said}");
        }
    }
    // A link that leads nowhere.
    symlink("/nowhere/at/all", bench.path("link")).unwrap();
    let said = bench.error(&compare(&runs, "link"));
    assert!(said.contains("link"), "{said}");
    std::fs::create_dir(bench.path("locked")).unwrap();
    let locked = std::fs::Permissions::from_mode(0o500);
    std::fs::set_permissions(bench.path("locked"), locked).unwrap();
    let may_write = std::fs::write(bench.path("locked/try"), "").is_ok();
    if may_write {
        eprintln!("skipped: whoever runs this may write everywhere");
    } else {
        let said = bench.error(&compare(&runs, "locked"));
        assert!(said.contains("locked") && said.contains("ermission"), "{said}");
    }
}

/// Whoever takes the folder away meanwhile gets an error or all files, never a half.
#[test]
fn a_folder_that_goes_away_is_no_panic() {
    let (bench, runs) = Bench::with_runs(1..=2);
    let begin = Instant::now();
    works(&bench.lacuna(&compare(&runs, "found")));
    let whole = begin.elapsed();
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !stop.load(Ordering::Relaxed) {
                // It is there or not: both are tried.
                let _ = std::fs::remove_dir_all(bench.path("found"));
            }
        });
        for _ in 0..12 {
            let output = bench.lacuna(&compare(&runs, "found"));
            let said = stderr(&output);
            let told = output.status.code() == Some(2) && said.contains("found");
            assert!(output.status.success() || told, "{:?} {said}", output.status);
            assert!(!said.contains("panicked"), "{said}");
        }
        stop.store(true, Ordering::Relaxed);
    });
    works(&bench.lacuna(&compare(&runs, "found")));
    assert_eq!(files(&bench.path("found")), WRITTEN, "after {whole:?} a run");
}

/// Killed, which nobody can wait for: each file is whole, the old one or the new one, and a rerun works.
#[test]
fn whoever_is_killed_leaves_no_half_file() {
    let (bench, runs) = Bench::with_runs(1..=2);
    let begin = Instant::now();
    works(&bench.lacuna(&compare(&runs, "found")));
    let whole = begin.elapsed();
    let read = |name: &str| std::fs::read_to_string(bench.path("found").join(name)).unwrap();
    let expected = WRITTEN.map(read);
    const ROUNDS: u32 = 24;
    for round in 0..ROUNDS {
        let mut child = Command::new(env!("CARGO_BIN_EXE_lacuna"))
            .args(compare(&runs, "found"))
            .current_dir(bench.path(""))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(whole * (ROUNDS / 2 + round) / (ROUNDS + ROUNDS / 2));
        // It may have ended before.
        let _ = child.kill();
        child.wait().unwrap();
        assert_eq!(WRITTEN.map(read), expected, "round {round}");
    }
    works(&bench.lacuna(&compare(&runs, "found")));
    assert_eq!(WRITTEN.map(read), expected);
}

#[test]
fn a_recording_that_ends_anywhere_is_read_or_told() {
    let (bench, runs) = Bench::with_runs(1..=1);
    let text = std::fs::read_to_string(bench.path(&runs[0])).unwrap();
    for length in (0..text.len()).step_by(text.len() / 12 + 1).chain([text.len() - 1]) {
        bench.write("cut.csv", &text[..length]);
        let output = bench.lacuna(&["check", "model.toml", "cut.csv"]);
        let said = stderr(&output);
        let told = output.status.code() == Some(2) && said.contains("cut.csv");
        assert!(output.status.success() || told, "{length} bytes: {said}");
        assert!(!said.contains("panicked"), "{said}");
    }
}

/// A logger that still writes, and one that begins anew: an answer or an error, at once.
#[test]
fn a_recording_that_changes_meanwhile_is_read_or_told() {
    let (bench, runs) = Bench::with_runs(1..=1);
    let text = std::fs::read_to_string(bench.path(&runs[0])).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            use std::io::Write;
            while !stop.load(Ordering::Relaxed) {
                let mut log = std::fs::File::create(bench.path("log.csv")).unwrap();
                for lines in lines.chunks(40) {
                    writeln!(log, "{}", lines.join("\n")).unwrap();
                    std::thread::sleep(Duration::from_millis(1));
                }
            }
        });
        while !bench.path("log.csv").exists() {
            std::thread::yield_now();
        }
        for _ in 0..12 {
            let begin = Instant::now();
            let output = bench.lacuna(&["check", "model.toml", "log.csv"]);
            let said = stderr(&output);
            let told = output.status.code() == Some(2) && said.contains("log.csv");
            assert!(output.status.success() || told, "{said}");
            assert!(!said.contains("panicked") && begin.elapsed().as_secs() < 60, "{said}");
        }
        stop.store(true, Ordering::Relaxed);
    });
}

/// What other programs make of a recording: the same answer, or what to do.
#[test]
fn recordings_of_other_programs_are_read_or_told() {
    let (bench, runs) = Bench::with_runs(1..=1);
    let plain = std::fs::read_to_string(bench.path(&runs[0])).unwrap();
    let expected = bench.lacuna(&["check", "model.toml", &runs[0]]);
    works(&expected);
    let same = |what: &str, bytes: &[u8]| {
        std::fs::write(bench.path(&runs[0]), bytes).unwrap();
        let output = bench.lacuna(&["check", "model.toml", &runs[0]]);
        assert_eq!(stderr(&output), "", "{what}");
        assert_eq!(output.stdout, expected.stdout, "{what}");
    };
    let decimal_commas = plain.replace(',', ";").replace('.', ",");
    let utf16: Vec<u8> =
        "\u{feff}".encode_utf16().chain(plain.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    same("byte-order mark", format!("\u{feff}{plain}").as_bytes());
    same("CRLF", plain.replace('\n', "\r\n").as_bytes());
    same("semicolons", plain.replace(',', ";").as_bytes());
    same("quoted header", plain.replacen("t,x,u", "\"t\",\"x\",\"u\"", 1).as_bytes());
    for (what, bytes, said) in [
        ("UTF-16", utf16, "save it as UTF-8"),
        ("decimal commas", decimal_commas.into_bytes(), "decimal point"),
        ("a row of units", plain.replacen('\n', "\ns,m,N\n", 1).into_bytes(), "unit"),
        ("two columns of one name", plain.replacen("t,x,u", "t,x,x", 1).into_bytes(), "'x'"),
    ] {
        std::fs::write(bench.path(&runs[0]), bytes).unwrap();
        let found = bench.error(&["check", "model.toml", &runs[0]]);
        assert!(found.contains(said) && found.contains(&runs[0]), "{what}: {found}");
    }
}

#[test]
fn two_thousand_columns_are_read() {
    let bench = Bench::new();
    let run = Run::new(1);
    let names: Vec<String> = (0..2000).map(|k| format!("other{k}")).collect();
    let mut columns: Vec<(&str, &[f64])> = vec![("t", &run.t), ("x", &run.x), ("u", &run.u)];
    columns.extend(names.iter().map(|name| (&**name, &run.dx[..])));
    bench.write("wide.csv", &Run::csv(&columns));
    let begin = Instant::now();
    works(&bench.lacuna(&["check", "model.toml", "wide.csv"]));
    assert!(begin.elapsed().as_secs() < 30, "{:?}", begin.elapsed());
}
