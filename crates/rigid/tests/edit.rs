//! Robots' own files with other values in them: what is read of them is what was written, and all else
//! is as it was, to the byte.

mod support;

use approx::assert_relative_eq;
use lacuna_rigid::edit::{Change, Edit, Edited, Unstated, edit, headed};
use lacuna_rigid::{Format, Inertia, InertialParameters, Robot, read};
use support::drawn_urdf;
use support::mjcf::drawn_mjcf;
use support::oracle::published;

const URDF: &str = r#"<?xml version="1.0"?>
<!-- The arm in the corner. -->
<robot name="arm">
  <link name="base"/>
  <link name='upper'>   <!-- weighed in May -->
    <inertial>
      <origin rpy="0 0 1.5" xyz="0 0 -0.15"/>
      <mass value="1.5"/>
      <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.015"/>
    </inertial>
  </link>
  <joint name="shoulder" type="continuous">
    <parent link="base"/><child link="upper"/>
    <axis xyz="0 1 0"/>
    <dynamics   damping = '0.6'/>
  </joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/></joint>
  <link name="lower"></link>
</robot>
"#;

const MJCF: &str = r#"<mujoco model="arm">
  <default>
    <joint axis="0 1 0" damping="0.3" stiffness="2" springref="10"/>
    <motor gear="50"/>
  </default>
  <worldbody>
    <body>
      <body name="lower" pos="0 0 -0.3">
        <geom size="0.1" mass="1"/>
        <frame euler="0 0 90"><joint name="elbow" /></frame>
      </body>
      <joint name="shoulder" damping="0.6"/>
      <inertial pos="0 0 -0.15"  quat="0.7 0 0.7 0" mass="1.5" diaginertia="0.02 0.01 0.015"/>
    </body>
  </worldbody>
  <actuator>
    <motor joint="shoulder"/>
    <position joint="elbow" kp="3" armature="0.001" gear="10"/>
  </actuator>
</mujoco>
"#;

fn edits(changes: &[Change]) -> Vec<Edit> {
    changes.iter().map(|c| Edit { change: c.clone(), says: "lacuna: -- said".to_owned() }).collect()
}

fn written(text: &str, changes: &[Change]) -> (Edited, Robot) {
    let edited = edit(text, &edits(changes)).expect("a robot");
    let robot = read(&edited.text).unwrap_or_else(|e| panic!("{e}\n{}", edited.text));
    (edited, robot)
}

/// One that is written without any being left out.
fn whole(text: &str, changes: &[Change]) -> (String, Robot) {
    let (edited, robot) = written(text, changes);
    assert_eq!(edited.left_out, [], "{}", edited.text);
    (edited.text, robot)
}

/// A ball.
fn ball(mass: f64, centre: [f64; 3]) -> Inertia<f64> {
    let i = 0.01 * mass;
    InertialParameters { mass, centre, inertia: [i, 0.0, 0.0, i, 0.0, i] }.about_origin()
}

fn assert_same(a: &Inertia<f64>, b: &Inertia<f64>) {
    for (a, b) in a.entries().iter().zip(b.entries()) {
        assert_relative_eq!(*a, b, epsilon = 1e-14, max_relative = 1e-12);
    }
}

fn link<'r>(robot: &'r Robot, name: &str) -> &'r Inertia<f64> {
    &robot.links.iter().find(|l| l.name == name).expect("a link").inertia
}

#[test]
fn nothing_to_write_changes_nothing() {
    for text in [URDF, MJCF] {
        assert_eq!(whole(text, &[]).0, text);
    }
}

#[test]
fn a_urdf_is_changed_where_it_must_be() {
    let damping = Change::Damping("shoulder".into(), 0.65);
    let (text, robot) = whole(URDF, &[damping, Change::Friction("elbow".into(), 3.5e-7)]);
    let expected = URDF
        .replace(
            "    <dynamics   damping = '0.6'/>",
            "    <!-- lacuna: - - said -->\n    <dynamics   damping = '0.65'/>",
        )
        .replace(
            "<child link=\"lower\"/></joint>",
            "<child link=\"lower\"/><!-- lacuna: - - said --><dynamics friction=\"3.5e-7\"/></joint>",
        );
    assert_eq!(text, expected);
    let of = |name| robot.joint(name).expect("a joint");
    assert_eq!((of("shoulder").damping, of("elbow").friction), (0.65, 3.5e-7));
}

