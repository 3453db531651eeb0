//! A robot from its own file, through the commands: friction that its URDF leaves out, what it carries and how
//! it stands are named, and written where the next command reads them. An MJCF of the same robot is the
//! same model.

mod bench;
mod refused;
mod servo;
mod written;

use bench::{ARM, Bench, FRICTION};
use lacuna::plants::Model;
use serde_json::Value;

const PAYLOAD: &str = "class = \"payload\"\nchannel = \"lower\"\nmass = 0.3\ncom_x = 0.04\ncom_y = 0.0\n\
    com_z = -0.15\ngyration_radius = 0.02\n";
const TILT: &str = "class = \"base_tilt\"\nchannel = \"base\"\npitch = 0.06\n";
/// What nobody writes into a URDF: on every joint something.
const MANY: &str = "class = \"coulomb_friction\"\nchannel = \"shoulder\"\nmagnitude = 0.5\n\
    smoothing_velocity = 0.02\n[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"elbow\"\n\
    magnitude = 0.3\nsmoothing_velocity = 0.02\n[[effect]]\nclass = \"viscous_friction\"\n\
    channel = \"shoulder\"\ncoefficient = 0.7\n[[effect]]\nclass = \"added_inertia\"\n\
    channel = \"elbow\"\ninertia = 0.03\n";
/// A gear whose flanks rub harder the more they carry.
const LOADED: &str = "class = \"load_friction\"\nchannel = \"elbow\"\nother = \"elbow_torque\"\n\
    magnitude = 0.1\nshare = 0.3\nsmoothing_velocity = 0.02\n";
/// What a light joint's torque goes into.
const LIGHT: &str = "class = \"coulomb_friction\"\nchannel = \"elbow\"\nmagnitude = 0.25\n\
    smoothing_velocity = 0.05\n[[effect]]\nclass = \"viscous_friction\"\nchannel = \"elbow\"\n\
    coefficient = 0.25\n";
/// What begins while the arm is at work.
const STEP: &str = "class = \"step_change\"\nchannel = \"elbow\"\nforce = 0.2\ntime = 2.5\n";
/// What swings on its own spring.
const HUNG: &str = "class = \"hidden_resonance\"\nchannel = \"shoulder\"\nmass = 0.08\n\
    frequency = 5.6\ndamping_ratio = 0.05\n";
/// Rubber that the elbow runs into.
const STOP: &str = "class = \"damped_stop\"\nchannel = \"elbow\"\nstiffness = 400\n\
    dissipation = 0.5\nposition = 0.44\nside = 1\n";

/// An arm that a lift carries.
const LIFT: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 0.05"/><mass value="1.5"/>
    <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.003"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0.1 0 0"/><mass value="0.8"/>
    <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
  <joint name="shoulder" type="prismatic"><parent link="base"/><child link="upper"/>
    <axis xyz="0 0 1"/><limit lower="-9" upper="9" effort="999" velocity="99"/>
    <dynamics damping="2"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
    <axis xyz="0 0 1"/><dynamics damping="0.3"/></joint>
</robot>
"#;
/// What rubs harder on the way up.
const UPWARDS: &str = "class = \"asymmetric_friction\"\nchannel = \"shoulder\"\npositive = 2.4\n\
    negative = 1.0\nsmoothing_velocity = 0.002\n";

/// The one finding of a diagnosis.
fn finding(diagnosis: &Value) -> &Value {
    assert_eq!(diagnosis["verdict"], "missing_physics", "{diagnosis}");
    match diagnosis["findings"].as_array().expect("a list").as_slice() {
        [only] => only,
        all => panic!("{all:?}"),
    }
}

/// A parameter: value, standard deviation.
fn parameter(finding: &Value, name: &str) -> (f64, f64) {
    let number = |key: &str| finding["parameters"][name][key].as_f64().expect("a number");
    (number("value"), number("std"))
}

