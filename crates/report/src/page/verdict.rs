//! The verdict: what is the matter, how sure, and whether it helps.

use crate::number::{change, diverged, percent, plain, ratio};
use crate::pictures::errors;
use crate::words;
use lacuna_discrepancy::Diagnosis;
use lacuna_discrepancy::diagnosis::{ChannelFit, ChannelMismatch, Verdict};
use maud::{Markup, html};

/// Errors up to this many times the noise are told in units of it: a noise far below what any
/// model reaches, as of a fine encoder, compares with nothing.
const COMPARABLE: f64 = 100.0;

pub(crate) fn section(d: &Diagnosis) -> Markup {
    html! {
        section #verdict.verdict.(tone(d.verdict)) aria-labelledby="verdict-title" {
            p.kind { (kind(d.verdict)) }
            h1 #verdict-title { (words::headline(d)) }
            p { (words::verdict(d)) }
            div.glance {
                (tiles(d))
                @if let Some(picture) = errors(d) { (super::figure(&picture)) }
            }
            @if !d.notes.is_empty() {
                p.about {
                    a href="#notes" {
                        @if d.notes.len() == 1 { "One note" } @else { (d.notes.len()) " notes" }
                        " on what these data cannot tell"
                    }
                }
            }
        }
    }
}

fn kind(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NoMismatch => "No mismatch",
        Verdict::Miscalibrated => "Miscalibrated",
        Verdict::MissingPhysics => "Missing physics",
        Verdict::SensorFault => "Sensor fault",
        Verdict::Unexplained => "Unexplained mismatch",
    }
}

fn tone(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NoMismatch => "good",
        Verdict::Unexplained => "open",
        _ => "found",
    }
}

/// The numbers that a reader looks for first.
fn tiles(d: &Diagnosis) -> Markup {
    let tile = |name: &str, number: &str, about: &str| {
        html! { div.tile { dt { (name) } dd { strong { (number) } span { (about) } } } }
    };
    let unexplained = d.ladder.iter().find(|r| r.what == "unexplained");
    html! {
        dl.tiles {
            @for (what, probability) in words::told(d) {
                (tile("How sure", &probability, &format!("that it is {what}")))
            }
            // In the wrong numbers no equation is suspected.
            @let suspected = suspected(d).filter(|_| d.otherwise.is_none());
            @if let (Verdict::Unexplained, Some((channel, m))) = (d.verdict, suspected) {
                (tile("How sure", &percent(likely(m.significance)), &format!("that something is missing, most of it in the equation of {channel}; its name is not known")))
            } @else if d.findings.is_empty() { @if let Some((channel, m)) = suspected {
                (tile("Evidence for missing physics", &plain(m.significance, "nats"), &format!("at most, in {channel}; 10 nats are odds of 22 000 to 1")))
            } }
            @if let Some((channel, fit)) = words::telling(d) {
                @let (number, about) = held_out(channel, fit);
                (tile("Error on held-out recordings", &number, &about))
            }
            @if let (Some(fit), Some(words)) = (&d.formula, words::formula(d)) {
                (tile("How well it fits", &format!("{} left", percent(fit.left)), &words))
            } @else if let (Some(rest), true) = (unexplained, d.verdict != Verdict::NoMismatch) {
                (tile("Still unexplained", &percent(rest.share), "of the mismatch"))
            }
        }
    }
}

/// The error before and after, in units of the noise where that compares.
fn held_out(channel: &str, fit: &ChannelFit) -> (String, String) {
    let errors = change(fit.rmse_before, "→", fit.rmse_after, &fit.unit);
    let over = plain(fit.horizon_s, "s");
    if fit.rmse_after < COMPARABLE * fit.noise {
        let times = |v: f64| if diverged(v) { "diverges".into() } else { ratio(v / fit.noise) };
        let number = format!("{} → {} × noise", times(fit.rmse_before), times(fit.rmse_after));
        return (number, format!("{channel}: {errors} over {over}, before → after"));
    }
    (errors, format!("{channel} over {over}, before → after"))
}

/// Probability after log evidence (nats), at even odds before.
fn likely(nats: f64) -> f64 {
    1.0 / (1.0 + (-nats).exp())
}

/// The channel with the most evidence for a missing force.
fn suspected(d: &Diagnosis) -> Option<(&String, &ChannelMismatch)> {
    d.location.channels.iter().max_by(|a, b| a.1.significance.total_cmp(&b.1.significance))
}
