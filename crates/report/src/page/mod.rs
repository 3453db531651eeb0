//! The page of a diagnosis: one HTML file that needs nothing else.

mod compare;
mod how;
mod proof;
mod table;
mod verdict;
mod what;
mod r#where;

pub use compare::{Closer, ComparedChannel, ComparedSeries, Comparison, compare_page};

use crate::Proof;
use lacuna_discrepancy::Diagnosis;
use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("style.css");

/// The page of a diagnosis: verdict, where, what, proof, how. It holds its style and figures,
/// uses no network and no script, and follows the reader's choice of light or dark.
///
/// `augmented_model` is the text of the augmented model file, `series` the free runs on
/// held-out recordings. Series are thinned, and beyond 60 not drawn, so that the page stays
/// below 3 MB.
#[must_use]
pub fn page(diagnosis: &Diagnosis, augmented_model: &str, series: &[Proof]) -> String {
    let sections = ["verdict", "where", "what", "proof", "how"];
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
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
                    (how::section(diagnosis, augmented_model))
                }
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

/// A figure with its caption, or the reason why there is none.
fn figure(figure: &crate::figures::Figure, caption: &str) -> Markup {
    let drawn = crate::figures::svg(figure);
    html! {
        figure {
            figcaption { (caption) }
            @match drawn {
                Ok(svg) => (PreEscaped(svg)),
                Err(reason) => p { "No figure: " (reason) "." },
            }
        }
    }
}
