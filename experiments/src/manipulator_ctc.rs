//! The two-link manipulator regulated by computed torque, with the true and with identified
//! models in the control law (the paper's figures 10 and 11).

use lacuna_control::{
    AccelerationModel, ClosedLoop, ComputedTorque, Gains, Origin, PlantAccelerations, Timing,
    VelocityRows, closed_loop,
};
use lacuna_plants::TwoLinkArm;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use crate::cli::Common;
use crate::identified::Evaluate;
use crate::manipulator_data::trajectories;
use crate::recipes::{Recipe, with_each};
use crate::{StudyError, figures, output};

/// Name of the study and of its results.
pub const NAME: &str = "manipulator-ctc";
/// Initial state: both angles (rad) and both velocities (rad/s).
pub(crate) const INITIAL: [f64; 4] = [0.3; 4];
/// Gains Kp = 20 I (1/s^2) and Kv = 30 I (1/s).
pub(crate) const GAINS: (f64, f64) = (20.0, 30.0);
/// Samples a second at which the loop is recorded; it is integrated with the same step.
pub(crate) const RATE: usize = 100;
/// Duration, seconds.
pub(crate) const SECONDS: usize = 10;

/// What the study found.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Results {
    /// [`NAME`].
    pub experiment: String,
    /// Number of data sets: one.
    pub trials: u64,
    /// Seed of all draws.
    pub seed: u64,
    /// True against identified model by recipe.
    pub recipes: BTreeMap<String, Comparison>,
}

/// Joint angles under the law with the true and with an identified model.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Comparison {
    /// With the true model.
    pub true_model: Angles,
    /// With the identified model.
    pub identified_model: Angles,
    /// Largest difference between the two in any angle at any time, rad.
    pub largest_difference: f64,
}

/// Both joint angles at two times, rad.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Angles {
    /// After 5 s.
    pub q_5s: [f64; 2],
    /// After 10 s.
    pub q_10s: [f64; 2],
}

impl Angles {
    /// The angles of a run.
    pub fn of(run: &ClosedLoop) -> Self {
        let angles = |second: usize| {
            let state = run.trajectory.state(second * RATE);
            [state[0], state[1]]
        };
        Self { q_5s: angles(5), q_10s: angles(10) }
    }
}

/// The regulator with the true model.
///
/// # Errors
/// [`StudyError::Control`] when the loop cannot be simulated.
pub fn regulate_true() -> Result<ClosedLoop, StudyError> {
    regulate(&PlantAccelerations::new(&TwoLinkArm::default())?)
}

/// The regulator with an identified first-order model of the arm.
///
/// # Errors
/// [`StudyError::Control`] when the loop cannot be simulated.
pub fn regulate_identified(model: &dyn Evaluate) -> Result<ClosedLoop, StudyError> {
    regulate(&accelerations(model))
}

/// An identified first-order model of the arm, for the control law.
pub(crate) fn accelerations(model: &dyn Evaluate) -> impl AccelerationModel {
    VelocityRows::new(2, 2, |x: &[f64], f: &mut [f64], g: &mut [f64]| {
        if model.evaluate(x, f, g).is_err() {
            // The control law reports a model that is not finite.
            f.fill(f64::NAN);
        }
    })
}

fn regulate(model: &dyn AccelerationModel) -> Result<ClosedLoop, StudyError> {
    let law = ComputedTorque::new(model, &Origin, Gains::uniform(2, GAINS.0, GAINS.1))?;
    let step = 1.0 / RATE as f64;
    let times: Vec<f64> = (0..=RATE * SECONDS).map(|k| step * k as f64).collect();
    let arm = TwoLinkArm::default();
    Ok(closed_loop(&arm, &law, &INITIAL, &times, step, Timing::Continuous)?)
}

/// The loop with the true model, and those with a model identified by each recipe.
///
/// # Errors
/// [`StudyError`] when simulation or identification fails.
pub fn runs(
    recipes: &[Recipe],
    seed: u64,
) -> Result<(ClosedLoop, BTreeMap<String, ClosedLoop>), StudyError> {
    let data = trajectories(seed, 0.0)?;
    let identified =
        with_each(recipes, |recipe| regulate_identified(&*recipe.manipulator(&data)?))?;
    Ok((regulate_true()?, identified))
}

/// Compare the loop with an identified model to that with the true one.
pub fn compare(truth: &ClosedLoop, identified: &ClosedLoop) -> Comparison {
    let states = truth.trajectory.states.chunks_exact(4);
    let others = identified.trajectory.states.chunks_exact(4);
    let difference = |(a, b): (&[f64], &[f64])| (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
    Comparison {
        true_model: Angles::of(truth),
        identified_model: Angles::of(identified),
        largest_difference: states.zip(others).map(difference).fold(0.0, f64::max),
    }
}

/// Carry out the study, write its results and print them.
///
/// # Errors
/// [`StudyError`] when identification or control fails or results cannot be written.
pub fn run(common: &Common) -> Result<(), StudyError> {
    let (truth, identified) = runs(&Recipe::ALL, common.seed)?;
    let recipes = identified.iter().map(|(name, r)| (name.clone(), compare(&truth, r))).collect();
    let results = Results { experiment: NAME.to_owned(), trials: 1, seed: common.seed, recipes };
    let file = output::write_json(&common.out, NAME, &results)?;
    output::write_figures(&common.out, &figures::regulator::all(&truth, &identified)?)?;
    if !common.quiet {
        print(&results);
        println!("wrote {}", file.display());
    }
    Ok(())
}

fn print(results: &Results) {
    println!(
        "{:<8} {:<11} {:>9} {:>9} {:>9} {:>9}  (rad)",
        "recipe", "model", "q1(5 s)", "q2(5 s)", "q1(10 s)", "q2(10 s)"
    );
    for (recipe, c) in &results.recipes {
        for (name, a) in [("true", c.true_model), ("identified", c.identified_model)] {
            let ([a5, b5], [a10, b10]) = (a.q_5s, a.q_10s);
            println!("{recipe:<8} {name:<11} {a5:>9.4} {b5:>9.4} {a10:>9.4} {b10:>9.4}");
        }
        println!("{recipe:<8} largest difference {:.4} rad", c.largest_difference);
    }
}
