//! The signature of every effect of the catalogue as a picture of the guide: what its law makes of a
//! typical motion, along the variable by which an engineer knows it.
//!
//! ```text
//! r(x; y)  against x for three y      a law without memory, of x and at most one y beside
//! r        along a motion, against q  a law with memory or an edge
//! |q''/u|  against the frequency      a memory that rings
//! u*       against u, or both in time what an actuator or a sensor makes of a series
//! M q'' - F along a motion            a robot's structure, with the effect and without
//! ```
//!
//! | what | module |
//! | --- | --- |
//! | magnitudes of what moves, in numbers and words | [`rig`] |
//! | parameters, from what is believed of them before any data | [`typical`] |
//! | pictures of forces | [`curve`], [`trace`], [`resonance`] |
//! | pictures of actuators and sensors, of robots | [`series`], [`structure`] |
//! | the guide's page about them | [`page`] |
//!
//! Which picture an effect gets follows from what its [`Effect`] says of itself: one that is new has
//! its picture without a change here.

pub mod curve;
pub mod force;
pub mod page;
pub mod resonance;
pub mod rig;
pub mod series;
pub mod structure;
pub mod thin;
pub mod trace;
pub mod typical;

use lacuna_charts::{Axis, Figure, Line, Surface, svg};
use lacuna_effects::{CATALOGUE, Effect, Law};
use std::path::Path;

use crate::{StudyError, output};

/// The page of the guide that shows the pictures.
pub const PAGE: &str = "catalogue.md";
/// Folder of the pictures beside it.
pub const FOLDER: &str = "signatures";

/// What writes them.
pub const COMMAND: &str = "cargo run --release -p experiments -- signatures";

/// Draw all pictures into the folder of the guide, and list them on its page.
///
/// # Errors
/// [`StudyError`] when one cannot be drawn, read or written.
pub fn run(guide: &Path, quiet: bool) -> Result<(), StudyError> {
    let path = guide.join(PAGE);
    let page = std::fs::read_to_string(&path)
        .map_err(|source| StudyError::Read { path: path.clone(), source })?;
    let page = page::with_pictures(&page);
    for effect in CATALOGUE {
        let name = format!("{FOLDER}/{}.svg", effect.class);
        output::replace(&guide.join(name), &picture(effect)?)?;
    }
    output::replace(&path, &page)?;
    if !quiet {
        println!("wrote {} pictures to {}", CATALOGUE.len(), guide.join(FOLDER).display());
    }
    Ok(())
}

/// The picture of an effect, as SVG text.
///
/// # Errors
/// [`StudyError`] when it cannot be drawn, or the robot that it acts on not be read.
pub fn picture(effect: &'static Effect) -> Result<String, StudyError> {
    let (x, y, lines) = match effect.law {
        Law::Force(law) => force::drawn(effect, law),
        Law::Input(law) | Law::Sensor(law) => series::drawn(effect, law),
        Law::Structure(_) => structure::drawn(effect)?,
    };
    let figure = Figure {
        description: format!("{}: {}", effect.class, effect.words),
        title: effect.class.to_owned(),
        lines: lines.into_iter().map(|l| thin::line(l, (&x.scale, &y.scale))).collect(),
        ..Figure::new(x, y)
    };
    Ok(svg(&figure, Surface::Paper)?)
}

/// Axes, and what is drawn between them.
pub type Drawn = (Axis, Axis, Vec<Line>);
