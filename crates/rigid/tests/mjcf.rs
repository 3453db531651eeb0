//! What is read of an MJCF file, and what is wrong with those that cannot be.

mod support;

use lacuna_excitation::rng;
use lacuna_rigid::{GRAVITY, JointKind, Moves, mjcf};
use rand::RngExt;
use std::f64::consts::{FRAC_PI_2, PI};
use support::mjcf::drawn_mjcf;
use support::{Wrong, assert_refused, mass_and_bias};

const ARM: &str = r#"<mujoco model="arm">
  <compiler autolimits="true"/>
  <default>
    <joint damping="0.4"/>
    <default class="elbows"><joint axis="0 2 0" stiffness="3" springref="90"/></default>
  </default>
  <worldbody>
    <body name="base">
      <geom type="mesh" mesh="base"/>
      <body name="upper">
        <inertial pos="0 0 0.2" mass="2" diaginertia="0.02 0.02 0.003"/>
        <geom type="mesh" mesh="upper"/>
        <joint name="shoulder" axis="0 1 0" frictionloss="0.1"/>
        <body name="lower" pos="0 0 0.4" childclass="elbows">
          <geom name="rod" type="cylinder" size="0.1 0.3" mass="1"/>
          <joint name="elbow" armature="0.5"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"#;

#[test]
fn an_arm_is_read() {
    let robot = mjcf::read(ARM).expect("a robot");
    assert_eq!((&*robot.name, robot.gravity), ("arm", Some(GRAVITY)));
    assert_eq!(robot.movable(), ["shoulder", "elbow"]);
    let [shoulder, elbow] = ["shoulder", "elbow"].map(|name| robot.joint(name).expect("a joint"));
    assert_eq!((shoulder.damping, shoulder.friction, shoulder.stiffness), (0.4, 0.1, 0.0));
    assert_eq!((elbow.damping, elbow.armature, elbow.axis), (0.4, 0.5, [0.0, 1.0, 0.0]));
    assert_eq!((elbow.stiffness, elbow.spring_reference), (3.0, FRAC_PI_2));
    let tree = robot.tree(&[]).expect("a tree");
    let names: Vec<_> = tree.bodies.iter().map(|b| (&*b.name, b.parent)).collect();
    assert_eq!(names, [("upper", None), ("lower", Some(0))]);
    // The rod: m (r^2 / 4 + h^2 / 12) about its middle, where the elbow is.
    let (mass, _) = mass_and_bias(&tree, &[0.0; 4], GRAVITY);
    let rod = 0.01 / 4.0 + 0.36 / 12.0;
    let upright = [0.02 + 2.0 * 0.04 + rod + 0.16, rod, rod, rod];
    for (found, expected) in mass.iter().zip(upright) {
        assert!((found - expected).abs() < 1e-15, "{mass:?}");
    }
    let (_, bias) = mass_and_bias(&tree, &[FRAC_PI_2, 0.0, 0.0, 0.0], GRAVITY);
    assert!((bias[0] + 9.81 * (2.0 * 0.2 + 0.4)).abs() < 1e-12, "{bias:?}");
}

/// A joint beside the body's origin, whose coordinate is not 0 where the file places the body.
#[test]
fn anchors_and_references() {
    let text = r#"<mujoco><compiler angle="radian"/><option gravity="0 -2 0"/><worldbody>
        <body name="flap"><joint name="hinge" pos="-0.5 0 0" ref="1"/>
          <inertial pos="0 0 0" mass="3" diaginertia="1 1 1"/></body></worldbody></mujoco>"#;
    let robot = mjcf::read(text).expect("a robot");
    let gravity = robot.gravity.expect("it is stated");
    let tree = robot.tree(&[]).expect("a tree");
    // Parameters are told in the body's own frame.
    assert_eq!(tree.bodies[0].inertia.centre, [0.0; 3]);
    for angle in [0.0f64, 1.0, 2.5] {
        let (mass, bias) = mass_and_bias(&tree, &[angle, 0.7], gravity);
        assert!((mass[0] - (1.0 + 3.0 * 0.25)).abs() < 1e-14, "{mass:?}");
        assert!((bias[0] - 3.0 * 2.0 * 0.5 * (angle - 1.0).cos()).abs() < 1e-14, "{bias:?}");
    }
}

