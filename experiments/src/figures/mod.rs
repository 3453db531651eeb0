//! Figures of the studies, as SVG. Those of the paper have its numbers, `figure_01` to `figure_11`.

pub mod concealed;
pub mod duffing;
mod legend;
pub mod manipulator;
pub mod noise_sweep;
pub mod regulator;

use lacuna_charts::{Figure, Grid, Surface, grid_svg, svg};

use crate::StudyError;

/// Name of a figure's file, and its text.
pub type File = (&'static str, String);

/// A figure as a file of its own.
fn drawn(figure: &Figure) -> Result<String, StudyError> {
    Ok(svg(figure, Surface::Own)?)
}

/// Figures side by side under the first one's legend, as a file of its own.
fn side_by_side(description: &str, figures: Vec<Figure>) -> Result<String, StudyError> {
    Ok(grid_svg(&Grid { description: description.to_owned(), rows: vec![figures] })?)
}
