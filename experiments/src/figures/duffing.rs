//! Figures of the Duffing study.

use lacuna_charts::{Axis, Band, Colour, Figure, Line, Size, Style, box_plot};
use lacuna_plants::Duffing;
use std::collections::BTreeMap;

use super::{File, drawn, legend, side_by_side};
use crate::StudyError;
use crate::duffing_data::{Errors, TrialErrors, evaluation_points};
use crate::lambda_ablation::Ablation;
use crate::published::{LambdaCurves, OneTrial};
use crate::recipes::Recipe;
use crate::statistics::quantile;

/// Evaluate functions at the evaluation points: `(x, f^)` and `(x, g^)`.
pub type Curves = [Vec<(f64, f64)>; 2];

/// Unit of f and of g.
const UNIT: &str = "1/s\u{b2}";
/// The two functions in words, and their letters.
const FUNCTIONS: [(&str, &str); 2] = [("drift", "f"), ("control effectiveness", "g")];

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

/// Mean errors against lambda; published ones dashed behind ours.
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
    let dashed = |label, colour, points: &Vec<(f64, f64)>| {
        Line::new(label, colour, Style::Dashed, points.clone())
    };
    let behind = published.map(|curves| {
        [
            dashed("drift f, published", Colour::Blue, &curves.f),
            dashed("control effectiveness g, published", Colour::Vermilion, &curves.g),
        ]
    });
    let ours = [
        Line::new("drift f", Colour::Blue, Style::Joined, f),
        Line::new("control effectiveness g", Colour::Vermilion, Style::Joined, g),
    ];
    drawn(&Figure {
        description: "Mean absolute errors of f and g against the regularisation.".into(),
        title: "Duffing: choice of the regularisation".into(),
        size: Size::Wide,
        lines: behind.into_iter().flatten().chain(ours).collect(),
        ..Figure::new(
            Axis::log("regularisation \u{3bb}", ""),
            Axis::log("mean absolute error over [-3, 3]", UNIT),
        )
    })
}

/// Figures 1 to 4 of the paper: drift and control effectiveness with their estimates, and the
/// errors of both, against position, of one trial.
///
/// # Errors
/// [`StudyError::Figure`] when one cannot be drawn.
pub fn trial(
    curves: &BTreeMap<&str, Curves>,
    errors: &BTreeMap<&str, Errors>,
) -> Result<[File; 4], StudyError> {
    let plant = Duffing::default();
    let truth = curve(|x| Ok([plant.f(x), plant.g(x)]))?;
    Ok([
        ("figure_01_duffing_f", estimate(0, &truth, curves)?),
        ("figure_02_duffing_g", estimate(1, &truth, curves)?),
        ("figure_03_duffing_f_error", error(0, errors, |e| &e.f)?),
        ("figure_04_duffing_g_error", error(1, errors, |e| &e.g)?),
    ])
}

/// A function and its estimates by the paper's recipe and by ours.
fn estimate(
    k: usize,
    truth: &Curves,
    recipes: &BTreeMap<&str, Curves>,
) -> Result<String, StudyError> {
    let (name, letter) = FUNCTIONS[k];
    let mut lines = vec![Line::new("true", Colour::Ink, Style::Broad, truth[k].clone())];
    for (recipe, style) in [(Recipe::Paper, Style::Dashed), (Recipe::Lacuna, Style::Solid)] {
        if let Some(curves) = recipes.get(recipe.name()) {
            let label = format!("estimate, {}", legend::words(recipe.name()));
            let colour = legend::colour(recipe.name());
            lines.push(Line::new(&label, colour, style, curves[k].clone()));
        }
    }
    drawn(&Figure {
        description: format!("The {name} {letter} and its estimates against position."),
        title: format!("Duffing: {name} {letter} and its estimates, one trial"),
        size: Size::Wide,
        lines,
        ..Figure::new(Axis::linear("position x", ""), Axis::linear(&format!("{letter}(x)"), UNIT))
    })
}

