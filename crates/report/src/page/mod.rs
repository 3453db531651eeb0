//! The page of a diagnosis: one HTML file that needs nothing else.

mod compare;
mod difference;
mod fleet;
mod how;
mod joints;
mod proof;
mod table;
mod verdict;
mod what;
mod r#where;

pub use compare::{Closer, ComparedChannel, ComparedSeries, Comparison, compare_page};
pub use difference::{DifferencePage, difference_page};
pub use fleet::{FleetPage, FleetRow, FleetTable, fleet_page};

use crate::Proof;
use crate::pictures::Picture;
use lacuna_charts::{ChartError, Surface};
use lacuna_discrepancy::Diagnosis;
use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("style.css");
/// Values under the pointer, a closer look, a choice of series, a button to copy. Everything is
/// there without it.
const SCRIPT: &str = include_str!("script.js");
/// The page asks for nothing from elsewhere, and browsers hold it to that.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// The page of a diagnosis: verdict, where, what, proof, how. It holds its style, figures and
/// script, uses no network, can be read without the script, and follows the reader's choice of
/// light or dark.
///
/// `augmented_model` is the text of the augmented model file, `series` the free runs on
/// held-out recordings, `command` what repeats the diagnosis. Series are thinned, and beyond 60
/// not drawn, so that the page stays below 3 MB.
#[must_use]
pub fn page(
    diagnosis: &Diagnosis,
    augmented_model: &str,
    series: &[Proof],
    command: &str,
) -> String {
    let sections = ["verdict", "where", "what", "proof", "how"];
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                title { "Lacuna: " (diagnosis.model) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    p.brand { "Lacuna · diagnosis of " strong { (diagnosis.model) } }
                    nav aria-label="Sections" {
                        @for name in sections { a href={ "#" (name) } { (title(name)) } " " }
                    }
                }
                main {
                    (verdict::section(diagnosis))
                    (r#where::section(diagnosis))
                    (what::section(diagnosis))
                    (proof::section(diagnosis, series))
                    (how::section(diagnosis, augmented_model, command))
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
    .into_string()
}

fn title(section: &str) -> &'static str {
    match section {
        "where" => "Where",
        "what" => "What",
        "proof" => "Proof",
        "how" => "How",
        _ => "Verdict",
    }
}

/// A section with its heading.
fn section(id: &str, about: &str, content: Markup) -> Markup {
    html! {
        section id=(id) aria-labelledby={ (id) "-title" } {
            h2 id={ (id) "-title" } { (title(id)) }
            p.about { (about) }
            (content)
        }
    }
}

/// A picture with its caption, or the reason why there is none; nothing where there is nothing to draw.
fn figure(picture: &Picture) -> Markup {
    let drawn = picture.svg(Surface::Container);
    html! {
        @if !matches!(drawn, Err(ChartError::Empty { .. })) {
            figure data-time[picture.over_time()] {
                figcaption { (picture.caption) }
                @match drawn {
                    Ok(svg) => (PreEscaped(svg)),
                    Err(reason) => p { "No figure: " (reason) "." },
                }
            }
        }
    }
}
