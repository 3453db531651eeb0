//! Relative errors of the identified two-link manipulator (the paper's figures 7 to 9).

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use crate::cli::Common;
use crate::manipulator_data::{Errors, Summary, trajectories};
use crate::recipes::{Recipe, with_each};
use crate::{StudyError, figures, output};

/// Name of the study and of its results.
pub const NAME: &str = "manipulator";
/// Name of its results on noisy states.
pub const NOISY: &str = "manipulator-noise";

/// What the study found.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Results {
    /// [`NAME`].
    pub experiment: String,
    /// Number of data sets: one.
    pub trials: u64,
    /// Seed of all draws.
    pub seed: u64,
    /// Standard deviation of the noise on all states, rad and rad/s.
    pub noise: f64,
    /// Errors by recipe.
    pub recipes: BTreeMap<String, Summary>,
}

/// Relative errors at each evaluation point by recipe.
///
/// # Errors
/// [`StudyError`] when simulation or identification fails.
pub fn errors(
    recipes: &[Recipe],
    seed: u64,
    noise: f64,
) -> Result<BTreeMap<String, Errors>, StudyError> {
    let data = trajectories(seed, noise)?;
    with_each(recipes, |recipe| Errors::of(&*recipe.manipulator(&data)?))
}

/// Carry out the study, write its results and print them.
///
/// # Errors
/// [`StudyError`] when identification fails or results cannot be written.
pub fn run(noise: f64, common: &Common) -> Result<(), StudyError> {
    let errors = errors(&Recipe::ALL, common.seed, noise)?;
    let recipes = errors.iter().map(|(name, e)| (name.clone(), e.summary())).collect();
    let noisy = noise > 0.0;
    let name = if noisy { NOISY } else { NAME };
    let experiment = NAME.to_owned();
    let results = Results { experiment, trials: 1, seed: common.seed, noise, recipes };
    let file = output::write_json(&common.out, name, &results)?;
    let drawings = match noisy {
        true => vec![("manipulator_noise_errors", figures::manipulator::noisy_errors(&errors)?)],
        false => figures::manipulator::errors(&errors)?.to_vec(),
    };
    output::write_figures(&common.out, &drawings)?;
    if !common.quiet {
        print(&results);
        println!("wrote {}", file.display());
    }
    Ok(())
}

fn print(results: &Results) {
    println!("{:<8} {:<15} {:>9} {:>9} {:>9}", "recipe", "relative error", "max", "median", "mean");
    for (recipe, s) in &results.recipes {
        for (name, o) in [("f", s.f), ("g1", s.g1), ("g2", s.g2)] {
            println!("{recipe:<8} {name:<15} {:>9.4} {:>9.4} {:>9.4}", o.max, o.median, o.mean);
        }
    }
}
