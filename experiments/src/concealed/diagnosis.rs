//! What `diagnosis.json` says, as far as the proof reads it.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use lacuna_discrepancy::diagnosis::{Calibration, Estimate, FormulaFit, Support};

use super::sealed::Name;

/// A diagnosis.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Diagnosis {
    /// What is the matter, in the words of the schema.
    pub verdict: String,
    /// The missing physics.
    pub findings: Vec<Finding>,
    /// How well the formulas fit.
    #[serde(default)]
    pub formula: Option<FormulaFit>,
    /// The model's own parameters as they were estimated.
    #[serde(default)]
    pub calibration: BTreeMap<String, Calibration>,
}

/// A finding.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(default)]
pub struct Finding {
    /// Class.
    pub class: String,
    /// Channel.
    pub channel: String,
    /// The other channel of a coupling.
    pub other: Option<String>,
    /// Channels that it depends on.
    pub depends_on: Vec<String>,
    /// Where it acts.
    pub region: BTreeMap<String, [f64; 2]>,
    /// When it begins (s).
    pub time: Option<f64>,
    /// Its numbers.
    pub parameters: BTreeMap<String, Estimate>,
    /// Claimed probability.
    pub probability: Option<f64>,
    /// What speaks for the class before calibration.
    pub support: Option<Support>,
    /// Rivals, the most probable first.
    pub alternatives: Vec<Alternative>,
}

/// A rival of a finding.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Alternative {
    /// Class and channel.
    #[serde(flatten)]
    pub name: Name,
}

impl Finding {
    /// Class and channel.
    pub fn name(&self) -> Name {
        Name::new(&self.class, &self.channel)
    }
}
