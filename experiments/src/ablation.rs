//! How much the findings hang on the numbers that decide: each field of
//! [`Decision`] halved and doubled, all else as it is, on drawn cases of [`crate::concealed`].
//!
//! The cases are the same for every setting and are diagnosed in this process. The file is written
//! anew after every setting, so that a run that is stopped loses one setting at most and
//! `--resume` goes on behind the last.

use lacuna_discrepancy::decision::{Decision, FIELDS, Field};
use lacuna_discrepancy::diagnose::{Options, Outcome, diagnose, split};
use lacuna_discrepancy::{Dataset, DiagnoseError, Predictor, Watch};
use lacuna_plants::Model;
use lacuna_recordings::Recording;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::Path;

use crate::StudyError;
use crate::cli::Common;
use crate::concealed::ConcealedError;
use crate::concealed::case::{Case, Plan, plans};
use crate::concealed::proportion::Proportion;
use crate::concealed::score::{Score, score};
use crate::concealed::sealed::{Matter, Sealed};
use crate::statistics::quantile;
use crate::{output, progress};

/// Name of the study, and of the directory of its results.
pub const NAME: &str = "ablation";
/// Name of its file there.
const FILE: &str = "statistics";
/// Factors that each number is multiplied with: far more than any of the reasons beside the numbers
/// leaves open.
const FACTORS: [f64; 2] = [0.5, 2.0];

/// What to do.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Number of cases.
    pub cases: usize,
    /// Names of the fields to move; none: all.
    pub fields: Vec<String>,
    /// Threads, each with one case at a time.
    pub jobs: usize,
    /// Keep the settings that the file of results has of the same cases.
    pub resume: bool,
}

/// What the study found.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Results {
    /// [`NAME`].
    pub experiment: String,
    /// The command that produced this file.
    pub command: String,
    /// Seed of all draws.
    pub seed: u64,
    /// Number of cases.
    pub cases: usize,
    /// One row a setting, the first with every number as it is.
    pub settings: Vec<Setting>,
}

/// What becomes of the cases under one setting.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Setting {
    /// The field that is moved; none: all as they are.
    pub field: Option<String>,
    /// Its value.
    pub value: Option<f64>,
    /// Effects whose class and channel are found, of all effects.
    pub named: Proportion,
    /// Findings that answer to no effect.
    pub false_findings: usize,
    /// Cases with the right verdict.
    pub verdicts: Proportion,
    /// Cases without missing physics on which nothing is found, of all such cases.
    pub nulls_silent: Proportion,
    /// Median error over the noise of the augmented model on recordings for the proof, over the
    /// cases that conceal an effect.
    pub median_error_over_noise: Option<f64>,
    /// Cases without an answer.
    pub crashes: usize,
}

/// One case under one setting.
struct Answer {
    matter: Matter,
    score: Score,
    answered: bool,
    error_over_noise: Option<f64>,
}

/// Carry out the study and print it.
///
/// # Errors
/// [`StudyError`] when a case cannot be drawn, a field is not one, or files cannot be read or written.
pub fn run(settings: &Settings, common: &Common) -> Result<(), StudyError> {
    let fields = fields(&settings.fields)?;
    let directory = common.out.join(NAME);
    let mut results = begun(settings, common, &directory)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.jobs).build()?;
    let plans = plans(common.seed, settings.cases, None);
    let draw = |plan: &Plan| Case::draw(common.seed, plan);
    let cases: Vec<Case> = pool.install(|| plans.par_iter().map(draw).collect::<Result<_, _>>())?;
    if !common.quiet {
        print_head(&results);
    }
    for (name, decision, value) in settings_of(&fields) {
        if results.settings.iter().any(|s| s.is(name, value)) {
            continue;
        }
        let bar = progress::bar(cases.len(), "cases", common.quiet);
        let one = |case: &Case| {
            let answer = answer(case, decision);
            bar.inc(1);
            answer
        };
        let answers = pool.install(|| cases.par_iter().map(one).collect::<Result<Vec<_>, _>>());
        bar.finish_and_clear();
        let setting = Setting::of(name, value, &answers?);
        if !common.quiet {
            println!("{}", line(&setting));
        }
        results.settings.push(setting);
        output::write_json(&directory, FILE, &results)?;
    }
    if !common.quiet {
        println!("wrote {}", directory.join(FILE).with_extension("json").display());
    }
    Ok(())
}

