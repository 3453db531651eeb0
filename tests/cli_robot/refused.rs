//! Robots' files that cannot be read: each is refused by its place, with the element that is wrong.

use crate::bench::{ARM, Bench, MJCF};
use std::fmt::Write;

/// What is replaced in a file and by what, the line of what is wrong then, and words that are said of it.
type Wrong<'a> = (&'a str, &'a str, u32, &'a [&'a str]);

/// What a command says of a file that it refuses.
fn refused(bench: &Bench, arguments: &[&str]) -> String {
    let output = bench.run(arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    assert!(said.starts_with("lacuna: ") && !said.contains("panicked"), "{said}");
    said
}

fn assert_refused(file: &str, text: &str, cases: &[Wrong]) {
    let bench = Bench::new("");
    let run = bench.record(0);
    for (from, to, line, words) in cases {
        assert!(text.contains(from), "{from}");
        std::fs::write(bench.path(file), text.replacen(from, to, 1)).expect("a file");
        for command in ["check", "diagnose"] {
            let said = refused(&bench, &[command, file, &run]);
            let place = format!("{file}:{line}:");
            assert!(said.contains(&place), "{to}: {said}");
            for word in *words {
                assert!(said.contains(word), "{to}: {word} in {said}");
            }
        }
    }
    assert!(!bench.path("lacuna-diagnosis").exists());
}

const LIMIT: &str = "<limit lower=\"-1\" upper=\"1\" effort=\"9\" velocity=\"9\"/>";

#[test]
fn wrong_urdfs_are_refused_with_the_element_and_its_line() {
    let end = "</robot>";
    let back = "<joint name=\"back\" type=\"fixed\"><parent link=\"lower\"/><child link=\"upper\"/></joint></robot>";
    let circle = "<joint name=\"back\" type=\"fixed\"><parent link=\"lower\"/><child link=\"base\"/></joint></robot>";
    let weightless = "<mass value=\"0\"/>\n    <inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/>";
    let lower = "<mass value=\"0.8\"/>\n    <inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.001\"/>";
    let base = "<link name=\"base\"/>";
    let elbow = "name=\"elbow\" type=\"continuous\"";
    let axis = "<axis xyz=\"0 1 0\"/><dynamics damping=\"0.3\"/>";
    let cases: &[Wrong] = &[
        (end, back, 11, &["link 'upper'", "'shoulder'", "'back'", "loops"]),
        (end, circle, 7, &["link 'upper'", "'shoulder'", "loops"]),
        (base, "<link name=\"base\"/><link name=\"spare\"/>", 2, &["'base'", "'spare'"]),
        ("value=\"0.8\"", "value=\"-0.8\"", 5, &["mass", "'lower'", "-0.8"]),
        ("value=\"0.8\"", "value=\"NaN\"", 5, &["value", "'lower'", "NaN"]),
        ("iyy=\"0.01\"", "iyy=\"-0.01\"", 6, &["inertia", "'lower'", "-0.01"]),
        (lower, weightless, 9, &["'elbow'", "no inertia", "'lower'", "elbow.armature"]),
        (elbow, "name=\"elbow\" type=\"screw\"", 9, &["'elbow'", "'screw'", "revolute"]),
        (elbow, "name=\"elbow\" type=\"revolute\"", 9, &["'elbow'", "revolute", "<limit>"]),
        (elbow, "name=\"elbow\" type=\"prismatic\"", 9, &["'elbow'", "prismatic", "<limit>"]),
        (axis, "<axis xyz=\"0 0 0\"/>", 10, &["axis", "'elbow'", "length 0"]),
        (axis, "<axis xyz=\"0 1\"/>", 10, &["'xyz'", "'elbow'", "3 numbers"]),
        (axis, "<mimic joint=\"elbow\"/>", 10, &["'elbow'", "follows itself"]),
        (axis, "<mimic joint=\"wrist\"/>", 10, &["'elbow'", "'wrist'"]),
        ("<parent link=\"upper\"/>", "<parent link=\"hand\"/>", 9, &["'elbow'", "'hand'"]),
        ("<child link=\"lower\"/>", "", 9, &["'elbow'", "<child>"]),
        ("name=\"lower\"", "name=\"upper\"", 5, &["'upper'", "twice", "line 3"]),
        ("<robot name=\"arm\">", "<robot name=\"arm\"><link>", 11, &["XML", "link"]),
    ];
    assert_refused("arm.urdf", ARM, cases);
    // Limits are all that a revolute joint lacks.
    let bench = Bench::new("");
    let limited =
        ARM.replace("\"continuous\"", "\"revolute\"").replace("<axis", &format!("{LIMIT}<axis"));
    std::fs::write(bench.path("limited.urdf"), limited).expect("a file");
    bench.says(&["check", "limited.urdf", &bench.record(0)]);
}

#[test]
fn wrong_mjcfs_are_refused_with_the_element_and_its_line() {
    let elbow = "<joint name=\"elbow\"/>";
    let inertial = "<inertial pos=\"0 0 -0.1\" mass=\"0.8\" diaginertia=\"0.01 0.01 0.001\"/>";
    let end = "</worldbody>";
    let ring = "</worldbody>\n<equality><joint joint1=\"elbow\" joint2=\"shoulder\"/>\n\
        <joint joint1=\"shoulder\" joint2=\"elbow\"/></equality>";
    let weld = "</worldbody>\n<equality><weld body1=\"lower\"/></equality>";
    let cases: &[Wrong] = &[
        ("mass=\"0.8\"", "mass=\"-0.8\"", 9, &["mass", "'lower'", "-0.8"]),
        (
            inertial,
            "<inertial pos=\"0 0 0\" mass=\"0\" diaginertia=\"0 0 0\"/>",
            8,
            &["'elbow'", "no inertia"],
        ),
        (inertial, "", 8, &["'elbow'", "no inertia", "'lower'"]),
        (elbow, "<joint name=\"elbow\" type=\"screw\"/>", 8, &["'elbow'", "'screw'", "hinge"]),
        (elbow, "<joint name=\"elbow\" axis=\"0 0 0\"/>", 8, &["axis", "'elbow'", "length 0"]),
        (elbow, "<joint name=\"elbow\" type=\"ball\"/>", 8, &["'elbow'", "ball", "damping 0.3"]),
        (elbow, "<freejoint name=\"elbow\"/>", 8, &["'elbow'", "free", "world"]),
        (elbow, "<joint name=\"shoulder\"/>", 8, &["'shoulder'", "twice", "line 5"]),
        (end, ring, 13, &["'shoulder'", "follows itself"]),
        (end, weld, 13, &["<weld>", "locked"]),
        ("<worldbody>", "<worldbodies>", 12, &["XML", "worldbod"]),
    ];
    assert_refused("arm.xml", MJCF, cases);
}

/// Entities that stand for many are not written out.
#[test]
fn xml_that_grows_is_refused() {
    let mut bomb = String::from("<!DOCTYPE robot [<!ENTITY e0 \"aaaaaaaaaa\">\n");
    for k in 1..12 {
        let ten = format!("&e{};", k - 1).repeat(10);
        writeln!(bomb, "<!ENTITY e{k} \"{ten}\">").expect("text");
    }
    bomb += "]>\n<robot name=\"&e11;\"><link name=\"base\"/></robot>\n";
    let bench = Bench::new("");
    let run = bench.record(0);
    std::fs::write(bench.path("bomb.urdf"), bomb).expect("a file");
    for command in ["check", "diagnose"] {
        let said = refused(&bench, &[command, "bomb.urdf", &run]);
        assert!(said.contains("bomb.urdf:1:") && said.contains("DTD"), "{said}");
    }
}

/// Ten megabytes: the mistake in the last of 40 000 joints is found, and told by its line.
#[test]
fn a_mistake_at_the_end_of_ten_megabytes_is_told() {
    let mut text = String::from("<robot><link name=\"l0\"/>\n");
    for k in 1..=40_000 {
        let kind = if k == 40_000 { "screw" } else { "fixed" };
        writeln!(
            text,
            "<link name=\"l{k}\"><inertial><origin xyz=\"0 0 0\" rpy=\"0 0 0\"/><mass value=\"0.001\"/><inertia ixx=\"1\" \
             ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link><joint name=\"j{k}\" type=\"{kind}\">\
             <parent link=\"l{}\"/><child link=\"l{k}\"/></joint>",
            k - 1
        )
        .expect("text");
    }
    text += "</robot>\n";
    assert!(text.len() > 9_000_000, "{}", text.len());
    let bench = Bench::new("");
    let run = bench.record(0);
    std::fs::write(bench.path("long.urdf"), &text).expect("a file");
    for command in ["check", "diagnose"] {
        let said = refused(&bench, &[command, "long.urdf", &run]);
        assert!(said.contains("long.urdf:40001:") && said.contains("'j40000'"), "{said}");
        assert!(said.contains("'screw'"), "{said}");
    }
    // Without it, all of them are one link that does not move.
    std::fs::write(bench.path("long.urdf"), text.replace("screw", "fixed")).expect("a file");
    let said = refused(&bench, &["check", "long.urdf", &run]);
    assert!(said.contains("long.urdf: no joint moves"), "{said}");
}
