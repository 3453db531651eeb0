//! The page of a comparison: two models against the same recordings.

use super::table::table;
use super::{POLICY, SCRIPT, STYLE, figure};
use crate::figures::{Colour, Figure, Line, Style};
use crate::number::{plain, ratio};
use crate::pictures::{Drawing, Picture};
use crate::thin::{POINTS, thin};
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// Series that are drawn at most.
const DRAWN: usize = 60;
/// Points of all series together: about ten bytes each.
const BUDGET: usize = 180_000;
/// Errors that differ by less than this share of the larger are the same.
const SAME: f64 = 0.05;

/// Characters of a model's name in the legend, which is as wide as the figure.
const LEGEND: usize = 32;

/// Which of two models is closer to what was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closer {
    /// The first.
    A,
    /// The second.
    B,
    /// Neither: the errors differ by less than 5 %.
    Neither,
}

impl Closer {
    /// By their rms errors, infinite where a model diverges.
    #[must_use]
    pub fn of(a: f64, b: f64) -> Self {
        match (a, b) {
            _ if a < (1.0 - SAME) * b => Self::A,
            _ if b < (1.0 - SAME) * a => Self::B,
            _ => Self::Neither,
        }
    }

    /// `A`, `B` or `same`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::A => "A",
            Self::B => "B",
            Self::Neither => "same",
        }
    }
}

/// The errors of one channel over all recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparedChannel {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Standard deviation of the noise.
    pub noise: f64,
    /// Rms error of the first model, infinite where it diverges.
    pub a: f64,
    /// Rms error of the second model.
    pub b: f64,
}

/// One channel of one recording with both models' runs.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparedSeries {
    /// Name of the recording.
    pub recording: String,
    /// Measured channel.
    pub channel: String,
    /// Its unit.
    pub unit: String,
    /// Time (s).
    pub time: Vec<f64>,
    /// What was measured.
    pub measured: Vec<f64>,
    /// What the first model says.
    pub a: Vec<f64>,
    /// What the second model says.
    pub b: Vec<f64>,
    /// Rms errors of both in this recording.
    pub rmse: [f64; 2],
}

/// Two models against the same recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// What the first model is called.
    pub a: String,
    /// What the second model is called.
    pub b: String,
    /// How they were run: `running free from the first 50 samples`.
    pub how: String,
    /// Errors of each channel.
    pub channels: Vec<ComparedChannel>,
    /// What is drawn.
    pub series: Vec<ComparedSeries>,
}

impl Comparison {
    /// Who is closer, in one line: `B is closer in q and dq`.
    #[must_use]
    pub fn headline(&self) -> String {
        let within = |closer| {
            let names = self.channels.iter().filter(|c| Closer::of(c.a, c.b) == closer);
            names.map(|c| c.name.as_str()).collect::<Vec<_>>()
        };
        let said = |name: &str, closer| match within(closer).as_slice() {
            [] => None,
            channels => Some(format!("{name} is closer in {}", channels.join(", "))),
        };
        let parts: Vec<String> =
            [said(&self.a, Closer::A), said(&self.b, Closer::B)].into_iter().flatten().collect();
        match parts.as_slice() {
            [] => format!("{} and {} are equally close", self.a, self.b),
            parts => parts.join("; "),
        }
    }
}

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
    let line = |label: &str, colour, style, values: &[f64]| Line {
        label: label.into(),
        colour,
        style,
        points: thin(&s.time, values, points),
    };
    let [a, b] = s.rmse.map(|e| plain(e, &s.unit));
    let drawing = Figure {
        description: format!(
            "{} of {} over time: measured, A (rms error {a}) and B (rms error {b}).",
            s.channel, s.recording
        ),
        x: "time (s)".into(),
        y: if s.unit.is_empty() {
            s.channel.clone()
        } else {
            format!("{} ({})", s.channel, s.unit)
        },
        bands: vec![],
        lines: vec![
            line(&entry("A", &comparison.a), Colour::Vermilion, Style::Dashed, &s.a),
            line("measured", Colour::Ink, Style::Broad, &s.measured),
            line(&entry("B", &comparison.b), Colour::Blue, Style::Solid, &s.b),
        ],
        rug: None,
        within: view(&s.measured),
    };
    figure(&Picture {
        kind: "comparison",
        of: format!("{} {}", s.recording, s.channel),
        caption: format!("{}: {}, rms error of A {a}, of B {b}", s.recording, s.channel),
        drawing: Drawing::Figure(drawing),
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
    use super::*;

    fn comparison(errors: &[(&str, f64, f64)]) -> Comparison {
        let channel = |&(name, a, b): &(&str, f64, f64)| ComparedChannel {
            name: name.into(),
            unit: "m".into(),
            noise: 0.01,
            a,
            b,
        };
        Comparison {
            a: "a.toml".into(),
            b: "<b>.toml".into(),
            how: "running free".into(),
            channels: errors.iter().map(channel).collect(),
            series: vec![],
        }
    }

    #[test]
    fn the_closer_model_is_named_for_each_channel() {
        let headline = |errors: &[_]| comparison(errors).headline();
        let apart = [("x", 1.0, 2.0), ("y", f64::INFINITY, 2.0), ("z", 1.0, 1.04)];
        assert_eq!(headline(&apart), "a.toml is closer in x; <b>.toml is closer in y");
        let same = [("x", 1.0, 1.0), ("y", f64::INFINITY, f64::INFINITY), ("z", 0.0, 0.0)];
        assert_eq!(headline(&same), "a.toml and <b>.toml are equally close");
    }

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
