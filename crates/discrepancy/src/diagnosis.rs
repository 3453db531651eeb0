//! The result of a diagnosis, as written to `diagnosis.json` (schema 1).
//!
//! Fields are added in later versions of the same schema number, never renamed or removed;
//! a change of meaning raises the number.

mod robot;

pub use robot::{Joint, Robot};

use crate::conventions::Otherwise;
use lacuna_plants::Substeps;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Number of the schema.
pub const SCHEMA: u32 = 1;

/// A diagnosis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// Number of the schema: [`SCHEMA`].
    pub schema: u32,
    /// Name of the model.
    pub model: String,
    /// The robot that the model is of, if it is one's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<Robot>,
    /// What is the matter.
    pub verdict: Verdict,
    /// How the recordings seem to be meant, where they are not as the model reads them: nothing is named then.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub otherwise: Option<Otherwise>,
    /// The missing physics, the most important first.
    pub findings: Vec<Finding>,
    /// How well the formulas of the findings fit, whatever their names; none without findings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub formula: Option<FormulaFit>,
    /// Parameters that the recordings move, by name.
    pub calibration: BTreeMap<String, Calibration>,
    /// Where the mismatch is.
    pub location: Location,
    /// What the held-out recordings say of the model that was decided on.
    #[serde(default)]
    pub proof: ProofOutcome,
    /// The fit before and after. After a proof that failed, `after` is the model as it was given,
    /// which is handed back.
    pub fit: Fit,
    /// How the mismatch splits up: shares of the misfit on the training recordings that
    /// calibration takes away, each finding takes away, and that remain above the noise.
    pub ladder: Vec<Rung>,
    /// What drives the machine beside what was recorded.
    #[serde(default)]
    pub driving: Driving,
    /// How the predictions of the model that is handed back were integrated.
    #[serde(default)]
    pub integration: Integration,
    /// What was used and how it was treated.
    pub data: DataUsed,
    /// What these data cannot tell, and anything the reader must know.
    pub notes: Vec<String>,
}

/// What is the matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The model explains the recordings down to the noise.
    NoMismatch,
    /// The physics is right, a parameter is not.
    Miscalibrated,
    /// Physics is missing, and named.
    MissingPhysics,
    /// A sensor is wrong.
    SensorFault,
    /// The model is wrong in a way that the catalogue does not explain.
    Unexplained,
}

/// What drives the machine beside what was recorded, as far as the likelihood tells; nothing where
/// the recorded inputs alone do.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Driving {
    /// Noise on the recorded inputs, by name: the machine got something else.
    pub inputs: BTreeMap<String, InputNoise>,
    /// White random forces, by the channel that they act on.
    pub forces: BTreeMap<String, RandomForce>,
    /// Noise of recorded channels over what it seems from sample to sample, where it is larger.
    #[serde(default)]
    pub outputs: BTreeMap<String, f64>,
}

/// How motion is integrated from sample to sample: in steps that are halved until that changes
/// predictions by less than a hundredth of the noise, at most five times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Integration {
    /// Runge-Kutta steps from one sample to the next.
    pub steps_a_sample: usize,
    /// Whether a step is cut in four, and these once more and again, where slopes jump within it
    /// ([`lacuna_plants::Substeps`]).
    #[serde(default)]
    pub cut_where_slopes_jump: bool,
    /// Largest change of a prediction by the last halving that was tried, in units of the noise (of a
    /// thousandth of the channel's range, where that is more).
    #[serde(with = "infinite_as_null")]
    pub error_over_noise: f64,
}

impl Integration {
    /// In such steps, whose error is not known.
    #[must_use]
    pub fn in_steps(substeps: Substeps) -> Self {
        let Substeps { count, cut } = substeps;
        Self { steps_a_sample: count, cut_where_slopes_jump: cut, error_over_noise: f64::INFINITY }
    }

    /// The steps.
    #[must_use]
    pub fn substeps(&self) -> Substeps {
        Substeps { count: self.steps_a_sample, cut: self.cut_where_slopes_jump }
    }
}

/// Noise on a recorded input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InputNoise {
    /// Standard deviation, each sample apart.
    pub std: f64,
    /// The same as a share of the input's own standard deviation; `null` in JSON where the input never
    /// changes, infinite here.
    #[serde(with = "infinite_as_null")]
    pub share: f64,
    /// Unit.
    pub unit: String,
}

