//! The regulated manipulator at 10 kHz: how long the control law takes with identified models, evaluated directly or
//! compiled.

use clap::ValueEnum;
use lacuna_control::{ClosedLoop, ComputedTorque, Gains, Origin, Timing, closed_loop};
use lacuna_occupation::IdentifiedModel;
use lacuna_occupation::compile::{Compiled, Domain, compile};
use lacuna_plants::TwoLinkArm;
use std::time::{Duration, Instant};

use crate::StudyError;
use crate::cli::Common;
use crate::identified::Evaluate;
use crate::manipulator_ctc::{GAINS, INITIAL, SECONDS, accelerations};
use crate::manipulator_data::trajectories;
use crate::recipes::Recipe;

/// Control periods a second.
const RATE: usize = 10_000;
/// Half the side of the box on which models are compiled, rad and rad/s.
const HALF_SIDE: f64 = 2.0;
/// Relative error to which they are compiled.
const TOLERANCE: f64 = 1e-6;

/// How the identified model is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Evaluator {
    /// The sum over samples or landmarks.
    Direct,
    /// Compiled on a box.
    Compiled,
}

/// Durations of the control law, microseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Latency {
    /// How many were measured.
    pub evaluations: usize,
    /// Median.
    pub p50: f64,
    /// 99 of 100 are shorter.
    pub p99: f64,
    /// 999 of 1000 are shorter.
    pub p999: f64,
    /// The longest.
    pub largest: f64,
}

impl Latency {
    /// Of some durations; all zero without any.
    pub fn of(mut durations: Vec<f64>) -> Self {
        durations.sort_by(f64::total_cmp);
        let at = |part: f64| {
            let rank = (part * durations.len() as f64) as usize;
            durations.get(rank.min(durations.len().saturating_sub(1))).copied().unwrap_or(0.0)
        };
        let [p50, p99, p999, largest] = [0.5, 0.99, 0.999, 1.0].map(at);
        Self { evaluations: durations.len(), p50, p99, p999, largest }
    }
}

/// Regulate the arm with an identified model in a law that is sampled at 10 kHz, and time the law at every state that
/// the loop visits.
///
/// # Errors
/// [`StudyError::Control`] when the loop cannot be simulated, also because it leaves the box of a compiled model.
pub fn regulate(model: &dyn Evaluate) -> Result<(ClosedLoop, Latency), StudyError> {
    let model = accelerations(model);
    let law = ComputedTorque::new(&model, &Origin, Gains::uniform(2, GAINS.0, GAINS.1))?;
    let period = 1.0 / RATE as f64;
    let times: Vec<f64> = (0..=RATE * SECONDS).map(|k| period * k as f64).collect();
    let held = Timing::Held { period };
    let run = closed_loop(&TwoLinkArm::default(), &law, &INITIAL, &times, period, held)?;
    let mut u = [0.0; 2];
    let latency = paced(times.len(), |k| law.input(times[k], run.trajectory.state(k), &mut u))?;
    Ok((run, latency))
}

/// Times something once in every control period, as a loop on a machine of its own would: waiting without sleeping.
fn paced<E>(count: usize, mut work: impl FnMut(usize) -> Result<(), E>) -> Result<Latency, E> {
    let period = Duration::from_secs(1) / RATE as u32;
    let mut durations = Vec::with_capacity(count);
    let begin = Instant::now();
    for k in 0..count {
        while begin.elapsed() < period * k as u32 {
            std::hint::spin_loop();
        }
        let start = Instant::now();
        work(k)?;
        durations.push(1e6 * start.elapsed().as_secs_f64());
    }
    Ok(Latency::of(durations))
}