#[test]
fn links_of_a_urdf_carry_more() {
    let before = read(URDF).expect("a robot");
    let added = ball(0.3, [0.04, 0.0, -0.15]);
    let carry = |name: &str| Change::Inertia(name.into(), added);
    let (text, robot) = whole(URDF, &[carry("upper"), carry("lower"), carry("base")]);
    for name in ["upper", "lower", "base"] {
        assert_same(link(&robot, name), &link(&before, name).plus(&added));
    }
    assert!(
        text.contains("<link name='upper'>   <!-- weighed in May -->\n    <!-- lacuna"),
        "{text}"
    );
    assert!(
        text.contains("<link name=\"base\">\n    <!-- lacuna: - - said -->\n    <inertial>"),
        "{text}"
    );
    assert!(text.contains("</inertial>\n  </link>\n  <link name='upper'>"), "{text}");
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
    let (old, new) = (lines(URDF), lines(&text));
    let kept = old.iter().filter(|line| new.contains(line)).count();
    assert_eq!(old.len() - kept, 5, "{text}");
}

#[test]
fn joints_of_an_mjcf_are_changed_where_they_must_be() {
    let (text, robot) = whole(
        MJCF,
        &[
            Change::Damping("elbow".into(), 0.43),
            Change::Friction("elbow".into(), 0.1),
            Change::Armature("elbow".into(), 0.15),
            Change::Spring("shoulder".into(), 2.5, -0.1),
            Change::Spring("elbow".into(), 3.0, 10f64.to_radians()),
            Change::Gravity([0.1, 0.0, -9.8]),
            Change::Gain("shoulder".into(), 0.9),
        ],
    );
    let elbow = robot.joint("elbow").expect("a joint");
    assert_eq!((elbow.damping, elbow.friction, elbow.stiffness), (0.43, 0.1, 3.0));
    // A tenth of it is the motor's.
    assert_relative_eq!(elbow.armature, 0.15, max_relative = 1e-15);
    assert_eq!(elbow.spring_reference, 10f64.to_radians());
    let shoulder = robot.joint("shoulder").expect("a joint");
    assert_eq!((shoulder.stiffness, shoulder.damping), (2.5, 0.6));
    assert_relative_eq!(shoulder.spring_reference, -0.1, max_relative = 1e-15);
    assert_eq!(robot.gravity, Some([0.1, 0.0, -9.8]));
    assert!(text.contains("<motor joint=\"shoulder\" gear=\"45\"/>"), "{text}");
    assert!(
        text.contains("<!-- lacuna: - - said --><joint name=\"elbow\" damping=\"0.43\" fri"),
        "{text}"
    );
    // What was put in is all that is new.
    let stripped = text.replace("<!-- lacuna: - - said -->", "");
    assert!(
        stripped.lines().count() > 20 && stripped.contains("<frame euler=\"0 0 90\"><joint name")
    );
}

#[test]
fn bodies_of_an_mjcf_carry_more_whether_they_say_their_inertia_or_shapes_do() {
    let before = read(MJCF).expect("a robot");
    let added = ball(0.3, [0.04, 0.0, -0.15]);
    let carry = |name: &str| Change::Inertia(name.into(), added);
    let (text, robot) = whole(MJCF, &[carry("body1"), carry("lower")]);
    for name in ["body1", "lower"] {
        assert_same(link(&robot, name), &link(&before, name).plus(&added));
    }
    assert!(text.contains("mass=\"1.8\"") && !text.contains("quat"), "{text}");
}

#[test]
fn what_a_format_cannot_say_is_left_out_and_told() {
    let none = |joint: &str| Change::Gain(joint.into(), 0.9);
    let negative =
        InertialParameters { mass: 0.0, centre: [0.0; 3], inertia: [0.0, 0.0, 0.0, 0.1, 0.0, 0.0] };
    let (edited, _) = written(
        URDF,
        &[
            Change::Armature("elbow".into(), 0.1),
            Change::Gravity([0.0; 3]),
            Change::Damping("elbow".into(), -0.1),
            Change::Damping("wrist".into(), 0.1),
            Change::Inertia("upper".into(), negative.about_origin()),
        ],
    );
    let place = Unstated::NoPlace(Format::Urdf);
    let reasons = [
        place.clone(),
        place,
        Unstated::Negative(-0.1),
        Unstated::NoElement("joint"),
        Unstated::NoBody,
    ];
    assert_eq!(edited.left_out, reasons.into_iter().enumerate().collect::<Vec<_>>());
    assert_eq!(edited.text, URDF);
    let (edited, _) = written(MJCF, &[none("elbow")]);
    assert_eq!(edited.left_out, [(0, Unstated::NoMotor)]);
    let shapes = MJCF.replace("<default>", "<compiler inertiafromgeom=\"true\"/><default>");
    let (edited, _) = written(&shapes, &[Change::Inertia("lower".into(), ball(1.0, [0.0; 3]))]);
    assert_eq!(edited.left_out, [(0, Unstated::FromGeoms)]);
}