#[test]
fn several_joints_are_a_chain_of_links_without_mass() {
    let text = r#"<mujoco><worldbody><body><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
        <joint/><geom size="0.1" density="1e3"/></body></worldbody></mujoco>"#;
    let tree = mjcf::read(text).expect("a robot").tree(&[]).expect("a tree");
    let names: Vec<_> = tree.bodies.iter().map(|b| (&*b.name, &*b.joint.name)).collect();
    let expected = [("body1/joint0", "joint0"), ("body1/joint1", "joint1"), ("body1", "joint2")];
    assert_eq!(names, expected);
    let kinds = [JointKind::Prismatic, JointKind::Prismatic, JointKind::Revolute];
    assert!(tree.bodies.iter().zip(kinds).all(|(b, kind)| b.joint.kind == kind));
    assert!(tree.moved().iter().all(|inertia| *inertia > 0.0));
    let m = 4.0 / 3.0 * PI;
    let (mass, _) = mass_and_bias(&tree, &[0.0; 6], GRAVITY);
    let expected = [m, 0.0, 0.0, 0.0, m, 0.0, 0.0, 0.0, 0.4 * m * 0.01];
    for (found, expected) in mass.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-14, "{mass:?}");
    }
}

/// One body on a hinge; settings of `<compiler>` and what it weighs by them, about z.
#[test]
fn the_compiler_says_what_bodies_weigh() {
    let cases = [
        ("", 2.0, 0.5),
        ("boundmass=\"3\"", 3.0, 0.5),
        ("boundinertia=\"0.7\"", 2.0, 0.7),
        ("boundinertia=\"0.01\" balanceinertia=\"true\"", 2.0, (0.1 + 0.1 + 0.5) / 3.0),
        ("inertiafromgeom=\"true\"", 8.0, 8.0 * 2.0 * 0.01 / 3.0),
        ("inertiafromgeom=\"true\" inertiagrouprange=\"1 5\" boundmass=\"1\"", 1.0, 0.0),
    ];
    for (compiler, mass, inertia) in cases {
        let text = format!(
            "<mujoco><compiler {compiler}/><worldbody><body><joint/><geom type=\"box\" size=\".1 .1 .1\"/>\
             <inertial pos=\"0 0 0\" mass=\"2\" diaginertia=\"0.1 0.1 0.5\"/></body></worldbody></mujoco>"
        );
        let tree = mjcf::read(&text).expect("a robot").tree(&[]).expect("a tree");
        let found = tree.bodies[0].inertia;
        assert!((found.mass - mass).abs() < 1e-12, "{compiler}: {found:?}");
        assert!((found.inertia[5] - inertia).abs() < 1e-12, "{compiler}: {found:?}");
    }
}

/// A rotor of 0.5 kg m^2 behind a gear of 3 is 4.5 kg m^2 at the joint.
#[test]
fn motors_have_rotors() {
    let motors = "</worldbody><default><position gear=\"3\"/></default><actuator>\
        <motor joint=\"elbow\" armature=\"0.5\" damping=\"0.1\"/><motor joint=\"shoulder\"/></actuator>";
    let text = ARM.replace("</worldbody>", motors);
    let robot = mjcf::read(&text).expect("a robot");
    let [shoulder, elbow] = ["shoulder", "elbow"].map(|name| robot.joint(name).expect("a joint"));
    assert_eq!((shoulder.armature, elbow.armature), (0.0, 0.5 + 9.0 * 0.5));
    assert_eq!((shoulder.damping, elbow.damping), (0.4, 0.4 + 9.0 * 0.1));
    let loose = text.replace("motor joint=\"elbow\"", "motor tendon=\"strap\"");
    let e = mjcf::read(&loose).expect_err("no joint");
    assert!(e.line == Some(20) && e.message.contains("rotor"), "{e}");
}

