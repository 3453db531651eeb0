//! `lacuna diagnose` on recordings of real machines, as their READMEs in examples/ tell. The
//! recordings were published by others and are not part of the project: each test says so and
//! passes where they are absent.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A published recording in the folder `../shared/real` beside the project; none where it is
/// absent.
fn published(file: &str) -> Option<PathBuf> {
    let path = root().join("../shared/real").join(file);
    if !path.exists() {
        println!("skipped: {file} is not here; examples/ tells where it is published");
    }
    path.exists().then_some(path)
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The diagnosis of an example's model; recordings may hold a range of rows.
fn diagnosed(example: &str, training: &str, held_out: &str) -> Value {
    let model = root().join("examples").join(example).join("model.toml");
    let mut command = Command::new(env!("CARGO_BIN_EXE_lacuna"));
    command.arg("diagnose").arg(model).arg(training).args(["--held-out", held_out, "--json"]);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn found(d: &Value) -> Vec<&str> {
    let mut classes: Vec<&str> =
        d["findings"].as_array().unwrap().iter().filter_map(|f| f["class"].as_str()).collect();
    classes.sort_unstable();
    classes
}

#[test]
fn the_silverbox_has_a_spring_of_three_powers_and_quadratic_drag() {
    let Some(file) = published("silverbox/silverbox_SNLS80mV.csv") else { return };
    let part = |rows: &str| format!("{}#rows={rows}", file.display());
    let d = diagnosed("silverbox", &part("40650..52000"), &part("106000..112000"));
    assert_eq!(
        found(&d),
        ["constant_force", "cubic_stiffness", "quadratic_drag", "quadratic_stiffness"]
    );
    let free = d["fit"]["held_out"]["y"]["free_run_after"].as_f64().unwrap();
    // With straight lines between the samples of the input it is 0.9 mV.
    assert!(free < 2.8e-4, "{free} V");
}

#[test]
fn a_drive_has_dry_friction() {
    let (Some(train), Some(test)) =
        (published("emps/emps_train.csv"), published("emps/emps_test_pulses.csv"))
    else {
        return;
    };
    let d = diagnosed("emps", &train.display().to_string(), &test.display().to_string());
    assert_eq!(found(&d), ["asymmetric_friction"]);
    let free = d["fit"]["held_out"]["q"]["free_run_after"].as_f64().unwrap();
    assert!(free < 6e-3, "{free} m");
}

/// The rig imposes the motion, and the force is what is measured: dry friction whose force builds up
/// over a very short travel.
#[test]
fn a_damper_has_dry_friction_and_hysteresis() {
    let (Some(train), Some(test)) = (
        published("mr_damper_labcontrol/mr_ensaio5_2.csv"),
        published("mr_damper_labcontrol/mr_ensaio8_2.csv"),
    ) else {
        return;
    };
    let moving = format!("{}#t=3..30", train.display());
    let d = diagnosed("damper", &moving, &test.display().to_string());
    assert_eq!(d["verdict"], "missing_physics");
    let classes = found(&d);
    assert!(classes.contains(&"hysteresis"), "{classes:?}");
    let fit = &d["fit"]["held_out"]["F_N"];
    let newtons = |name: &str| fit[name].as_f64().unwrap();
    // The measured force varies by 203 N: R^2 is above 0.99.
    assert!(newtons("free_run_after") < 20.3 && newtons("free_run_before") > 80.0, "{fit}");
}

/// The upper tank, which nothing measures, spills, and the lower one catches a part of it. Free levels
/// take this up in short windows; only long ones, which the model no longer follows, show it. The
/// pump's offset beside it is a force that does not depend on the levels, and only that.
#[test]
fn a_tank_spills_into_the_next() {
    let (Some(train), Some(test)) = (
        published("cascaded_tanks/cascaded_tanks_train.csv"),
        published("cascaded_tanks/cascaded_tanks_test.csv"),
    ) else {
        return;
    };
    let d = diagnosed("tanks", &train.display().to_string(), &test.display().to_string());
    assert_eq!(d["verdict"], "missing_physics");
    assert_eq!(found(&d), ["constant_force", "spill"]);
    let findings = d["findings"].as_array().unwrap();
    let spill = findings.iter().find(|f| f["class"] == "spill").unwrap();
    assert_eq!(spill["channel"], "x1");
    // Nothing measures the upper level, and with s times the pump's gain and sqrt(s) times its outflow's coefficient that
    // tank does the same at s times the level. What reaches the lower tank changes with sqrt(s), which k3 and the force
    // take up as far as these recordings tell. So both are read in the scale of the model's own gain.
    let pump = &d["calibration"]["k4"];
    let scale = pump["value"].as_f64().unwrap() / pump["nominal"].as_f64().unwrap();
    let parameter = |name: &str| spill["parameters"][name]["value"].as_f64().unwrap();
    assert!((5.0..20.0).contains(&(parameter("position") / scale)), "{spill}, {pump}");
    assert!((0.3..1.0).contains(&(parameter("share") * scale)), "{spill}, {pump}");
    // The best linear model leaves 0.59 V, the best black box 0.31 V.
    let fit = &d["fit"]["held_out"]["x2"];
    let volts = |name: &str| fit[name].as_f64().unwrap();
    assert!(volts("rmse_after") < 0.31 && volts("free_run_after") < 0.4, "{fit}");
}
