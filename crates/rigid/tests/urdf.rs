//! What is read of a URDF file, and what is wrong with those that cannot be.

mod support;

use lacuna_rigid::{GRAVITY, Moves, urdf};
use support::{Wrong, assert_refused, drawn_states, drawn_urdf, mass_and_bias};

const ARM: &str = r#"<?xml version="1.0"?>
<robot name="arm">
  <link name="base"/>
  <link name="upper">
    <inertial>
      <origin xyz="0 0 0.2" rpy="0 0 0"/>
      <mass value="2"/>
      <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.003"/>
    </inertial>
    <visual><geometry><mesh filename="package://nowhere/upper.stl"/></geometry></visual>
  </link>
  <link name="lower">
    <inertial>
      <mass value="1"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.001"/>
    </inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/>
    <child link="upper"/>
    <axis xyz="0 2 0"/>
    <limit lower="-2" upper="2" effort="50" velocity="5"/>
    <dynamics damping="0.4" friction="0.1"/>
  </joint>
  <joint name="elbow" type="continuous">
    <parent link="upper"/>
    <child link="lower"/>
    <origin xyz="0 0 0.4"/>
    <axis xyz="0 1 0"/>
  </joint>
</robot>
"#;

#[test]
fn an_arm_is_read() {
    let robot = urdf::read(ARM).expect("a robot");
    let shoulder = robot.joint("shoulder").expect("a joint");
    assert_eq!(shoulder.axis, [0.0, 1.0, 0.0]);
    assert_eq!((shoulder.damping, shoulder.friction), (0.4, 0.1));
    let tree = robot.tree(&[]).expect("a tree");
    let names: Vec<_> = tree.bodies.iter().map(|b| (&*b.name, b.parent)).collect();
    assert_eq!(names, [("upper", None), ("lower", Some(0))]);
    // A double pendulum that stands on its head: the upper link's centre at .2 m, the elbow at .4 m.
    let (mass, bias) = mass_and_bias(&tree, &[0.0; 4], GRAVITY);
    let upright = [0.02 + 2.0 * 0.04 + 0.01 + 0.16, 0.01, 0.01, 0.01];
    for (found, expected) in mass.iter().zip(upright) {
        assert!((found - expected).abs() < 1e-15, "{mass:?}");
    }
    assert!(bias.iter().all(|h| h.abs() < 1e-15), "{bias:?}");
    let (_, bias) = mass_and_bias(&tree, &[std::f64::consts::FRAC_PI_2, 0.0, 0.0, 0.0], GRAVITY);
    // Turned to the side it falls on: what holds it pushes back.
    assert!((bias[0] + 9.81 * (2.0 * 0.2 + 0.4)).abs() < 1e-12, "{bias:?}");
}

#[test]
fn mistakes_are_told_with_their_element_and_line() {
    let joint = |text: &str| format!("{text}\n</robot>");
    let loops = joint(
        r#"<joint name="back" type="fixed"><parent link="lower"/><child link="upper"/></joint>"#,
    );
    let cases: [Wrong; 12] = [
        ("</robot>", &loops, 31, &["upper", "shoulder", "back", "loops"]),
        (
            "<link name=\"base\"/>",
            "<link name=\"base\"/><link name=\"spare\"/>",
            3,
            &["spare", "base"],
        ),
        ("<mass value=\"2\"/>", "<mass value=\"-2\"/>", 7, &["mass", "upper", "-2"]),
        ("<mass value=\"2\"/>", "", 5, &["upper", "<mass>"]),
        ("<mass value=\"2\"/>", "<mass value=\"two\"/>", 7, &["value", "two"]),
        ("type=\"continuous\"", "type=\"rotary\"", 25, &["elbow", "rotary", "revolute"]),
        (
            "<limit lower=\"-2\" upper=\"2\" effort=\"50\" velocity=\"5\"/>",
            "",
            18,
            &["shoulder", "<limit>"],
        ),
        ("<axis xyz=\"0 2 0\"/>", "<axis xyz=\"0 0 0\"/>", 21, &["shoulder", "length 0"]),
        ("<child link=\"lower\"/>", "<child link=\"hand\"/>", 27, &["elbow", "hand"]),
        ("name=\"lower\"", "name=\"upper\"", 12, &["upper", "twice", "line 4"]),
        ("damping=\"0.4\"", "damping=\"-1\"", 23, &["damping", "shoulder"]),
        ("<robot name=\"arm\">", "<robot name=\"arm\"><link>", 31, &["XML"]),
    ];
    assert_refused(urdf::read, ARM, &cases);
}

