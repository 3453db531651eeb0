//! Findings in an engineer's words.

pub(crate) mod shape;

use lacuna_effects::Kind;
use lacuna_plants::Model;
use lacuna_plants::model::{ModelEffect, NewEffect};

/// One sentence: what, where, how much.
pub(crate) fn says(e: &ModelEffect, new: &NewEffect, model: &Model) -> String {
    let numbers: Vec<String> = e
        .effect
        .values()
        .zip(&new.parameters)
        .filter(|(p, _)| p.kind == Kind::Number && p.physical)
        .map(|(p, (value, std, unit))| {
            let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
            format!("{} {}{unit}", p.name.replace('_', " "), with_std(*value, std.unwrap_or(0.0)))
        })
        .collect();
    let mut what = e.effect.words.to_owned();
    if let Some(first) = what.get_mut(0..1) {
        first.make_ascii_uppercase();
    }
    let joined = if e.effect.names_input() { "by" } else { "and" };
    let other = new.other.as_ref().map_or_else(String::new, |o| format!(" {joined} {o}"));
    let model = &model.name;
    format!("{what} on {}{other} is missing from {model}: {}.", new.channel, numbers.join(", "))
}

/// Value and standard deviation, both to the deviation's second digit.
fn with_std(value: f64, std: f64) -> String {
    if !(std > 0.0 && std.is_finite()) {
        return format!("{value:.4}");
    }
    let digits = (1 - std.log10().floor() as i32).clamp(0, 12) as usize;
    format!("{value:.digits$} +- {std:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::with_std;

    #[test]
    fn numbers_show_the_digits_that_are_known() {
        assert_eq!(with_std(20.4137, 0.1234), "20.41 +- 0.12");
        assert_eq!(with_std(-3.16, 0.04), "-3.160 +- 0.040");
        assert_eq!(with_std(1234.5, 56.0), "1234 +- 56");
        assert_eq!(with_std(2.5, 0.0), "2.5000");
    }
}