#[test]
fn mistakes_are_told_with_their_element_and_line() {
    let elbow = "<joint name=\"elbow\" armature=\"0.5\"/>";
    let inertial = "<inertial pos=\"0 0 0.2\" mass=\"2\" diaginertia=\"0.02 0.02 0.003\"/>";
    let rod = "<geom name=\"rod\" type=\"cylinder\" size=\"0.1 0.3\" mass=\"1\"/>";
    let compiler = "<compiler autolimits=\"true\"/>";
    let cases: &[Wrong] = &[
        ("mass=\"2\"", "mass=\"-2\"", 11, &["mass", "upper", "-2"]),
        ("mass=\"2\"", "", 11, &["'mass'", "upper"]),
        ("mass=\"2\"", "mass=\"two\"", 11, &["mass", "two"]),
        ("pos=\"0 0 0.2\"", "pos=\"0 0\"", 11, &["pos", "3 numbers", "upper"]),
        ("0.02 0.02 0.003", "0.02 -0.02 0.003", 11, &["inertia", "-0.02"]),
        (inertial, "", 12, &["mesh", "<inertial>", "upper"]),
        (elbow, "<joint name=\"elbow\" type=\"screw\"/>", 16, &["elbow", "screw", "hinge"]),
        (elbow, "<joint name=\"elbow\" axis=\"0 0 0\"/>", 16, &["elbow", "length 0"]),
        ("0 2 0", "0 0 0", 5, &["elbow", "length 0"]),
        (elbow, "<joint name=\"elbow\" class=\"wrists\"/>", 16, &["elbow", "wrists", "<default"]),
        ("\"elbows\">\n", "\"wrists\">\n", 14, &["lower", "wrists"]),
        (elbow, "<joint name=\"elbow\" damping=\"-1\"/>", 16, &["elbow", "damping", "-1"]),
        ("damping=\"0.4\"", "damping=\"1e999\"", 4, &["damping", "1e999"]),
        (elbow, "<joint name=\"elbow\" springdamper=\"0.1 1\"/>", 16, &["elbow", "stiffness"]),
        (elbow, "<joint name=\"shoulder\"/>", 16, &["shoulder", "twice", "line 13"]),
        ("body name=\"lower\"", "body name=\"upper\"", 14, &["upper", "twice", "line 10"]),
        (elbow, "<include file=\"elbow.xml\"/>", 16, &["<include>", "elbow.xml", "mj_saveLastXML"]),
        (elbow, "<replicate count=\"3\"/>", 16, &["<replicate>", "lower"]),
        (rod, "<geom name=\"rod\" type=\"cone\"/>", 15, &["rod", "cone", "capsule"]),
        (rod, "<geom name=\"rod\" type=\"box\" size=\"1 1\"/>", 15, &["size", "rod", "3 numbers"]),
        (rod, "<geom name=\"rod\" size=\"1\" density=\"-1\"/>", 15, &["density", "rod"]),
        (rod, "<geom name=\"rod\" size=\"1\" quat=\"0 0 0 0\"/>", 15, &["rod", "quat"]),
        (
            rod,
            "<geom name=\"rod\" type=\"box\" size=\"1\" fromto=\"1 1 1 1 1 1\"/>",
            15,
            &["fromto"],
        ),
        (rod, "<geom name=\"rod\" size=\"1e200\"/>", 14, &["inertia", "lower", "finite"]),
        (compiler, "<compiler angle=\"turns\"/>", 2, &["angle", "degree, radian", "turns"]),
        (compiler, "<compiler eulerseq=\"xyw\"/>", 2, &["eulerseq", "xyw"]),
        (compiler, "<compiler coordinate=\"global\"/>", 2, &["coordinate", "local"]),
        (compiler, "<compiler settotalmass=\"20\"/>", 2, &["settotalmass"]),
        (compiler, "<option density=\"1.2\"/>", 2, &["density", "fluid"]),
        (compiler, "<option gravity=\"0 0\"/>", 2, &["gravity", "3 numbers"]),
        ("body name=\"lower\"", "body name=\"lower\" gravcomp=\"1\"", 14, &["gravcomp", "lower"]),
        ("<mujoco model=\"arm\">", "<mujoco><body>", 21, &["XML"]),
        ("<worldbody>", "<worldbodies>", 20, &["XML"]),
    ];
    assert_refused(mjcf::read, ARM, cases);
    let e = mjcf::read("<robot/>").expect_err("a URDF");
    assert!(e.message.contains("<mujoco>"), "{e}");
    let e = mjcf::read("<mujoco/>").expect_err("no bodies");
    assert!(e.message.contains("<worldbody>"), "{e}");
    let none = "<mujoco><worldbody><body name=\"rock\"/></worldbody></mujoco>";
    let e = mjcf::read(none).expect("a robot").tree(&[]).expect_err("nothing moves");
    assert!(e.message.contains("no joint moves"), "{e}");
}