/// The same of a plain sum over so many numbers: what the machine alone makes of reading them once a period.
fn reading(count: usize, numbers: usize) -> Latency {
    let table: Vec<f64> = (0..numbers).map(|k| k as f64).collect();
    let work = |_| {
        // Eight sums side by side, so that memory is what takes time.
        let mut sums = [0.0; 8];
        for eight in std::hint::black_box(&table).as_chunks::<8>().0 {
            sums.iter_mut().zip(eight).for_each(|(sum, value)| *sum += value);
        }
        std::hint::black_box(sums);
        Ok::<(), std::convert::Infallible>(())
    };
    match paced(count, work) {
        Ok(latency) => latency,
        Err(never) => match never {},
    }
}

/// Identify the arm by the recipes of occupation kernels, close the loops and print what came of it.
///
/// # Errors
/// [`StudyError`] when identification, compilation or control fails.
pub fn run(evaluator: Evaluator, common: &Common) -> Result<(), StudyError> {
    let say = |line: String| {
        if !common.quiet {
            println!("{line}");
        }
    };
    let data = trajectories(common.seed, 0.0)?;
    say(format!(
        "{:<8} {:<9} {:>9} {:>9} {:>11} {:>7} {:>7} {:>7} {:>8}  of the law, us",
        "recipe",
        "evaluator",
        "q1(10 s)",
        "q2(10 s)",
        "evaluations",
        "p50",
        "p99",
        "p99.9",
        "largest"
    ));
    for recipe in Recipe::ALL {
        let Some(model) = recipe.occupation_kernels(&data)? else { continue };
        let ((run, l), numbers) = match evaluator {
            Evaluator::Direct => {
                let columns = model.arguments() + model.inputs() + 1;
                (regulate(&model)?, model.points() * columns)
            }
            Evaluator::Compiled => {
                let compiled = compiled(&model)?;
                (regulate(&compiled)?, compiled.evaluator().numbers())
            }
        };
        let end = run.trajectory.state(RATE * SECONDS);
        let name = match evaluator {
            Evaluator::Direct => "direct",
            Evaluator::Compiled => "compiled",
        };
        say(format!(
            "{:<8} {name:<9} {:>9.5} {:>9.5} {:>11} {:>7.2} {:>7.2} {:>7.2} {:>8.1}",
            recipe.name(),
            end[0],
            end[1],
            l.evaluations,
            l.p50,
            l.p99,
            l.p999,
            l.largest
        ));
        let l = reading(l.evaluations, numbers);
        say(format!(
            "{:<40} {:>11} {:>7.2} {:>7.2} {:>7.2} {:>8.1}",
            "  a sum over as many numbers", l.evaluations, l.p50, l.p99, l.p999, l.largest
        ));
    }
    Ok(())
}

fn compiled(model: &IdentifiedModel) -> Result<Compiled, StudyError> {
    let sides = vec![HALF_SIDE; model.arguments()];
    let domain = Domain::new(sides.iter().map(|s| -s).collect(), sides)?;
    Ok(compile(model, &domain, TOLERANCE)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manipulator_ctc;

    #[test]
    fn percentiles_are_those_of_sorted_durations() {
        let latency = Latency::of((0..2000).rev().map(f64::from).collect());
        let expected =
            Latency { evaluations: 2000, p50: 1000.0, p99: 1980.0, p999: 1998.0, largest: 1999.0 };
        assert_eq!(latency, expected);
        assert_eq!(Latency::of(vec![]).largest, 0.0);
    }

    /// On the compiled model the loop goes where it goes on the model itself.
    #[test]
    fn the_compiled_model_closes_the_same_loop() {
        let data = trajectories(1, 0.0).unwrap();
        let model = Recipe::Paper.occupation_kernels(&data[..150]).unwrap().unwrap();
        let direct = manipulator_ctc::regulate_identified(&model).unwrap();
        let compiled = manipulator_ctc::regulate_identified(&compiled(&model).unwrap()).unwrap();
        let pairs = direct.trajectory.states.iter().zip(&compiled.trajectory.states);
        let largest = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(0.0 < largest && largest < 1e-4, "{largest}");
    }
}
