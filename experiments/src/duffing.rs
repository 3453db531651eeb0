//! One Duffing trial, and how the errors depend on lambda (the paper's figures 1 and 3).

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use crate::cli::Common;
use crate::duffing_data::{Errors, TrialErrors, trajectories, values};
use crate::recipes::{paper, with_each};
use crate::statistics::OverTrials;
use crate::{StudyError, figures, output, progress};

/// Name of the study and of its results.
pub const NAME: &str = "duffing";

/// What the study found.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Results {
    /// [`NAME`].
    pub experiment: String,
    /// Trials over which each lambda is judged.
    pub trials: u64,
    /// Seed of all draws.
    pub seed: u64,
    /// Errors of trial 0 by recipe.
    pub recipes: BTreeMap<String, TrialErrors>,
    /// The paper's recipe with other values of lambda.
    pub lambda_ablation: Vec<Ablation>,
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

/// Carry out the study, write its results and print them.
///
/// # Errors
/// [`StudyError`] when identification fails or results cannot be written.
pub fn run(trials: u64, common: &Common) -> Result<(), StudyError> {
    let data = trajectories(common.seed, 0)?;
    let (mut curves, mut errors) = (BTreeMap::new(), BTreeMap::new());
    let recipes = with_each(|recipe| {
        let model = recipe.duffing(&data)?;
        let found = Errors::of(&model)?;
        let summary = found.summary();
        errors.insert(recipe.name(), found);
        curves.insert(recipe.name(), figures::duffing::curve(|x| values(&model, x))?);
        Ok(summary)
    })?;
    let lambda_ablation = ablation(trials, common.seed, common.quiet)?;
    let experiment = NAME.to_owned();
    let results = Results { experiment, trials, seed: common.seed, recipes, lambda_ablation };
    let file = output::write_json(&common.out, NAME, &results)?;
    let drawings = [
        ("figure_01_lambda_ablation", figures::duffing::ablation(&results.lambda_ablation)?),
        ("duffing_functions", figures::duffing::functions(&curves)?),
        ("figure_03_duffing_errors", figures::duffing::errors(&errors)?),
    ];
    for (name, svg) in &drawings {
        output::write_figure(&common.out, name, svg)?;
    }
    if !common.quiet {
        for (recipe, e) in &results.recipes {
            println!(
                "{recipe}: |f error| max {:.4} mean {:.4}, |g error| max {:.4} mean {:.4}",
                e.max_f, e.mean_f, e.max_g, e.mean_g
            );
        }
        println!("wrote {}", file.display());
    }
    Ok(())
}

/// The paper's recipe with lambda = 1e-13 ... 1e7 on the same trials.
fn ablation(trials: u64, seed: u64, quiet: bool) -> Result<Vec<Ablation>, StudyError> {
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
    let data = trajectories(seed, trial)?;
    lambdas()
        .map(|lambda| match paper(2, lambda).fit(&data) {
            Ok(model) => Ok(Some(Errors::of(&model)?.summary())),
            Err(lacuna_occupation::FitError::NotPositiveDefinite { .. }) => Ok(None),
            Err(other) => Err(other.into()),
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