/// A white random force.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RandomForce {
    /// Root of its spectral density: over t seconds its mean has this over the root of t as its
    /// standard deviation.
    pub intensity: f64,
    /// Its standard deviation over one sample as a share of the force that moves the channel.
    pub share: f64,
    /// Unit.
    pub unit: String,
}

/// What recordings that nothing was fitted to and nothing was chosen by say of the decided model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProofOutcome {
    /// It predicts better than the model as it was.
    Better,
    /// Neither predicts better, or they are the same.
    #[default]
    Same,
    /// It predicts worse, and is refused.
    Worse,
}

/// An effect that the evidence supports.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Class of the catalogue.
    pub class: String,
    /// The law as it stands in the augmented model, where that is a variation of the class.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<String>,
    /// Channel (or input) it acts on.
    pub channel: String,
    /// The other channel of a coupling, or the input that a law depends on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other: Option<String>,
    /// Channels that the effect depends on; of an inertia "acceleration of" its channel.
    pub depends_on: Vec<String>,
    /// Range of those channels in which it acts.
    pub region: BTreeMap<String, [f64; 2]>,
    /// When it begins (s), for effects that begin.
    pub time: Option<f64>,
    /// Parameters by name.
    pub parameters: BTreeMap<String, Estimate>,
    /// Probability that this class on this channel is right, as often as such findings were in
    /// drawn cases ([`crate::probability`]). What it and its rivals leave to 1 is the
    /// probability that none of them is.
    pub probability: f64,
    /// Rivals, the most probable first.
    pub alternatives: Vec<Alternative>,
    /// Log evidence (nats) that it gains.
    pub evidence: f64,
    /// What speaks for the class before it is calibrated on drawn cases.
    #[serde(default)]
    pub support: Support,
    /// The finding in words.
    pub says: String,
    /// What would tell it from its first rival, where the recordings leave that open.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub experiment: Option<Experiment>,
    /// The missing force along one variable, for a picture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curve: Option<Curve>,
}

impl Finding {
    /// The law whose formula, parameters and words it has: a variation of its class, or the class itself.
    #[must_use]
    pub fn named_law(&self) -> &str {
        self.law.as_deref().unwrap_or(&self.class)
    }
}

/// What speaks for a finding's class: the evidence alone, before it is calibrated on drawn cases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Support {
    /// Log odds (nats) of the class against all of its rivals and against nothing at all.
    pub log_odds: f64,
    /// Evidence that it gains, relative to the finding that gains most.
    pub part: f64,
}

/// How well formulas fit: what the findings leave, all of them together, of the mismatch that the
/// calibrated model has without them. A class may be beyond doubt whose formula is only nearly
/// reality's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FormulaFit {
    /// Share of the mean square residual above the noise that is left on the training recordings.
    pub left: f64,
    /// Root mean square of what is left there with the noise, over the noise.
    pub residual_over_noise: f64,
}

/// An experiment that would tell rivals apart: a sine on one input, and what it would show.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Experiment {
    /// Input or imposed coordinate to drive.
    pub drive: String,
    /// Amplitude of the sine.
    pub amplitude: f64,
    /// Its unit.
    pub unit: String,
    /// Its frequency (Hz).
    pub frequency_hz: f64,
    /// Output to watch.
    pub watch: String,
    /// Root mean square difference of the two predictions there, in units of the noise.
    pub difference_over_noise: f64,
}

/// A number with its standard deviation and unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Value.
    pub value: f64,
    /// Standard deviation.
    pub std: f64,
    /// Unit.
    pub unit: String,
    /// Whether the value lies at the edge of what was tried: the recordings would have it beyond, and
    /// it is no estimate.
    #[serde(default)]
    pub at_bound: bool,
}

/// A rival of a finding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Alternative {
    /// Class of the catalogue.
    pub class: String,
    /// Channel (or input) it would act on.
    pub channel: String,
    /// Its probability.
    pub probability: f64,
    /// Nats by which it lies behind the finding.
    #[serde(default)]
    pub behind: f64,
}