/// The error of a function by every recipe.
fn error(
    k: usize,
    recipes: &BTreeMap<&str, Errors>,
    pick: fn(&Errors) -> &[f64],
) -> Result<String, StudyError> {
    let (name, letter) = FUNCTIONS[k];
    let one = |(recipe, errors): (&&str, &Errors)| {
        let values = pick(errors);
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let published = match *recipe == Recipe::Paper.name() {
            true => {
                format!(" (published: {:.3}, {:.3})", OneTrial::ALL[k].max, OneTrial::ALL[k].mean)
            }
            false => String::new(),
        };
        let label = format!(
            "{}: max {:.4}, mean {mean:.4}{published}",
            legend::words(recipe),
            quantile(values, 1.0)
        );
        let style = if *recipe == Recipe::Sindyc.name() { Style::Dashed } else { Style::Solid };
        let points = evaluation_points().into_iter().zip(values.iter().copied()).collect();
        Line::new(&label, legend::colour(recipe), style, points)
    };
    drawn(&Figure {
        description: format!("Absolute error of the {name} {letter} against position."),
        title: format!("Duffing: error of the {name} {letter}, one trial"),
        size: Size::Wide,
        lines: recipes.iter().map(one).collect(),
        ..Figure::new(
            Axis::linear("position x", ""),
            Axis::log(&format!("|error of {letter}|"), UNIT),
        )
    })
}

/// Figures 5 and 6 of the paper, the mean errors trial by trial, and box plots of the greatest
/// errors.
///
/// # Errors
/// [`StudyError::Figure`] when one cannot be drawn.
pub fn montecarlo(recipes: &BTreeMap<String, Vec<TrialErrors>>) -> Result<[File; 3], StudyError> {
    Ok([
        ("figure_05_duffing_f_mean_error", means(0, recipes, |e| e.mean_f)?),
        ("figure_06_duffing_g_mean_error", means(1, recipes, |e| e.mean_g)?),
        ("duffing_montecarlo_boxes", boxes(recipes)?),
    ])
}

/// Mean error of each trial by every recipe.
fn means(
    k: usize,
    recipes: &BTreeMap<String, Vec<TrialErrors>>,
    pick: fn(&TrialErrors) -> f64,
) -> Result<String, StudyError> {
    let (name, letter) = FUNCTIONS[k];
    let one = |(recipe, errors): (&String, &Vec<TrialErrors>)| {
        let values: Vec<f64> = errors.iter().map(pick).collect();
        let published = match *recipe == Recipe::Paper.name() {
            true => format!(" (published, one trial: {:.3})", OneTrial::ALL[k].mean),
            false => String::new(),
        };
        let label =
            format!("{}: median {:.4}{published}", legend::words(recipe), quantile(&values, 0.5));
        let points = (1..).map(f64::from).zip(values).collect();
        Line::new(&label, legend::colour(recipe), Style::Dots, points)
    };
    drawn(&Figure {
        description: format!("Mean absolute error of the {name} {letter} of each trial."),
        title: format!("Duffing: mean error of the {name} {letter}, trial by trial"),
        size: Size::Wide,
        lines: recipes.iter().map(one).collect(),
        ..Figure::new(
            Axis::linear("trial", ""),
            Axis::log(&format!("mean |error of {letter}| over [-3, 3]"), UNIT),
        )
    })
}

/// Greatest errors over trials.
fn boxes(recipes: &BTreeMap<String, Vec<TrialErrors>>) -> Result<String, StudyError> {
    let names: Vec<&str> = recipes.keys().map(|name| legend::words(name)).collect();
    let panel = |k: usize, pick: fn(&TrialErrors) -> f64| {
        let (name, letter) = FUNCTIONS[k];
        let parts = recipes.iter().enumerate().map(|(at, (recipe, errors))| {
            let values: Vec<f64> = errors.iter().map(pick).collect();
            box_plot(at, legend::colour(recipe), &values)
        });
        let (bands, lines): (Vec<Option<Band>>, Vec<Vec<Line>>) = parts.unzip();
        Figure {
            title: format!("Duffing: {name} {letter}, all trials"),
            bands: bands.into_iter().flatten().collect(),
            lines: lines.into_iter().flatten().collect(),
            ..Figure::new(
                Axis::names(&names),
                Axis::log(&format!("greatest |error of {letter}| over [-3, 3]"), UNIT),
            )
        }
    };
    let panels = vec![panel(0, |e| e.max_f), panel(1, |e| e.max_g)];
    side_by_side("Box plots of the greatest errors of f and g over the trials.", panels)
}
