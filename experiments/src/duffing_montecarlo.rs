//! Errors of the Duffing study over many trials (the paper's table 1 and figures 5 and 6).

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use crate::cli::Common;
use crate::duffing_data::{Errors, NOISE, TrialErrors, trajectories};
use crate::recipes::{Recipe, with_each};
use crate::statistics::OverTrials;
use crate::{StudyError, figures, output, progress};

/// Name of the study and of its results.
pub const NAME: &str = "duffing-montecarlo";

/// What the study found.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Results {
    /// [`NAME`].
    pub experiment: String,
    /// Number of trials.
    pub trials: u64,
    /// Seed of all draws.
    pub seed: u64,
    /// Errors by recipe.
    pub recipes: BTreeMap<String, Statistics>,
}

/// Absolute errors on the evaluation points, over trials.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Statistics {
    /// Greatest error of the drift.
    pub max_f: OverTrials,
    /// Greatest error of the control effectiveness.
    pub max_g: OverTrials,
    /// Mean error of the drift.
    pub mean_f: OverTrials,
    /// Mean error of the control effectiveness.
    pub mean_g: OverTrials,
    /// Share of the points at which f and g are within two of their standard deviations.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coverage: Option<[OverTrials; 2]>,
}

impl Statistics {
    /// Summarise the errors of trials.
    pub fn of(trials: &[TrialErrors]) -> Self {
        let over = |pick: fn(&TrialErrors) -> f64| {
            OverTrials::of(&trials.iter().map(pick).collect::<Vec<_>>())
        };
        Self {
            max_f: over(|e| e.max_f),
            max_g: over(|e| e.max_g),
            mean_f: over(|e| e.mean_f),
            mean_g: over(|e| e.mean_g),
            coverage: Self::coverage(trials),
        }
    }
}

impl Statistics {
    fn coverage(trials: &[TrialErrors]) -> Option<[OverTrials; 2]> {
        let found: Vec<[f64; 2]> = trials.iter().filter_map(|t| t.coverage).collect();
        let of = |k: usize| OverTrials::of(&found.iter().map(|c| c[k]).collect::<Vec<_>>());
        (!found.is_empty()).then(|| [of(0), of(1)])
    }
}

/// Errors of each trial by recipe. Trial `k` draws from stream `k` of the seed, so that the
/// first trials of a longer study are those of a shorter one, on any number of threads.
///
/// # Errors
/// [`StudyError`] when a trial fails.
pub fn trials(
    count: u64,
    seed: u64,
    quiet: bool,
) -> Result<BTreeMap<String, Vec<TrialErrors>>, StudyError> {
    let bar = progress::bar(count as usize, "trials", quiet);
    let one = |trial| {
        let data = trajectories(seed, trial, NOISE)?;
        let found =
            with_each(&Recipe::ALL, |recipe| Ok(Errors::of(&*recipe.duffing(&data)?)?.summary()));
        bar.inc(1);
        found
    };
    let found: Vec<BTreeMap<String, TrialErrors>> =
        (0..count).into_par_iter().map(one).collect::<Result<_, StudyError>>()?;
    bar.finish_and_clear();
    let mut by_recipe: BTreeMap<String, Vec<TrialErrors>> = BTreeMap::new();
    for (recipe, errors) in found.into_iter().flatten() {
        by_recipe.entry(recipe).or_default().push(errors);
    }
    Ok(by_recipe)
}

/// Carry out the study, write its results and print them.
///
/// # Errors
/// [`StudyError`] when a trial fails or results cannot be written.
pub fn run(count: u64, common: &Common) -> Result<(), StudyError> {
    let found = trials(count, common.seed, common.quiet)?;
    let recipes = found.iter().map(|(name, e)| (name.clone(), Statistics::of(e))).collect();
    let experiment = NAME.to_owned();
    let results = Results { experiment, trials: count, seed: common.seed, recipes };
    let file = output::write_json(&common.out, NAME, &results)?;
    output::write_figures(&common.out, &figures::duffing::montecarlo(&found)?)?;
    if !common.quiet {
        print(&results);
        println!("wrote {}", file.display());
    }
    Ok(())
}

fn print(results: &Results) {
    println!("{:<8} {:<12} {:>9} {:>9} {:>9}", "recipe", "error", "mean", "sd", "median");
    for (recipe, s) in &results.recipes {
        let rows = [
            ("max |f|", s.max_f),
            ("max |g|", s.max_g),
            ("mean |f|", s.mean_f),
            ("mean |g|", s.mean_g),
        ];
        for (name, o) in rows {
            println!("{recipe:<8} {name:<12} {:>9.4} {:>9.4} {:>9.4}", o.mean, o.sd, o.median);
        }
        if let Some([f, g]) = s.coverage {
            println!("{recipe:<8} within two sd: f {:.3}, g {:.3} of the points", f.mean, g.mean);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trials_do_not_depend_on_the_number_of_threads() {
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| trials(3, 7, true)).unwrap()
        };
        assert_eq!(run(1), run(2));
    }
}
