//! What is missing: the findings, and the parameters that move.

use super::table::table;
use crate::number::{estimate, given, percent, plain};
use crate::words;
use lacuna_discrepancy::Diagnosis;
use lacuna_discrepancy::diagnosis::{Alternative, Calibration, Finding};
use maud::{Markup, html};

pub(crate) fn section(d: &Diagnosis) -> Markup {
    let about = match d.findings.len() {
        0 => "No effect of the catalogue is supported by the evidence.",
        _ => "The effects that the evidence supports, the most important first.",
    };
    super::section(
        "what",
        about,
        html! {
            (super::joints::overview(d))
            div.cards { @for f in &d.findings { (card(f)) } }
            (calibration(d))
        },
    )
}

fn card(f: &Finding) -> Markup {
    let law = lacuna_effects::find(f.named_law());
    html! {
        article.card {
            h3 { (words::name(f)) }
            p { (f.says.replace("+-", "±")) }
            dl.facts {
                dt { "Class" } dd { code { (f.class) } }
                @if let Some(effect) = law { dt { "Law" } dd { code { (effect.formula) } } }
                @for (name, e) in &f.parameters {
                    dt { (name.replace('_', " ")) }
                    dd { strong { (estimate(e.value, e.std, &e.unit, e.at_bound)) } }
                }
                @if !f.depends_on.is_empty() { dt { "Depends on" } dd { (f.depends_on.join(", ")) } }
                @for (name, [low, high]) in &f.region {
                    dt { "Seen for" }
                    dd { (name) " from " (plain(*low, "")) " to " (plain(*high, "")) }
                }
                @if let Some(t) = f.time { dt { "Begins at" } dd { (plain(t, "s")) } }
                dt { "Probability" } dd { strong { (percent(f.probability)) } }
                dt { "Rivals" } dd { (rivals(&f.alternatives)) }
                @if let Some(e) = &f.experiment { dt { "Next" } dd { (words::experiment(e)) } }
                dt { "Evidence" } dd { (plain(f.evidence, "nats")) }
            }
        }
    }
}

fn rivals(alternatives: &[Alternative]) -> String {
    let one = |a: &Alternative| {
        format!("{} ({})", words::class_at(&a.class, &a.channel), percent(a.probability))
    };
    let all: Vec<String> = alternatives.iter().map(one).collect();
    if all.is_empty() { "none".to_owned() } else { all.join(", ") }
}

fn calibration(d: &Diagnosis) -> Markup {
    let moved: Vec<&str> = words::moved(d).map(|(name, _)| name).collect();
    let row = |(name, c): (&String, &Calibration)| {
        let far = if moved.contains(&name.as_str()) { "yes" } else { "no" };
        let change = words::shift(c);
        let change = change.trim_matches([' ', '(', ')']).to_owned();
        vec![
            name.clone(),
            given(c.nominal),
            estimate(c.value, c.std, &c.unit, c.at_bound),
            change,
            far.into(),
        ]
    };
    let rows: Vec<_> = d.calibration.iter().map(row).collect();
    let head = ["Parameter", "In the model", "From the recordings", "Change", "Beyond 2 std"];
    html! { @if !rows.is_empty() { (table("Calibration", &head, &rows)) } }
}