/// Two joints in a ring that hangs from nothing.
#[test]
fn a_circle_is_told() {
    let ring = "<robot><link name=\"base\"/><link name=\"a\"/><link name=\"b\"/>\
        <joint name=\"j\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>\n\
        <joint name=\"k\" type=\"fixed\"><parent link=\"b\"/><child link=\"a\"/></joint></robot>";
    let e = urdf::read(ring).expect_err("a circle");
    assert!(e.message.contains("hangs from itself"), "{e}");
}

#[test]
fn entities_that_grow_are_refused() {
    let bomb = "<!DOCTYPE robot [<!ENTITY a \"aaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;\">]>\
        <robot name=\"&b;\"><link name=\"base\"/></robot>";
    let e = urdf::read(bomb).expect_err("a bomb");
    assert!(e.message.contains("XML"), "{e}");
}

/// Ten megabytes of links in one chain: read, merged, and no stack overflows.
#[test]
fn a_chain_of_thousands_is_read() {
    let count = 40_000;
    let mut text = String::from("<robot><link name=\"l0\"/>\n");
    for k in 1..=count {
        let kind = if k == 1 { "continuous" } else { "fixed" };
        text += &format!(
            "<link name=\"l{k}\"><inertial><origin xyz=\"0 0 0\" rpy=\"0 0 0\"/><mass value=\"0.001\"/><inertia ixx=\"1\" \
             ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link><joint name=\"j{k}\" type=\"{kind}\">\
             <parent link=\"l{}\"/><child link=\"l{k}\"/></joint>\n",
            k - 1
        );
    }
    text += "</robot>";
    assert!(text.len() > 9_000_000, "{}", text.len());
    let robot = urdf::read(&text).expect("a robot");
    let moving = robot.joints.iter().filter(|j| j.moves != Moves::Fixed).count();
    assert_eq!((robot.links.len(), moving), (count + 1, 1));
    let tree = robot.tree(&[]).expect("a tree");
    assert_eq!(tree.bodies.len(), 1);
    let mass = tree.bodies[0].inertia.mass;
    assert!((mass - 0.001 * count as f64).abs() < 1e-9, "{mass}");
}

/// A joint that is held moves its links with their parent: the other joints have the mass matrix and
/// the forces that they have where it stands still.
#[test]
fn a_held_joint_is_one_that_stands_still() {
    for seed in 20..26 {
        let robot = urdf::read(&drawn_urdf(6, seed)).expect("a robot");
        let whole = robot.tree(&[]).expect("a tree");
        let n = whole.bodies.len();
        for (held, body) in whole.bodies.iter().enumerate() {
            let mut state = drawn_states(n, 1, seed).remove(0);
            state[n + held] = 0.0;
            let fewer = robot.tree(&[(body.joint.name.clone(), state[held])]).expect("a tree");
            let place = |name: &str| {
                whole.bodies.iter().position(|b| b.joint.name == name).expect("the same joint")
            };
            let map: Vec<usize> = fewer.bodies.iter().map(|b| place(&b.joint.name)).collect();
            assert_eq!(map.len(), n - 1);
            let of = |k: &usize| [state[*k], state[n + *k]];
            let both: Vec<[f64; 2]> = map.iter().map(of).collect();
            let less =
                both.iter().map(|s| s[0]).chain(both.iter().map(|s| s[1])).collect::<Vec<_>>();
            let gravity = [1.0, -2.0, 9.0];
            let (mass, bias) = mass_and_bias(&whole, &state, gravity);
            let (mass_less, bias_less) = mass_and_bias(&fewer, &less, gravity);
            for (a, &i) in map.iter().enumerate() {
                assert!(
                    (bias_less[a] - bias[i]).abs() < 1e-9 * (1.0 + bias[i].abs()),
                    "seed {seed}"
                );
                for (b, &j) in map.iter().enumerate() {
                    let (found, expected) = (mass_less[a * (n - 1) + b], mass[i * n + j]);
                    assert!(
                        (found - expected).abs() < 1e-9 * (1.0 + expected.abs()),
                        "seed {seed}"
                    );
                }
            }
        }
    }
}

