//! The page of two sets of recordings, one of them simulated, that are compared without a model.

use super::table::table;
use super::{POLICY, SCRIPT, STYLE, figure};
use crate::pictures::{Drawing, Picture};
use lacuna_charts::Figure;
use maud::{DOCTYPE, PreEscaped, html};

/// What the page says.
#[derive(Clone, Debug)]
pub struct DifferencePage {
    /// Names of the simulated recordings.
    pub simulated: String,
    /// Names of the recorded ones.
    pub recorded: String,
    /// Sentences; the first is the heading.
    pub says: Vec<String>,
    /// What the table's numbers are.
    pub about: String,
    /// Headings of the table.
    pub head: Vec<String>,
    /// Its rows, a function each.
    pub rows: Vec<Vec<String>>,
    /// The differences.
    pub figures: Vec<Figure>,
    /// What else there is to know.
    pub notes: Vec<String>,
}

/// The page: one file that needs nothing else, in the look of the diagnosis' [`page`](super::page).
#[must_use]
pub fn difference_page(d: &DifferencePage) -> String {
    let head: Vec<&str> = d.head.iter().map(String::as_str).collect();
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                title { "Lacuna: " (d.recorded) " beside " (d.simulated) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header { p.brand { "Lacuna · " strong { (d.recorded) } " beside simulated " strong { (d.simulated) } } }
                main {
                    section aria-labelledby="title" {
                        h1 #title { (d.says.first().map_or("", String::as_str)) }
                        @for more in d.says.iter().skip(1) { p.about { (more) } }
                        (table("What was identified of both", &head, &d.rows))
                        p.about { (d.about) }
                    }
                    @if !d.figures.is_empty() {
                        section aria-labelledby="differences" {
                            h2 #differences { "Differences" }
                            div.proofs { @for one in &d.figures { article.series { (drawn(one)) } } }
                        }
                    }
                    @if !d.notes.is_empty() {
                        section aria-labelledby="notes" {
                            h2 #notes { "Notes" }
                            ul { @for note in &d.notes { li { (note) } } }
                        }
                    }
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
    .into_string()
}

fn drawn(one: &Figure) -> maud::Markup {
    figure(&Picture {
        kind: "difference",
        of: one.y.name.clone(),
        caption: one.description.clone(),
        drawing: Drawing::Figure(Box::new(one.clone())),
    })
}