#[test]
fn friction_that_a_urdf_leaves_out_is_named() {
    let bench = Bench::new(FRICTION);
    let run = bench.record(0);
    let checked = bench.says(&["check", "arm.urdf", &run]);
    assert!(checked.contains("shoulder_torque") && checked.contains("N m"), "{checked}");

    let diagnosis = bench.diagnosed();
    let found = finding(&diagnosis);
    assert_eq!(found["channel"], "elbow");
    // A law of dry friction: that which also knows of position or of standing still holds it as a case.
    let dry = ["coulomb_friction", "position_friction", "stribeck_friction"];
    assert!(dry.iter().any(|class| found["class"] == *class), "{found}");
    assert_eq!(found["parameters"]["magnitude"]["unit"], "N m");
    assert!((parameter(found, "magnitude").0 - 0.35).abs() < 0.03, "{found}");

    // The model that was written is read from its own folder, and predicts.
    bench.assert_predicts(5.0);
}

#[test]
fn an_mjcf_is_the_model_that_its_urdf_is() {
    let bench = Bench::new(FRICTION);
    let run = bench.record(0);
    let checked = bench.says(&["check", "arm.xml", &run]);
    assert!(checked.contains("shoulder_torque") && checked.contains("N m"), "{checked}");
    let (urdf, mjcf) = (bench.error("arm.urdf", &run), bench.error("arm.xml", &run));
    assert!((urdf - mjcf).abs() < 1e-9 * urdf && urdf > 1e-3, "{urdf} {mjcf}");
}

#[test]
fn a_payload_is_named_on_its_link() {
    let bench = Bench::new(PAYLOAD);
    let diagnosis = bench.diagnosed();
    let found = finding(&diagnosis);
    assert_eq!((&found["class"], &found["channel"]), (&"payload".into(), &"lower".into()));
    for (name, truth) in [("mass", 0.3), ("com_x", 0.04), ("com_z", -0.15)] {
        let (value, std) = parameter(found, name);
        assert!((value - truth).abs() < 3.0 * std && std < 0.2 * value.abs(), "{name}: {found}");
    }
    // Along the axes of both joints it could be anywhere.
    assert!(parameter(found, "com_y").1 > 0.05, "{found}");
    assert_eq!(found["parameters"]["mass"]["unit"], "kg");
    let says = found["says"].as_str().expect("a sentence");
    assert!(says.starts_with("A payload on link lower is missing from arm: mass 0."), "{says}");
    bench.assert_predicts(5.0);
}

#[test]
fn a_base_that_is_not_level_is_named() {
    let bench = Bench::new(TILT);
    let diagnosis = bench.diagnosed();
    let found = finding(&diagnosis);
    assert_eq!((&found["class"], &found["channel"]), (&"base_tilt".into(), &"base".into()));
    let (pitch, std) = parameter(found, "pitch");
    assert!((pitch - 0.06).abs() < 3.0 * std && std < 0.005, "{found}");
    // Both joints turn about the y axis: they do not feel what is across.
    assert!(parameter(found, "roll").1 > 0.02, "{found}");
    let says = found["says"].as_str().expect("a sentence");
    assert!(says.starts_with("A tilt of the base is missing from arm"), "{says}");
    bench.assert_predicts(2.0);
}

#[test]
fn a_robot_that_is_as_its_file_says_carries_nothing() {
    let bench = Bench::new("");
    let diagnosis = bench.diagnosed();
    assert_eq!(diagnosis["verdict"], "no_mismatch", "{diagnosis}");
    let written = std::fs::read_to_string(bench.path("found/augmented.urdf")).expect("a file");
    assert_eq!(written, ARM);
}

/// That what the arm lacks that falls without its controller is named, with its parameters as they are, each to a share.
fn assert_named_upright(effect: &str, named: (&str, &str), parameters: [(&str, f64); 2], to: f64) {
    let diagnosis = Bench::new(effect).diagnosed_upright();
    let found = finding(&diagnosis);
    assert_eq!((&found["class"], &found["channel"]), (&named.0.into(), &named.1.into()));
    for (name, truth) in parameters {
        let (value, std) = parameter(found, name);
        assert!((value - truth).abs() < 4.0 * std && std < to * truth, "{name}: {found}");
    }
}