/// The fields of these names; of none, all.
fn fields(names: &[String]) -> Result<Vec<Field>, StudyError> {
    if names.is_empty() {
        return Ok(FIELDS.to_vec());
    }
    let find = |name: &String| {
        let unknown =
            || StudyError::NoField { name: name.clone(), known: FIELDS.map(|f| f.name).join(", ") };
        FIELDS.iter().find(|f| f.name == name).copied().ok_or_else(unknown)
    };
    names.iter().map(find).collect()
}

/// All settings: the decision as it is, then each field halved and doubled.
fn settings_of(fields: &[Field]) -> Vec<(Option<&'static str>, Decision, Option<f64>)> {
    let plain = Decision::default();
    let moved = fields.iter().flat_map(|field| {
        FACTORS.map(|factor| {
            let decision = field.set(plain, factor * field.of(&plain));
            (Some(field.name), decision, Some(field.of(&decision)))
        })
    });
    std::iter::once((None, plain, None)).chain(moved).collect()
}

/// What is there of an earlier run of the same cases, where that is wanted.
fn begun(settings: &Settings, common: &Common, directory: &Path) -> Result<Results, StudyError> {
    let fresh = Results {
        experiment: NAME.to_owned(),
        command: format!(
            "cargo run --release -p experiments -- {NAME} --cases {} --seed {}",
            settings.cases, common.seed
        ),
        seed: common.seed,
        cases: settings.cases,
        settings: vec![],
    };
    let path = directory.join(FILE).with_extension("json");
    if !settings.resume || !path.exists() {
        return Ok(fresh);
    }
    let earlier: Results = output::read_json(&path)?;
    let same = (earlier.seed, earlier.cases) == (fresh.seed, fresh.cases);
    Ok(if same { Results { settings: earlier.settings, ..fresh } } else { fresh })
}

/// Diagnose a case and score it.
fn answer(case: &Case, decision: Decision) -> Result<Answer, StudyError> {
    let model = case.files.read()?;
    let options = Options { decision, ..Options::default() };
    let truth = &case.sealed;
    let (diagnosis, error_over_noise) = match diagnosed(&model, &case.recordings, options) {
        Ok(outcome) => {
            let error = error_over_noise(&model, &outcome, &case.tests, truth)?;
            let said = serde_json::to_value(&outcome.diagnosis)
                .and_then(serde_json::from_value)
                .map_err(|source| StudyError::Json { path: "diagnosis.json".into(), source })?;
            (Some(said), error)
        }
        Err(_) => (None, None),
    };
    Ok(Answer {
        matter: truth.matter,
        answered: diagnosis.is_some(),
        score: score(truth, &diagnosis.unwrap_or_default()),
        error_over_noise,
    })
}

fn diagnosed(
    model: &Model,
    recordings: &[Recording],
    options: Options,
) -> Result<Outcome, DiagnoseError> {
    let (training, held_out) = split(&Dataset::new(model, recordings)?);
    diagnose(model, &training, &held_out, options, &Watch::default())
}

/// Error of the augmented model on recordings for the proof over the noise, greatest channel; none
/// where it diverges.
fn error_over_noise(
    model: &Model,
    outcome: &Outcome,
    tests: &[Recording],
    truth: &Sealed,
) -> Result<Option<f64>, StudyError> {
    let text = model.augmented_text(&outcome.augmentation).map_err(ConcealedError::from)?;
    let augmented = Model::from_text(&text, "augmented.toml").map_err(ConcealedError::from)?;
    let mut squares = vec![0.0; truth.noise_sd.len()];
    for test in tests {
        let Ok(dataset) = Dataset::new(&augmented, std::slice::from_ref(test)) else {
            return Ok(None);
        };
        let (predictor, observed) = (Predictor::new(&augmented, &dataset), &dataset.recordings[0]);
        let prediction = predictor.windowed(observed, truth.horizon_s);
        for (sum, (channel, sd)) in squares.iter_mut().zip(&truth.noise_sd) {
            let output = dataset.outputs.iter().position(|o| o.name == *channel);
            let Some(k) = output else { return Ok(None) };
            *sum += (prediction.rmse(observed, k) / sd).powi(2) / tests.len() as f64;
        }
    }
    let worst = squares.into_iter().fold(0.0, f64::max).sqrt();
    Ok(worst.is_finite().then_some(worst))
}

