//! MJCF files that are drawn, of every way to say things.

use super::spaced;
use lacuna_excitation::rng;
use rand::{Rng, RngExt};

const HEAD: &str = r#"<default>
  <joint damping="0.1" armature="0.02"/>
  <geom density="800" size="0.05 0.07 0.09"/>
  <default class="soft"><joint stiffness="3" springref="0.2" ref="0.3"/><geom euler="0.3 0.2 0.1"/>
    <default class="slide"><joint type="slide" axis="1 2 -1" armature="0.3"/></default></default>
  <default class="heavy"><geom density="5000" type="box"/></default>
</default>
"#;

/// A tree of so many bodies on hinges and slides: they hang from any that is there.
pub fn drawn_mjcf(bodies: usize, seed: u64) -> String {
    let (worldbody, _) = drawn(bodies, seed, false);
    worldbody + "</mujoco>\n"
}

/// The same with free bodies and balls, and with hinges and slides that follow others.
pub fn drawn_every_joint(bodies: usize, seed: u64) -> String {
    let (worldbody, named) = drawn(bodies, seed, true);
    let mut rng = rng(seed, 4);
    let mut text = worldbody + "<equality>\n";
    for (k, follower) in named.iter().enumerate().skip(1).filter(|(k, _)| k % 2 == 1) {
        let leader = &named[rng.random_range(0..k)];
        let numbers = match rng.random_range(0..4) {
            0 => String::new(),
            _ => format!("polycoef=\"{}\"", spaced(&three(&mut rng, 1.0)[..2])),
        };
        text += &format!("<joint joint1=\"{follower}\" joint2=\"{leader}\" {numbers}/>\n");
    }
    text + "</equality></mujoco>\n"
}

/// All but the end, and the names of hinges and slides.
fn drawn(bodies: usize, seed: u64, several: bool) -> (String, Vec<String>) {
    let rng = &mut rng(seed, 2);
    let parents: Vec<usize> =
        (0..bodies).map(|k| rng.random_range(k.saturating_sub(3)..=k)).collect();
    let angle = ["radian", "degree"][rng.random_range(0..2)];
    let order = ["xyz", "zyx", "XYZ", "zXy", "yXY"][rng.random_range(0..5)];
    let mut text = format!(
        "<mujoco model=\"drawn\">\n<compiler angle=\"{angle}\" eulerseq=\"{order}\" inertiagrouprange=\"0 3\"/>\n\
         <option gravity=\"1 -2 -9\"/>\n{HEAD}<worldbody><geom type=\"plane\" size=\"1 1 1\"/>\n"
    );
    let mut named = vec![];
    inner(0, (&parents, several), rng, (&mut text, &mut named));
    (text + "</worldbody>\n", named)
}

/// The bodies that hang from one; the world is 0.
fn inner(
    of: usize,
    (parents, several): (&[usize], bool),
    rng: &mut impl Rng,
    (text, named): (&mut String, &mut Vec<String>),
) {
    for k in (0..parents.len()).filter(|k| parents[*k] == of) {
        let framed = rng.random_range(0..4) == 0;
        if framed {
            *text += &format!("<frame {}>", place(rng));
        }
        let class = ["", "childclass=\"soft\"", "childclass=\"slide\""][rng.random_range(0..3)];
        let name = if k % 5 == 4 { String::new() } else { format!("name=\"b{k}\"") };
        *text += &format!("<body {name} {class} {}>\n", place(rng));
        mass(rng, text);
        let kind = if several { rng.random_range(0..3) } else { 2 };
        if kind == 0 && of == 0 {
            *text += "<freejoint/>\n";
        } else {
            let joints = if k == 0 { 1 } else { [0, 1, 1, 1, 2, 3][rng.random_range(0..6)] };
            for j in 0..joints {
                named.extend(joint(&format!("j{k}_{j}"), rng, text));
            }
            if kind == 0 {
                ball(&format!("ball{k}"), rng, text);
            }
        }
        inner(k + 1, (parents, several), rng, (text, named));
        *text += if framed { "</body></frame>\n" } else { "</body>\n" };
    }
}

fn three(rng: &mut impl Rng, size: f64) -> [f64; 3] {
    [(); 3].map(|()| rng.random_range(-size..size))
}

