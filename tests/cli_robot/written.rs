//! What is found stands in the robot's own file as well, for the simulators that read it: `augmented.urdf`,
//! `augmented.xml`.

use crate::bench::{ARM, Bench};
use lacuna::discrepancy::robot_file::{Augmented, augmented};
use lacuna::excitation::{SinusoidRanges, SumOfSinusoids, rng};
use lacuna::plants::model::Augmentation;
use lacuna::plants::{Model, SampledInput, System, rk4};
use lacuna::rigid;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// Seconds from sample to sample, steps between them, samples.
const STEP: f64 = 0.01;
const SUBSTEPS: usize = 20;
const SAMPLES: usize = 600;

const VISCOUS: &str = "class = \"viscous_friction\"\nchannel = \"shoulder\"\ncoefficient = 0.25\n";
const DRY: &str = "class = \"coulomb_friction\"\nchannel = \"elbow\"\nmagnitude = 0.35\nsmoothing_velocity = 0.01\n";
const PAYLOAD: &str = "class = \"payload\"\nchannel = \"lower\"\nmass = 0.3\ncom_x = 0.04\ncom_y = 0.02\n\
    com_z = -0.15\ngyration_radius = 0.02\n";
/// What a URDF has no place for.
const FURTHER: [&str; 5] = [
    "class = \"added_inertia\"\nchannel = \"elbow\"\ninertia = 0.02\n",
    "class = \"linear_stiffness\"\nchannel = \"shoulder\"\nstiffness = 1.5\n",
    "class = \"constant_force\"\nchannel = \"shoulder\"\nforce = 0.4\n",
    "class = \"base_tilt\"\nchannel = \"base\"\nroll = 0.03\npitch = 0.06\n",
    "class = \"gain_error\"\nchannel = \"elbow_torque\"\ngain = 0.9\n",
];
const PARAMETERS: &str = "[parameters]\n\"lower.mass\" = { value = 0.85, unit = \"kg\" }\n\
    \"lower.com_z\" = { value = -0.11, unit = \"m\" }\n";

/// A model of a robot with effects, beside it in a bench.
fn model(bench: &Bench, file: &str, effects: &[&str]) -> Model {
    let effects: String = effects.iter().map(|e| format!("[[effect]]\n{e}")).collect();
    let text = format!("name = \"arm\"\n[robot]\nfile = \"{file}\"\n{PARAMETERS}{effects}");
    std::fs::write(bench.path("model.toml"), text).expect("a file");
    Model::read(&bench.path("model.toml")).expect("a model")
}

/// The robot's own file, of a model that has what it has.
fn written(bench: &Bench, file: &str, effects: &[&str]) -> (Model, Augmented) {
    let model = model(bench, file, effects);
    let file = augmented(&model, &Augmentation::default(), &[]).expect("a robot");
    let file = file.expect("its own file");
    std::fs::write(bench.path(&file.name), &file.text).expect("a file");
    (model, file)
}

