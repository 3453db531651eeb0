//! An arm as an FMU that is compiled for the test, the same arm as text, and recordings of one that has
//! friction besides.

use lacuna::excitation::{SinusoidRanges, SumOfSinusoids, add_gaussian_noise, rng};
use lacuna::plants::integrate::rk4_sampled;
use lacuna::plants::{Model, System};
use lacuna::recordings::{Column, Recording, write_csv_with_time};
use serde_json::Value;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Output};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

const SOURCE: &str = include_str!("arm.c");
const DESCRIPTIONS: [&str; 2] = [include_str!("arm2.xml"), include_str!("arm3.xml")];

/// The arm as text, in the form that an FMU has: accelerations.
pub const TEXT: &str = r#"name = "arm"
[parameters]
J = { value = 0.05, unit = "kg m^2", tolerance = 0.1 }
b = { value = 0.03, unit = "N m s/rad", tolerance = 0.1 }
mgl = { value = 0.4, unit = "N m", tolerance = 0.1 }
[[input]]
name = "tau"
unit = "N m"
[[coordinate]]
name = "q"
velocity = "dq"
unit = "rad"
[mechanics]
mass = [["1"]]
force = ["(tau - b*dq - mgl*sin(q))/J"]
"#;

/// What the FMU's model file says beside its name.
pub const BESIDE: &str = r#"
[parameters]
J = { value = 0.05, unit = "kg m^2", tolerance = 0.1 }
b = { value = 0.03, tolerance = 0.1 }
mgl = { value = 40, unit = "N cm", tolerance = 0.1 }
"#;

const FRICTION: &str = "\n[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"q\"\nmagnitude = 1.2\nsmoothing_velocity = 0.02\n";
pub const RUNS: [&str; 3] = ["run0.csv", "run1.csv", "run2.csv"];

/// A kind of FMU: version of the standard, whether it has derivatives, definitions for the compiler.
#[derive(Clone, Copy)]
pub struct Kind {
    pub version: usize,
    pub derivatives: bool,
    pub define: &'static str,
}

impl Kind {
    pub fn new(version: usize, derivatives: bool) -> Self {
        Self { version, derivatives, define: "-DPLAIN" }
    }

    /// Its description.
    pub fn description(self) -> String {
        let said = if self.derivatives { "true" } else { "false" };
        DESCRIPTIONS[self.version - 2].replace("DIRECTIONAL", said)
    }

    /// Where its library stands in the archive.
    pub fn library(self) -> String {
        let (os, arch) = (std::env::consts::OS, std::env::consts::ARCH);
        let folder = match (self.version, os, arch) {
            (2, "linux", "x86_64") => "linux64".to_owned(),
            (2, "macos", _) => "darwin64".to_owned(),
            _ => format!("{arch}-{}", if os == "macos" { "darwin" } else { os }),
        };
        format!("binaries/{folder}/arm{}", std::env::consts::DLL_SUFFIX)
    }
}

pub struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    /// With recordings; none where there is no compiler of C.
    pub fn with_runs() -> Option<Self> {
        let bench = Self::new();
        bench.compiled(Kind::new(2, false))?;
        bench.write("model.toml", TEXT.as_bytes());
        let truth = Model::from_text(&format!("{TEXT}{FRICTION}"), "truth.toml").unwrap();
        for (run, name) in RUNS.iter().enumerate() {
            write_csv_with_time(&bench.path(name), &record(&truth, run as u64), "t").unwrap();
        }
        Some(bench)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    /// An archive of entries.
    pub fn archive(&self, name: &str, entries: &[(&str, &[u8])]) {
        let mut zip = ZipWriter::new(std::fs::File::create(self.path(name)).unwrap());
        for (entry, bytes) in entries {
            zip.start_file(*entry, SimpleFileOptions::default()).unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap();
    }

    /// The shared library of an arm; none where there is no compiler of C.
    fn compiled(&self, kind: Kind) -> Option<Vec<u8>> {
        self.write("arm.c", SOURCE.as_bytes());
        let version = format!("-DVERSION={}", kind.version);
        let arguments = [
            "-O1",
            "-w",
            "-shared",
            "-fPIC",
            &version,
            kind.define,
            "-o",
            "arm.so",
            "arm.c",
            "-lm",
        ];
        let status = Command::new("cc").args(arguments).current_dir(self.folder.path()).status();
        let Ok(status) = status else {
            eprintln!("skipped: there is no C compiler (cc)");
            return None;
        };
        assert!(status.success(), "the arm compiles");
        Some(std::fs::read(self.path("arm.so")).unwrap())
    }

    /// An FMU of an arm, its description as `edit` makes it.
    pub fn fmu(&self, name: &str, kind: Kind, edit: impl Fn(&str) -> String) -> Option<()> {
        let library = self.compiled(kind)?;
        let description = edit(&kind.description());
        let entries =
            [("modelDescription.xml", description.as_bytes()), (&kind.library(), &library[..])];
        self.archive(name, &entries);
        Some(())
    }

    fn lacuna(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lacuna"));
        command.args(arguments).current_dir(self.folder.path()).output().unwrap()
    }

    /// What a run that succeeds prints.
    pub fn prints(&self, arguments: &[&str]) -> String {
        let output = self.lacuna(arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {said}");
        String::from_utf8(output.stdout).unwrap()
    }

    pub fn json(&self, arguments: &[&str]) -> Value {
        serde_json::from_str(&self.prints(arguments)).unwrap()
    }

    /// What is said of a file that is refused.
    pub fn refused(&self, model: &str) -> String {
        let output = self.lacuna(&["check", model, "run0.csv"]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.starts_with("lacuna: ") && !said.contains("panicked"), "{said}");
        said
    }

    /// The values of a column of a CSV file.
    pub fn column(&self, file: &str, name: &str) -> Vec<f64> {
        let text = std::fs::read_to_string(self.path(file)).unwrap();
        let mut lines = text.lines();
        let header = lines.next().unwrap().split(',');
        let names: Vec<&str> = header.collect();
        let k = names.iter().position(|n| *n == name).unwrap_or_else(|| panic!("{names:?}"));
        lines.filter_map(|line| line.split(',').nth(k)?.parse().ok()).collect()
    }
}

fn record(truth: &Model, run: u64) -> Recording {
    const STEP: f64 = 0.01;
    const ROWS: usize = 400;
    let mut rng = rng(7, run);
    let ranges = SinusoidRanges {
        amplitude: 0.1..=0.3,
        angular_frequency: 0.5..=6.0,
        phase: 0.0..=std::f64::consts::TAU,
    };
    let time: Vec<f64> = (0..ROWS).map(|k| STEP * k as f64).collect();
    let torque = SumOfSinusoids::random(&mut rng, 1, 4, &ranges).unwrap().sample(&time);
    let system = System::new(truth);
    let start = system.at_rest(&[0.2, 0.0]);
    let motion = rk4_sampled(&system, &start, &time, &torque, truth.hold, 8).unwrap();
    let mut angle: Vec<f64> = (0..ROWS).map(|k| motion.state(k)[0]).collect();
    add_gaussian_noise(&mut angle, 1e-3, &mut rng).unwrap();
    let columns = vec![
        Column { name: "q".to_owned(), values: angle },
        Column { name: "tau".to_owned(), values: torque },
    ];
    Recording { name: String::new(), time, columns }
}