fn place(rng: &mut impl Rng) -> String {
    format!("pos=\"{}\" {}", spaced(&three(rng, 0.5)), turn(rng))
}

fn turn(rng: &mut impl Rng) -> String {
    let (a, b, angle) =
        (spaced(&three(rng, 1.0)), spaced(&three(rng, 1.0)), rng.random_range(-3.0..3.0));
    match rng.random_range(0..7) {
        0 => format!("quat=\"{angle} {a}\""),
        1 => format!("axisangle=\"{a} {angle}\""),
        2 => format!("xyaxes=\"{a} {b}\""),
        3 => format!("zaxis=\"{a}\""),
        4 => "zaxis=\"0 0 -1\"".to_owned(),
        5 => format!("euler=\"{a}\""),
        _ => String::new(),
    }
}

/// A ball without friction, rotor or spring, which are not simulated in it.
fn ball(name: &str, rng: &mut impl Rng, text: &mut String) {
    let anchor = spaced(&three(rng, 0.4));
    *text += &format!(
        "<joint name=\"{name}\" type=\"ball\" pos=\"{anchor}\" damping=\"0\" armature=\"0\" stiffness=\"0\"/>\n"
    );
}

/// A hinge or a slide; its name, if it has one.
fn joint(name: &str, rng: &mut impl Rng, text: &mut String) -> Option<String> {
    let kind = ["", "type=\"slide\"", "type=\"hinge\""][rng.random_range(0..3)];
    let class = ["", "class=\"soft\"", "class=\"main\""][rng.random_range(0..3)];
    let named = (rng.random_range(0..5) != 0).then(|| name.to_owned());
    let name = named.as_ref().map_or_else(String::new, |name| format!("name=\"{name}\""));
    let (anchor, axis) = (spaced(&three(rng, 0.4)), spaced(&three(rng, 1.0)));
    let framed = rng.random_range(0..5) == 0;
    let joint = format!("<joint {name} {kind} {class} pos=\"{anchor}\" axis=\"{axis}\"/>\n");
    *text += &if framed { format!("<frame {}>{joint}</frame>", place(rng)) } else { joint };
    named
}

/// What a body weighs: an `<inertial>` or geoms.
fn mass(rng: &mut impl Rng, text: &mut String) {
    let [x, y, z] = three(rng, 0.04).map(|r| r.abs() + 0.01);
    let (pos, mass) = (spaced(&three(rng, 0.2)), rng.random_range(0.2..4.0));
    let principal = spaced(&[y + z, x + z, x + y]);
    match rng.random_range(0..4) {
        0 => {
            let turn = turn(rng);
            *text += &format!(
                "<inertial pos=\"{pos}\" mass=\"{mass}\" diaginertia=\"{principal}\" {turn}/>\n"
            );
        }
        1 => {
            let full = format!("{principal} 0.001 -0.002 0.0015");
            *text += &format!("<inertial pos=\"{pos}\" mass=\"{mass}\" fullinertia=\"{full}\"/>\n");
        }
        _ => {
            for _ in 0..rng.random_range(1..4) {
                geom(rng, text);
            }
            *text += "<geom type=\"sphere\" size=\"1\" group=\"4\"/>\n";
        }
    }
}

fn geom(rng: &mut impl Rng, text: &mut String) {
    let kind = ["sphere", "capsule", "cylinder", "ellipsoid", "box"][rng.random_range(0..5)];
    let class = ["", "class=\"heavy\"", "class=\"soft\""][rng.random_range(0..3)];
    let weight = match rng.random_range(0..3) {
        0 => format!("mass=\"{}\"", rng.random_range(0.1..2.0)),
        1 => format!("density=\"{}\"", rng.random_range(100.0..9000.0)),
        _ => String::new(),
    };
    // A part of the class's size is left, or all of it.
    let size = ["", "size=\"0.04\"", "size=\"0.03 0.11\"", "size=\"0.02 0.03 0.04\""]
        [rng.random_range(0..4)];
    let place = if kind != "sphere" && rng.random_range(0..3) == 0 {
        format!("fromto=\"{} {}\"", spaced(&three(rng, 0.3)), spaced(&three(rng, 0.3)))
    } else {
        place(rng)
    };
    *text += &format!("<geom type=\"{kind}\" {class} {weight} {size} {place}/>\n");
}
