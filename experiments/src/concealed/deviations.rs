//! Reported numbers against the true ones, in reported standard deviations.
//!
//! ```text
//! z = (value - truth) / std,      of standard normal z 95.4 % are within two
//! ```
//!
//! Only where the findings are the effects that are concealed, each by its own name and law, do its numbers and the
//! model's parameters have true values: beside another law the best values of the rest are others.

use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

use lacuna_discrepancy::diagnosis::Estimate;

use super::diagnosis::{Diagnosis, Finding};
use super::proportion::Proportion;
use super::row::Row;
use super::sealed::{Sealed, SealedEffect};

/// Reported standard deviations within which a number counts as covered.
const TWO: f64 = 2.0;

/// A reported number whose true value is known.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Deviation {
    /// Class of the finding that it is a number of; none: a parameter of the model.
    pub class: Option<String>,
    /// Its name.
    pub of: String,
    /// By how many reported standard deviations it is above the truth.
    pub deviation: f64,
}

/// How far reported standard deviations are to be relied on.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Coverage {
    /// Numbers of findings within two of their standard deviations.
    pub findings: Proportion,
    /// Parameters of models within two of theirs.
    pub parameters: Proportion,
}

impl Coverage {
    /// Of some rows.
    pub fn of(rows: &[&Row]) -> Self {
        let all = || rows.iter().flat_map(|r| &r.deviations);
        let within = |finding: bool| {
            let own: Vec<_> = all().filter(|d| d.class.is_some() == finding).collect();
            let inside = own.iter().filter(|d| d.deviation.abs() <= TWO).count();
            Proportion::new(inside, own.len())
        };
        Self { findings: within(true), parameters: within(false) }
    }
}

/// The numbers of a diagnosis whose true values are known; none where it is not right.
pub fn deviations(truth: &Sealed, diagnosis: &Diagnosis) -> Vec<Deviation> {
    let found = &diagnosis.findings;
    let own = |effect: &SealedEffect| found.iter().find(|f| is(effect, f));
    let pairs: Option<Vec<_>> = truth.effects.iter().map(|e| Some((e, own(e)?))).collect();
    let Some(pairs) = pairs.filter(|pairs| pairs.len() == found.len()) else { return vec![] };
    let of_findings = pairs.into_iter().flat_map(|(effect, finding)| numbers(effect, finding));
    let of_parameters = diagnosis.calibration.iter().filter_map(|(name, c)| {
        let factor = truth.miscalibrated.get(name).copied().unwrap_or(1.0);
        deviation((None, name), c.value - factor * c.nominal, (c.std, c.at_bound))
    });
    of_findings.chain(of_parameters).collect()
}

/// Whether a finding is an effect by its own law.
fn is(effect: &SealedEffect, finding: &Finding) -> bool {
    effect.catalogue && effect.name == finding.name() && effect.other == finding.other
}

fn numbers(effect: &SealedEffect, finding: &Finding) -> Vec<Deviation> {
    let number = |(name, estimate): (&String, &Estimate)| {
        let off = estimate.value - effect.parameters.get(name)?.as_f64()?;
        // An angle is known to a whole turn.
        let off = if name == "phase" { (off + PI).rem_euclid(TAU) - PI } else { off };
        deviation((Some(&finding.class), name), off, (estimate.std, estimate.at_bound))
    };
    finding.parameters.iter().filter_map(number).collect()
}

/// What sits on its bound is marked, and what is given has no standard deviation.
fn deviation(
    (class, of): (Option<&String>, &String),
    off: f64,
    (std, at_bound): (f64, bool),
) -> Option<Deviation> {
    let told = std > 0.0 && !at_bound;
    told.then(|| Deviation { class: class.cloned(), of: of.clone(), deviation: off / std })
}

#[cfg(test)]
mod tests;
