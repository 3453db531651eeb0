//! What a robot carries and how it stands: a payload is mass that its file might have had, a tilt is
//! another gravity.

mod support;

use lacuna_effects::Acts;
use lacuna_numbers::{Dual, Number};
use lacuna_plants::model::{Augmentation, Direction, NewEffect, StepInput};
use lacuna_plants::{Model, Plant, Substeps, System};
use support::Folder;

/// A column that turns, two links askew, a slide, and a tool that is fixed to it.
const ARM: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="column"><inertial><origin xyz="0 0.01 0.1"/><mass value="3"/>
    <inertia ixx="0.03" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.01"/></inertial></link>
  <link name="upper"><inertial><origin xyz="0.02 0 -0.2"/><mass value="2"/>
    <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.003"/></inertial></link>
  <link name="slider"><inertial><origin xyz="0.01 0 -0.1" rpy="0.1 0.2 0.3"/><mass value="MASS"/>
    <inertia ixx="0.01" ixy="0" ixz="0.001" iyy="0.01" iyz="0" izz="0.001"/></inertial></link>
  PAYLOAD
  <link name="tool"><inertial><origin xyz="0 0 0"/><mass value="0.5"/>
    <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial></link>
  <joint name="pan" type="continuous"><parent link="base"/><child link="column"/>
    <origin xyz="0 0 0.1" rpy="0.05 0 0"/><axis xyz="0 0 1"/><dynamics damping="0.4" friction="0.2"/></joint>
  <joint name="elbow" type="continuous"><parent link="column"/><child link="upper"/>
    <origin xyz="0 0 0.4" rpy="0.3 0.2 0.1"/><axis xyz="0 0.6 0.8"/></joint>
  <joint name="slide" type="prismatic"><parent link="upper"/><child link="slider"/>
    <origin xyz="0 0.1 -0.2"/><axis xyz="0.6 0 -0.8"/>
    <limit lower="0" upper="1" effort="9" velocity="9"/></joint>
  <joint name="mount" type="fixed"><parent link="slider"/><child link="tool"/><origin xyz="0 0 -0.1"/></joint>
</robot>
"#;

const CARRIED: &str = r#"<link name="carried"><inertial><origin xyz="0.05 -0.04 0.1"/><mass value="0.9"/>
    <inertia ixx="0.00081" ixy="0" ixz="0" iyy="0.00081" iyz="0" izz="0.00081"/></inertial></link>
  <joint name="grip" type="fixed"><parent link="LINK"/><child link="carried"/></joint>"#;

/// The arm with a payload in its own file, on this link, and with more text in its model's.
fn arm(carrying: Option<&str>, more: &str) -> Result<Model, String> {
    arm_in(&Folder::new(), carrying, more)
}

fn arm_in(folder: &Folder, carrying: Option<&str>, more: &str) -> Result<Model, String> {
    let carried = carrying.map_or(String::new(), |link| CARRIED.replace("LINK", link));
    folder.write("arm.urdf", ARM.replace("MASS", "1").replace("PAYLOAD", &carried));
    folder.model(&format!("name = \"arm\"\n[robot]\nfile = \"arm.urdf\"\n{more}"))
}

fn payload(link: &str) -> String {
    format!(
        "[[effect]]\nclass = \"payload\"\nchannel = \"{link}\"\nmass = {{ value = 900, unit = \"g\" }}\n\
         com_x = 0.05\ncom_y = -0.04\ncom_z = 0.1\ngyration_radius = 0.03\n"
    )
}

fn tilt(roll: f64, pitch: f64) -> String {
    format!(
        "[[effect]]\nclass = \"base_tilt\"\nchannel = \"base\"\nroll = {roll}\npitch = {pitch}\n"
    )
}

/// Rates of a state that has nothing to do with any symmetry.
fn rates(model: &Model) -> Vec<f64> {
    let mut rates = vec![0.0; 6];
    System::new(model).derivative(0.0, &STATE, &[0.8, -1.1, 2.0], &mut rates);
    rates
}

