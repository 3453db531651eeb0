//! Robots that log where they are told to be and where they are, and no torque: the servos of an MJCF are part of the
//! model, and what it leaves out beside them is named.

use crate::bench::{ARM, Bench};
use lacuna::excitation::{SinusoidRanges, SumOfSinusoids, add_gaussian_noise, rng};
use lacuna::plants::{Model, SampledInput, System, rk4};
use serde_json::Value;
use std::fmt::Write;

const SERVOS: &str = "<actuator>\n    <position joint=\"shoulder\" kp=\"60\" kv=\"3\"/>\n    \
    <position joint=\"elbow\" kp=\"25\" kv=\"1\" forcerange=\"-9 9\"/>\n  </actuator>";
const COMMANDED: [&str; 2] = ["shoulder", "elbow"];

/// The arm of the bench with position servos.
fn arm() -> String {
    let motors = "<actuator><motor joint=\"shoulder\" gear=\"50\"/><motor joint=\"elbow\" gear=\"50\"/></actuator>";
    assert!(crate::bench::MJCF.contains(motors));
    crate::bench::MJCF.replace(motors, SERVOS)
}

/// Folder with the arm, and what it does with some effects.
fn bench(effects: &str) -> Bench {
    let bench = Bench::new("");
    std::fs::write(bench.path("arm.xml"), arm()).expect("a file");
    let tables: String = COMMANDED
        .map(|joint| format!("[[actuator]]\ntemplate = \"pd_servo\"\nchannel = \"{joint}\"\n"))
        .concat();
    let truth = format!("name = \"truth\"\n[robot]\nfile = \"arm.xml\"\n{tables}{effects}");
    std::fs::write(bench.path("truth.toml"), truth).expect("a file");
    bench
}

/// What its controller logs: commands and encoders.
fn record(bench: &Bench, run: u64) -> String {
    const NOISE: f64 = 3e-4;
    let truth = Model::read(&bench.path("truth.toml")).expect("a model");
    let mut rng = rng(79, run);
    let ranges = SinusoidRanges {
        amplitude: 0.1..=0.4,
        angular_frequency: 0.7..=7.0,
        phase: 0.0..=std::f64::consts::TAU,
    };
    let times: Vec<f64> = (0..600).map(|k| 0.01 * f64::from(k)).collect();
    let wanted = SumOfSinusoids::random(&mut rng, 2, 4, &ranges).expect("ranges").sample(&times);
    let values = truth.effective_inputs(&times, &wanted);
    let input = SampledInput { times: &times, values: &values, hold: truth.hold };
    let system = System::new(&truth);
    let begin = system.at_rest(&[wanted[0], wanted[1], 0.0, 0.0]);
    let motion = rk4(&system, &begin, &input, &times, 5e-4).expect("it does not diverge");
    let mut angles = [0, 1].map(|j| (0..600).map(|k| motion.state(k)[j]).collect::<Vec<f64>>());
    for angles in &mut angles {
        add_gaussian_noise(angles, NOISE, &mut rng).expect("a deviation");
    }
    let mut text = String::from("t,shoulder,elbow,shoulder_command,elbow_command\n");
    for (k, t) in times.iter().enumerate() {
        let (a, b) = (angles[0][k], angles[1][k]);
        writeln!(text, "{t},{a},{b},{},{}", wanted[2 * k], wanted[2 * k + 1]).expect("text");
    }
    let name = format!("servo{run}.csv");
    std::fs::write(bench.path(&name), text).expect("a file");
    name
}

fn diagnosed(bench: &Bench) -> Value {
    let runs: Vec<String> = (0..4).map(|run| record(bench, run)).collect();
    let mut arguments = vec!["diagnose", "arm.xml"];
    arguments.extend(runs[..3].iter().map(String::as_str));
    arguments.extend(["--held-out", &runs[3], "--out", "found"]);
    bench.says(&arguments);
    let text = std::fs::read_to_string(bench.path("found/diagnosis.json")).expect("it is written");
    serde_json::from_str(&text).expect("JSON")
}

fn number(finding: &Value, name: &str) -> (f64, f64) {
    let of = |key: &str| finding["parameters"][name][key].as_f64().expect("a number");
    (of("value"), of("std"))
}

fn found<'d>(diagnosis: &'d Value, channel: &str, classes: &[&str]) -> &'d Value {
    let all = diagnosis["findings"].as_array().expect("a list");
    let is = |f: &&Value| f["channel"] == channel && classes.iter().any(|c| f["class"] == *c);
    all.iter().find(is).unwrap_or_else(|| panic!("{classes:?} on {channel}: {diagnosis}"))
}

