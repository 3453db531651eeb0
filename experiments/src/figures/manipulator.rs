//! Figures of the manipulator study.

use lacuna_charts::{Axis, Figure, Line, Size, Style};
use std::collections::BTreeMap;

use super::{File, drawn, legend, side_by_side};
use crate::StudyError;
use crate::manipulator_data::Errors;
use crate::published::MANIPULATOR;
use crate::recipes::Recipe;
use crate::statistics::OverPoints;

/// What the errors are of.
const FUNCTIONS: [&str; 3] = ["drift f", "first column of g", "second column of g"];

/// Figures 7 to 9 of the paper: relative errors by decreasing distance from the origin.
///
/// # Errors
/// [`StudyError::Figure`] when one cannot be drawn.
pub fn errors(recipes: &BTreeMap<String, Errors>) -> Result<[File; 3], StudyError> {
    let draw = |k: usize| {
        let numbers = |name: &str, e: &Errors| numbers(name, values(e, k), MANIPULATOR[k]);
        drawn(&Figure { size: Size::Wide, ..figure(recipes, k, numbers) })
    };
    Ok([
        ("figure_07_manipulator_f_error", draw(0)?),
        ("figure_08_manipulator_g1_error", draw(1)?),
        ("figure_09_manipulator_g2_error", draw(2)?),
    ])
}

/// The same from noisy states, in one figure.
///
/// # Errors
/// [`StudyError::Figure`] when it cannot be drawn.
pub fn noisy_errors(recipes: &BTreeMap<String, Errors>) -> Result<String, StudyError> {
    let name = |name: &str, _: &Errors| legend::words(name).to_owned();
    let panels = (0..FUNCTIONS.len()).map(|k| figure(recipes, k, name)).collect();
    side_by_side("Relative errors of f, g1 and g2 from noisy states.", panels)
}

fn values(errors: &Errors, k: usize) -> &[f64] {
    [&errors.f, &errors.g1, &errors.g2][k]
}

/// A recipe with its errors, and those that the paper shows.
fn numbers(name: &str, values: &[f64], published: OverPoints) -> String {
    let ours = OverPoints::of(values);
    let published = match name == Recipe::Paper.name() {
        true => format!(" (published: {:.3}, {:.3})", published.max, published.median),
        false => String::new(),
    };
    let words = legend::words(name);
    format!("{words}: max {:.3}, median {:.3}{published}", ours.max, ours.median)
}

fn figure(
    recipes: &BTreeMap<String, Errors>,
    k: usize,
    label: impl Fn(&str, &Errors) -> String,
) -> Figure {
    let one = |(name, errors): (&String, &Errors)| {
        let points = (1..).map(f64::from).zip(values(errors, k).iter().copied()).collect();
        Line::new(&label(name, errors), legend::colour(name), Style::Joined, points)
    };
    let what = FUNCTIONS[k];
    Figure {
        description: format!("Relative error of the {what} at each evaluation point."),
        title: format!("Manipulator: {what}"),
        lines: recipes.iter().map(one).collect(),
        ..Figure::new(
            Axis::linear("evaluation point, farthest from the origin first", ""),
            Axis::log("relative error", ""),
        )
    }
}