/// What ties joints, or moves in ways that are not simulated, may be held.
#[test]
fn what_is_not_simulated_can_be_held() {
    let with = |more: &str| ARM.replace("</worldbody>", &format!("</worldbody>\n{more}"));
    let tendon = "<tendon><fixed name=\"strap\" stiffness=\"4\"><joint joint=\"elbow\" coef=\"1\"/></fixed></tendon>";
    let cases = [
        (with("<equality><joint joint1=\"elbow\"/></equality>"), 21, "<equality>"),
        (with("<equality><weld body1=\"upper\" body2=\"lower\"/></equality>"), 21, "<weld>"),
        (with(tendon), 21, "stiffness"),
    ];
    for (text, line, what) in cases {
        let robot = mjcf::read(&text).expect("a robot");
        let e = robot.tree(&[]).expect_err("it is not simulated");
        assert_eq!(e.line, Some(line), "{e}");
        assert!(e.message.contains(what) && e.message.contains("locked = [\"elbow\"]"), "{e}");
        assert_eq!(robot.tree(&[("elbow".to_owned(), 0.0)]).expect("a tree").bodies.len(), 1);
    }
    let both = with(
        "<equality><joint joint1=\"elbow\" joint2=\"shoulder\" polycoef=\"0 1 1 0 0\"/></equality>",
    );
    let e = mjcf::read(&both).expect("a robot").tree(&[]).expect_err("tied");
    assert!(e.message.contains("hold them still with locked = [\"elbow\", \"shoulder\"]"), "{e}");
    let slack = with("<equality><joint active=\"false\" joint1=\"elbow\"/></equality>");
    mjcf::read(&slack).expect("a robot").tree(&[]).expect("a tree");
    let lost = with("<equality><joint joint1=\"wrist\"/></equality>");
    assert!(mjcf::read(&lost).expect_err("no such joint").message.contains("wrist"));
}

/// Files with pieces that are lost, copied or moved are read or refused.
#[test]
fn torn_files_do_no_harm() {
    let (mut rng, mut read) = (rng(5, 0), 0);
    for seed in 0..600 {
        let mut pieces: Vec<String> =
            drawn_mjcf(4, seed % 20).split_inclusive(['"', '>']).map(str::to_owned).collect();
        for _ in 0..rng.random_range(1..4) {
            let [from, to] = [(); 2].map(|()| rng.random_range(0..pieces.len()));
            match rng.random_range(0..3) {
                0 => pieces[to] = pieces[from].clone(),
                1 => pieces.swap(from, to),
                _ => drop(pieces.remove(from)),
            }
        }
        if let Ok(robot) = mjcf::read(&pieces.concat()) {
            read += 1;
            if let Ok(tree) = robot.tree(&[]) {
                let states = 2 * tree.coordinates();
                let (mass, _) = mass_and_bias(&tree, &vec![0.1; states], GRAVITY);
                assert_eq!(4 * mass.len(), states * states);
            }
        }
    }
    assert!(read > 20, "{read}");
}