#[test]
fn friction_and_a_delay_are_named_without_a_torque() {
    let bench = bench(
        "[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"elbow\"\nmagnitude = 0.4\n\
         smoothing_velocity = 0.01\n[[effect]]\nclass = \"input_delay\"\n\
         channel = \"shoulder_command\"\ndelay = 0.03\n",
    );
    let run = record(&bench, 0);
    let checked = bench.says(&["check", "arm.xml", &run]);
    assert!(checked.contains("elbow_command") && !checked.contains("elbow_torque"), "{checked}");

    let diagnosis = diagnosed(&bench);
    let dry = ["coulomb_friction", "stribeck_friction", "position_friction"];
    let (magnitude, _) = number(found(&diagnosis, "elbow", &dry), "magnitude");
    let (delay, _) = number(found(&diagnosis, "shoulder_command", &["input_delay"]), "delay");
    assert!((magnitude - 0.4).abs() < 0.05 && (delay - 0.03).abs() < 3e-3, "{diagnosis}");
    assert_eq!(diagnosis["findings"].as_array().map(Vec::len), Some(2), "{diagnosis}");

    // What was written stands on the servos of the file, and predicts; the file says what it can.
    let error = |model: &str| {
        let said = bench.says(&["simulate", model, "--like", "servo3.csv", "--json"]);
        let said: Value = serde_json::from_str(&said).expect("JSON");
        said["channels"]["elbow"]["rmse"].as_f64().expect("a number")
    };
    let (before, after) = (error("arm.xml"), error("found/augmented.toml"));
    assert!(after < 6e-4 && before > 5.0 * after, "{before} {after}");
    let written = std::fs::read_to_string(bench.path("found/augmented.xml")).expect("a file");
    assert!(written.contains("frictionloss") && written.contains("input_delay"), "{written}");
    assert!(written.contains("kp=\"25\" kv=\"1\" forcerange=\"-9 9\""), "{written}");
}

/// Dead zone and limit act within a servo, and not on the angle that it is told.
#[test]
fn a_servo_that_does_not_feel_small_errors_and_saturates_is_named() {
    let bench = bench(
        "[[effect]]\nclass = \"dead_zone\"\nchannel = \"elbow_command\"\nhalf_width = 0.03\n\
         [[effect]]\nclass = \"saturation\"\nchannel = \"shoulder_command\"\nlimit = 3.5\n",
    );
    let diagnosis = diagnosed(&bench);
    let dead = found(&diagnosis, "elbow_command", &["dead_zone"]);
    let (half_width, _) = number(dead, "half_width");
    let limited = found(&diagnosis, "shoulder_command", &["saturation"]);
    let (limit, _) = number(limited, "limit");
    assert!((half_width - 0.03).abs() < 3e-3 && (limit - 3.5).abs() < 0.1, "{diagnosis}");
    assert_eq!(dead["parameters"]["half_width"]["unit"], "rad");
    assert_eq!(limited["parameters"]["limit"]["unit"], "N m");
    let again = bench.says(&["simulate", "found/augmented.toml", "--like", "servo3.csv", "--json"]);
    let again: Value = serde_json::from_str(&again).expect("JSON");
    assert!(again["channels"]["elbow"]["rmse"].as_f64() < Some(6e-4), "{again}");
}

/// What a log holds says what drives the joints, and a log of torques is one as before.
#[test]
fn logs_of_torques_are_read_as_before() {
    let bench = bench("");
    let run = record(&bench, 0);
    let text = std::fs::read_to_string(bench.path(&run)).expect("a file");
    std::fs::write(bench.path("torques.csv"), text.replace("_command", "_torque")).expect("a file");
    let checked = bench.says(&["check", "arm.xml", "torques.csv"]);
    assert!(checked.contains("elbow_torque") && !checked.contains("_command"), "{checked}");
    // One joint of each kind.
    std::fs::write(bench.path("both.csv"), text.replace("elbow_command", "elbow_torque"))
        .expect("a file");
    let checked = bench.says(&["check", "arm.xml", "both.csv"]);
    assert!(checked.contains("elbow_torque") && checked.contains("shoulder_command"), "{checked}");
    let rows = bench.says(&["compare", "arm.xml", "truth.toml", &run, "--json"]);
    assert!(rows.contains("elbow"), "{rows}");
}

#[test]
fn a_model_file_with_servos_is_begun_from_commands() {
    let bench = bench("");
    let run = record(&bench, 0);
    let text = std::fs::read_to_string(bench.path(&run)).expect("a file");
    std::fs::write(bench.path("log.csv"), text.replace("elbow_command", "elbow_goal"))
        .expect("a file");
    let said = bench.says(&["init", "arm.xml", "log.csv", "--out", "begun.toml"]);
    assert!(said.contains("elbow_command = elbow_goal"), "{said}");
    assert!(said.contains("with the gains of the robot's file"), "{said}");
    let model = Model::read(&bench.path("begun.toml")).expect("a model");
    let inputs: Vec<&str> = model.inputs.iter().map(|i| &*i.name).collect();
    assert_eq!(inputs, ["shoulder_command", "elbow_command"]);
    let checked = bench.says(&["check", "begun.toml", "log.csv"]);
    assert!(checked.contains("elbow_goal"), "{checked}");

    // A URDF has no gains: they are asked for where the next command reads them.
    assert!(ARM.contains("<robot"));
    let said = bench.says(&["init", "arm.urdf", "log.csv", "--out", "of_urdf.toml"]);
    assert!(said.contains("say kp and kd"), "{said}");
    let written = std::fs::read_to_string(bench.path("of_urdf.toml")).expect("a file");
    assert!(written.contains("# kp = { value = ..., unit = \"N m/rad\""), "{written}");
    let refused = bench.run(&["check", "of_urdf.toml", "log.csv"]);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(said.contains("of_urdf.toml:") && said.contains("needs kp"), "{said}");
}
