//! The pictures of a diagnosis: what the page shows and what is written as files.

mod errors;
mod friction;
mod missing_force;
mod proof;

use crate::Proof;
use lacuna_charts::{ChartError, Figure, Ratios, Surface, ratios_svg, svg};
use lacuna_discrepancy::Diagnosis;

pub(crate) use errors::errors;
pub(crate) use friction::friction;
pub(crate) use missing_force::missing_forces;
pub(crate) use proof::{Series, shown};

/// A picture with its caption.
pub(crate) struct Picture {
    /// What kind of picture, for its file: `proof`, `residual`.
    pub kind: &'static str,
    /// What it is of, for its file and in the file's words.
    pub of: String,
    pub caption: String,
    pub drawing: Drawing,
}

pub(crate) enum Drawing {
    Figure(Box<Figure>),
    Ratios(Ratios),
}

impl Picture {
    pub(crate) fn svg(&self, surface: Surface) -> Result<String, ChartError> {
        match &self.drawing {
            Drawing::Figure(figure) => svg(figure, surface),
            Drawing::Ratios(ratios) => ratios_svg(ratios, surface),
        }
    }

    /// Whether its horizontal axis is time, so that a part may be worth a closer look.
    pub(crate) fn over_time(&self) -> bool {
        matches!(&self.drawing, Drawing::Figure(f) if f.x.is_time())
    }
}

/// A picture as a file of its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FigureFile {
    /// Name of the file: letters, digits, `-`, `_` and `.svg`.
    pub name: String,
    /// Its text.
    pub svg: String,
}

/// The pictures of the page as files of their own, numbered in its order. A picture that has
/// nothing to show is left out.
#[must_use]
pub fn files(diagnosis: &Diagnosis, series: &[Proof]) -> Vec<FigureFile> {
    let located = missing_forces(diagnosis).into_iter().flat_map(|(_, pictures)| pictures);
    let proofs = shown(diagnosis, series).drawn.into_iter().flat_map(|s| s.pictures);
    errors(diagnosis)
        .into_iter()
        .chain(located)
        .chain(friction(diagnosis))
        .chain(proofs)
        .filter_map(|p| Some((p.svg(Surface::Own).ok()?, p)))
        .enumerate()
        .map(|(k, (svg, p))| FigureFile {
            name: format!("{:02}-{}-{}.svg", k + 1, p.kind, plain_name(&p.of)),
            svg: svg + "\n",
        })
        .collect()
}

/// A name that every file system takes: letters and digits of the Latin alphabet, `-` and `_`.
fn plain_name(name: &str) -> String {
    const LONGEST: usize = 60;
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' };
    let text: String = name.chars().map(plain).take(LONGEST).collect();
    text.trim_matches('-').to_owned()
}

#[cfg(test)]
mod tests {
    use super::plain_name;

    #[test]
    fn names_of_files_hold_nothing_that_a_path_obeys() {
        assert_eq!(plain_name("../run <1>.csv q"), "run--1--csv-q");
        assert_eq!(plain_name("q_1 dq"), "q_1-dq");
        assert_eq!(plain_name(&"x".repeat(300)).len(), 60);
    }
}