const STATE: [f64; 6] = [0.7, -0.4, 0.15, 0.9, -1.3, 0.6];

fn assert_alike(a: &[f64], b: &[f64]) {
    for (x, y) in a.iter().zip(b) {
        assert!((x - y).abs() < 1e-12 * (1.0 + x.abs()), "{a:?} {b:?}");
    }
}

#[test]
fn a_payload_moves_as_mass_that_the_file_has() {
    let plain = rates(&arm(None, "").expect("a model"));
    for link in ["column", "upper", "slider"] {
        let in_file = rates(&arm(Some(link), "").expect("a model"));
        let as_effect = rates(&arm(None, &payload(link)).expect("a model"));
        assert_alike(&in_file, &as_effect);
        assert!(plain.iter().zip(&as_effect).any(|(a, b)| (a - b).abs() > 0.01), "{link}");
    }
    // Two of them, and one beside friction.
    let friction =
        "[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"elbow\"\nmagnitude = 0.3\n";
    let both = format!("{}{friction}{}", payload("upper"), payload("slider"));
    let two = rates(&arm(None, &both).expect("a model"));
    let mixed = format!("{friction}{}", payload("slider"));
    assert_alike(&rates(&arm(Some("upper"), &mixed).expect("a model")), &two);
}

/// A base that is turned by roll about x and then by pitch about y sees gravity turned back.
#[test]
fn a_tilt_is_another_gravity() {
    for (roll, pitch) in [(0.2, 0.0), (0.0, -0.3), (0.2, -0.3)] {
        let tilted = rates(&arm(None, &tilt(roll, pitch)).expect("a model"));
        let (r, p): (f64, f64) = (roll, pitch);
        let gravity = [9.81 * p.sin(), -9.81 * p.cos() * r.sin(), -9.81 * p.cos() * r.cos()]
            .map(|g| g.to_string());
        let turned = format!("gravity = [{}]\n", gravity.join(", "));
        assert_alike(&rates(&arm(None, &turned).expect("a model")), &tilted);
    }
    // It keeps all of gravity, and beside a payload the payload's weight is tilted as well.
    let both = format!("{}{}", tilt(0.1, 0.2), payload("slider"));
    let both = rates(&arm(None, &both).expect("a model"));
    assert_alike(&rates(&arm(Some("slider"), &tilt(0.1, 0.2)).expect("a model")), &both);
}

/// The state after some steps, with derivatives by every parameter of both effects, against differences.
#[test]
fn derivatives_are_exact() {
    let text = format!("{}{}", payload("slider"), tilt(0.1, -0.2));
    let model = arm(None, &text).expect("a model");
    let directions: Vec<(Direction, usize)> =
        (0..7).map(|k| (Direction::Effect(usize::from(k > 4), k % 5), k)).collect();
    let parameters = model.values();
    let system = System::along(&model, &parameters, &model.effects, &directions, 0.01);
    let mut along: Vec<Dual> = STATE.iter().map(|x| Dual::constant(*x)).collect();
    let torques = [0.8, -1.1, 2.0];
    let inputs = torques.map(Dual::constant);
    let (mut w, steps) = (system.workspace(), Substeps::even(4));
    system.advance(&mut w, (0.0, 0.02), StepInput::Line(&inputs, &inputs), steps, &mut along);
    for (direction, lane) in directions {
        let Direction::Effect(effect, parameter) = direction else { panic!() };
        let moved = |by: f64| {
            let mut effects = model.effects.clone();
            effects[effect].parameters[parameter] += by;
            let system = System::with(&model, &parameters, &effects);
            let (mut w, mut state) = (system.workspace(), STATE.to_vec());
            let line = StepInput::Line(&torques, &torques);
            system.advance(&mut w, (0.0, 0.02), line, steps, &mut state);
            state
        };
        const STEP: f64 = 1e-5;
        let mut largest = 0.0f64;
        for ((above, below), exact) in moved(STEP).iter().zip(moved(-STEP)).zip(&along) {
            let slope = (above - below) / (2.0 * STEP);
            assert!((slope - exact.tangent[lane]).abs() < 1e-7, "{direction:?}");
            largest = largest.max(slope.abs());
        }
        assert!(largest > 1e-4, "{direction:?} does nothing");
    }
}

