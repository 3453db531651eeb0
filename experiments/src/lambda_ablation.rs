//! How the paper's recipe depends on lambda (a figure of the paper's final version).

use lacuna_occupation::FitError;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::Path;

use crate::cli::Common;
use crate::duffing_data::{Errors, NOISE, TrialErrors, trajectories};
use crate::published::{self, LambdaCurves};
use crate::recipes::{IdentificationError, paper};
use crate::statistics::OverTrials;
use crate::{StudyError, figures, output, progress};

/// Name of the study and of its results.
pub const NAME: &str = "lambda-ablation";

/// What the study found.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Results {
    /// [`NAME`].
    pub experiment: String,
    /// Trials over which each lambda is judged.
    pub trials: u64,
    /// Seed of all draws.
    pub seed: u64,
    /// The paper's recipe with each value of lambda.
    pub lambdas: Vec<Ablation>,
}

/// Errors with one value of lambda.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Ablation {
    /// The regularisation.
    pub lambda: f64,
    /// Mean `|f - f^|` over the points, summarised over trials.
    pub mean_f: OverTrials,
    /// Mean `|g - g^|` over the points, summarised over trials.
    pub mean_g: OverTrials,
    /// Trials left out because rounding made the regularised Gram matrix indefinite.
    pub failed_trials: usize,
}

/// Carry out the study, write its results and print them. Where the file `published` exists, its
/// curves are drawn behind ours; they go nowhere else.
///
/// # Errors
/// [`StudyError`] when identification fails, `published` exists but does not hold the curves, or
/// results cannot be written.
pub fn run(trials: u64, published: &Path, common: &Common) -> Result<(), StudyError> {
    let curves = published::lambda_curves(published)?;
    let lambdas = ablation(trials, common.seed, common.quiet)?;
    let results = Results { experiment: NAME.to_owned(), trials, seed: common.seed, lambdas };
    let file = output::write_json(&common.out, NAME, &results)?;
    let svg = figures::duffing::ablation(&results.lambdas, curves.as_ref())?;
    output::write_figure(&common.out, "lambda_ablation", &svg)?;
    if !common.quiet {
        print(&results, curves.as_ref(), published);
        println!("wrote {}", file.display());
    }
    Ok(())
}

fn print(results: &Results, curves: Option<&LambdaCurves>, published: &Path) {
    println!("{:<8} {:>10} {:>10} {:>7}", "lambda", "mean |f|", "mean |g|", "failed");
    for a in &results.lambdas {
        let (f, g, failed) = (a.mean_f.mean, a.mean_g.mean, a.failed_trials);
        println!("{:<8.0e} {f:>10.4} {g:>10.4} {failed:>7}", a.lambda);
    }
    let path = published.display();
    match curves {
        Some(_) => println!("the figure shows the published curves of {path} behind ours"),
        None => println!("the figure is drawn without published curves: no file {path}"),
    }
}

/// The paper's recipe with lambda = 1e-13 ... 1e7 on the same trials.
///
/// # Errors
/// [`StudyError`] when simulation or identification fails, but for indefinite Gram matrices.
pub fn ablation(trials: u64, seed: u64, quiet: bool) -> Result<Vec<Ablation>, StudyError> {
    let bar = progress::bar(trials as usize, "choice of lambda", quiet);
    let one = |trial| {
        let found = judge_lambdas(seed, trial);
        bar.inc(1);
        found
    };
    let trials: Vec<Vec<Option<TrialErrors>>> =
        (0..trials).into_par_iter().map(one).collect::<Result<_, _>>()?;
    bar.finish_and_clear();
    Ok(lambdas().enumerate().map(|(k, lambda)| summarise(k, lambda, &trials)).collect())
}

fn lambdas() -> impl Iterator<Item = f64> {
    (-13..=7).map(|exponent| 10_f64.powi(exponent))
}

/// Errors of one trial for each lambda; none where the Gram matrix cannot be factorised.
fn judge_lambdas(seed: u64, trial: u64) -> Result<Vec<Option<TrialErrors>>, StudyError> {
    let data = trajectories(seed, trial, NOISE)?;
    lambdas()
        .map(|lambda| match paper(2, lambda).fit(&data) {
            Ok(model) => Ok(Some(Errors::of(&model)?.summary())),
            Err(FitError::NotPositiveDefinite { .. }) => Ok(None),
            Err(other) => Err(IdentificationError::from(other).into()),
        })
        .collect()
}

fn summarise(k: usize, lambda: f64, trials: &[Vec<Option<TrialErrors>>]) -> Ablation {
    let found: Vec<TrialErrors> = trials.iter().filter_map(|t| t[k]).collect();
    let over =
        |pick: fn(&TrialErrors) -> f64| OverTrials::of(&found.iter().map(pick).collect::<Vec<_>>());
    let failed_trials = trials.len() - found.len();
    Ablation { lambda, mean_f: over(|e| e.mean_f), mean_g: over(|e| e.mean_g), failed_trials }
}
