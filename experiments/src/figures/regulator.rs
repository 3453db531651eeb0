//! Figures of the regulated manipulator.

use lacuna_control::ClosedLoop;
use std::collections::BTreeMap;

use super::chart::{Axis, Panel, Series, line_figure};
use crate::StudyError;

/// A signal of a joint (0 or 1) against time.
type Pick<'a> = &'a dyn Fn(&ClosedLoop, usize) -> Vec<(f64, f64)>;

/// Joint angles, velocities, torques, and the differences that the identified model makes, each
/// with the name of its file.
///
/// # Errors
/// [`StudyError::Figure`] when one cannot be drawn.
pub fn all(
    truth: &ClosedLoop,
    identified: &BTreeMap<String, ClosedLoop>,
) -> Result<[(&'static str, String); 4], StudyError> {
    let angle = |run: &ClosedLoop, joint: usize| column(run, &run.trajectory.states, 4, joint);
    let speed = |run: &ClosedLoop, joint: usize| column(run, &run.trajectory.states, 4, 2 + joint);
    let torque = |run: &ClosedLoop, joint: usize| column(run, &run.inputs, 2, joint);
    let pair = |label, pick: Pick| {
        line_figure(&[0, 1].map(|joint| panel(truth, identified, joint, label, pick)))
    };
    Ok([
        ("regulator_angles", pair("joint angle (rad)", &angle)?),
        ("regulator_velocities", pair("joint velocity (rad/s)", &speed)?),
        ("regulator_torques", pair("torque (N m)", &torque)?),
        ("regulator_differences", differences(truth, identified, &angle)?),
    ])
}

/// One column of row-major values against time.
fn column(run: &ClosedLoop, values: &[f64], width: usize, k: usize) -> Vec<(f64, f64)> {
    let times = run.trajectory.times.iter().copied();
    times.zip(values.chunks_exact(width).map(|row| row[k])).collect()
}

fn panel<'a>(
    truth: &ClosedLoop,
    identified: &BTreeMap<String, ClosedLoop>,
    joint: usize,
    label: &'a str,
    pick: Pick,
) -> Panel<'a> {
    let mut series = vec![Series::line("true model", 0, pick(truth, joint))];
    for (k, (name, run)) in identified.iter().enumerate() {
        let label = format!("identified model ({name})");
        series.push(Series::dashed(&label, k + 1, pick(run, joint)));
    }
    let title = ["Regulator: joint 1", "Regulator: joint 2"][joint];
    Panel { title, x: Axis::linear("time (s)"), y: Axis::linear(label), series }
}

fn differences(
    truth: &ClosedLoop,
    identified: &BTreeMap<String, ClosedLoop>,
    angle: Pick,
) -> Result<String, StudyError> {
    let mut series = Vec::new();
    for (k, (name, run)) in identified.iter().enumerate() {
        for joint in 0..2 {
            let pairs = angle(run, joint).into_iter().zip(angle(truth, joint));
            let points = pairs.map(|((t, a), (_, b))| (t, 1e3 * (a - b))).collect();
            let label = format!("joint {} ({name})", joint + 1);
            let draw = [Series::line, Series::dashed][joint];
            series.push(draw(&label, k + 1, points));
        }
    }
    line_figure(&[Panel {
        title: "Regulator: identified minus true model",
        x: Axis::linear("time (s)"),
        y: Axis::linear("difference of angles (mrad)"),
        series,
    }])
}
