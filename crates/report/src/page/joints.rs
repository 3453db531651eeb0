//! What is missing of a robot, joint by joint.

use super::table::table;
use crate::joints::{Kind, kinds};
use crate::number::{estimate, percent};
use crate::pictures::friction;
use lacuna_discrepancy::Diagnosis;
use lacuna_discrepancy::diagnosis::{Finding, Robot};
use lacuna_effects::{Kind as Holds, find};
use maud::{Markup, html};

/// A table of joints and kinds of physics, and their friction side by side, where findings are on several.
pub(crate) fn overview(d: &Diagnosis) -> Markup {
    let kinds = kinds(d);
    let has_any = |joint: &usize| kinds.iter().any(|k| !k.of_joints[*joint].is_empty());
    let Some(robot) = d.robot.as_ref().filter(|r| (0..r.joints.len()).filter(has_any).count() > 1)
    else {
        return html! {};
    };
    let head: Vec<&str> = std::iter::once("Joint").chain(kinds.iter().map(|k| k.words)).collect();
    let pictures = friction(d);
    html! {
        (table("What is missing, by joint", &head, &rows(robot, &kinds)))
        @if !pictures.is_empty() {
            h3 { "Friction of the joints" }
            div.figures.three { @for p in &pictures { (super::figure(p)) } }
        }
    }
}

fn rows(robot: &Robot, kinds: &[Kind]) -> Vec<Vec<String>> {
    let cell = |found: &Vec<&Finding>| {
        let all: Vec<String> = found.iter().map(|f| numbers(f)).collect();
        if all.is_empty() { "-".to_owned() } else { all.join("; ") }
    };
    let row = |(k, name): (usize, &String)| {
        let cells = kinds.iter().map(|kind| cell(&kind.of_joints[k]));
        std::iter::once(name.clone()).chain(cells).collect()
    };
    robot.joints.iter().map(|j| &j.name).enumerate().map(row).collect()
}

/// `0.352 ± 0.004 N m (98 %)`; several numbers with their names.
fn numbers(f: &Finding) -> String {
    let parameters = find(f.named_law()).map_or(&[][..], |e| e.parameters);
    let told = parameters.iter().filter(|p| p.physical && p.kind == Holds::Number);
    let told = told.filter_map(|p| Some((p.name, f.parameters.get(p.name)?)));
    let told: Vec<(&str, String)> =
        told.map(|(name, e)| (name, estimate(e.value, e.std, &e.unit, e.at_bound))).collect();
    let numbers = match &told[..] {
        [(_, only)] => only.clone(),
        all => {
            let named = all.iter().map(|(name, e)| format!("{} {e}", name.replace('_', " ")));
            named.collect::<Vec<_>>().join(", ")
        }
    };
    format!("{numbers} ({})", percent(f.probability))
}