/// Free runs of what falls run away whatever they lack: filters, which do not, find it.
#[test]
fn what_an_arm_lacks_that_falls_without_its_controller_is_named() {
    assert_named_upright(STEP, ("step_change", "elbow"), [("force", 0.2), ("time", 2.5)], 0.02);
}

/// What has a memory the forces that the measured motion needs do not tell: of what falls, filters do.
#[test]
fn what_hangs_on_an_arm_that_falls_without_its_controller_is_named() {
    let parameters = [("mass", 0.08), ("frequency", 5.6)];
    assert_named_upright(HUNG, ("hidden_resonance", "shoulder"), parameters, 0.05);
}

/// A mass that is not quite known can take up most of what differs between the ways up and down: it is told all the same, as
/// one law or as two.
#[test]
fn a_lift_that_rubs_harder_on_the_way_up() {
    let diagnosis = Bench::of(LIFT, UPWARDS, 0.0).diagnosed_upright();
    let all = diagnosis["findings"].as_array().expect("a list");
    let of = |class: &str| all.iter().find(|f| f["class"] == class && f["channel"] == "shoulder");
    let (up, down) = match (of("asymmetric_friction"), of("coulomb_friction"), of("constant_force"))
    {
        (Some(one), None, None) => (parameter(one, "positive").0, parameter(one, "negative").0),
        (None, Some(rubs), Some(force)) => {
            let (mean, force) = (parameter(rubs, "magnitude").0, parameter(force, "force").0);
            (mean - force, mean + force)
        }
        _ => panic!("{all:?}"),
    };
    assert!((up - 2.4).abs() < 0.05 && (down - 1.0).abs() < 0.05, "{up} {down}");
}

/// A search that adds one effect a round would begin far from such a machine.
#[test]
fn what_all_joints_lack_is_named_together() {
    let bench = Bench::new(MANY);
    let diagnosis = bench.diagnosed();
    let all = diagnosis["findings"].as_array().expect("a list");
    let mut named = vec![];
    for (class, channel, size, truth) in [
        ("coulomb_friction", "shoulder", "magnitude", 0.5),
        ("coulomb_friction", "elbow", "magnitude", 0.3),
        ("viscous_friction", "shoulder", "coefficient", 0.7),
        ("added_inertia", "elbow", "inertia", 0.03),
    ] {
        let found = all.iter().find(|f| f["class"] == class && f["channel"] == channel);
        let found = found.unwrap_or_else(|| panic!("{class} on {channel}: {diagnosis}"));
        let (value, std) = parameter(found, size);
        assert!((value - truth).abs() < 4.0 * std && std < 0.1 * truth, "{found}");
        named.push(found);
    }
    assert_eq!(named.len(), all.len(), "{diagnosis}");
    bench.assert_predicts(5.0);
}

/// The forces that the measured motion needs show dry friction; that it grows with the load shows in what it leaves.
#[test]
fn friction_that_grows_with_the_load_is_named() {
    let diagnosis = Bench::new(LOADED).diagnosed();
    let found = finding(&diagnosis);
    assert_eq!((&found["law"], &found["channel"]), (&"load_friction".into(), &"elbow".into()));
    for (name, value) in [("magnitude", 0.1), ("share", 0.3)] {
        let (estimate, std) = parameter(found, name);
        assert!((estimate - value).abs() < 4.0 * std + 0.05 * value, "{name}: {estimate} {std}");
    }
}

