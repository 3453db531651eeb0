//! One case from its files to its scores.

use lacuna_discrepancy::diagnosis::FormulaFit;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::Path;

use super::deviations::{Deviation, deviations};
use super::diagnosis::Diagnosis;
use super::draw::{RECORDINGS, TESTS};
use super::files::Folders;
use super::localise::localised;
use super::score::{Score, score};
use super::sealed::{Group, Matter, Name, Sealed};
use super::tool::Tool;
use crate::StudyError;

/// Column of time in all cases.
const TIME: &str = "t";

/// What became of a case.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Row {
    /// Case.
    pub case: String,
    /// Plant.
    pub plant: String,
    /// Family.
    pub group: Group,
    /// Topic.
    pub topic: String,
    /// What is the matter.
    pub matter: Matter,
    /// What is concealed.
    pub truth: Vec<Name>,
    /// Gap of the model file over short windows, in noise standard deviations.
    pub model_gap_over_noise: f64,
    /// Verdict; none where there is no diagnosis.
    pub verdict: Option<String>,
    /// What is found.
    pub findings: Vec<Name>,
    /// How well the formulas of the findings fit.
    #[serde(default)]
    pub formula: Option<FormulaFit>,
    /// The score.
    pub score: Score,
    /// F1 of each local effect.
    pub f1: Vec<f64>,
    /// Reported numbers against the true ones, where the findings are right.
    #[serde(default)]
    pub deviations: Vec<Deviation>,
    /// Error of the nominal model on the recordings for the proof, greatest channel, in noise
    /// standard deviations.
    pub before_over_noise: Option<f64>,
    /// That of the augmented model.
    pub after_over_noise: Option<f64>,
    /// Wall time of the diagnosis (s).
    pub seconds: f64,
    /// What went wrong, where the tool gave no diagnosis.
    pub crash: Option<String>,
    /// Score of the peers' way on the same files; where it gave no answer, as if it found nothing.
    pub peer: Score,
    /// Whether the peers' way gave no answer.
    pub peer_failed: bool,
}

/// Diagnose a case that has been written, break its seal, and score it.
///
/// # Errors
/// [`StudyError`] when the tool cannot be started or files cannot be read.
pub fn judge(tool: &Tool, folders: &Folders) -> Result<Row, StudyError> {
    let (diagnosis, seconds) = diagnose(tool, folders)?;
    let peer = super::peer::diagnose(folders, RECORDINGS);
    // Nothing above this line has seen what is below.
    let truth = folders.unseal()?;
    let (diagnosis, crash) = match diagnosis {
        Ok(diagnosis) => (Some(diagnosis), None),
        Err(complaint) => (None, Some(complaint)),
    };
    let found = diagnosis.clone().unwrap_or_default();
    let score = score(&truth, &found);
    let f1 = localised(&truth, &score, &found, &folders.states(RECORDINGS), TIME)?;
    let nominal = folders.open.join("model.toml");
    let augmented = folders.open.join("diagnosis/augmented.toml");
    let after = match &diagnosis {
        Some(_) => on_tests(tool, &augmented, &truth, folders)?,
        None => None,
    };
    Ok(Row {
        before_over_noise: on_tests(tool, &nominal, &truth, folders)?,
        after_over_noise: after,
        case: truth.case.clone(),
        plant: truth.plant.clone(),
        group: truth.group,
        topic: truth.topic.clone(),
        matter: truth.matter,
        truth: truth.effects.iter().map(|e| e.name.clone()).collect(),
        model_gap_over_noise: truth.model_gap_over_noise,
        verdict: diagnosis.map(|d| d.verdict),
        findings: found.findings.iter().map(|f| f.name()).collect(),
        deviations: deviations(&truth, &found),
        formula: found.formula,
        score,
        f1,
        seconds,
        crash,
        peer_failed: peer.is_none(),
        peer: super::score::score(&truth, &peer.unwrap_or_default()),
    })
}

/// The diagnosis by the tool, or what it complained of, and the wall time.
fn diagnose(
    tool: &Tool,
    folders: &Folders,
) -> Result<(Result<Diagnosis, String>, f64), StudyError> {
    let mut arguments: Vec<OsString> = vec!["diagnose".into(), "model.toml".into()];
    arguments.extend(Folders::recordings(RECORDINGS).into_iter().map(OsString::from));
    arguments.extend(["--out", "diagnosis", "--quiet"].map(OsString::from));
    let answer = tool.run(&folders.open, &arguments)?;
    let path = folders.open.join("diagnosis/diagnosis.json");
    let outcome = match answer.code {
        None => Err(format!("no answer after {:.0} s", answer.seconds)),
        Some(0 | 1) => read(&path).map_err(|e| match answer.complaint.is_empty() {
            true => e,
            false => answer.complaint.clone(),
        }),
        Some(code) => Err(format!("exit code {code}: {}", answer.complaint)),
    };
    Ok((outcome, answer.seconds))
}

fn read(path: &Path) -> Result<Diagnosis, String> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("diagnosis.json: {e}"))?;
    serde_json::from_str(&text).map_err(|e| format!("diagnosis.json: {e}"))
}

/// Error on the recordings for the proof over the noise, greatest channel; none where the model
/// cannot be simulated on one of them.
fn on_tests(
    tool: &Tool,
    model: &Path,
    truth: &Sealed,
    folders: &Folders,
) -> Result<Option<f64>, StudyError> {
    let mut squares: BTreeMap<String, f64> = BTreeMap::new();
    for test in folders.tests(TESTS) {
        let Some(errors) = tool.errors(model, &test, truth.horizon_s)? else { return Ok(None) };
        for (channel, error) in errors {
            *squares.entry(channel).or_default() += error * error / TESTS as f64;
        }
    }
    let ratios = truth.noise_sd.iter().filter_map(|(c, sd)| Some(squares.get(c)?.sqrt() / sd));
    Ok(ratios.reduce(f64::max))
}