#[test]
fn entities_that_grow_are_refused() {
    let bomb = "<!DOCTYPE mujoco [<!ENTITY a \"aaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;\">]>\
        <mujoco model=\"&b;\"/>";
    let e = mjcf::read(bomb).expect_err("a bomb");
    assert!(e.message.contains("XML"), "{e}");
}

/// Ten megabytes, body within body: read, merged, and no stack overflows.
#[test]
fn a_chain_of_thousands_is_read() {
    let count = 100_000;
    let mut text = String::from("<mujoco><worldbody><body><joint/>");
    text +=
        &"<body><geom size=\"1\" density=\"0.001\" zaxis=\"1 0 0\"/><site/><site/><site/><site/><site/>\n"
            .repeat(count);
    text += &"</body>".repeat(count + 1);
    text += "</worldbody></mujoco>";
    assert!(text.len() > 9_000_000, "{}", text.len());
    let robot = mjcf::read(&text).expect("a robot");
    let moving = robot.joints.iter().filter(|j| j.moves != Moves::Fixed).count();
    assert_eq!((robot.links.len(), moving), (count + 2, 1));
    let tree = robot.tree(&[]).expect("a tree");
    let mass = tree.bodies[0].inertia.mass;
    assert!((mass / (count as f64 * 0.004 / 3.0 * PI) - 1.0).abs() < 1e-9, "{mass}");
}

#[test]
fn classes_without_end_are_refused() {
    let deep = "<default class=\"a\">".repeat(30_000) + &"</default>".repeat(30_000);
    let text = format!("<mujoco><default>{deep}</default><worldbody/></mujoco>");
    assert!(mjcf::read(&text).is_err());
}

/// An `<equality>` of two joints by a straight line, about where the file places them.
#[test]
fn a_joint_follows_another() {
    let tie = |numbers: &str| {
        let equality = format!(
            "</worldbody><equality><joint joint1=\"elbow\" joint2=\"shoulder\" {numbers}/></equality>"
        );
        let placed = ARM.replace("armature=\"0.5\"", "armature=\"0.5\" ref=\"90\"");
        mjcf::read(&placed.replace("</worldbody>", &equality)).expect("a robot")
    };
    for (numbers, ratio, offset) in [
        ("", 1.0, FRAC_PI_2),
        ("polycoef=\"0.1 -2\"", -2.0, FRAC_PI_2 + 0.1),
        ("polycoef=\"0 3 0 0 0\"", 3.0, FRAC_PI_2),
    ] {
        let tree = tie(numbers).tree(&[]).expect("a tree");
        assert_eq!(tree.coordinates(), 1);
        let joint = &tree.bodies[1].joint;
        assert!(joint.ratio == ratio && (joint.offset - offset).abs() < 1e-15, "{joint:?}");
        assert_eq!(joint.coordinate, 0);
    }
}

/// Its coordinates are those of the world; held, it is where the file places it.
#[test]
fn a_free_joint_floats() {
    let text = r#"<mujoco><worldbody><body name="b" pos="1 2 3"><freejoint name="base"/><geom size="0.1" mass="2"/>
        <body name="arm"><joint name="j" axis="0 1 0"/><geom size="0.1" mass="1"/></body></body></worldbody></mujoco>"#;
    let robot = mjcf::read(text).expect("a robot");
    let tree = robot.tree(&[]).expect("a tree");
    assert_eq!((tree.coordinates(), &*tree.bodies[5].name), (7, "b"));
    assert_eq!(tree.bodies[0].joint.pose.translation, [0.0; 3]);
    let (mass, bias) = mass_and_bias(&tree, &[0.1; 14], GRAVITY);
    assert!((mass[0] - 3.0).abs() < 1e-14 && (bias[2] - 3.0 * 9.81).abs() < 1e-12);
    let held = robot.tree(&[("base".to_owned(), 0.0)]).expect("a tree");
    assert_eq!(held.bodies[0].joint.pose.translation, [1.0, 2.0, 3.0]);
}
