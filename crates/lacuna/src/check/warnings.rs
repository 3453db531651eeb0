//! What to mind, and what to do about it.

use super::Report;
use super::channels::{Channel, Input, Run, Stretch};
use super::velocities::Velocity;
use crate::plants::Model;
use crate::plants::model::same_unit;
use crate::table::number;
use std::f64::consts::PI;

/// A channel that moves less than this many noise standard deviations says little.
const FAINT: f64 = 5.0;
/// Recordings whose ranges differ by this factor may differ in their unit.
const UNLIKE: f64 = 10.0;
/// Steps that differ by more than this share are another sampling.
const OTHER_STEP: f64 = 0.05;
/// More dropped rows or missing values than this share are said.
const MANY: f64 = 0.05;
/// More outliers than this share are a fault to look for: chance bit errors are rarer.
const OFTEN: f64 = 0.01;
/// A velocity that is off by more than this share of its coordinate's rate is off by more than a sensor's scale.
const OFF: f64 = 0.1;
/// Velocities correlated with their coordinates' rates less than this are something else's: less than half of either is in
/// the other.
const UNRELATED: f64 = 0.7;
/// A velocity that comes later than this many samples is late: differences of samples make half a sample.
const LATE: f64 = 1.0;
/// A factor is one of units within this share.
const NEAR: f64 = 0.03;
/// Seconds from 1970 to 1990 and to 2100: clocks of today are between them.
const TODAY: [f64; 2] = [6.3e8, 4.1e9];
/// Units of times that are often recorded, and their seconds.
const CLOCKS: [(&str, f64); 3] = [("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];
/// What a factor between a coordinate's rate and its velocity often means.
const FACTORS: [(f64, &str); 8] = [
    (180.0 / PI, "degrees for radians"),
    (2.0 * PI, "turns for radians"),
    (30.0 / PI, "rpm for rad/s"),
    (6.0, "rpm for deg/s"),
    (60.0, "minutes for seconds, or rpm for turns a second"),
    (360.0, "degrees for turns"),
    (1e3, "thousandths (mm for m), or times in ms: then time_unit = \"ms\" in [recordings]"),
    (1e6, "millionths, or times in us: then time_unit = \"us\" in [recordings]"),
];
/// Inputs correlated above this are one input.
const SAME_INPUT: f64 = 0.98;

/// All warnings, the gravest first.
pub fn warnings(model: &Model, report: &Report) -> Vec<String> {
    let mut out = model.assumptions.clone();
    force_units(model, &mut out);
    out.extend(report.recordings.iter().filter_map(clock));
    out.extend(report.velocities.iter().filter_map(|v| velocity(v, &report.channels)));
    units(report, &mut out);
    sampling(report, &mut out);
    missing(report, &mut out);
    channels(report, &mut out);
    inputs(report, &mut out);
    parameters(model, report, &mut out);
    out
}

/// Equations that cannot be right in the units that the model states.
fn force_units(model: &Model, out: &mut Vec<String>) {
    for (channel, coordinate) in model.coordinates.iter().enumerate() {
        let said = model.said_force_units(channel);
        let Some(first) = said.first() else { continue };
        let Some(other) = said.iter().find(|s| !same_unit(&s.unit, &first.unit)) else { continue };
        out.push(format!(
            "the units of the model do not agree in the equation of '{}': by '{}' its force is in {}, by '{}' \
             in {}; correct the units, or convert in the equation",
            coordinate.name, first.by, first.unit, other.by, other.unit
        ));
    }
}

/// Times that are a date, if they are not in seconds.
fn clock(run: &Run) -> Option<String> {
    let is_today = |seconds: f64| (TODAY[0]..TODAY[1]).contains(&(run.from_s * seconds));
    let (unit, _) = CLOCKS.into_iter().find(|(_, seconds)| is_today(*seconds))?;
    Some(format!(
        "{}: its times begin at {} and are read as seconds; they look like {unit} since 1970: state time_unit = \
         \"{unit}\" in [recordings] of the model",
        run.name,
        number(run.from_s)
    ))
}

/// A velocity that is not its coordinate's rate.
fn velocity(v: &Velocity, channels: &[Channel]) -> Option<String> {
    let Velocity { coordinate, velocity, scale: [low, high], correlation, .. } = v;
    let is_faint = |c: &&Channel| c.name == *coordinate || c.name == *velocity;
    if channels.iter().filter(is_faint).any(|c| c.signal_to_noise.is_some_and(|r| r < FAINT)) {
        return None;
    }
    if correlation.abs() < UNRELATED {
        return Some(format!(
            "velocity '{velocity}' is not the rate of '{coordinate}' (correlation {correlation:.2}): check which \
             columns they are"
        ));
    }
    let size = (low * high).abs().sqrt();
    if *high < 0.0 && is_one(size, OFF) {
        return Some(format!(
            "velocity '{velocity}' is the rate of '{coordinate}' with the other sign: reverse one of the columns"
        ));
    }
    if low.abs() > 1.0 + OFF || high.abs() < 1.0 - OFF {
        let sign = if *high < 0.0 { "-" } else { "" };
        let factor = if size > 1.0 { size } else { 1.0 / size };
        let known = FACTORS.into_iter().find(|(known, _)| is_one(factor / known, NEAR));
        let known = known.map_or_else(String::new, |(_, words)| format!(" ({words})"));
        return Some(format!(
            "the rate of '{coordinate}' is {sign}{} times what '{velocity}' says{known}: state the unit of each column \
             (unit in [[measurement]])",
            number(size)
        ));
    }
    (v.lag_samples.abs() > LATE).then(|| {
        let late = if v.lag_s > 0.0 { "after" } else { "before" };
        format!(
            "velocity '{velocity}' comes {} s {late} the rate of '{coordinate}': a filter or another clock, which \
             `diagnose` tells as a lag or a delay of its sensor",
            number(v.lag_s.abs())
        )
    })
}

fn is_one(ratio: f64, within: f64) -> bool {
    (ratio - 1.0).abs() <= within
}

fn units(report: &Report, out: &mut Vec<String>) {
    let channels = report.channels.iter().map(|c| (&c.column, &c.recordings));
    let inputs = report.inputs.iter().map(|u| (&u.column, &u.recordings));
    for (column, stretches) in channels.chain(inputs) {
        out.extend(unlike(column, stretches));
    }
}

/// A recording in which a column moves far more or far less than usual.
fn unlike(column: &str, stretches: &[Stretch]) -> Option<String> {
    let mut spreads: Vec<f64> = stretches.iter().map(|s| s.sd).filter(|sd| *sd > 0.0).collect();
    spreads.sort_by(f64::total_cmp);
    // The lower middle: of two recordings, the larger one is then the odd one.
    let usual = *spreads.get(spreads.len().checked_sub(1)? / 2)?;
    let ratio = |s: &Stretch| s.sd / usual;
    let odd =
        stretches.iter().find(|s| s.sd > 0.0 && !(1.0 / UNLIKE..UNLIKE).contains(&ratio(s)))?;
    Some(format!(
        "{}: column '{column}' moves {} times as much as in the other recordings: if its unit is \
         another one, write it in the unit that the model states",
        odd.recording,
        number(ratio(odd))
    ))
}

fn sampling(report: &Report, out: &mut Vec<String>) {
    let first = &report.recordings[0];
    for r in &report.recordings[1..] {
        if (r.step_s / first.step_s - 1.0).abs() > OTHER_STEP {
            out.push(format!(
                "{} is sampled every {} s, {} every {} s: check that both count time in seconds; \
                 recordings of one sampling weigh alike",
                r.name,
                number(r.step_s),
                first.name,
                number(first.step_s)
            ));
        }
    }
    for r in report.recordings.iter().filter(|r| !r.uniform) {
        out.push(format!(
            "{}: the sampling is uneven (jitter {:.0} %): its times are used as they are; make \
             sure that they are the times of measurement and not of writing",
            r.name,
            100.0 * r.jitter
        ));
    }
}

fn missing(report: &Report, out: &mut Vec<String>) {
    for r in &report.recordings {
        let share = r.dropped_rows as f64 / (r.rows + r.dropped_rows) as f64;
        if share > MANY {
            out.push(format!(
                "{}: {:.0} % of the rows are dropped ({} in {} gaps): inputs there are drawn as \
                 straight lines; if a gap is a pause, give the parts as recordings of their own \
                 (#rows=FROM..TO)",
                r.name,
                100.0 * share,
                r.dropped_rows,
                r.gaps
            ));
        }
        for (column, &count) in &r.missing {
            let is_input = report.inputs.iter().any(|u| &u.column == column);
            let is_channel = report.channels.iter().any(|c| &c.column == column);
            if is_input {
                out.push(format!(
                    "{}: {count} values of the input column '{column}' are missing: they are drawn \
                     as straight lines between their neighbours; record the input without holes",
                    r.name
                ));
            } else if is_channel && count as f64 > MANY * r.rows as f64 {
                out.push(format!(
                    "{}: {count} of {} values of column '{column}' are missing",
                    r.name, r.rows
                ));
            }
        }
    }
}

fn channels(report: &Report, out: &mut Vec<String>) {
    for c in &report.channels {
        if c.range[0] == c.range[1] {
            out.push(format!(
                "channel '{}' never changes: nothing about it can be learned; check the column '{}'",
                c.name, c.column
            ));
        } else if let Some(ratio) = c.signal_to_noise.filter(|r| *r < FAINT) {
            out.push(faint(c, ratio));
        }
        let count: usize = c.outliers.iter().map(|m| m.count).sum();
        let rows: usize = report.recordings.iter().map(|r| r.rows).sum();
        if count as f64 > OFTEN * rows as f64 {
            out.push(format!(
                "{:.1} % of the samples of channel '{}' are outliers: check its sensor and cables; \
                 if they are real, they last too short for this sampling",
                100.0 * count as f64 / rows as f64,
                c.name
            ));
        }
    }
}

fn faint(c: &Channel, ratio: f64) -> String {
    format!(
        "channel '{}' barely moves: {} times its noise of {} {}; drive it harder, or measure it \
         more finely",
        c.name,
        number(ratio),
        number(c.noise_sd),
        c.conversion.unit
    )
}

fn inputs(report: &Report, out: &mut Vec<String>) {
    for u in &report.inputs {
        match u.order {
            0 => out.push(format!(
                "input '{}' never changes: its gain, and any effect on it, cannot be seen; record \
                 with a moving input",
                u.name
            )),
            1..=3 => out.push(format!(
                "input '{}' holds a single frequency or a single step (order {}): many models fit \
                 such recordings; excite with several frequencies across the band of interest",
                u.name, u.order
            )),
            _ => {}
        }
    }
    for (i, a) in report.inputs.iter().enumerate() {
        for b in &report.inputs[i + 1..] {
            let r = correlation(a, b);
            if r.abs() > SAME_INPUT {
                out.push(format!(
                    "inputs '{}' and '{}' move together (correlation {r:.3}): what each does cannot \
                     be told apart; excite them independently",
                    a.name, b.name
                ));
            }
        }
    }
}

fn correlation(a: &Input, b: &Input) -> f64 {
    let series = |u: &Input| u.series.concat();
    let (a, b) = (series(a), series(b));
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (ma, mb) = (mean(&a), mean(&b));
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (x, y) in a.iter().zip(&b) {
        ab += (x - ma) * (y - mb);
        aa += (x - ma).powi(2);
        bb += (y - mb).powi(2);
    }
    // An input that never changes correlates with nothing.
    if aa * bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 }
}

fn parameters(model: &Model, report: &Report, out: &mut Vec<String>) {
    if let Some(reason) = &report.parameters.not_assessed {
        out.push(format!(
            "whether the recordings excite the parameters of {} is not known: {reason}; simulate \
             works all the same, diagnose does not",
            model.name
        ));
    }
    for pair in &report.parameters.confounded {
        out.push(format!(
            "parameters '{}' and '{}' cannot be told apart in these recordings (correlation {:.3}): \
             only a combination of them shows; vary the motion, or state one of them without \
             tolerance",
            pair.parameters[0], pair.parameters[1], pair.correlation
        ));
    }
    for p in report.parameters.list.iter().filter(|p| !p.excited) {
        out.push(format!(
            "parameter '{}' is not excited: its standard deviation stays at {:.0} % of its \
             tolerance; record a motion in which it matters",
            p.name,
            100.0 * p.std_after / p.std_before
        ));
    }
}
