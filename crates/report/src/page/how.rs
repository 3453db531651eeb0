//! How it was done: the data, what they cannot tell, how to repeat it, and the model to copy.

use lacuna_discrepancy::Diagnosis;
use lacuna_discrepancy::diagnosis::DataUsed;
use maud::{Markup, html};

pub(crate) fn section(d: &Diagnosis, augmented_model: &str, command: &str) -> Markup {
    super::section(
        "how",
        "What was used, what it cannot tell, how to repeat it, and the augmented model.",
        html! {
            dl.facts {
                dt { "Fitted" } dd { (names(&d.data.training)) }
                dt { "Held out" } dd { (names(&d.data.held_out)) }
                dt { "Samples fitted" } dd { (d.data.samples) }
                dt { "Left out" } dd { (left_out(&d.data)) }
                dt { "Version" } dd { "Lacuna " (d.data.version) ", results of schema " (d.schema) }
                dt { "Seeds" } dd { "None: a diagnosis draws no random numbers." }
            }
            @if !d.notes.is_empty() {
                h3 #notes { "Notes" }
                ul { @for note in &d.notes { li { (note) } } }
            }
            @if !command.is_empty() { (text("command", "The command that repeats it", command)) }
            (text("model", "The augmented model", augmented_model))
        },
    )
}

/// Text to copy under its heading.
fn text(id: &str, title: &str, text: &str) -> Markup {
    html! {
        h3 id=(id) { (title) }
        div.copy { pre tabindex="0" role="region" aria-labelledby=(id) { code { (text) } } }
    }
}

/// What was not used, and why.
fn left_out(data: &DataUsed) -> String {
    let rows = match data.dropped {
        0 => "no rows are missing in the recordings".to_owned(),
        1 => "1 row that is missing in the recordings, filled in for smoothing alone".to_owned(),
        n => format!("{n} rows that are missing in the recordings, filled in for smoothing alone"),
    };
    let mut all = vec![rows];
    if !data.outliers.is_empty() {
        let each = data.outliers.iter().map(|(channel, count)| format!("{count} of {channel}"));
        all.push(format!("outliers: {}", each.collect::<Vec<_>>().join(", ")));
    }
    if !data.unmeasured.is_empty() {
        let states = data.unmeasured.join(", ");
        all.push(format!("the states {states}, which no recording measures"));
    }
    all.join("; ")
}

fn names(recordings: &[String]) -> String {
    if recordings.is_empty() { "none".to_owned() } else { recordings.join(", ") }
}
