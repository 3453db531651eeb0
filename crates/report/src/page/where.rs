//! Where the mismatch is: its shares, its channels, its shape.

use super::table::table;
use crate::number::{percent, plain};
use crate::pictures::missing_forces;
use crate::words;
use lacuna_discrepancy::Diagnosis;
use lacuna_discrepancy::diagnosis::{ChannelMismatch, Rung, Verdict};
use maud::{Markup, html};

pub(crate) fn section(d: &Diagnosis) -> Markup {
    let about = "How the mismatch splits up, which equations it is in, and what shape it has.";
    super::section(
        "where",
        about,
        html! {
            @if d.verdict == Verdict::NoMismatch {
                p { "The model explains the recordings down to the noise: there is nothing to split up." }
            } @else if !d.ladder.is_empty() { (ladder(&d.ladder)) }
            (location(d))
            @for (channel, pictures) in missing_forces(d) {
                h3 { "The missing force in the equation of " (channel) }
                div.figures { @for p in &pictures { (super::figure(p)) } }
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
            p.about {
                "Evidence: 10 nats are odds of 22 000 to 1. Where there is enough of it, the force is "
                "drawn below as the recordings show it, whatever its name."
            }
        }
    }
}

/// The range of the variable in which the missing force acts.
fn acts(m: &ChannelMismatch) -> String {
    let range = |(name, [a, b]): (&String, &[f64; 2])| format!("{name} from {a:.3} to {b:.3}");
    let all: Vec<String> = m.region.iter().map(range).collect();
    if all.is_empty() { "-".to_owned() } else { all.join(", ") }
}