/// What is written of a diagnosis is read as it was found.
#[test]
fn they_are_written_and_read() {
    let text = format!("{}{}", payload("upper"), tilt(0.1, -0.2));
    // What is written names the robot's own file.
    let folder = Folder::new();
    let with = arm_in(&folder, None, &text).expect("a model");
    let effects = with.effects.iter().map(|e| NewEffect::of(&with, e)).collect();
    let plain = arm_in(&folder, None, "").expect("a model");
    let augmentation = Augmentation { parameters: vec![], effects };
    let written = plain.augmented_text(&augmentation).expect("text");
    let again = Model::from_text(&written, "/nowhere/augmented.toml").expect("a model");
    assert_alike(&rates(&with), &rates(&again));
    let units: Vec<&str> = written.lines().filter(|l| l.contains("unit")).collect();
    assert!(units[0].contains("\"kg\"") && units[1].contains("\"m\""), "{written}");
    assert!(written.contains("channel = \"upper\"") && written.contains("channel = \"base\""));
}

#[test]
fn mistakes_are_told() {
    let cases = [
        (payload("wrist"), "expected one of column, upper, slider"),
        (payload("elbow"), "expected one of column, upper, slider"),
        (payload("tool"), "'tool' is fixed to link 'slider'"),
        (payload("upper").replace("value = 900", "value = -900"), "mass"),
        (tilt(0.1, 0.1).replace("\"base\"", "\"column\""), "expected one of base"),
    ];
    for (text, words) in cases {
        let said = arm(None, &text).expect_err(words);
        assert!(said.contains(words) && said.contains("model.toml:"), "{said}");
    }
    let plain = "name = \"p\"\n[[input]]\nname = \"u\"\nunit = \"N\"\n[[coordinate]]\nname = \"x\"\n\
        velocity = \"v\"\nunit = \"m\"\n[mechanics]\nmass = [[\"2\"]]\nforce = [\"u\"]\n";
    let said =
        Model::from_text(&format!("{plain}{}", payload("x")), "p.toml").expect_err("no robot");
    assert!(said.to_string().contains("[robot]"), "{said}");
}

/// What turns about the vertical alone shows no more of a payload than a rotor would.
#[test]
fn a_payload_is_told_where_it_does_what_no_rotor_can() {
    let model = arm(None, "").expect("a model");
    // Its axis is not quite vertical.
    assert!(model.tells_structure(Acts::Links, 0) && model.tells_structure(Acts::Links, 1));
    let upright = "gravity = [0, 0.48999, -9.797]\n";
    let along: f64 = 9.797 * 0.05f64.tan();
    let upright = arm(None, &upright.replace("0.48999", &format!("{along:.15}")));
    let upright = upright.expect("a model");
    assert!(!upright.tells_structure(Acts::Links, 0), "gravity is along the column's axis");
    assert!(upright.tells_structure(Acts::Links, 1) && upright.tells_structure(Acts::Base, 0));
}

/// What a link carries is borne by the joints that carry the link.
#[test]
fn joints_bear_what_stands_on_them() {
    let model = arm(None, &payload("upper")).expect("a model");
    let e = &model.effects[0];
    assert_eq!(model.effect_channel_name(e.effect, e.channel), "upper");
    assert_eq!(model.joints_under(e.effect.acts, e.channel), [0, 1]);
    let tilted = arm(None, &tilt(0.1, 0.1)).expect("a model");
    assert_eq!(tilted.joints_under(tilted.effects[0].effect.acts, 0), [0, 1, 2]);
}