impl Setting {
    fn of(field: Option<&str>, value: Option<f64>, answers: &[Answer]) -> Self {
        let sum = |f: fn(&Answer) -> usize| answers.iter().map(f).sum::<usize>();
        let null = |a: &&Answer| a.answered && matches!(a.matter, Matter::None | Matter::Parameter);
        let nulls: Vec<_> = answers.iter().filter(null).collect();
        let silent = nulls.iter().filter(|a| a.score.false_findings == 0).count();
        let errors: Vec<f64> = answers
            .iter()
            .filter(|a| a.score.effects > 0)
            .filter_map(|a| a.error_over_noise)
            .collect();
        Self {
            field: field.map(str::to_owned),
            value,
            named: Proportion::new(sum(|a| a.score.named), sum(|a| a.score.effects)),
            false_findings: sum(|a| a.score.false_findings),
            verdicts: Proportion::new(
                sum(|a| usize::from(a.answered && a.score.verdict_right)),
                answers.len(),
            ),
            nulls_silent: Proportion::new(silent, nulls.len()),
            median_error_over_noise: (!errors.is_empty()).then(|| quantile(&errors, 0.5)),
            crashes: sum(|a| usize::from(!a.answered)),
        }
    }

    fn is(&self, field: Option<&str>, value: Option<f64>) -> bool {
        (self.field.as_deref(), self.value) == (field, value)
    }
}

fn print_head(results: &Results) {
    println!("{} cases, seed {}; counts with Wilson's 95 % interval", results.cases, results.seed);
    println!(
        "{:<16} {:>8}  {:<20} {:>5}  {:<20} {:<18} {:>11} {:>9}",
        "field", "value", "named", "false", "verdicts", "nulls silent", "error/noise", "no answer"
    );
    for setting in &results.settings {
        println!("{}", line(setting));
    }
}

fn line(s: &Setting) -> String {
    let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.4}"));
    format!(
        "{:<16} {:>8}  {:<20} {:>5}  {:<20} {:<18} {:>11} {:>9}",
        s.field.as_deref().unwrap_or("as they are"),
        number(s.value),
        s.named,
        s.false_findings,
        s.verdicts,
        s.nulls_silent,
        number(s.median_error_over_noise),
        s.crashes
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_halved_and_doubled_once() {
        let settings = settings_of(&FIELDS);
        assert_eq!(settings.len(), 1 + 2 * FIELDS.len());
        let plain = Decision::default();
        assert_eq!(settings[0].1, plain);
        for (field, pair) in FIELDS.iter().zip(settings[1..].chunks(2)) {
            let values = [pair[0].2, pair[1].2].map(Option::unwrap);
            assert!(values[0] < field.of(&plain) && field.of(&plain) < values[1], "{}", field.name);
        }
    }

    #[test]
    fn a_field_that_is_none_is_refused_with_those_that_are() {
        let error = fields(&["prior_odds".to_owned(), "luck".to_owned()]).unwrap_err();
        let said = error.to_string();
        assert!(said.contains("luck") && said.contains("prior_odds"), "{said}");
    }

    #[test]
    fn counts_are_those_of_the_answers() {
        let score = |effects, named, false_findings| Score {
            effects,
            named,
            false_findings,
            verdict_right: true,
            ..Score::default()
        };
        let answer = |matter, score, error| Answer {
            matter,
            score,
            answered: true,
            error_over_noise: error,
        };
        let lost = Answer { answered: false, ..answer(Matter::None, score(0, 0, 0), None) };
        let answers = [
            answer(Matter::MissingPhysics, score(2, 1, 1), Some(3.0)),
            answer(Matter::MissingPhysics, score(1, 1, 0), Some(1.0)),
            answer(Matter::None, score(0, 0, 0), Some(9.0)),
            answer(Matter::Parameter, score(0, 0, 1), Some(9.0)),
            lost,
        ];
        let s = Setting::of(Some("tie"), Some(1.0), &answers);
        assert_eq!((s.named.count, s.named.of, s.false_findings), (2, 3, 2));
        assert_eq!((s.verdicts.count, s.verdicts.of, s.crashes), (4, 5, 1));
        assert_eq!((s.nulls_silent.count, s.nulls_silent.of), (1, 2));
        assert_eq!(s.median_error_over_noise, Some(2.0));
    }
}
