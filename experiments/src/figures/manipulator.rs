//! Figures of the manipulator study.

use std::collections::BTreeMap;

use super::chart::{Axis, Panel, Series, line_figure};
use crate::StudyError;
use crate::manipulator_data::Errors;

/// Relative errors by decreasing distance from the origin, the paper's figure 5.
///
/// # Errors
/// [`StudyError::Figure`] when it cannot be drawn.
pub fn errors(recipes: &BTreeMap<String, Errors>) -> Result<String, StudyError> {
    let at = |values: &[f64]| (1..).map(f64::from).zip(values.iter().copied()).collect();
    let panel = |title, pick: fn(&Errors) -> &[f64]| {
        let curves = recipes.iter().enumerate();
        let series = curves.map(|(k, (name, e))| Series::dots(name, k + 1, at(pick(e)))).collect();
        let x = Axis::linear("evaluation point, farthest from the origin first");
        Panel { title, x, y: Axis::linear("relative error"), series }
    };
    line_figure(&[
        panel("Manipulator: drift f", |e| &e.f),
        panel("Manipulator: g, first column", |e| &e.g1),
        panel("Manipulator: g, second column", |e| &e.g2),
    ])
}