#[test]
fn what_is_held_must_be_there() {
    let robot = urdf::read(ARM).expect("a robot");
    let e = robot.tree(&[("wrist".to_owned(), 0.0)]).expect_err("no such joint");
    assert!(e.message.contains("shoulder, elbow"), "{e}");
}

/// Mistakes of what joints follow, with their lines.
#[test]
fn what_follows_is_told() {
    let axis = "<axis xyz=\"0 1 0\"/>";
    let mimic = |joint: &str| format!("<mimic joint=\"{joint}\"/>");
    let several = ARM.replace("continuous", "floating");
    for (text, joint, words) in [
        (ARM, "elbow", "follows itself"),
        (ARM, "wrist", "which there is not"),
        (&several, "shoulder", "floating"),
    ] {
        let e = urdf::read(&text.replace(axis, &mimic(joint))).expect_err(joint);
        assert!(e.line == Some(29) && e.message.contains(words), "{e}");
    }
}

/// A follower loads its leader: of both joints, turned alike, the inertia is that of all four entries.
#[test]
fn a_joint_that_follows_loads_its_leader() {
    let axis = "<axis xyz=\"0 1 0\"/>";
    let mimic = format!("{axis}<mimic joint=\"shoulder\" multiplier=\"-2\" offset=\"0.3\"/>");
    let tied = urdf::read(&ARM.replace(axis, &mimic)).expect("a robot");
    let free = urdf::read(ARM).expect("a robot").tree(&[]).expect("a tree");
    let tree = tied.tree(&[]).expect("a tree");
    assert_eq!((tree.bodies.len(), tree.coordinates(), tree.has_followers()), (2, 1, true));
    let (q, v) = (0.7, 1.3);
    let (mass, bias) = mass_and_bias(&tree, &[q, v], GRAVITY);
    let both = [q, -2.0 * q + 0.3, v, -2.0 * v];
    let (m, h) = mass_and_bias(&free, &both, GRAVITY);
    assert!((mass[0] - (m[0] - 2.0 * (m[1] + m[2]) + 4.0 * m[3])).abs() < 1e-14, "{mass:?}");
    assert!((bias[0] - (h[0] - 2.0 * h[1])).abs() < 1e-13, "{bias:?}");
    // Held with its leader, it is where that takes it.
    let held = urdf::read(ARM).expect("a robot");
    let alone = held.tree(&[("shoulder".to_owned(), 0.7)]).expect("a tree");
    assert_eq!(alone.coordinates(), 1);
    let e = tied.tree(&[("shoulder".to_owned(), 0.7)]).expect_err("nothing moves");
    assert!(e.message.contains("no joint moves"), "{e}");
}

#[test]
fn joints_of_several_coordinates_are_chains() {
    let floating = ARM.replace("type=\"continuous\"", "type=\"floating\"");
    let robot = urdf::read(&floating).expect("a robot");
    let names = |held: &[&str]| {
        let held: Vec<_> = held.iter().map(|name| ((*name).to_owned(), 0.0)).collect();
        let tree = robot.tree(&held).expect("a tree");
        tree.joints().map(|j| j.name.clone()).collect::<Vec<_>>().join(" ")
    };
    let all = "shoulder elbow_x elbow_y elbow_z elbow_yaw elbow_pitch elbow_roll";
    assert_eq!(names(&[]), all);
    assert_eq!(names(&["elbow"]), "shoulder");
    assert_eq!(names(&["elbow_z", "elbow_roll"]), "shoulder elbow_x elbow_y elbow_yaw elbow_pitch");
    let e = robot.tree(&[("elbow".to_owned(), 0.1)]).expect_err("which of six");
    assert!(e.line == Some(25) && e.message.contains("elbow_pitch"), "{e}");
    let rubbing = floating.replace("<origin xyz=\"0 0 0.4\"/>", "<dynamics damping=\"1\"/>");
    let robot = urdf::read(&rubbing).expect("a robot");
    let e = robot.tree(&[]).expect_err("along which");
    assert!(e.line == Some(25) && e.message.contains("damping 1"), "{e}");
    assert_eq!(robot.tree(&[("elbow".to_owned(), 0.0)]).expect("a tree").coordinates(), 1);
}
