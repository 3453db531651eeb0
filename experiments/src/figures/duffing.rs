//! Figures of the Duffing study.

use lacuna_plants::Duffing;
use std::collections::BTreeMap;

use super::chart::{Axis, Panel, Samples, Series, box_figure, line_figure};
use crate::StudyError;
use crate::duffing_data::{Errors, TrialErrors, evaluation_points};
use crate::lambda_ablation::Ablation;
use crate::published::LambdaCurves;

/// Evaluate functions at the evaluation points: `(x, f^)` and `(x, g^)`.
pub type Curves = [Vec<(f64, f64)>; 2];

/// Evaluate `[f^, g^]` at the evaluation points.
///
/// # Errors
/// The first error of `values`.
pub fn curve(values: impl Fn(f64) -> Result<[f64; 2], StudyError>) -> Result<Curves, StudyError> {
    let mut curves = [Vec::new(), Vec::new()];
    for x in evaluation_points() {
        let [f, g] = values(x)?;
        curves[0].push((x, f));
        curves[1].push((x, g));
    }
    Ok(curves)
}

/// Mean errors against lambda, the paper's figure 1; published ones dashed behind ours.
///
/// # Errors
/// [`StudyError::Figure`] when it cannot be drawn.
pub fn ablation(
    found: &[Ablation],
    published: Option<&LambdaCurves>,
) -> Result<String, StudyError> {
    let usable = || found.iter().filter(|a| a.failed_trials == 0);
    let f = usable().map(|a| (a.lambda, a.mean_f.mean)).collect();
    let g = usable().map(|a| (a.lambda, a.mean_g.mean)).collect();
    let behind = published.map(|curves| {
        [
            Series::dashed("drift f, published", 0, curves.f.clone()),
            Series::dashed("control effectiveness g, published", 1, curves.g.clone()),
        ]
    });
    let ours = [Series::dots("drift f", 0, f), Series::dots("control effectiveness g", 1, g)];
    let series = behind.into_iter().flatten().chain(ours).collect();
    line_figure(&[Panel {
        title: "Duffing: choice of the regularisation",
        x: Axis::log("regularisation \u{3bb}"),
        y: Axis::log("mean absolute error (1/s\u{b2})"),
        series,
    }])
}

/// True and identified functions of one trial.
///
/// # Errors
/// [`StudyError::Figure`] when it cannot be drawn.
pub fn functions(recipes: &BTreeMap<&str, Curves>) -> Result<String, StudyError> {
    let plant = Duffing::default();
    let truth = curve(|x| Ok([plant.f(x), plant.g(x)]))?;
    let panel = |k: usize, title, label| {
        let mut series = vec![Series::line("true", 0, truth[k].clone())];
        for (colour, (name, curves)) in recipes.iter().enumerate() {
            let label = format!("identified ({name})");
            series.push(Series::dashed(&label, colour + 1, curves[k].clone()));
        }
        Panel { title, x: Axis::linear("position x"), y: Axis::linear(label), series }
    };
    line_figure(&[
        panel(0, "Duffing: drift", "f(x) (1/s\u{b2})"),
        panel(1, "Duffing: control effectiveness", "g(x) (1/s\u{b2})"),
    ])
}

/// Errors against position of one trial, the paper's figure 3.
///
/// # Errors
/// [`StudyError::Figure`] when it cannot be drawn.
pub fn errors(recipes: &BTreeMap<&str, Errors>) -> Result<String, StudyError> {
    let at = |values: &[f64]| evaluation_points().into_iter().zip(values.iter().copied()).collect();
    let panel = |title, label, pick: fn(&Errors) -> &[f64]| {
        let curves = recipes.iter().enumerate();
        let series = curves.map(|(k, (name, e))| Series::line(name, k + 1, at(pick(e)))).collect();
        Panel { title, x: Axis::linear("position x"), y: Axis::linear(label), series }
    };
    line_figure(&[
        panel("Duffing: error of the drift", "|f error| (1/s\u{b2})", |e| &e.f),
        panel("Duffing: error of the control effectiveness", "|g error| (1/s\u{b2})", |e| &e.g),
    ])
}

/// Greatest errors over trials, the paper's figure 4.
///
/// # Errors
/// [`StudyError::Figure`] when it cannot be drawn.
pub fn boxes(recipes: &BTreeMap<String, Vec<TrialErrors>>) -> Result<String, StudyError> {
    let panel = |pick: fn(&TrialErrors) -> f64| {
        let samples = recipes.iter();
        let samples =
            samples.map(|(name, e)| Samples { label: name, values: e.iter().map(pick).collect() });
        samples.collect::<Vec<_>>()
    };
    let titles = ["Duffing: drift, all trials", "Duffing: control effectiveness, all trials"];
    let panels = [panel(|e| e.max_f), panel(|e| e.max_g)];
    box_figure(&titles, "greatest absolute error (1/s\u{b2})", &panels)
}
