//! Machines that are driven by more than what was recorded, and states that nobody measures.

use crate::findings::classes;
use crate::machines::{Bench, Driven, ON_PENDULUM, ON_TWO_MASS, diagnosed};
use lacuna_discrepancy::diagnose::{Options, diagnose, split};
use lacuna_discrepancy::diagnosis::{ProofOutcome, Verdict};
use lacuna_discrepancy::likelihood::{
    FULL, Fit, Hypothesis, Problem, ProcessNoise, STILL, intensity,
};
use lacuna_discrepancy::{Dataset, Watch};
use lacuna_excitation::{SinusoidRanges, SumOfSinusoids, add_gaussian_noise, rng};
use lacuna_plants::{Model, System, integrate::rk4_sampled};
use lacuna_recordings::{Column, Recording};
use nalgebra::{DMatrix, DVector};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

static NEVER: AtomicBool = AtomicBool::new(false);

/// A mass on a spring: linear, so that a filter is exact.
const SPRING: &str = r#"
name = "spring"
[parameters]
m = { value = 0.5, unit = "kg" }
[[input]]
name = "u"
unit = "N"
[[coordinate]]
name = "x"
velocity = "v"
unit = "m"
[mechanics]
mass = [["m"]]
force = ["u - 0.4*v - 3*x"]
"#;

/// Recordings whose input differs from what the machine got by noise of a share of its spread.
pub fn with_noisy_input(
    mut recordings: Vec<Recording>,
    share: f64,
    seed: u64,
) -> (Vec<Recording>, f64) {
    let mut sd = 0.0;
    for (k, r) in recordings.iter_mut().enumerate() {
        let input = &mut r.columns[0].values;
        let n = input.len() as f64;
        let mean = input.iter().sum::<f64>() / n;
        let spread = (input.iter().map(|u| (u - mean).powi(2)).sum::<f64>() / n).sqrt();
        sd = share * spread;
        add_gaussian_noise(input, sd, &mut rng(seed, 1000 + k as u64)).expect("a deviation");
    }
    (recordings, sd)
}

/// The likelihood of the innovations is that of all samples together, whose covariance is found by
/// simulating what each sample of the input changes.
#[test]
fn innovations_have_the_likelihood_of_the_whole_recording() {
    const SIGMA: f64 = 0.4;
    // The output is noisier than its samples show.
    const WIDER: f64 = 1.3;
    let bench = Bench { text: SPRING, samples: 120, ..ON_PENDULUM };
    let model = bench.model();
    let dataset = Dataset::new(&model, &bench.record(&model, 900, 1)).expect("a dataset");
    let problem = Problem::new(&model, &dataset).expect("a problem");
    let free = Fit::begin(&problem, Hypothesis::of(&model), 0).expect("a fit");
    let (inputs, outputs) = (vec![SIGMA], vec![WIDER]);
    let noise = ProcessNoise { inputs, outputs, ..ProcessNoise::none(&problem) };
    let driven = free.driven_by(Some(Arc::new(noise)), STILL).expect("a fit");

    let observed = &dataset.recordings[0];
    let start = &free.windowed.starts[0].machine[0];
    let n = observed.len();
    let run = |commands: &[f64]| -> Vec<f64> {
        let system = System::new(&model);
        let times = &observed.times;
        let motion = rk4_sampled(&system, start, times, commands, model.hold, free.substeps.count);
        let motion = motion.expect("it does not diverge");
        (0..n).map(|k| motion.state(k)[0] * problem.weights[0]).collect()
    };
    let plain = run(&observed.commands);
    let residual =
        DVector::from_fn(n, |k, _| observed.outputs[0][k] * problem.weights[0] - plain[k]);
    let mut changes = DMatrix::zeros(n, n);
    for j in 0..n {
        let mut commands = observed.commands.clone();
        commands[j] += SIGMA;
        let moved = run(&commands);
        (0..n).for_each(|k| changes[(k, j)] = moved[k] - plain[k]);
    }
    let own = DMatrix::identity(n, n) * WIDER.powi(2);
    let covariance = own + &changes * changes.transpose();
    let factor = covariance.cholesky().expect("positive definite");
    let width: f64 = factor.l().diagonal().map(|d| 2.0 * d.ln()).sum();
    let chi2 = residual.dot(&factor.solve(&residual));
    assert!((driven.width() - width).abs() < 1e-6 * width, "{} {width}", driven.width());
    assert!((driven.chi2 - chi2).abs() < 1e-6 * chi2, "{} {chi2}", driven.chi2);
    assert!(width > 10.0, "the noise is felt: {width}");
}

