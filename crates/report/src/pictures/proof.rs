//! A held-out recording: what was measured, what the model says, and what is left.

use super::{Drawing, Picture};
use crate::autocorrelation::Autocorrelation;
use crate::number::{percent, plain};
use crate::thin::{POINTS, thin};
use crate::{Imposed, Proof};
use lacuna_charts::{Axis, Band, Colour, Figure, Line, Style};
use lacuna_discrepancy::Diagnosis;

/// Series that are drawn at most.
const DRAWN: usize = 60;
/// Points of all lines together, at most nine bytes each, and lines of a series.
const BUDGET: usize = 240_000;
const LINES: usize = 5;
/// Samples of a loop that are drawn at most: more of them lie upon one another.
const LOOP: usize = 600;
/// Residuals before are cut off beyond this many times what is left after, which they would
/// flatten.
const CUT: f64 = 6.0;

/// The series that are drawn, and how many are not.
pub(crate) struct Shown<'a> {
    pub drawn: Vec<Series<'a>>,
    pub left: usize,
}

/// A series with its pictures.
pub(crate) struct Series<'a> {
    pub proof: &'a Proof,
    pub pictures: Vec<Picture>,
}

pub(crate) fn shown<'a>(d: &Diagnosis, series: &'a [Proof]) -> Shown<'a> {
    let drawn = &series[..series.len().min(DRAWN)];
    let points = (BUDGET / (LINES * drawn.len().max(1))).min(POINTS);
    let one = |proof: &'a Proof| {
        let noise = d.fit.held_out.get(&proof.channel).map_or(0.0, |f| f.noise);
        let (before, after) = (residual(proof, &proof.before), residual(proof, &proof.after));
        let mut pictures = vec![run(proof, points), left(proof, (&before, &after), noise, points)];
        pictures.extend(autocorrelation(proof, &before, &after));
        pictures.extend(proof.imposed.iter().map(|over| force_loop(proof, over)));
        Series { proof, pictures }
    };
    Shown { drawn: drawn.iter().map(one).collect(), left: series.len() - drawn.len() }
}

fn residual(p: &Proof, model: &[f64]) -> Vec<f64> {
    p.measured.iter().zip(model).map(|(y, m)| y - m).collect()
}

fn picture(p: &Proof, kind: &'static str, caption: String, figure: Figure) -> Picture {
    let of = format!("{} {}", p.recording, p.channel);
    Picture { kind, of, caption, drawing: Drawing::Figure(Box::new(figure)) }
}

fn run(p: &Proof, points: usize) -> Picture {
    let line = |label, colour, style, values: &[f64]| {
        Line::new(label, colour, style, thin(&p.time, values, points))
    };
    let rms = |model: &[f64]| plain(rms(&residual(p, model)), &p.unit);
    let figure = Figure {
        description: format!(
            "{} of {} over time: measured, model before (rms error {}) and model after (rms error \
             {}).",
            p.channel,
            p.recording,
            rms(&p.before),
            rms(&p.after)
        ),
        lines: vec![
            line("model before", Colour::Vermilion, Style::Dashed, &p.before),
            line("measured", Colour::Ink, Style::Broad, &p.measured),
            line("model after", Colour::Blue, Style::Solid, &p.after),
        ],
        within: view(p),
        ..Figure::new(Axis::linear("time", "s"), Axis::linear(&p.channel, &p.unit))
    };
    picture(p, "proof", "Measured, and the model running free".to_owned(), figure)
}

/// A force against the motion that was imposed, in the middle of the recording.
fn force_loop(p: &Proof, over: &Imposed) -> Picture {
    let samples = over.values.len().min(p.time.len());
    let first = (samples - samples.min(LOOP)) / 2;
    let line = |label, colour, style, values: &[f64]| {
        let points = over.values.iter().copied().zip(values.iter().copied());
        Line::new(label, colour, style, points.skip(first).take(LOOP).collect())
    };
    let figure = Figure {
        description: format!(
            "{} of {} against the imposed {}: measured, model before and model after, the middle {} \
             of {samples} samples.",
            p.channel,
            p.recording,
            over.name,
            samples.min(LOOP)
        ),
        lines: vec![
            line("model before", Colour::Vermilion, Style::Dashed, &p.before),
            line("measured", Colour::Ink, Style::Broad, &p.measured),
            line("model after", Colour::Blue, Style::Solid, &p.after),
        ],
        within: view(p),
        ..Figure::new(Axis::linear(&over.name, &over.unit), Axis::linear(&p.channel, &p.unit))
    };
    picture(p, "loop", format!("{} against {}", p.channel, over.name), figure)
}

