//! The page of a comparison: two models against the same recordings.

mod comparison;

pub use comparison::{Closer, ComparedChannel, ComparedSeries, Comparison};

use super::table::table;
use super::{POLICY, SCRIPT, STYLE, figure};
use crate::number::{plain, ratio};
use crate::pictures::{Drawing, Picture};
use crate::thin::{POINTS, thin};
use lacuna_charts::{Axis, Colour, Figure, Line, Style};
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// Series that are drawn at most.
const DRAWN: usize = 60;
/// Points of all series together: about ten bytes each.
const BUDGET: usize = 180_000;
/// Characters of a model's name in the legend, which is as wide as the figure.
const LEGEND: usize = 32;

/// The page of a comparison: the errors, and every channel of every recording drawn. One file
/// that needs nothing else, in the look of the diagnosis' [`page`](super::page).
#[must_use]
pub fn compare_page(comparison: &Comparison) -> String {
    let Comparison { a, b, series, .. } = comparison;
    let drawn = &series[..series.len().min(DRAWN)];
    let points = (BUDGET / (3 * drawn.len().max(1))).min(POINTS);
    let left = series.len() - drawn.len();
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                title { "Lacuna: " (a) " and " (b) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header { p.brand { "Lacuna · comparison of " strong { (a) } " and " strong { (b) } } }
                main {
                    section aria-labelledby="title" {
                        h1 #title { (comparison.headline()) }
                        p.about { "A is " (a) ", B is " (b) ", " (comparison.how) "." }
                        (errors(comparison))
                    }
                    section aria-labelledby="recordings" {
                        h2 #recordings { "Recordings" }
                        div.proofs {
                            @for s in drawn {
                                article.series data-recording=(s.recording) data-channel=(s.channel) {
                                    (plot(comparison, s, points))
                                }
                            }
                        }
                        @if left > 0 { p.about { (left) " more series are not drawn." } }
                    }
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
    .into_string()
}

fn errors(comparison: &Comparison) -> Markup {
    let times = |error: f64, noise: f64| match error.is_finite() && noise > 0.0 {
        true => ratio(error / noise),
        false => "-".to_owned(),
    };
    let row = |c: &ComparedChannel| {
        vec![
            c.name.clone(),
            plain(c.noise, &c.unit),
            plain(c.a, &c.unit),
            plain(c.b, &c.unit),
            format!("{}, {}", times(c.a, c.noise), times(c.b, c.noise)),
            Closer::of(c.a, c.b).word().to_owned(),
        ]
    };
    let rows: Vec<_> = comparison.channels.iter().map(row).collect();
    let head = ["Channel", "Noise", "Error of A", "Error of B", "Times the noise", "Closer"];
    table("Rms error over all recordings", &head, &rows)
}

fn plot(comparison: &Comparison, s: &ComparedSeries, points: usize) -> Markup {
    let line = |label: &str, colour, style, values: &[f64]| {
        Line::new(label, colour, style, thin(&s.time, values, points))
    };
    let [a, b] = s.rmse.map(|e| plain(e, &s.unit));
    let drawing = Figure {
        description: format!(
            "{} of {} over time: measured, A (rms error {a}) and B (rms error {b}).",
            s.channel, s.recording
        ),
        lines: vec![
            line(&entry("A", &comparison.a), Colour::Vermilion, Style::Dashed, &s.a),
            line("measured", Colour::Ink, Style::Broad, &s.measured),
            line(&entry("B", &comparison.b), Colour::Blue, Style::Solid, &s.b),
        ],
        within: view(&s.measured),
        ..Figure::new(Axis::linear("time", "s"), Axis::linear(&s.channel, &s.unit))
    };
    figure(&Picture {
        kind: "comparison",
        of: format!("{} {}", s.recording, s.channel),
        caption: format!("{}: {}, rms error of A {a}, of B {b}", s.recording, s.channel),
        drawing: Drawing::Figure(Box::new(drawing)),
    })
}

/// A model in the legend: the end of a long name, where versions differ.
fn entry(letter: &str, name: &str) -> String {
    let count = name.chars().count();
    match count > LEGEND {
        true => format!("{letter}: …{}", name.chars().skip(count - LEGEND).collect::<String>()),
        false => format!("{letter}: {name}"),
    }
}

/// The measured values with one span around them: a model that runs away must not flatten
/// them.
fn view(measured: &[f64]) -> Option<(f64, f64)> {
    let finite = measured.iter().filter(|v| v.is_finite());
    let (low, high) =
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
    (high > low).then_some((2.0 * low - high, 2.0 * high - low))
}

#[cfg(test)]
mod tests {
    use super::comparison::tests::comparison;
    use super::*;

    #[test]
    fn long_names_keep_their_ends() {
        assert_eq!(entry("A", "model.toml"), "A: model.toml");
        let long = entry("B", &format!("{}_v2.toml", "é".repeat(60)));
        assert!(long.starts_with("B: …é") && long.ends_with("é_v2.toml"), "{long}");
        assert_eq!(long.chars().count(), LEGEND + 4);
    }

    #[test]
    fn a_page_holds_its_words_escaped_and_tells_of_divergence() {
        let mut c = comparison(&[("x", f64::INFINITY, 0.02)]);
        let time: Vec<f64> = (0..200).map(|k| 0.01 * f64::from(k)).collect();
        let measured: Vec<f64> = time.iter().map(|t| t.sin()).collect();
        let (recording, channel, unit) = ("run.csv".into(), "x".into(), "m".into());
        let a = vec![f64::NAN; 200];
        let (b, rmse) = (measured.clone(), [f64::INFINITY, 0.02]);
        c.series.push(ComparedSeries { recording, channel, unit, time, measured, a, b, rmse });
        let page = compare_page(&c);
        assert!(page.contains("&lt;b&gt;.toml is closer in x") && !page.contains("<b>"), "{page}");
        assert!(page.contains("diverges") && page.contains("<svg"), "{page}");
    }
}
