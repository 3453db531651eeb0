//! What was compiled, to print.

use super::sides::Sides;
use super::timing::Times;
use crate::say::sayln;
use lacuna::occupation::Names;
use lacuna::occupation::compile::{BOUNDARY_POINTS, Compiled, PROOF_POINTS, Representation};
use serde::Serialize;
use std::path::Path;

#[derive(Serialize)]
pub struct Report {
    model: String,
    out: String,
    tolerance: f64,
    #[serde(rename = "box")]
    sides: Vec<Side>,
    functions: Vec<Row>,
    /// Largest of all functions.
    relative_error: f64,
    numbers: usize,
    median_us: Times,
}

#[derive(Serialize)]
struct Side {
    argument: String,
    lower: f64,
    upper: f64,
    given: bool,
}

#[derive(Serialize)]
struct Row {
    function: String,
    representation: Representation,
    coefficients: usize,
    magnitude: f64,
    absolute: f64,
    relative: f64,
    estimate: f64,
}

impl Report {
    pub fn new(
        model: &Path,
        out: &Path,
        compiled: &Compiled,
        names: &Names,
        sides: &Sides,
        median_us: Times,
    ) -> Self {
        let side = |i: usize| Side {
            argument: names.arguments[i].clone(),
            lower: sides.domain.lower()[i],
            upper: sides.domain.upper()[i],
            given: sides.given[i],
        };
        let functions = compiled.functions().iter().map(|f| Row {
            function: f.name(Some(names)),
            representation: f.representation,
            coefficients: f.coefficients,
            magnitude: f.magnitude,
            absolute: f.absolute,
            relative: f.relative,
            estimate: f.estimate,
        });
        Self {
            model: model.display().to_string(),
            out: out.display().to_string(),
            tolerance: compiled.tolerance(),
            sides: (0..names.arguments.len()).map(side).collect(),
            functions: functions.collect(),
            relative_error: compiled.relative_error(),
            numbers: compiled.evaluator().numbers(),
            median_us,
        }
    }

    pub fn print(&self) -> std::io::Result<()> {
        sayln!(
            "{} compiled on the box: relative error {:.1e} (asked for: {:e})",
            self.model,
            self.relative_error,
            self.tolerance
        )?;
        for side in &self.sides {
            let from = if side.given { "" } else { "  (range of the data)" };
            sayln!("  {} from {:.6} to {:.6}{from}", side.argument, side.lower, side.upper)?;
        }
        let width = self.functions.iter().map(|f| f.function.len()).max().unwrap_or(0).max(8);
        sayln!(
            "{:<width$} {:<10} {:>12} {:>10} {:>11} {:>11} {:>11}",
            "function",
            "as",
            "coefficients",
            "largest",
            "error",
            "relative",
            "estimate"
        )?;
        for f in &self.functions {
            let kind = match f.representation {
                Representation::Zero => "zero",
                Representation::Series => "series",
                Representation::Landmarks => "landmarks",
            };
            sayln!(
                "{:<width$} {kind:<10} {:>12} {:>10.3e} {:>11.3e} {:>11.3e} {:>11.3e}",
                f.function,
                f.coefficients,
                f.magnitude,
                f.absolute,
                f.relative,
                f.estimate
            )?;
        }
        sayln!(
            "Errors are the largest on {PROOF_POINTS} points of the box and up to {BOUNDARY_POINTS} of its boundary, in \
             the units of\nthe recordings and relative to the function's largest value; the estimate is from what \
             was left out."
        )?;
        if self.functions.iter().any(|f| f.representation == Representation::Landmarks) {
            sayln!(
                "'landmarks': no series meets the tolerance at less cost; the model's own sum remains."
            )?;
        }
        let Times { direct, compiled } = self.median_us;
        sayln!(
            "One evaluation of all functions: {compiled:.2} us, {direct:.2} us before (medians, measured now); {} numbers.",
            self.numbers
        )?;
        sayln!("wrote {}", self.out)
    }
}
