//! How fast the parts are, beside the same algorithms in NumPy, in one run.
//!
//! Times are the least of a few repetitions. They are printed, not written: results/ holds what can be reproduced.

mod peer;
mod rows;

use lacuna_occupation::compile::{Domain, compile};
use rayon::prelude::*;
use std::time::Instant;

use crate::duffing_data::{NOISE, trajectories as duffing};
use crate::manipulator_data::trajectories as arm;
use crate::recipes::{Recipe, paper};
use crate::{StudyError, manipulator_large};
use lacuna_occupation::{Gaussian, IdentifiedModel, Limits, Regression, TrajectoryData};
use peer::Peer;
use rows::{Row, print};

/// Name of the study.
pub const NAME: &str = "speed";
/// The paper's regularisation and kernel.
const LAMBDA: f64 = 1e-3;
const MU: f64 = 5.0;
/// Half width of the box on which a model is compiled.
const BOX: f64 = 2.0;
/// States at which models are evaluated.
const STATES: usize = 2000;

/// What to measure.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Trials of the Duffing study.
    pub trials: u64,
    /// Numbers of trajectories of streamed fits.
    pub trajectories: Vec<usize>,
    /// The script in NumPy.
    pub peer: std::path::PathBuf,
    /// Seed of all draws.
    pub seed: u64,
}

/// Measures and prints the table.
///
/// # Errors
/// [`StudyError`] when a simulation or a fit fails, or no pool of threads can be had.
pub fn run(settings: &Settings) -> Result<(), StudyError> {
    let data = arm(settings.seed, 0.0)?;
    let one_trial = duffing(settings.seed, 0, NOISE)?;
    let states = states();
    println!("measuring the peer ...");
    let peer = Peer::measure(&settings.peer, &data, &one_trial, &states);
    if let Err(reason) = &peer {
        println!("no peer: {reason}");
    }
    let peer = peer.ok();
    let seconds = |pick: fn(&Peer) -> f64| peer.as_ref().map(pick);
    let mut rows = Vec::new();
    let regression = paper(1, LAMBDA);
    rows.extend(kernel_sums(&data, &states, seconds(|p| p.kernel_sums))?);
    let fit = |threads| timed_in(threads, 5, || Ok(regression.fit(&data).map(drop)?));
    rows.push(Row::seconds("fit, 1000 x 21 samples, 1 thread", fit(1)?, seconds(|p| p.fit)));
    rows.push(Row::seconds("the same, all threads", fit(0)?, seconds(|p| p.fit)));
    rows.extend(evaluation(&regression.fit(&data)?, &states, seconds(|p| p.evaluation))?);
    rows.extend(duffing_study(settings, seconds(|p| p.duffing))?);
    for &count in &settings.trajectories {
        let limits = Limits::default();
        let start = Instant::now();
        let (fitted, _) = manipulator_large::fit(count, settings.seed, limits)?;
        let what = format!("streamed fit with simulation, {count} x 51 samples ({})", fitted.way);
        rows.push(Row::seconds(&what, start.elapsed().as_secs_f64(), None));
    }
    print(&rows);
    Ok(())
}

/// States within the box, without a period.
fn states() -> Vec<[f64; 4]> {
    const STEPS: [f64; 4] =
        [0.856_674_883_854_502_9, 0.733_891_856_627_126, 0.628_706_721_155_39, 0.538_596_951_7];
    let state = |k: usize| STEPS.map(|step| BOX * (2.0 * (k as f64 * step).fract() - 1.0));
    (0..STATES).map(state).collect()
}

