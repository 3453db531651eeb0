//! How it was done: the data, what they cannot tell, and the model to copy.

use lacuna_discrepancy::Diagnosis;
use maud::{Markup, html};

pub(crate) fn section(d: &Diagnosis, augmented_model: &str) -> Markup {
    let data = &d.data;
    super::section(
        "how",
        "What was used, what it cannot tell, and the augmented model.",
        html! {
            dl.facts {
                dt { "Fitted" } dd { (names(&data.training)) }
                dt { "Held out" } dd { (names(&data.held_out)) }
                dt { "Samples fitted" } dd { (data.samples) }
                dt { "Rows dropped" } dd { (data.dropped) " in the recordings, filled in for smoothing alone" }
                dt { "Version" } dd { "Lacuna " (data.version) ", results of schema " (d.schema) }
            }
            @if !d.notes.is_empty() {
                h3 #notes { "Notes" }
                ul { @for note in &d.notes { li { (note) } } }
            }
            h3 #model { "The augmented model" }
            pre tabindex="0" role="region" aria-labelledby="model" { code { (augmented_model) } }
        },
    )
}

fn names(recordings: &[String]) -> String {
    if recordings.is_empty() { "none".to_owned() } else { recordings.join(", ") }
}