/// Of a joint that its file says needs hardly a torque, a law that silences the actuator would leave as little as
/// its friction does.
#[test]
fn a_light_joint_with_friction_has_no_wrong_actuator() {
    let light = ARM.replace("mass value=\"0.8\"", "mass value=\"0.02\"").replace(
        "ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.001\"",
        "ixx=\"2e-4\" ixy=\"0\" ixz=\"0\" iyy=\"2e-4\" iyz=\"0\" izz=\"2e-4\"",
    );
    let light = light.replace("damping=\"0.3\"", "damping=\"0.0\"");
    let bench = Bench::of(&light, LIGHT, 0.03);
    let diagnosis = bench.diagnosed();
    let all = diagnosis["findings"].as_array().expect("a list");
    let on_elbow = |f: &&Value| f["channel"].as_str().is_some_and(|c| c.starts_with("elbow"));
    let elbow: Vec<&Value> = all.iter().filter(on_elbow).collect();
    assert!(!elbow.is_empty(), "{diagnosis}");
    for found in &elbow {
        assert_eq!(found["channel"], "elbow", "{found}");
    }
    assert!(elbow.iter().any(|f| f["class"] == "viscous_friction"), "{diagnosis}");
    // What is driven as it is follows; what hardly anything drives would not.
    let error = |model| bench.error(model, "run3.csv");
    let (before, after) = (error("arm.urdf"), error("found/augmented.toml"));
    assert!(before > 100.0 * after, "{before} {after}");
}

/// A stiff stop hangs on where it stands, and the motion that is smoothed where a joint runs into it is the least
/// right: neither what is left of it is a further law, nor is it a random force.
#[test]
fn a_stiff_stop_that_dissipates_has_no_company() {
    let bench = Bench::new(STOP);
    let diagnosis = bench.diagnosed();
    let found = finding(&diagnosis);
    assert_eq!((&found["class"], &found["channel"]), (&"end_stop".into(), &"elbow".into()));
    for (name, truth) in [("stiffness", 400.0), ("dissipation", 0.5), ("position", 0.44)] {
        let (value, _) = parameter(found, name);
        assert!((value - truth).abs() < 0.1 * truth, "{name}: {found}");
    }
    bench.assert_predicts(5.0);
}

/// What is recorded under other names is found, what is not recorded is held still, and nothing is written over.
#[test]
fn a_model_file_is_begun_from_a_robot_and_a_recording() {
    let bench = Bench::new("");
    let run = bench.record(0);
    let recorded = std::fs::read_to_string(bench.path(&run)).expect("a file");
    let renamed = recorded.replacen("t,shoulder,elbow,", "time,q_shoulder,other,", 1);
    let renamed = renamed.replacen("shoulder_torque,elbow_torque", "shoulder_effort,more", 1);
    std::fs::write(bench.path("log.csv"), renamed).expect("a file");
    let said = bench.says(&["init", "arm.urdf", "log.csv"]);
    assert!(said.contains("elbow: not in log.csv, held still"), "{said}");
    assert!(said.contains("columns that no joint explains: other, more"), "{said}");
    let model = Model::read(&bench.path("arm.toml")).expect("a model");
    assert_eq!((model.coordinates.len(), &*model.coordinates[0].name), (1, "shoulder"));
    let columns: Vec<&str> = model.measurements.iter().map(|m| &*m.column).collect();
    assert_eq!(columns, ["q_shoulder", "shoulder_effort"]);
    let checked = bench.says(&["check", "arm.toml", "log.csv"]);
    assert!(checked.contains("shoulder_effort"), "{checked}");

    let again = bench.run(&["init", "arm.urdf", "log.csv"]);
    let said = String::from_utf8_lossy(&again.stderr).into_owned();
    assert!(!again.status.success() && said.contains("--out"), "{said}");
    std::fs::write(bench.path("none.csv"), "t,a,b\n0,1,2\n1,2,3\n").expect("a file");
    let none = bench.run(&["init", "arm.urdf", "none.csv", "--out", "none.toml"]);
    let said = String::from_utf8_lossy(&none.stderr).into_owned();
    assert!(said.contains("shoulder, elbow") && said.contains("a, b"), "{said}");
    assert!(!bench.path("none.toml").exists());
}
