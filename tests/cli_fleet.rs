//! `lacuna fleet` as a user runs it: shares, what is done before, what fails, and who is unlike the others.

mod arm;

use arm::{MODEL, record};
use lacuna::plants::Model;
use lacuna::recordings::write_csv_with_time;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const ROWS: usize = 400;

const FLEET: &str = r#"model = "arm.toml"
machines = "data/*/"
held_out = "proof.csv"
[options]
only = ["coulomb_friction", "cubic_stiffness"]
"#;

/// A folder with a model and the recordings of seven machines: all rub, and one does not.
struct Fleet {
    folder: tempfile::TempDir,
}

/// The machine that does not rub.
const ODD: usize = 4;

impl Fleet {
    fn new() -> Self {
        let fleet = Self { folder: tempfile::tempdir().unwrap() };
        std::fs::write(fleet.path("arm.toml"), MODEL).unwrap();
        std::fs::write(fleet.path("fleet.toml"), FLEET).unwrap();
        for m in 0..7 {
            fleet.record(m);
        }
        fleet
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Two recordings of a machine.
    fn record(&self, m: usize) {
        let magnitude = 0.06 + 0.001 * m as f64;
        let friction = format!(
            "[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"q\"\nmagnitude = {magnitude}\nsmoothing_velocity = 0.02\n"
        );
        let concealed = if m == ODD { "" } else { &friction };
        let truth = Model::from_text(&format!("{MODEL}{concealed}"), "truth.toml").unwrap();
        let folder = self.path(&format!("data/m{m}"));
        std::fs::create_dir_all(&folder).unwrap();
        for (run, name) in ["run.csv", "proof.csv"].iter().enumerate() {
            write_csv_with_time(
                &folder.join(name),
                &record(&truth, (11, (m * 2 + run) as u64), ROWS),
                "t",
            )
            .unwrap();
        }
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lacuna"));
        let arguments = [&["fleet", "fleet.toml", "--out", "out"], arguments].concat();
        command.args(arguments).current_dir(self.folder.path()).output().unwrap()
    }

    /// What a run without failed machines prints.
    fn prints(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    }

    fn json(&self) -> Value {
        serde_json::from_str(&std::fs::read_to_string(self.path("out/fleet.json")).unwrap())
            .unwrap()
    }
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap()
}

#[test]
fn shares_together_find_the_machine_that_is_unlike_the_others_and_nothing_is_done_twice() {
    let fleet = Fleet::new();
    let first = fleet.prints(&["--shard", "1/2", "--jobs", "2"]);
    assert!(first.contains("m0: diagnosed") && !first.contains("m1"), "{first}");
    assert!(first.contains("3 machines of other shares are not done"), "{first}");
    assert!(!fleet.path("out/fleet.json").exists());
    let second = fleet.prints(&["--shard", "2/2", "--jobs", "1"]);
    assert!(second.contains("1 of 7 machines is unlike the others: m4"), "{second}");
    assert!(
        second.contains("m4: no dry friction on q, where typical machines have 0.0"),
        "{second}"
    );
    let json = fleet.json();
    assert_eq!(
        (json["unlike"].as_array().unwrap().len(), &json["unlike"][0]["machine"]),
        (1, &"m4".into())
    );
    assert_eq!(json["machines"].as_array().unwrap().len(), 7);
    let sizes = &json["quantities"][0];
    assert_eq!((&sizes["sort"], &sizes["name"]), (&"size".into(), &"dry friction on q".into()));
    let mean = sizes["mean"].as_f64().unwrap();
    assert!((mean - 0.063).abs() < 0.003, "{mean}");
    let page = String::from_utf8(bytes(&fleet.path("out/fleet.html"))).unwrap();
    assert!(page.contains("href=\"m4/report.html\"") && page.contains("<svg"), "{page}");

    // What a kill leaves of a machine that it was at: no inputs.json.
    std::fs::remove_file(fleet.path("out/m2/inputs.json")).unwrap();
    let before = bytes(&fleet.path("out/m2/diagnosis.json"));
    fleet.record(ODD);
    std::fs::copy(fleet.path("data/m0/proof.csv"), fleet.path("data/m3/proof.csv")).unwrap();
    let again = fleet.prints(&[]);
    let told = |name: &str, what: &str| again.contains(&format!("{name}: {what}"));
    assert!(told("m2", "diagnosed") && told("m3", "diagnosed"), "{again}");
    for name in ["m0", "m1", "m4", "m5", "m6"] {
        assert!(told(name, "was diagnosed before"), "{again}");
    }
    assert_eq!(bytes(&fleet.path("out/m2/diagnosis.json")), before);
}

#[test]
fn a_machine_that_fails_is_told_and_stops_no_other() {
    let fleet = Fleet::new();
    for m in 2..7 {
        std::fs::remove_dir_all(fleet.path(&format!("data/m{m}"))).unwrap();
    }
    std::fs::write(fleet.path("data/m1/run.csv"), "t,q\n0,0\n1,0\n").unwrap();
    std::fs::create_dir(fleet.path("data/empty")).unwrap();
    let output = fleet.run(&[]);
    let (said, printed) = (stderr(&output), String::from_utf8(output.stdout).unwrap());
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("lacuna: m1: ") && said.contains("lacuna: empty: no recordings to fit"),
        "{said}"
    );
    assert!(
        printed.contains("1 machines: too few") && printed.contains("2 not diagnosed"),
        "{printed}"
    );
    assert_eq!(fleet.json()["failed"].as_array().unwrap().len(), 2);
    assert!(!fleet.path("out/m1/inputs.json").exists());
    // Mended, it is diagnosed; the other is not done again.
    fleet.record(1);
    std::fs::remove_dir(fleet.path("data/empty")).unwrap();
    let mended = fleet.prints(&[]);
    assert!(
        mended.contains("m0: was diagnosed before") && mended.contains("m1: diagnosed"),
        "{mended}"
    );
    assert!(!fleet.path("out/m1/failed.json").exists());
}

#[test]
fn mistakes_in_the_file_are_told_with_their_place() {
    let fleet = Fleet::new();
    let wrong = FLEET.replace("cubic_stiffness", "cubic_stifness");
    std::fs::write(fleet.path("fleet.toml"), wrong).unwrap();
    let said = stderr(&fleet.run(&[]));
    assert!(said.contains("cubic_stiffness"), "{said}");
    std::fs::write(fleet.path("fleet.toml"), FLEET.replace("data/*/", "dota/*/")).unwrap();
    let output = fleet.run(&[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).starts_with("lacuna: fleet.toml:2:12: no folder matches 'dota/*/'"),
        "{}",
        stderr(&output)
    );
    assert!(!fleet.path("out").exists());
}