/// A Python that knows MuJoCo; none where there is none, which is said.
fn mujoco() -> Option<String> {
    let python = std::env::var("LACUNA_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let knows = Command::new(&python).args(["-c", "import mujoco"]).output();
    if knows.is_ok_and(|o| o.status.success()) {
        return Some(python);
    }
    eprintln!("skipped: {python} does not know mujoco (pip install mujoco; LACUNA_PYTHON=...)");
    None
}

/// Greatest difference of a coordinate from what MuJoCo says of a file, and its greatest change, on a motion
/// that begins at rest.
fn difference(python: &str, model: &Model, file: &Path) -> (f64, f64) {
    let ranges = SinusoidRanges {
        amplitude: 0.3..=1.2,
        angular_frequency: 0.7..=7.0,
        phase: 0.0..=std::f64::consts::TAU,
    };
    let drive = SumOfSinusoids::random(&mut rng(77, 9), 2, 4, &ranges).expect("ranges");
    let times: Vec<f64> = (0..SAMPLES).map(|k| STEP * k as f64).collect();
    let torques = drive.sample(&times);
    let effective = model.effective_inputs(&times, &torques);
    let input = SampledInput { times: &times, values: &effective, hold: model.hold };
    let system = System::new(model);
    let start = [0.1, -0.2];
    let rest = system.at_rest(&[start[0], start[1], 0.0, 0.0]);
    let ours = rk4(&system, &rest, &input, &times, STEP / SUBSTEPS as f64).expect("a motion");
    let names: Vec<&str> = model.coordinates.iter().map(|c| &*c.name).collect();
    let mut asked = format!("{}\n{} {}\n", names.join(" "), start[0], start[1]);
    for torque in torques.chunks_exact(2) {
        asked += &format!("{:e} {:e}\n", torque[0], torque[1]);
    }
    let said = run(python, file, &asked);
    assert_eq!(said.lines().count(), SAMPLES);
    let (mut worst, mut size) = (0.0f64, 0.0f64);
    for (k, line) in said.lines().enumerate() {
        for (joint, theirs) in line.split(' ').enumerate() {
            let (ours, theirs) = (ours.state(k)[joint], theirs.parse::<f64>().expect("a number"));
            worst = worst.max((ours - theirs).abs());
            size = size.max((ours - start[joint]).abs());
        }
    }
    (worst, size)
}

fn run(python: &str, file: &Path, asked: &str) -> String {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/cli_robot/mujoco_run.py");
    let mut child = Command::new(python)
        .arg(script)
        .arg(file)
        .args([STEP.to_string(), SUBSTEPS.to_string()])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("python starts");
    let mut to = child.stdin.take().expect("a pipe");
    let asked = asked.to_owned();
    let tell = std::thread::spawn(move || to.write_all(asked.as_bytes()).expect("it listens"));
    let said = child.wait_with_output().expect("it answers");
    tell.join().expect("it was told");
    assert!(said.status.success(), "{}", std::fs::read_to_string(file).unwrap_or_default());
    String::from_utf8(said.stdout).expect("text")
}

#[test]
fn what_a_file_cannot_say_is_told_and_the_rest_is_written() {
    let bench = Bench::new("");
    let mut effects = vec![VISCOUS, DRY, PAYLOAD];
    effects.extend(FURTHER);
    let (_, urdf) = written(&bench, "arm.urdf", &effects);
    let left: Vec<&str> = urdf.left_out.iter().map(|l| &*l.what).collect();
    assert_eq!(
        left,
        [
            "stiffness of joint shoulder",
            "rotor inertia of joint elbow",
            "gain of joint elbow",
            "gravity on the base"
        ],
        "{}",
        urdf.text
    );
    assert_eq!(urdf.name, "augmented.urdf");
    let robot = rigid::read(&urdf.text).expect("a robot");
    let joint = |name| robot.joint(name).expect("a joint");
    assert_eq!((joint("shoulder").damping, joint("elbow").friction), (0.6 + 0.25, 0.35));
    let lower = robot.links.iter().find(|l| l.name == "lower").expect("a link");
    assert!((lower.inertia.mass - 1.15).abs() < 1e-14);
    let (_, mjcf) = written(&bench, "arm.xml", &effects);
    assert_eq!((&*mjcf.name, mjcf.left_out.len()), ("augmented.xml", 0), "{}", mjcf.text);
    // Where nothing is new, nothing is changed.
    let same = Model::read(&bench.path("arm.urdf")).expect("a model");
    let same = augmented(&same, &Augmentation::default(), &[]).expect("a robot").expect("a file");
    assert_eq!((same.text.as_str(), same.left_out.len()), (ARM, 0));
}

/// What is told of a link that is fixed to another stands at that link, whatever the other is told of.
#[test]
fn of_a_fixed_link_that_is_told_apart_its_own_is_written() {
    let bench = Bench::new("");
    let tool = r#"  <link name="tool"><inertial><origin xyz="0.01 0 0.02"/><mass value="0.2"/>
    <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial></link>
  <joint name="flange" type="fixed"><parent link="lower"/><child link="tool"/>
    <origin xyz="0 0.05 -0.2" rpy="0.4 0 -0.3"/></joint>
</robot>"#;
    let arm = ARM.replace("</robot>", tool);
    std::fs::write(bench.path("arm.urdf"), &arm).expect("a file");
    let believed = format!("{PARAMETERS}\"tool.mass\" = {{ value = 0.27, unit = \"kg\" }}\n");
    let text = format!("name = \"arm\"\n[robot]\nfile = \"arm.urdf\"\n{believed}");
    std::fs::write(bench.path("model.toml"), text).expect("a file");
    let model = Model::read(&bench.path("model.toml")).expect("a model");
    let file = augmented(&model, &Augmentation::default(), &[]).expect("a robot").expect("a file");
    assert_eq!(file.left_out, []);
    let mass = |text: &str, link: &str| {
        let robot = rigid::read(text).expect("a robot");
        robot.links.iter().find(|l| l.name == link).expect("a link").inertia.mass
    };
    for (link, expected) in [("upper", 1.5), ("lower", 0.85), ("tool", 0.27)] {
        assert!((mass(&file.text, link) - expected).abs() < 1e-14, "{link}: {}", file.text);
    }
}

/// No law of these files holds what a peak or a direction is beside its magnitude.
#[test]
fn of_a_law_that_says_more_the_part_that_is_said_is_written() {
    let bench = Bench::new("");
    let more =
        "class = \"asymmetric_friction\"\nchannel = \"elbow\"\npositive = 0.3\nnegative = 0.5\n";
    let none = "class = \"cubic_stiffness\"\nchannel = \"elbow\"\nstiffness = 0.2\n";
    let (_, urdf) = written(&bench, "arm.urdf", &[more, none]);
    let elbow = rigid::read(&urdf.text).expect("a robot").joint("elbow").expect("a joint").friction;
    assert_eq!(elbow, 0.4);
    let lost = "the difference between the directions (asymmetric_friction on elbow)";
    let left: Vec<&str> = urdf.left_out.iter().map(|l| &*l.what).collect();
    assert_eq!(left, [lost, "cubic_stiffness on elbow"]);
    let numbers = format!("{lost}: positive 0.300 N m, negative 0.500 N m: a URDF has no place");
    assert!(urdf.text.contains(&numbers), "{}", urdf.text);
}

#[test]
fn mujoco_moves_what_is_written_as_the_augmented_model_moves() {
    let Some(python) = mujoco() else { return };
    // Motors of gear 1 get torques themselves.
    let bench = Bench::new("");
    let plain = std::fs::read_to_string(bench.path("arm.xml")).expect("a file");
    std::fs::write(bench.path("arm.xml"), plain.replace("gear=\"50\"", "")).expect("a file");
    let all = [&[VISCOUS, PAYLOAD][..], &FURTHER].concat();
    for (file, effects) in [("arm.urdf", &[VISCOUS, PAYLOAD][..]), ("arm.xml", &all)] {
        let (model, file) = written(&bench, file, effects);
        assert_eq!(file.left_out, [], "{}", file.text);
        let (worst, size) = difference(&python, &model, &bench.path(&file.name));
        println!("{}: {worst:.1e} rad of {size:.2} rad", file.name);
        assert!(worst < 1e-11 && size > 0.5, "{worst:e} of {size}");
    }
    // Dry friction is a constraint there and steep, not infinitely so, here.
    for file in ["arm.urdf", "arm.xml"] {
        let (model, file) = written(&bench, file, &[VISCOUS, PAYLOAD, DRY]);
        let (worst, size) = difference(&python, &model, &bench.path(&file.name));
        println!("{} with dry friction: {worst:.1e} rad of {size:.2} rad", file.name);
        assert!(worst < 0.02 * size && size > 0.5, "{worst:e} of {size}");
    }
}

/// Through the command: what it finds is in the file that it writes, with how sure that is.
#[test]
fn friction_that_is_found_is_written_into_the_file() {
    let bench = Bench::new(&format!("{VISCOUS}\n[[effect]]\n{DRY}"));
    let diagnosis = bench.diagnosed();
    let text = std::fs::read_to_string(bench.path("found/augmented.urdf")).expect("a file");
    let robot = rigid::read(&text).expect("a robot");
    let joint = |name: &str| robot.joint(name).expect("a joint");
    let (damping, friction) = (joint("shoulder").damping, joint("elbow").friction);
    assert!((damping - 0.85).abs() < 0.05 && (friction - 0.35).abs() < 0.03, "{text}");
    let found = Model::read(&bench.path("found/augmented.toml")).expect("a model");
    let magnitude = found.effects.iter().find(|e| e.channel == 1).expect("on the elbow");
    assert_eq!(friction, magnitude.parameters[0], "{diagnosis}");
    assert!(text.contains("<!-- lacuna: damping 0.8") && text.contains("probability"), "{text}");
    // All else is the engineer's own.
    let mut rest = text.as_str();
    for kept in [
        ARM.split_once("    <axis").expect("the first joint").0,
        "    <axis xyz=\"0 1 0\"/>",
        "<dynamics damping=\"0.",
        "\"/></joint>\n  <joint name=\"elbow\"",
        "</robot>\n",
    ] {
        let at = rest.find(kept).unwrap_or_else(|| panic!("{kept}\n{text}"));
        rest = &rest[at + kept.len()..];
    }
    let Some(python) = mujoco() else { return };
    let (worst, size) = difference(&python, &found, &bench.path("found/augmented.urdf"));
    println!("found/augmented.urdf: {worst:.1e} rad of {size:.2} rad");
    assert!(worst < 0.02 * size, "{worst:e} of {size}");
}