/// Free runs would look for physics that says what the noise of an input does, for as long as there are candidates.
#[test]
fn noise_that_an_input_shows_is_asked_before_free_runs() {
    let model = ON_PENDULUM.model();
    let (recordings, _) = with_noisy_input(ON_PENDULUM.record(&model, 905, 3), 0.08, 905);
    let dataset = Dataset::new(&model, &recordings).expect("a dataset");
    let (training, held_out) = split(&dataset);
    let told = Mutex::new(vec![]);
    let tell = |doing: &str| told.lock().expect("nobody panics").push(doing.to_owned());
    let watch = Watch::new(&tell, &NEVER);
    let outcome = diagnose(&model, &training, &held_out, Options::default(), &watch);
    let d = outcome.expect("it is made").diagnosis;
    assert_eq!(d.verdict, Verdict::NoMismatch, "{:?}", d.findings);
    let told = told.into_inner().expect("nobody panics");
    let first = told.iter().find(|doing| doing.starts_with("looking for"));
    let driven = first.is_some_and(|doing| doing.contains("what drives the machine"));
    assert!(driven, "{told:?}");
}

#[test]
fn the_intensity_of_noise_on_an_input_is_found_and_none_where_there_is_none() {
    let model = ON_PENDULUM.model();
    for (seed, share) in [(910, 0.05), (911, 0.1), (912, 0.0)] {
        let (recordings, sd) = with_noisy_input(ON_PENDULUM.record(&model, seed, 3), share, seed);
        let dataset = Dataset::new(&model, &recordings).expect("a dataset");
        let problem = Problem::new(&model, &dataset).expect("a problem");
        // Along a filter of half the intensity: an estimate does not hang on where it begins.
        let begun = Fit::begin(&problem, Hypothesis::of(&model), 3).expect("a fit");
        let half = ProcessNoise { inputs: vec![0.5 * sd], ..ProcessNoise::none(&problem) };
        let half = (share > 0.0).then(|| Arc::new(half));
        let fit = begun.driven_by(half, FULL).and_then(|f| f.at_level(0, FULL)).expect("a fit");
        let (noise, gained) = intensity::most_likely(&fit, 2.0, None).expect("likelihoods");
        if share > 0.0 {
            let found = noise.inputs[0];
            assert!((found / sd - 1.0).abs() < 0.25, "seed {seed}: {found} for {sd}");
            assert!(noise.forces.iter().all(|f| *f == 0.0), "an input explains it: {noise:?}");
            assert!(gained > 10.0, "{gained}");
            // A force that was taken for it before gives way to it.
            let step = dataset.recordings[0].times[1] - dataset.recordings[0].times[0];
            let forces = vec![sd * step.sqrt(); problem.model.channels()];
            let before = ProcessNoise { forces, ..ProcessNoise::none(&problem) };
            let (again, _) = intensity::most_likely(&fit, 2.0, Some(&before)).expect("likelihoods");
            assert!((again.inputs[0] / found - 1.0).abs() < 0.05, "{again:?}, {noise:?}");
            assert!(again.forces.iter().all(|f| *f == 0.0), "a force stays: {again:?}");
        } else {
            assert!(gained < 10.0, "seed {seed}: {noise:?} gains {gained}");
        }
    }
}

/// Noise on the recorded input is no missing physics, and moves no parameter.
#[test]
fn noisy_inputs_alone_are_no_mismatch() {
    for (bench, seed) in [(ON_PENDULUM, 920), (ON_PENDULUM, 921), (ON_TWO_MASS, 922)] {
        let model = bench.model();
        let (recordings, sd) = with_noisy_input(bench.record(&model, seed, 4), 0.05, seed);
        let d = diagnosed(&model, &recordings).diagnosis;
        let found: Vec<_> = d.findings.iter().map(|f| &f.says).collect();
        let told = (found, &d.driving);
        assert_eq!(d.verdict, Verdict::NoMismatch, "{} seed {seed}: {told:?}", d.model);
        let noise = d.driving.inputs.values().next().expect("it is told");
        assert!((noise.std / sd - 1.0).abs() < 0.3, "{noise:?}, truth {sd}");
        assert!(
            d.notes.iter().any(|n| n.contains("not quite what the machine got")),
            "{:?}",
            d.notes
        );
    }
}

