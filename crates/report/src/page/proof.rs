//! Proof: recordings that nothing was fitted to.

use super::table::table;
use crate::Proof;
use crate::figures::{Colour, Figure, Line, Style};
use crate::number::{change, plain, ratio};
use crate::thin::{POINTS, thin};
use crate::words;
use lacuna_discrepancy::Diagnosis;
use lacuna_discrepancy::diagnosis::ChannelFit;
use maud::{Markup, html};

/// Series that are drawn at most.
const DRAWN: usize = 60;
/// Points of all series together: about ten bytes each.
const BUDGET: usize = 180_000;

pub(crate) fn section(d: &Diagnosis, series: &[Proof]) -> Markup {
    let drawn = &series[..series.len().min(DRAWN)];
    let points = (BUDGET / (3 * drawn.len().max(1))).min(POINTS);
    let left = series.len() - drawn.len();
    super::section(
        "proof",
        "The model before and after, on recordings that nothing was fitted to.",
        html! {
            (errors(d))
            div.figures { @for p in drawn { (plot(p, points)) } }
            @if left > 0 { p.about { (left) " more series are not drawn." } }
        },
    )
}

fn errors(d: &Diagnosis) -> Markup {
    let rows: Vec<_> = words::by_error(d).into_iter().map(row).collect();
    let head = ["Channel", "Noise", "Windows", "Times the noise", "Running free", ""];
    let horizon = d.fit.held_out.values().next().map_or(String::new(), |f| plain(f.horizon_s, "s"));
    let caption = format!("Rms error on held-out recordings, before → after; windows of {horizon}");
    html! {
        @if rows.is_empty() { p { "No recording was held out." } }
        @else { (table(&caption, &head, &rows)) }
    }
}

fn row((name, f): (&str, &ChannelFit)) -> Vec<String> {
    let arrow = |before, after| change(before, "→", after, &f.unit);
    let times = |v: f64| ratio(v / f.noise);
    let noisy = match f.noise > 0.0 {
        true => format!("{} → {}", times(f.rmse_before), times(f.rmse_after)),
        false => "-".to_owned(),
    };
    let remark = match (
        words::grows(f.rmse_before, f.rmse_after)
            || words::grows(f.free_run_before, f.free_run_after),
        words::falls(f.rmse_before, f.rmse_after),
    ) {
        (true, _) => "worse",
        (false, true) => "better",
        (false, false) => "same",
    };
    vec![
        name.to_owned(),
        plain(f.noise, &f.unit),
        arrow(f.rmse_before, f.rmse_after),
        noisy,
        arrow(f.free_run_before, f.free_run_after),
        remark.to_owned(),
    ]
}

fn plot(p: &Proof, points: usize) -> Markup {
    let line = |label: &str, colour, style, values: &[f64]| Line {
        label: label.into(),
        colour,
        style,
        points: thin(&p.time, values, points),
    };
    let figure = Figure {
        description: description(p),
        x: "time (s)".into(),
        y: format!("{} ({})", p.channel, p.unit),
        bands: vec![],
        lines: vec![
            line("model before", Colour::Vermilion, Style::Dashed, &p.before),
            line("measured", Colour::Ink, Style::Broad, &p.measured),
            line("model after", Colour::Blue, Style::Solid, &p.after),
        ],
        rug: None,
        within: view(p),
    };
    super::figure(
        &figure,
        &format!("{}: {} running free from the first samples", p.recording, p.channel),
    )
}

/// The measured values with one span around them: a model that runs away must not flatten
/// them.
fn view(p: &Proof) -> Option<(f64, f64)> {
    let finite = p.measured.iter().filter(|v| v.is_finite());
    let (low, high) =
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
    (high > low).then_some((2.0 * low - high, 2.0 * high - low))
}

fn description(p: &Proof) -> String {
    let rms = |model: &[f64]| {
        let errors = p.measured.iter().zip(model).map(|(a, b)| (a - b).powi(2));
        let finite: Vec<f64> = errors.filter(|e| e.is_finite()).collect();
        plain((finite.iter().sum::<f64>() / finite.len().max(1) as f64).sqrt(), &p.unit)
    };
    format!(
        "{} of {} over time: measured, model before (rms error {}) and model after (rms error {}).",
        p.channel,
        p.recording,
        rms(&p.before),
        rms(&p.after)
    )
}