/// Sums of Gaussian kernels over the samples of the arm, at many states.
fn kernel_sums(
    data: &[TrajectoryData],
    states: &[[f64; 4]],
    peer: Option<f64>,
) -> Result<[Row; 2], StudyError> {
    let alone = |data: &TrajectoryData| {
        let coordinate = data.coordinates().iter().step_by(4).copied().collect();
        TrajectoryData::new(data.times().to_vec(), data.arguments().to_vec(), vec![], coordinate)
    };
    let data: Vec<TrajectoryData> = data.iter().map(alone).collect::<Result<_, _>>()?;
    let gaussian = Gaussian { widths: vec![1.0] }.into();
    let model = Regression { kernel: gaussian, ..paper(1, LAMBDA) }.fit(&data)?;
    let count = (states.len() * model.points()) as f64;
    let sums = |threads| timed_in(threads, 5, || evaluate_all(&model, states));
    let what = "Gaussian kernel sums, 4 arguments";
    Ok([
        Row::rate(&format!("{what}, 1 thread"), sums(1)? / count, peer),
        Row::rate("the same, all threads", sums(0)? / count, peer),
    ])
}

fn evaluate_all(model: &IdentifiedModel, states: &[[f64; 4]]) -> Result<(), StudyError> {
    let (n, m) = (model.dimension(), model.inputs());
    states.par_chunks(50).try_for_each(|states| {
        let (mut f, mut g) = (vec![0.0; n], vec![0.0; n * m]);
        states.iter().try_for_each(|x| {
            model.evaluate(x, &mut f, &mut g)?;
            std::hint::black_box((&f, &g));
            Ok(())
        })
    })
}

/// f and g at one state: all samples, and compiled.
fn evaluation(
    model: &IdentifiedModel,
    states: &[[f64; 4]],
    peer: Option<f64>,
) -> Result<Vec<Row>, StudyError> {
    let count = states.len() as f64;
    let direct = timed_in(1, 5, || evaluate_all(model, states))? / count;
    let mut rows = vec![Row::seconds("f and g at one state, 21 000 samples", direct, peer)];
    let domain = Domain::new(vec![-BOX; 4], vec![BOX; 4])?;
    for tolerance in [1e-6, 1e-3] {
        let compiled = compile(model, &domain, tolerance)?;
        let evaluator = compiled.evaluator();
        let (mut f, mut g) = ([0.0; 4], [0.0; 8]);
        let seconds = timed_in(1, 20, || {
            for x in states {
                let _ = std::hint::black_box(evaluator.evaluate(x, &mut f, &mut g));
            }
            Ok(())
        })?;
        let what = format!("compiled, relative error {:.1e}", compiled.relative_error());
        rows.push(Row::seconds(&what, seconds / count, peer));
    }
    Ok(rows)
}

/// A trial of the Duffing study: its simulation and both recipes, on one thread.
fn duffing_study(settings: &Settings, peer: Option<f64>) -> Result<Vec<Row>, StudyError> {
    let trials = settings.trials;
    let data: Vec<Vec<TrajectoryData>> =
        (0..trials).map(|k| duffing(settings.seed, k, NOISE)).collect::<Result<_, _>>()?;
    let of = |recipe: Recipe| {
        timed_in(1, 1, || {
            data.iter().try_for_each(|data| {
                recipe.duffing(data).map(drop)?;
                Ok(())
            })
        })
    };
    let simulation = timed_in(1, 1, || {
        (0..trials).try_for_each(|k| duffing(settings.seed, k, NOISE).map(drop))
    })?;
    let per_trial = |seconds: f64| seconds / trials as f64;
    Ok(vec![
        Row::seconds("Duffing trial, 169 x 51: simulation", per_trial(simulation), None),
        Row::seconds("the same: recipe paper", per_trial(of(Recipe::Paper)?), peer),
        Row::seconds("the same: recipe lacuna", per_trial(of(Recipe::Lacuna)?), peer),
    ])
}

/// Least wall time of a few repetitions, in a pool of so many threads (0: all).
fn timed_in(
    threads: usize,
    repetitions: usize,
    work: impl FnMut() -> Result<(), StudyError> + Send,
) -> Result<f64, StudyError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    pool.install(move || {
        let mut work = work;
        let mut least = f64::INFINITY;
        for _ in 0..repetitions {
            let start = Instant::now();
            work()?;
            least = least.min(start.elapsed().as_secs_f64());
        }
        Ok(least)
    })
}
