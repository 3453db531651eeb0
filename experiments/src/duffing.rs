//! One Duffing trial (the paper's figures 1 to 4).

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use crate::cli::Common;
use crate::duffing_data::{Errors, NOISE, TrialErrors, trajectories, values};
use crate::recipes::{Recipe, with_each};
use crate::{StudyError, figures, output};

/// Name of the study and of its results.
pub const NAME: &str = "duffing";

/// What the study found.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Results {
    /// [`NAME`].
    pub experiment: String,
    /// Number of trials: one, number 0.
    pub trials: u64,
    /// Seed of all draws.
    pub seed: u64,
    /// Errors by recipe.
    pub recipes: BTreeMap<String, TrialErrors>,
}

/// Carry out the study, write its results and print them.
///
/// # Errors
/// [`StudyError`] when identification fails or results cannot be written.
pub fn run(common: &Common) -> Result<(), StudyError> {
    let data = trajectories(common.seed, 0, NOISE)?;
    let (mut curves, mut errors) = (BTreeMap::new(), BTreeMap::new());
    let recipes = with_each(&Recipe::ALL, |recipe| {
        let model = recipe.duffing(&data)?;
        let found = Errors::of(&*model)?;
        let summary = found.summary();
        errors.insert(recipe.name(), found);
        curves.insert(recipe.name(), figures::duffing::curve(|x| values(&*model, x))?);
        Ok(summary)
    })?;
    let results = Results { experiment: NAME.to_owned(), trials: 1, seed: common.seed, recipes };
    let file = output::write_json(&common.out, NAME, &results)?;
    output::write_figures(&common.out, &figures::duffing::trial(&curves, &errors)?)?;
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
