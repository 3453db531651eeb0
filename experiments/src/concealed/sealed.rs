//! The sealed truth of a case, as written to `truth.json`.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use super::plants::{PLANTS, PlantSpec, ROBOTS};
use super::sensor::Concealment;

/// Families of cases.
#[derive(Clone, Copy, Debug, Deserialize, Eq, Ord, PartialEq, PartialOrd, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Group {
    /// Effects of the catalogue, by its formulas.
    Catalogue,
    /// Effects by other formulas, or with noise that is not white.
    OffFormula,
    /// Effects that act in a region or from a time on.
    Local,
    /// No physics is missing.
    Null,
    /// What real machines do beside: noisy inputs, random forces, hidden coordinates, outliers, slow
    /// sampling, laws of several variables, three effects at once.
    Machines,
    /// Robots that their own files describe.
    Robots,
}

impl Group {
    /// All groups.
    pub const ALL: [Self; 6] =
        [Self::Catalogue, Self::OffFormula, Self::Local, Self::Null, Self::Machines, Self::Robots];

    /// Its name on the command line and in the results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Catalogue => "catalogue",
            Self::OffFormula => "off-formula",
            Self::Local => "local",
            Self::Null => "null",
            Self::Machines => "machines",
            Self::Robots => "robots",
        }
    }

    /// What its cases are drawn from.
    pub fn plants(self) -> &'static [PlantSpec] {
        if self == Self::Robots { ROBOTS } else { PLANTS }
    }
}

/// What is the matter with the machine, as against its model.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Matter {
    /// Nothing.
    None,
    /// Nothing but a random force, which no model foresees.
    Disturbed,
    /// A parameter is wrong.
    Parameter,
    /// A sensor is wrong.
    Sensor,
    /// An effect is missing.
    MissingPhysics,
}

/// A class on a channel.
#[derive(Clone, Debug, Deserialize, Eq, PartialEq, Serialize)]
pub struct Name {
    /// Class of the catalogue.
    pub class: String,
    /// Channel, input or sensor.
    pub channel: String,
}

impl Name {
    /// A class on a channel.
    pub fn new(class: &str, channel: &str) -> Self {
        Self { class: class.to_owned(), channel: channel.to_owned() }
    }
}

/// Where or when a local effect acts.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Area {
    /// While a variable lies in a range.
    Region {
        /// A coordinate or state.
        variable: String,
        /// From this value on; none: from any.
        from: Option<f64>,
        /// To this value; none: to any.
        to: Option<f64>,
    },
    /// From this time (s) on.
    From(f64),
}

/// A concealed effect.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct SealedEffect {
    /// Class and channel.
    #[serde(flatten)]
    pub name: Name,
    /// The other coordinate of a coupling.
    pub other: Option<String>,
    /// Channels it depends on.
    pub depends_on: Vec<String>,
    /// Its numbers, in words for laws beyond the catalogue.
    pub parameters: serde_json::Value,
    /// Other names that count as right: nearest classes of a law beyond the catalogue, the other
    /// end of a coupling, and what these data cannot tell apart from it. `parameter_error` stands
    /// for the verdict miscalibrated without a finding.
    pub accept: Vec<Name>,
    /// Whether the catalogue holds the law.
    pub catalogue: bool,
    /// Where or when it acts, for local effects.
    pub area: Option<Area>,
    /// Calibrated gap without it alone, greatest output, in noise standard deviations.
    pub gap_over_noise: f64,
}

/// The sealed truth.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Sealed {
    /// Case.
    pub case: String,
    /// Plant.
    pub plant: String,
    /// Family.
    pub group: Group,
    /// What the case is about, in a word or two.
    pub topic: String,
    /// What is the matter.
    pub matter: Matter,
    /// How the plant is driven.
    pub drive: String,
    /// What is concealed.
    pub effects: Vec<SealedEffect>,
    /// True over nominal value of the parameters that are wrong.
    pub miscalibrated: BTreeMap<String, f64>,
    /// Standard deviation of all that is added to each measured channel, quantisation included.
    pub noise_sd: BTreeMap<String, f64>,
    /// How far the model file is off over short windows, in noise standard deviations: the
    /// greatest output.
    pub model_gap_over_noise: f64,
    /// How the recordings hide it.
    pub concealment: Concealment,
    /// Length of a short window (s), on which test recordings are scored.
    pub horizon_s: f64,
}
