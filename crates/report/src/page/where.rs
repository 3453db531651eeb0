//! Where the mismatch is: its shares, its channels, its shape.

use super::table::table;
use crate::number::{percent, plain, ratio};
use crate::pictures::missing_forces;
use crate::words;
use lacuna_discrepancy::Diagnosis;
use lacuna_discrepancy::diagnosis::{ChannelFit, ChannelMismatch, Verdict};
use maud::{Markup, html};

pub(crate) fn section(d: &Diagnosis) -> Markup {
    let about = "How the mismatch splits up, which equations it is in, and what shape it has.";
    super::section(
        "where",
        about,
        html! {
            @if d.verdict == Verdict::NoMismatch && words::leaves_more_than_noise(d) {
                p { "What the model leaves is more than the noise that shows from sample to sample, but nothing that was looked for explains it." }
            } @else if d.verdict == Verdict::NoMismatch {
                p { "The model explains the recordings down to the noise: there is nothing to split up." }
            } @else if !d.ladder.is_empty() { (ladder(d)) }
            (location(d))
            @for (channel, pictures) in missing_forces(d) {
                @let drawn: Vec<Markup> =
                    pictures.iter().map(super::figure).filter(|f| !f.0.is_empty()).collect();
                @if !drawn.is_empty() {
                    h3 { "The missing force in the equation of " (channel) }
                    div.figures { @for figure in &drawn { (figure) } }
                }
            }
        },
    )
}

fn ladder(d: &Diagnosis) -> Markup {
    html! {
        h3 { "Shares of the mismatch" }
        ul.ladder {
            @for rung in &d.ladder {
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
            "Shares of the mean square misfit above the noise, on the recordings that were fitted: what "
            "other values of the model's parameters take away, what each effect does (where one can "
            "stand for the other, half to each), and what is left." (noise(d))
        }
    }
}

/// How far above the noise the recordings that were fitted remain, in the worst channel.
fn noise(d: &Diagnosis) -> String {
    let over = |f: &ChannelFit| f.rmse_after / f.noise;
    let known = d.fit.training.iter().filter(|(_, f)| over(f).is_finite());
    let worst = known.max_by(|a, b| over(a.1).total_cmp(&over(b.1)));
    worst.map_or_else(String::new, |(channel, f)| {
        format!(
            " The noise is in none of these shares: with all of them the error there is at most {} \
             times the noise, in {channel}.",
            ratio(over(f))
        )
    })
}

fn width(share: f64) -> String {
    let shown = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 };
    format!("{:.1}", 100.0 * shown)
}

fn location(d: &Diagnosis) -> Markup {
    let row = |(name, m): (&String, &ChannelMismatch)| {
        let classes: Vec<String> = m.explained_by.iter().map(|c| words::class_words(c)).collect();
        let by = if classes.is_empty() { "-".to_owned() } else { classes.join(", ") };
        // Nothing is said of a force that nothing speaks for, or that nothing measured tells.
        let told = m.missing_force > 0.0 || m.significance > 0.0;
        let said = |value: f64, unit: &str| if told { plain(value, unit) } else { "-".to_owned() };
        let (force, evidence) = (said(m.missing_force, &m.unit), said(m.significance, "nats"));
        vec![name.clone(), force, evidence, acts(m), by]
    };
    let rows: Vec<_> = d.location.channels.iter().map(row).collect();
    let head =
        ["Equation of", "Missing force (rms)", "Evidence for it", "Where it acts", "Explained by"];
    html! {
        @if !rows.is_empty() {
            (table("The missing force in each channel, before anything is added", &head, &rows))
            p.about {
                "Evidence: 10 nats are odds of 22 000 to 1. Where there is enough of it, the force is "
                "drawn below as the recordings show it, whatever its name."
                @if elsewhere(d) {
                    " What acts on an input, a sensor or another channel shows in several equations."
                }
            }
        }
    }
}

/// Whether a channel with evidence is explained by what acts elsewhere.
fn elsewhere(d: &Diagnosis) -> bool {
    let bare = |m: &ChannelMismatch| m.explained_by.is_empty() && !m.curves.is_empty();
    !d.findings.is_empty() && d.location.channels.values().any(bare)
}

/// The range of the variable in which the missing force acts.
fn acts(m: &ChannelMismatch) -> String {
    let range = |(name, [a, b]): (&String, &[f64; 2])| format!("{name} from {a:.3} to {b:.3}");
    let all: Vec<String> = m.region.iter().map(range).collect();
    if all.is_empty() { "-".to_owned() } else { all.join(", ") }
}
