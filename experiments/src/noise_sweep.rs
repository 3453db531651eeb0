//! Errors of the Duffing study against the noise on the position.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use crate::cli::Common;
use crate::duffing_data::{Errors, TrialErrors, trajectories};
use crate::duffing_montecarlo::Statistics;
use crate::recipes::{Recipe, with_each};
use crate::{StudyError, figures, output, progress};

/// Name of the study and of its results.
pub const NAME: &str = "noise-sweep";
/// Standard deviations of the noise on the position.
pub const NOISE: [f64; 6] = [0.0, 0.001, 0.003, 0.01, 0.03, 0.1];

/// What the study found.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Results {
    /// [`NAME`].
    pub experiment: String,
    /// Trials with each noise; trial k has the same inputs with each.
    pub trials: u64,
    /// Seed of all draws.
    pub seed: u64,
    /// Errors with each noise.
    pub levels: Vec<Level>,
}

/// Errors with one noise.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Level {
    /// Standard deviation of the noise on the position.
    pub noise: f64,
    /// Errors by recipe.
    pub recipes: BTreeMap<String, Found>,
}

/// What a recipe found with one noise.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Found {
    /// Trials of which the recipe made no model; they do not enter the errors.
    pub failed_trials: usize,
    /// Errors over the other trials; none when all failed.
    pub errors: Option<Statistics>,
}

impl Found {
    fn of(trials: &[Option<TrialErrors>]) -> Self {
        let found: Vec<TrialErrors> = trials.iter().copied().flatten().collect();
        let errors = (!found.is_empty()).then(|| Statistics::of(&found));
        Self { failed_trials: trials.len() - found.len(), errors }
    }
}

/// Errors with each of [`NOISE`] over the trials 0 to `trials - 1`.
///
/// # Errors
/// [`StudyError`] when a trial cannot be simulated. A recipe that fails is counted.
pub fn levels(
    recipes: &[Recipe],
    trials: u64,
    seed: u64,
    quiet: bool,
) -> Result<Vec<Level>, StudyError> {
    let jobs: Vec<(f64, u64)> =
        NOISE.iter().flat_map(|&noise| (0..trials).map(move |trial| (noise, trial))).collect();
    let bar = progress::bar(jobs.len(), "trials", quiet);
    let one = |&(noise, trial): &(f64, u64)| {
        let found = judge(recipes, seed, trial, noise);
        bar.inc(1);
        found
    };
    let found: Vec<BTreeMap<String, Option<TrialErrors>>> =
        jobs.par_iter().map(one).collect::<Result<_, _>>()?;
    bar.finish_and_clear();
    let by_level = NOISE.iter().zip(found.chunks_exact(trials as usize));
    Ok(by_level.map(|(&noise, trials)| Level { noise, recipes: by_recipe(trials) }).collect())
}

/// Errors of each recipe on one trial; none where it fails.
fn judge(
    recipes: &[Recipe],
    seed: u64,
    trial: u64,
    noise: f64,
) -> Result<BTreeMap<String, Option<TrialErrors>>, StudyError> {
    let data = trajectories(seed, trial, noise)?;
    with_each(recipes, |recipe| match recipe.duffing(&data) {
        Ok(model) => Ok(Some(Errors::of(&*model)?.summary())),
        Err(_) => Ok(None),
    })
}

fn by_recipe(trials: &[BTreeMap<String, Option<TrialErrors>>]) -> BTreeMap<String, Found> {
    let mut recipes: BTreeMap<String, Vec<Option<TrialErrors>>> = BTreeMap::new();
    for (recipe, errors) in trials.iter().flatten() {
        recipes.entry(recipe.clone()).or_default().push(*errors);
    }
    recipes.into_iter().map(|(recipe, errors)| (recipe, Found::of(&errors))).collect()
}

/// Carry out the study, write its results and print them.
///
/// # Errors
/// [`StudyError`] when a trial cannot be simulated or results cannot be written.
pub fn run(trials: u64, common: &Common) -> Result<(), StudyError> {
    let levels = levels(&Recipe::ALL, trials, common.seed, common.quiet)?;
    let results = Results { experiment: NAME.to_owned(), trials, seed: common.seed, levels };
    let file = output::write_json(&common.out, NAME, &results)?;
    let svg = figures::noise_sweep::errors(&results.levels)?;
    output::write_figure(&common.out, "noise_sweep", &svg)?;
    if !common.quiet {
        print(&results);
        println!("wrote {}", file.display());
    }
    Ok(())
}

fn print(results: &Results) {
    println!("medians over {} trials of the greatest and the mean error", results.trials);
    println!(
        "{:<7} {:<8} {:>9} {:>9} {:>9} {:>9} {:>7}",
        "noise", "recipe", "max |f|", "max |g|", "mean |f|", "mean |g|", "failed"
    );
    for level in &results.levels {
        for (recipe, found) in &level.recipes {
            print!("{:<7} {recipe:<8}", level.noise);
            match found.errors {
                Some(s) => [s.max_f, s.max_g, s.mean_f, s.mean_g]
                    .iter()
                    .for_each(|o| print!(" {:>9.4}", o.median)),
                None => print!("{:>40}", "none"),
            }
            println!(" {:>7}", found.failed_trials);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{duffing_data, duffing_montecarlo};

    #[test]
    fn failed_trials_are_counted_and_left_out() {
        let errors =
            TrialErrors { max_f: 1.0, max_g: 2.0, mean_f: 0.5, mean_g: 0.25, coverage: None };
        let found = Found::of(&[None, Some(errors), None]);
        assert_eq!((found.failed_trials, found.errors.unwrap().max_g.mean), (2, 2.0));
        let none = Found::of(&[None]);
        assert_eq!(none, Found { failed_trials: 1, errors: None });
        let text = serde_json::to_string(&none).unwrap();
        assert_eq!(serde_json::from_str::<Found>(&text).unwrap(), none);
    }

    /// With the paper's noise the trials are those of the Monte-Carlo study.
    #[test]
    fn the_sweep_and_the_montecarlo_share_their_trials() {
        let sweep = judge(&Recipe::ALL, 7, 1, duffing_data::NOISE).unwrap();
        for (recipe, trials) in duffing_montecarlo::trials(2, 7, true).unwrap() {
            assert_eq!(sweep[&recipe], Some(trials[1]), "{recipe}");
        }
    }
}