/// A servo's numbers are told on its joint's side, and stand in the file on that of its gear.
#[test]
fn a_servo_is_that_of_its_position_actuator() {
    let servo = |text: &str| {
        let robot = read(text).expect("a robot");
        robot.joint("elbow").and_then(|joint| joint.servo)
    };
    let own = "<position joint=\"elbow\" kp=\"3\" armature=\"0.001\" gear=\"10\"/>";
    let with = |actuator: &str| MJCF.replace(own, actuator);
    let change = [Change::Servo("elbow".into(), [50.0, 2.0], Some(6.0))];
    let geared =
        "<position joint=\"elbow\" kp=\"10\" dampratio=\"1\" gear=\"2\" forcerange=\"-2 2\"/>";
    let (edited, _) = written(&with(geared), &change);
    assert!(edited.left_out.is_empty(), "{:?}", edited.left_out);
    assert!(!edited.text.contains("dampratio"), "{}", edited.text);
    let found = servo(&edited.text).expect("a servo");
    assert_eq!((found.gain, found.damping(9.0), found.limit), (50.0, 2.0, Some(6.0)));
    // Nothing else is a place for it.
    for other in [
        "<motor joint=\"elbow\"/>",
        "<general joint=\"elbow\" biastype=\"affine\" \
        gainprm=\"9\" biasprm=\"0 -9 0\"/>",
        "",
    ] {
        let text = with(other);
        let (edited, _) = written(&text, &change);
        assert_eq!((edited.left_out, edited.text), (vec![(0, Unstated::NoServo)], text));
    }
    let (edited, _) = written(URDF, &change);
    assert_eq!(edited.left_out, [(0, Unstated::NoPlace(Format::Urdf))]);
}

/// Another folder's file finds meshes by their address alone.
#[test]
fn a_file_that_names_others_says_so() {
    let names = |file: &str| {
        let mesh =
            format!("<visual><geometry><mesh filename=\"{file}\"/></geometry></visual></link>");
        edit(&URDF.replace("</link>", &mesh), &[]).expect("a robot").names_files
    };
    assert!(names("meshes/upper.stl") && !names("package://arm/upper.stl") && !names("/upper.stl"));
    assert!(!edit(URDF, &[]).expect("a robot").names_files);
}

#[test]
fn a_comment_stands_before_the_first_element() {
    let text = headed(URDF, "one\n  two").expect("XML");
    assert_eq!(text, URDF.replace("<robot name=", "<!-- one\n  two -->\n<robot name="));
    assert!(read(&text).is_ok());
    let other = headed(&MJCF.replace('\n', "\r\n"), "one\ntwo").expect("XML");
    assert!(other.starts_with("<!-- one\r\ntwo -->\r\n<mujoco"));
}

/// Every joint, and every link that has mass, changed at once.
fn assert_all_can_change(text: &str) {
    let before = read(text).expect("a robot");
    let carried = before.joints.iter().map(|j| &before.links[j.child]);
    let carried: Vec<_> = carried.filter(|l| l.inertia.mass > 0.0).collect();
    let movable = before.movable();
    let added = ball(0.7, [0.1, -0.2, 0.3]);
    let of_joints = movable.iter().flat_map(|joint| {
        [Change::Damping((*joint).into(), 77.0), Change::Friction((*joint).into(), 1.3)]
    });
    let of_links = carried.iter().map(|l| Change::Inertia(l.name.clone(), added));
    let (_, after) = whole(text, &of_joints.chain(of_links).collect::<Vec<_>>());
    for (b, a) in before.joints.iter().zip(&after.joints) {
        let changed = movable.contains(&a.name.as_str());
        let expected = if changed { (77.0, 1.3) } else { (b.damping, b.friction) };
        assert_eq!((a.damping, a.friction), expected, "{}", a.name);
        assert_eq!((a.pose, a.armature, a.stiffness), (b.pose, b.armature, b.stiffness));
    }
    for (b, a) in before.links.iter().zip(&after.links) {
        let changed = carried.iter().any(|l| l.name == b.name);
        let added = if changed { added } else { Inertia::none() };
        assert_same(&a.inertia, &b.inertia.plus(&added));
    }
}

#[test]
fn drawn_robots_are_read_as_they_were_written() {
    for seed in 0..12 {
        assert_all_can_change(&drawn_urdf(4 + seed as usize, seed));
        assert_all_can_change(&drawn_mjcf(4 + seed as usize, seed));
    }
}

#[test]
fn published_robots_are_read_as_they_were_written() {
    for file in ["robot.urdf", "robot.xml"].into_iter().flat_map(published) {
        assert_all_can_change(&std::fs::read_to_string(file).expect("a file"));
    }
}
