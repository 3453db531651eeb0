//! Where the mismatch is: its shares, its channels, its shape.

use super::table::table;
use crate::figures::{Band, Colour, Figure, Line, Style};
use crate::number::{percent, plain};
use crate::words;
use lacuna_discrepancy::Diagnosis;
use lacuna_discrepancy::diagnosis::{ChannelMismatch, Curve, Finding, Rung};
use maud::{Markup, html};

pub(crate) fn section(d: &Diagnosis) -> Markup {
    let about = "How the mismatch splits up, which equations it is in, and what shape it has.";
    super::section(
        "where",
        about,
        html! {
            @if !d.ladder.is_empty() { (ladder(&d.ladder)) }
            (location(d))
            div.figures {
                @for f in &d.findings { @if let Some(c) = &f.curve { (curve(f, c)) } }
            }
        },
    )
}

fn ladder(rungs: &[Rung]) -> Markup {
    html! {
        h3 { "Shares of the mismatch" }
        ul.ladder {
            @for rung in rungs {
                li {
                    span.what { (rung.what) }
                    span.bar aria-hidden="true" {
                        span.(if rung.what == "unexplained" { "rest" } else { "share" })
                            style={ "width:" (width(rung.share)) "%" } {}
                    }
                    span.percent { (percent(rung.share)) }
                }
            }
        }
        p.about {
            "Shares of the mean square misfit above the noise, on the recordings that were fitted."
        }
    }
}

fn width(share: f64) -> String {
    let shown = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 };
    format!("{:.1}", 100.0 * shown)
}

fn location(d: &Diagnosis) -> Markup {
    let row = |(name, m): (&String, &ChannelMismatch)| {
        let classes: Vec<String> = m.explained_by.iter().map(|c| words::class_words(c)).collect();
        let by = if classes.is_empty() { "-".to_owned() } else { classes.join(", ") };
        let evidence = plain(m.significance, "nats");
        vec![name.clone(), plain(m.missing_force, &m.unit), evidence, acts(m), by]
    };
    let rows: Vec<_> = d.location.channels.iter().map(row).collect();
    let head =
        ["Equation of", "Missing force (rms)", "Evidence for it", "Where it acts", "Explained by"];
    html! {
        @if !rows.is_empty() {
            (table("The missing force in each channel, before anything is added", &head, &rows))
            p.about { "Evidence: 10 nats are odds of 22 000 to 1." }
        }
    }
}

/// The range of the variable in which the missing force acts.
fn acts(m: &ChannelMismatch) -> String {
    let range = |(name, [a, b]): (&String, &[f64; 2])| format!("{name} from {a:.3} to {b:.3}");
    let all: Vec<String> = m.region.iter().map(range).collect();
    if all.is_empty() { "-".to_owned() } else { all.join(", ") }
}

/// The learned force with a band of two standard deviations, and the law over it.
fn curve(finding: &Finding, c: &Curve) -> Markup {
    let name = words::name(finding);
    let points = |y: &[f64]| c.at.iter().copied().zip(y.iter().copied()).collect();
    let edges = c.at.iter().zip(&c.learned).zip(&c.std);
    let edges = edges.map(|((&x, &y), &s)| (x, y - 2.0 * s, y + 2.0 * s)).collect();
    let line = |label: &str, colour, points| Line {
        label: label.into(),
        colour,
        style: Style::Solid,
        points,
    };
    let figure = Figure {
        description: description(&name, c),
        x: axis(&c.variable, &c.variable_unit),
        y: axis("missing force", &c.force_unit),
        bands: vec![Band { label: "± 2 std".into(), colour: Colour::Ink, edges }],
        lines: vec![
            line("learned, no formula", Colour::Ink, points(&c.learned)),
            line("named law", Colour::Blue, points(&c.law)),
        ],
        rug: None,
        within: view(c),
    };
    super::figure(&figure, &format!("Missing force over {}: {name}", c.variable))
}

/// Both curves with half their span around them: the band may open wide where data are few.
fn view(c: &Curve) -> Option<(f64, f64)> {
    let curves = c.learned.iter().chain(&c.law).filter(|v| v.is_finite());
    let (low, high) =
        curves.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
    let half = 0.5 * (high - low);
    (half > 0.0).then_some((low - half, high + half))
}

fn description(name: &str, c: &Curve) -> String {
    let inside = c.at.len().min(c.law.len()).min(c.learned.len()).min(c.std.len());
    let within = (0..inside).filter(|&k| (c.law[k] - c.learned[k]).abs() <= 2.0 * c.std[k]).count();
    format!(
        "Missing force over {}, learned without a formula, with the law of {name} over it; the law \
         is within two standard deviations at {within} of {inside} points.",
        c.variable
    )
}

fn axis(name: &str, unit: &str) -> String {
    if unit.is_empty() || unit == "1" { name.to_owned() } else { format!("{name} ({unit})") }
}