#[test]
fn an_effect_is_named_and_its_size_right_beside_noisy_inputs() {
    let effect = "[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"q\"\nmagnitude = 0.05\nsmoothing_velocity = 0.02";
    let (model, truth) = (ON_PENDULUM.model(), ON_PENDULUM.truth(effect));
    for seed in [930, 931] {
        let (recordings, _) = with_noisy_input(ON_PENDULUM.record(&truth, seed, 4), 0.06, seed);
        let d = diagnosed(&model, &recordings).diagnosis;
        let found: Vec<_> = d.findings.iter().map(|f| (&f.class, &f.channel)).collect();
        assert_eq!(d.findings.len(), 1, "seed {seed}: {found:?}");
        assert_eq!(d.findings[0].class, "coulomb_friction", "seed {seed}");
        let magnitude = &d.findings[0].parameters["magnitude"];
        let off = (magnitude.value - 0.05).abs();
        assert!(off < 4.0 * magnitude.std, "seed {seed}: {magnitude:?}");
        assert!(off < 0.005, "seed {seed}: {magnitude:?}");
        assert_eq!(d.proof, ProofOutcome::Better, "seed {seed}");
    }
}

/// A pendulum whose torque is another at every sample, so that no noise shows on it.
fn driven_at_random(truth: &Model, run: u64) -> Recording {
    let time: Vec<f64> = (0..1500).map(|k| 0.01 * f64::from(k)).collect();
    let mut torque = vec![0.0; time.len()];
    add_gaussian_noise(&mut torque, 1.0, &mut rng(936, run)).expect("a deviation");
    let system = System::new(truth);
    let start = system.at_rest(&[0.2, 0.0]);
    let motion = rk4_sampled(&system, &start, &time, &torque, truth.hold, 8).expect("a motion");
    let mut q: Vec<f64> = (0..time.len()).map(|k| motion.state(k)[0]).collect();
    add_gaussian_noise(&mut q, 1e-3, &mut rng(937, run)).expect("a deviation");
    let column = |name: &str, values| Column { name: name.to_owned(), values };
    let columns = vec![column("tau", torque), column("q", q)];
    Recording { name: format!("run{run}"), time, columns }
}

/// Free runs and filters name the same law; the numbers are those of filters, since what is left is noise on the input.
#[test]
fn numbers_beside_noisy_inputs_know_of_the_noise() {
    let effect = "[[effect]]\nclass = \"cubic_stiffness\"\nchannel = \"q\"\nstiffness = 0.25";
    let (model, truth) = (ON_PENDULUM.model(), ON_PENDULUM.truth(effect));
    let clean = (0..4).map(|run| driven_at_random(&truth, run)).collect();
    let (recordings, sd) = with_noisy_input(clean, 0.05, 938);
    let d = diagnosed(&model, &recordings).diagnosis;
    assert_eq!(classes(&d), ["cubic_stiffness"]);
    let noise = d.driving.inputs.get("tau").expect("noise on the input is told");
    assert!((noise.std / sd - 1.0).abs() < 0.1, "{noise:?}, {sd}");
    let stiffness = &d.findings[0].parameters["stiffness"];
    assert!((stiffness.value - 0.25).abs() < 3.0 * stiffness.std, "{stiffness:?}");
    assert!(stiffness.std < 0.005, "{stiffness:?}");
    for (name, parameter) in &d.calibration {
        let off = (parameter.value - parameter.nominal).abs();
        assert!(off < 3.5 * parameter.std, "{name}: {parameter:?}");
    }
}

/// What noise on an input leaves is noise, and none of what the formula leaves of the mismatch: a law that is small beside
/// it is handed back.
#[test]
fn a_law_that_is_small_beside_a_noisy_input_is_handed_back() {
    let effect = "[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"q\"\nmagnitude = 0.006\nsmoothing_velocity = 0.02";
    let (model, truth) = (ON_PENDULUM.model(), ON_PENDULUM.truth(effect));
    let (recordings, _) = with_noisy_input(ON_PENDULUM.record(&truth, 935, 4), 0.06, 935);
    let outcome = diagnosed(&model, &recordings);
    let d = &outcome.diagnosis;
    let found: Vec<_> = d.findings.iter().map(|f| &f.class[..]).collect();
    assert_eq!(found, ["coulomb_friction"]);
    let formula = d.formula.as_ref().expect("something is found");
    assert!(formula.left < 0.1, "{formula:?}");
    assert_eq!(outcome.augmentation.effects.len(), 1, "{:?}", d.notes);
}

