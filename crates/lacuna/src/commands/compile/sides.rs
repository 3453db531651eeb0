//! The box: what is given, and the range of the data for the rest.

use lacuna::occupation::compile::Domain;
use lacuna::occupation::{IdentifiedModel, Names};

/// A box, and which of its sides were given.
pub struct Sides {
    pub domain: Domain,
    pub given: Vec<bool>,
}

impl Sides {
    /// From `NAME=LOW..HIGH` for some arguments of the model.
    pub fn read(texts: &[String], model: &IdentifiedModel, names: &Names) -> Result<Self, String> {
        let [mut lower, mut upper] = Domain::range_of_points(model);
        let mut given = vec![false; names.arguments.len()];
        for text in texts {
            let (name, low, high) = side(text)?;
            let known = names.arguments.iter().position(|n| n == name);
            let argument = known.ok_or_else(|| {
                let all = names.arguments.join(", ");
                format!("--box {text}: the model has no argument '{name}'; it has {all}")
            })?;
            if std::mem::replace(&mut given[argument], true) {
                return Err(format!("--box {text}: a second range of '{name}'"));
            }
            (lower[argument], upper[argument]) = (low, high);
        }
        let empty = |&i: &usize| lower[i] >= upper[i];
        if let Some(i) = (0..given.len()).find(empty) {
            let name = &names.arguments[i];
            return Err(format!(
                "the data do not vary in '{name}' ({} to {}); --box {name}=LOW..HIGH gives its range",
                lower[i], upper[i]
            ));
        }
        let domain = Domain::new(lower, upper).map_err(|e| e.to_string())?;
        Ok(Self { domain, given })
    }
}

fn side(text: &str) -> Result<(&str, f64, f64), String> {
    let form = || format!("--box {text}: expected NAME=LOW..HIGH, such as q1=-2..2");
    let (name, range) = text.split_once('=').ok_or_else(form)?;
    let (low, high) = range.split_once("..").ok_or_else(form)?;
    let number = |part: &str| {
        let value = part.trim().parse::<f64>().ok().filter(|v| v.is_finite());
        value.ok_or_else(|| format!("--box {text}: '{part}' is no finite number"))
    };
    let (low, high) = (number(low)?, number(high)?);
    if low >= high {
        return Err(format!(
            "--box {text}: the lower end must be below the upper one, found {low} and {high}"
        ));
    }
    Ok((name.trim(), low, high))
}
