//! Figures of the regulated manipulator.

use lacuna_charts::{Axis, Colour, Figure, Line, Size, Style};
use lacuna_control::ClosedLoop;
use std::collections::BTreeMap;

use super::{File, drawn, legend, side_by_side};
use crate::StudyError;
use crate::manipulator_ctc::Angles;
use crate::published::REGULATOR;
use crate::recipes::Recipe;

/// A signal of a joint (0 or 1) against time.
type Pick = fn(&ClosedLoop, usize) -> Vec<(f64, f64)>;

/// Figures 10 and 11 of the paper, the joint angles with the torque from the true and from the
/// identified model; then velocities, torques, and the differences that the identified model
/// makes.
///
/// # Errors
/// [`StudyError::Figure`] when one cannot be drawn.
pub fn all(
    truth: &ClosedLoop,
    identified: &BTreeMap<String, ClosedLoop>,
) -> Result<[File; 5], StudyError> {
    let by = |recipe: Recipe| Some((recipe, identified.get(recipe.name())?));
    let kernels: Vec<(Recipe, &ClosedLoop)> = Recipe::KERNELS.into_iter().filter_map(by).collect();
    let pair = |name: &str, unit: &str, pick: Pick| {
        let panels = [0, 1].map(|joint| panel(truth, identified, joint, pick));
        let axes = panels.map(|p| Figure { y: Axis::linear(name, unit), ..p });
        side_by_side(&format!("{name} of both joints against time."), axes.into())
    };
    Ok([
        ("figure_10_regulator_true_model", with_true_model(truth)?),
        ("figure_11_regulator_identified_model", with_identified_models(&kernels)?),
        ("regulator_velocities", pair("joint velocity", "rad/s", speed)?),
        ("regulator_torques", pair("torque", "N m", torque)?),
        ("regulator_differences", differences(truth, identified)?),
    ])
}

fn angle(run: &ClosedLoop, joint: usize) -> Vec<(f64, f64)> {
    column(run, &run.trajectory.states, 4, joint)
}

fn speed(run: &ClosedLoop, joint: usize) -> Vec<(f64, f64)> {
    column(run, &run.trajectory.states, 4, 2 + joint)
}

fn torque(run: &ClosedLoop, joint: usize) -> Vec<(f64, f64)> {
    column(run, &run.inputs, 2, joint)
}

/// One column of row-major values against time.
fn column(run: &ClosedLoop, values: &[f64], width: usize, k: usize) -> Vec<(f64, f64)> {
    let times = run.trajectory.times.iter().copied();
    times.zip(values.chunks_exact(width).map(|row| row[k])).collect()
}

fn with_true_model(run: &ClosedLoop) -> Result<String, StudyError> {
    let (ours, published) = (Angles::of(run), REGULATOR[0]);
    let lines = [(0, Style::Broad, Colour::Ink), (1, Style::Dashed, Colour::Vermilion)];
    let lines = lines.map(|(joint, style, colour)| {
        let label = label(joint, "true model", &ours, Some(&published));
        Line::new(&label, colour, style, angle(run, joint))
    });
    angles("Regulator: joint angles, torque from the true model", lines.into())
}

/// Solid lines are the first joint's, dashed ones the second's.
fn with_identified_models(runs: &[(Recipe, &ClosedLoop)]) -> Result<String, StudyError> {
    let mut lines = Vec::new();
    for (recipe, run) in runs {
        let (name, ours) = (recipe.name(), Angles::of(run));
        let published = (*recipe == Recipe::Paper).then_some(&REGULATOR[1]);
        for (joint, style) in [(0, Style::Solid), (1, Style::Dashed)] {
            let label = label(joint, legend::words(name), &ours, published);
            lines.push(Line::new(&label, legend::colour(name), style, angle(run, joint)));
        }
    }
    angles("Regulator: joint angles, torque from the identified model", lines)
}

/// A joint with its angles after 5 s and 10 s, and those that the paper shows.
fn label(joint: usize, model: &str, ours: &Angles, published: Option<&Angles>) -> String {
    let at = |a: &Angles| format!("{:.4}, {:.4}", a.q_5s[joint], a.q_10s[joint]);
    let published = published.map_or(String::new(), |p| format!(" (published: {})", at(p)));
    format!("q{}, {model}: 5 s, 10 s: {}{published}", joint + 1, at(ours))
}

fn angles(title: &str, lines: Vec<Line>) -> Result<String, StudyError> {
    drawn(&Figure {
        description: format!("{title}, against time."),
        title: title.to_owned(),
        size: Size::Wide,
        lines,
        ..Figure::new(Axis::linear("time", "s"), Axis::linear("joint angle", "rad"))
    })
}

fn panel(
    truth: &ClosedLoop,
    identified: &BTreeMap<String, ClosedLoop>,
    joint: usize,
    pick: Pick,
) -> Figure {
    let mut lines = vec![Line::new("true model", Colour::Ink, Style::Broad, pick(truth, joint))];
    for (name, run) in identified {
        let label = format!("identified, {}", legend::words(name));
        let style = if name == Recipe::Lacuna.name() { Style::Solid } else { Style::Dashed };
        lines.push(Line::new(&label, legend::colour(name), style, pick(run, joint)));
    }
    Figure {
        title: format!("Regulator: joint {}", joint + 1),
        lines,
        ..Figure::new(Axis::linear("time", "s"), Axis::linear("", ""))
    }
}

fn differences(
    truth: &ClosedLoop,
    identified: &BTreeMap<String, ClosedLoop>,
) -> Result<String, StudyError> {
    let mut lines = Vec::new();
    for (name, run) in identified {
        for (joint, style) in [(0, Style::Solid), (1, Style::Dashed)] {
            let pairs = angle(run, joint).into_iter().zip(angle(truth, joint));
            let points = pairs.map(|((t, a), (_, b))| (t, 1e3 * (a - b))).collect();
            let label = format!("q{}, {}", joint + 1, legend::words(name));
            lines.push(Line::new(&label, legend::colour(name), style, points));
        }
    }
    drawn(&Figure {
        description: "Joint angles with identified models minus those with the true one.".into(),
        title: "Regulator: identified minus true model".into(),
        size: Size::Wide,
        lines,
        ..Figure::new(Axis::linear("time", "s"), Axis::linear("difference of angles", "mrad"))
    })
}
