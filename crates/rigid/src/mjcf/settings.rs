//! `<compiler>` and `<option>`: how the rest of a file is meant.

use crate::GRAVITY;
use crate::algebra::Vector;
use crate::robot::RobotError;
use crate::xml::{Element, numbers_or};

/// A turn of three about axes, one after the other.
#[derive(Clone, Copy)]
pub(super) struct Turn {
    /// The number of its axis.
    pub axis: usize,
    /// Whether that is an axis of the parent, and not one that the turns before have moved.
    pub fixed: bool,
}

/// Whether geoms say a body's inertia.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum FromGeoms {
    Never,
    Always,
    /// Where there is no `<inertial>`.
    Auto,
}

pub(super) struct Settings {
    /// Of an angle in the file, rad.
    pub angle: f64,
    pub euler: [Turn; 3],
    pub from_geoms: FromGeoms,
    /// The first and last group of the geoms that have mass.
    pub groups: [f64; 2],
    /// Least mass of a body, kg.
    pub least_mass: f64,
    /// Least principal inertia of a body, kg m^2.
    pub least_inertia: f64,
    /// Whether an inertia that no body can have becomes that of a sphere.
    pub balance: bool,
    pub gravity: Vector<f64>,
}

impl Settings {
    pub fn read(root: Element) -> Result<Self, RobotError> {
        let compiler = |name| last(root, "compiler", name);
        let option = |name| last(root, "option", name);
        check_supported(root)?;
        let angle =
            choice(compiler("angle"), "angle", &[("degree", 1f64.to_radians()), ("radian", 1.0)])?;
        let from_geoms = choice(
            compiler("inertiafromgeom"),
            "inertiafromgeom",
            &[("auto", FromGeoms::Auto), ("true", FromGeoms::Always), ("false", FromGeoms::Never)],
        )?;
        let balance = choice(
            compiler("balanceinertia"),
            "balanceinertia",
            &[("false", false), ("true", true)],
        )?;
        let [least_mass] = numbers_or(compiler("boundmass"), "boundmass", [0.0])?;
        let [least_inertia] = numbers_or(compiler("boundinertia"), "boundinertia", [0.0])?;
        let flags = || root.children("option").flat_map(|o| o.children("flag"));
        let falls = flags().all(|flag| flag.get("gravity") != Some("disable"));
        let gravity = numbers_or(option("gravity"), "gravity", GRAVITY)?;
        Ok(Self {
            angle,
            euler: turns(compiler("eulerseq"))?,
            from_geoms,
            groups: numbers_or(compiler("inertiagrouprange"), "inertiagrouprange", [0.0, 5.0])?,
            least_mass,
            least_inertia,
            balance,
            gravity: if falls { gravity } else { [0.0; 3] },
        })
    }
}

/// No part of the robot may be in another file, or written by a rule that MuJoCo carries out.
pub(super) fn check_alone(root: Element) -> Result<(), RobotError> {
    match root.descendants().find(|e| e.tag() == "include") {
        Some(include) => {
            let file = include.get("file").unwrap_or_default();
            Err(include.error(format!("<include> of \"{file}\": no other file is read. {EXPAND}")))
        }
        None => Ok(()),
    }
}

/// What makes one plain file of any.
pub(super) const EXPAND: &str = "MuJoCo writes a robot as one plain file with mj_saveLastXML";

/// What changes how a robot moves and is not simulated.
fn check_supported(root: Element) -> Result<(), RobotError> {
    let number = |element: Option<Element>, name, otherwise: f64| {
        numbers_or(element, name, [otherwise]).map(|[n]| n)
    };
    for (section, name, why) in [
        ("option", "density", "forces of a fluid are not simulated"),
        ("option", "viscosity", "forces of a fluid are not simulated"),
        ("compiler", "settotalmass", "masses are taken as they are written"),
    ] {
        let stated = last(root, section, name);
        if let Some(element) = stated
            && number(stated, name, 0.0)? > 0.0
        {
            return Err(element.error(format!("'{name}' of <{section}>: {why}")));
        }
    }
    if let Some(element) = last(root, "compiler", "coordinate")
        && element.get("coordinate") != Some("local")
    {
        return Err(element.must_be("coordinate", "\"local\""));
    }
    for flag in root.children("option").flat_map(|o| o.children("flag")) {
        for name in ["spring", "damper", "frictionloss"] {
            if flag.get(name) == Some("disable") {
                let message =
                    format!("'{name}' is disabled by <flag>: leave it out of the joints instead");
                return Err(flag.error(message));
            }
        }
    }
    Ok(())
}

/// The last section that states something: later ones win.
pub(super) fn last<'a>(
    root: Element<'a>,
    section: &'static str,
    name: &str,
) -> Option<Element<'a>> {
    root.children(section).rev().find(|e| e.get(name).is_some())
}

/// One of some words, the first where nothing is said.
fn choice<T: Copy>(
    element: Option<Element>,
    name: &str,
    choices: &[(&str, T)],
) -> Result<T, RobotError> {
    let Some(element) = element else { return Ok(choices[0].1) };
    let said = element.attribute(name)?;
    let found = choices.iter().find(|(word, _)| *word == said);
    found.map(|(_, meaning)| *meaning).ok_or_else(|| {
        let words: Vec<&str> = choices.iter().map(|(word, _)| *word).collect();
        element.must_be(name, &format!("one of {}", words.join(", ")))
    })
}

/// Small letters are moved axes, capitals are fixed ones.
fn turns(compiler: Option<Element>) -> Result<[Turn; 3], RobotError> {
    let Some(element) = compiler else {
        return Ok([0, 1, 2].map(|axis| Turn { axis, fixed: false }));
    };
    let turn = |letter: char| {
        let axis = "xyz".find(letter.to_ascii_lowercase())?;
        Some(Turn { axis, fixed: letter.is_ascii_uppercase() })
    };
    let turns: Option<Vec<Turn>> = element.attribute("eulerseq")?.chars().map(turn).collect();
    turns.and_then(|turns| turns.try_into().ok()).ok_or_else(|| {
        element.must_be("eulerseq", "three of the letters x, y, z (moved axes), X, Y, Z (fixed)")
    })
}