/// A missing force over the variable it depends on: what the recordings show, learned
/// without a formula, and the law that is found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Name of the variable.
    pub variable: String,
    /// Its unit.
    pub variable_unit: String,
    /// Unit of the force.
    pub force_unit: String,
    /// Values of the variable, on an even grid but for those that were never visited.
    pub at: Vec<f64>,
    /// Learned force there.
    pub learned: Vec<f64>,
    /// Its standard deviation.
    pub std: Vec<f64>,
    /// The named law there; empty where no law is named.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub law: Vec<f64>,
}

/// A parameter that the recordings move.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// What the model says.
    pub nominal: f64,
    /// What the recordings say.
    pub value: f64,
    /// Standard deviation.
    pub std: f64,
    /// Unit.
    pub unit: String,
    /// Whether the value lies at the edge of what the model's uncertainty allows.
    #[serde(default)]
    pub at_bound: bool,
}

/// Where the mismatch is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Location {
    /// By channel.
    pub channels: BTreeMap<String, ChannelMismatch>,
}

/// The mismatch in one channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChannelMismatch {
    /// Classes of the findings that act on it.
    pub explained_by: Vec<String>,
    /// Log evidence (nats) that a force of one variable is missing in this channel's equation,
    /// which its uncertain parameters cannot stand for; 0 where nothing measured tells.
    pub significance: f64,
    /// The variable over which a free curve shows it best.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depends_on: Option<String>,
    /// Range of that variable in which it acts.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub region: BTreeMap<String, [f64; 2]>,
    /// When it begins (s), where nothing was missing before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// Root mean square, along the measured motion, of the force that is missing before anything
    /// is added; 0 where the evidence supports none.
    pub missing_force: f64,
    /// Its unit.
    pub unit: String,
    /// The force that is missing before anything is added, learned along the measured motion
    /// without a formula: over the variable that shows it best, and what varies beside it (with
    /// no mean) over others where the evidence supports that. Values of the variable that the
    /// recordings never came near are left out. Empty where the evidence does not support any.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub curves: Vec<Curve>,
}

/// The fit before and after.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Fit {
    /// On recordings that nothing was fitted to.
    pub held_out: BTreeMap<String, ChannelFit>,
    /// On the recordings that were used.
    pub training: BTreeMap<String, ChannelFit>,
    /// On each held-out recording by its name, where there are several.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub by_recording: BTreeMap<String, BTreeMap<String, ChannelFit>>,
}

/// Errors of one measured channel; `null` in JSON where the model diverges, infinite here.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChannelFit {
    /// Unit of all errors.
    pub unit: String,
    /// Of the model as it was, over windows.
    #[serde(with = "infinite_as_null")]
    pub rmse_before: f64,
    /// Of the augmented model, over windows.
    #[serde(with = "infinite_as_null")]
    pub rmse_after: f64,
    /// Noise standard deviation.
    pub noise: f64,
    /// Length of the windows (s).
    pub horizon_s: f64,
    /// Of the model as it was, running free from the first samples to the end.
    #[serde(with = "infinite_as_null")]
    pub free_run_before: f64,
    /// Of the augmented model, running free.
    #[serde(with = "infinite_as_null")]
    pub free_run_after: f64,
}

/// One step of the ladder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rung {
    /// What it is: "calibration", a finding, "unexplained".
    pub what: String,
    /// Share of the mean square of the missing force.
    pub share: f64,
}

/// What was used.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DataUsed {
    /// Recordings that were fitted.
    pub training: Vec<String>,
    /// Recordings kept for proof.
    pub held_out: Vec<String>,
    /// Samples that were fitted.
    pub samples: usize,
    /// Rows that were dropped in the recordings and filled in for smoothing.
    pub dropped: usize,
    /// Samples of each channel, of all recordings, that were left out as outliers.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub outliers: BTreeMap<String, usize>,
    /// States of the model that no recording measures; what acts on them shows in the others
    /// alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unmeasured: Vec<String>,
    /// The version of Lacuna.
    pub version: String,
}

/// JSON has no infinity: an infinite error is null there.
mod infinite_as_null {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(value: &f64, to: S) -> Result<S::Ok, S::Error> {
        value.is_finite().then_some(*value).serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
        Ok(Option::deserialize(from)?.unwrap_or(f64::INFINITY))
    }
}