/// The measured values with one span around them: a model that runs away must not flatten
/// them.
fn view(p: &Proof) -> Option<(f64, f64)> {
    let finite = p.measured.iter().filter(|v| v.is_finite());
    let (low, high) =
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
    (high > low).then_some((2.0 * low - high, 2.0 * high - low))
}

/// What the models leave, with the band of the noise.
fn left(p: &Proof, (before, after): (&[f64], &[f64]), noise: f64, points: usize) -> Picture {
    let line = |label, colour, style, values: &[f64]| {
        Line::new(label, colour, style, thin(&p.time, values, points))
    };
    let within = near(before, after, noise);
    let cut = within.is_some_and(|(_, high)| before.iter().any(|v| v.abs() > high));
    let ends = p.time.first().into_iter().chain(p.time.last());
    let edges = ends.map(|&t| (t, -2.0 * noise, 2.0 * noise)).collect();
    let band = Band { label: "± 2 std noise".into(), colour: Colour::Ink, edges };
    let figure = Figure {
        description: format!(
            "Residuals of {} in {} over time, measured minus model: rms {} before, {} after; two \
             standard deviations of the noise are {}.",
            p.channel,
            p.recording,
            plain(rms(before), &p.unit),
            plain(rms(after), &p.unit),
            plain(2.0 * noise, &p.unit)
        ),
        bands: if noise > 0.0 { vec![band] } else { vec![] },
        lines: vec![
            line(
                if cut { "before (cut off)" } else { "before" },
                Colour::Vermilion,
                Style::Dashed,
                before,
            ),
            line("after", Colour::Blue, Style::Thin, after),
        ],
        within,
        ..Figure::new(
            Axis::linear("time", "s"),
            Axis::linear(&format!("{} - model", p.channel), &p.unit),
        )
    };
    picture(p, "residual", "Residuals: measured minus model".to_owned(), figure)
}

/// All that is left after, and of before as much as does not flatten it.
fn near(before: &[f64], after: &[f64], noise: f64) -> Option<(f64, f64)> {
    let largest = |values: &[f64]| {
        values.iter().filter(|v| v.is_finite()).fold(0.0f64, |a, v| a.max(v.abs()))
    };
    let after = largest(after).max(3.0 * noise);
    let reach = after.max(largest(before).min(CUT * after));
    (reach > 0.0 && reach.is_finite()).then_some((-reach, reach))
}

fn autocorrelation(p: &Proof, before: &[f64], after: &[f64]) -> Option<Picture> {
    let (before, after) = (Autocorrelation::of(before), Autocorrelation::of(after));
    let step = step(&p.time)?;
    let white = after.as_ref().or(before.as_ref())?.white;
    let lags = || before.iter().chain(&after).filter_map(|a| a.at.last()).map(|l| l.0);
    let last = step * lags().max()? as f64;
    let points =
        |a: &Autocorrelation| a.at.iter().map(|(k, rho)| (step * *k as f64, *rho)).collect();
    let share = |a: &Option<Autocorrelation>| {
        a.as_ref().map_or("not known".to_owned(), |a| percent(a.inside()))
    };
    let lines = [
        before.as_ref().map(|a| Line::new("before", Colour::Vermilion, Style::Dashed, points(a))),
        after.as_ref().map(|a| Line::new("after", Colour::Blue, Style::Solid, points(a))),
    ];
    let figure = Figure {
        description: format!(
            "Autocorrelation of the residuals of {} in {} up to a lag of {}: {} of the lags are \
             within the 95 % band of white noise before, {} after.",
            p.channel,
            p.recording,
            plain(last, "s"),
            share(&before),
            share(&after)
        ),
        bands: vec![Band {
            label: "95 % white noise".into(),
            colour: Colour::Ink,
            edges: vec![(0.0, -white, white), (last, -white, white)],
        }],
        lines: lines.into_iter().flatten().collect(),
        ..Figure::new(Axis::linear("lag", "s"), Axis::linear("autocorrelation", ""))
    };
    let caption = "Autocorrelation of the residuals".to_owned();
    Some(picture(p, "autocorrelation", caption, figure))
}

/// Mean step between samples (s).
fn step(time: &[f64]) -> Option<f64> {
    let (first, last) = (time.first()?, time.last()?);
    let step = (last - first) / time.len().checked_sub(1)? as f64;
    (step > 0.0 && step.is_finite()).then_some(step)
}

fn rms(values: &[f64]) -> f64 {
    let finite = values.iter().filter(|v| v.is_finite());
    (finite.clone().map(|v| v * v).sum::<f64>() / finite.count().max(1) as f64).sqrt()
}