fn without(column: &str, mut recordings: Vec<Recording>) -> Vec<Recording> {
    recordings.iter_mut().for_each(|r| r.columns.retain(|c| c.name != column));
    recordings
}

/// A pendulum with a wheel on its axis, whose speed alone is recorded: nothing depends on its angle.
const WHEEL: &str = r#"
name = "reaction_wheel"
[parameters]
J = { value = 0.05, unit = "kg m^2", tolerance = 0.1 }
g = { value = 1.5, unit = "N m", tolerance = 0.1 }
b = { value = 0.02, unit = "N m s/rad", tolerance = 0.2 }
W = { value = 0.004, unit = "kg m^2", tolerance = 0.1 }
[[input]]
name = "u"
unit = "N m"
[[coordinate]]
name = "q"
velocity = "v"
unit = "rad"
[[coordinate]]
name = "p"
velocity = "w"
unit = "rad"
[mechanics]
mass = [["J", "0"], ["0", "W"]]
force = ["-g*sin(q) - b*v - u", "u"]
"#;

#[test]
fn of_what_turns_its_speed_is_enough() {
    const RUBS: f64 = 0.03;
    const STEP: f64 = 0.01;
    let effect = format!(
        "{WHEEL}\n[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"p\"\n\
         magnitude = {RUBS}\nsmoothing_velocity = 0.3"
    );
    let truth = Model::from_text(&effect, "truth.toml").expect("the truth is right");
    let model = Model::from_text(WHEEL, "model.toml").expect("the model is right");
    let one = |run: u64| {
        let mut rng = rng(9, run);
        let time: Vec<f64> = (0..1000).map(|k| STEP * k as f64).collect();
        let ranges = SinusoidRanges {
            amplitude: 0.05..=0.2,
            angular_frequency: 1.0..=9.0,
            phase: 0.0..=std::f64::consts::TAU,
        };
        let drive = SumOfSinusoids::random(&mut rng, 1, 4, &ranges).expect("ranges");
        let u = drive.sample(&time);
        let driven = Driven { truth: &truth, time: &time, commands: &u, late: 0.0 };
        driven.recorded(run, &[0.1, 0.0, 0.0, 5.0], &[("q", 0, 1e-3), ("w", 3, 0.05)], &mut rng)
    };
    let d = diagnosed(&model, &(0..3).map(one).collect::<Vec<_>>()).diagnosis;
    assert_eq!(d.findings.len(), 1);
    let found = &d.findings[0];
    assert_eq!((&*found.class, &*found.channel), ("coulomb_friction", "p"));
    assert!((found.parameters["magnitude"].value / RUBS - 1.0).abs() < 0.02, "{}", found.says);
}

#[test]
fn an_effect_on_a_coordinate_that_nobody_measures_is_found() {
    let effect = "[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"x2\"\nmagnitude = 0.8\nsmoothing_velocity = 0.01";
    let (model, truth) = (ON_TWO_MASS.model(), ON_TWO_MASS.truth(effect));
    let d = diagnosed(&model, &without("x2", ON_TWO_MASS.record(&truth, 940, 4))).diagnosis;
    let found: Vec<_> = d.findings.iter().map(|f| (&f.class[..], &f.channel[..])).collect();
    assert_eq!(found, [("coulomb_friction", "x2")]);
    let magnitude = &d.findings[0].parameters["magnitude"];
    assert!((magnitude.value - 0.8).abs() < 0.04, "{magnitude:?}");
    let fit = &d.fit.held_out["x1"];
    assert!(fit.free_run_after < 1.1 * fit.noise, "{fit:?}");
    // Nothing is found where nothing is missing.
    let d = diagnosed(&model, &without("x2", ON_TWO_MASS.record(&model, 941, 4))).diagnosis;
    assert_eq!(d.verdict, Verdict::NoMismatch);
    assert_eq!(d.data.unmeasured, ["x2"]);
}

/// The first mass knows nothing of the second, which nothing holds: where that one is cannot be told.
pub fn two_apart() -> Model {
    let text = ON_TWO_MASS.text;
    let apart = text
        .replace("u - k*(x1 - x2) - d*(v1 - v2) - 15*x1", "u - d*v1 - 15*x1")
        .replace("k*(x1 - x2) + d*(v1 - v2)", "k*x1");
    assert_ne!(text, apart);
    Model::from_text(&apart, "apart.toml").expect("the model is right")
}
