//! The value of an effect's entry, in the ways in which it can be written.

use crate::model::Uncertainty;
use crate::model::units::same_unit;
use lacuna_effects::{Kind, Parameter, Range};
use lacuna_units::{Unit, convert_factor};
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "a number, a name, a list of numbers, or a table with value (or values), and perhaps std and unit"
)]
pub(super) enum RawValue {
    Number(f64),
    Text(String),
    Numbers(Vec<f64>),
    Table(RawNumber),
    Curve(RawNumbers),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawNumber {
    value: f64,
    std: Option<f64>,
    unit: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawNumbers {
    values: Vec<f64>,
    std: Option<Vec<f64>>,
    unit: Option<String>,
}

/// Values of a parameter with their standard deviations.
pub(super) struct Given {
    pub values: Vec<f64>,
    pub std: Vec<Option<f64>>,
}

impl Given {
    fn scale(&mut self, factor: f64) {
        let std = self.std.iter_mut().flatten();
        self.values.iter_mut().chain(std).for_each(|value| *value *= factor);
    }
}

/// The number of `unit` in one of what is `written`, or why there is none.
pub(super) fn factor(written: &str, unit: &str) -> Result<f64, String> {
    if same_unit(written, unit) {
        return Ok(1.0);
    }
    // Where nothing says what unit the equations are in, the one that is written is believed.
    let Ok(expected) = Unit::parse(unit) else { return Ok(1.0) };
    let written = Unit::parse(written).map_err(|e| format!("here it must be in {unit}: {e}"))?;
    convert_factor(&written, &expected).map_err(|e| format!("here it must be in {unit}: {e}"))
}

impl RawValue {
    /// What is given for a parameter, in this unit.
    pub fn given(&self, p: &Parameter, unit: &str) -> Result<Given, String> {
        let (mut given, written) = self.numbers(p)?;
        if let Some(written) = written {
            let factor = factor(written, unit)
                .map_err(|why| format!("'{}' is given in {written}; {why}", p.name))?;
            given.scale(factor);
        }
        given.values.iter().try_for_each(|value| check_range(p, *value))?;
        Ok(given)
    }

    fn numbers(&self, p: &Parameter) -> Result<(Given, Option<&str>), String> {
        let one = |value: f64, std| Given { values: vec![value], std: vec![std] };
        let several = |values: &[f64], std: Option<&[f64]>| Given {
            values: values.to_vec(),
            std: std.map_or_else(
                || vec![None; values.len()],
                |all| all.iter().copied().map(Some).collect(),
            ),
        };
        match (p.kind, self) {
            (Kind::Number | Kind::Side, Self::Number(v)) => Ok((one(*v, None), None)),
            (Kind::Number | Kind::Side, Self::Table(t)) => {
                Ok((one(t.value, t.std), t.unit.as_deref()))
            }
            (Kind::Numbers(n), Self::Numbers(values)) => {
                check_count(p.name, "values", n, values.len())?;
                Ok((several(values, None), None))
            }
            (Kind::Numbers(n), Self::Curve(t)) => {
                check_count(p.name, "values", n, t.values.len())?;
                let std = t.std.as_deref();
                check_count(p.name, "standard deviations", n, std.map_or(n, <[f64]>::len))?;
                Ok((several(&t.values, std), t.unit.as_deref()))
            }
            (Kind::Numbers(n), _) => Err(format!(
                "'{}' holds {n} values: {} = {{ values = [...], unit = \"...\" }}",
                p.name, p.name
            )),
            _ => Err(format!("'{}' is one number, or a table with its value", p.name)),
        }
    }
}

/// That a value is one that a parameter may have.
pub(super) fn check_range(p: &Parameter, value: f64) -> Result<(), String> {
    if p.range.contains(value) {
        return Ok(());
    }
    let range = match p.range {
        Range::Any => "finite",
        Range::NonNegative => "0 or more",
        Range::Positive => "more than 0",
    };
    Err(format!("'{}' must be {range}; found {value}", p.name))
}

/// How sure a file is of a parameter, which says it relative to the value or in its unit.
pub(super) fn uncertainty(
    name: &str,
    tolerance: Option<f64>,
    std: Option<f64>,
) -> Result<Uncertainty, String> {
    match (tolerance, std) {
        (Some(_), Some(_)) => Err(format!(
            "'{name}' has both a tolerance (relative) and a std (in its unit): say one of them"
        )),
        (_, Some(std)) => Ok(Uncertainty::Absolute(std)),
        (tolerance, None) => Ok(Uncertainty::Relative(tolerance.unwrap_or(0.0))),
    }
}

fn check_count(name: &str, what: &str, expected: usize, found: usize) -> Result<(), String> {
    if expected == found {
        return Ok(());
    }
    Err(format!("'{name}' must hold {expected} {what}; found {found}"))
}
