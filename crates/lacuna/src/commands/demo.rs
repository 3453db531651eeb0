//! `lacuna demo`: conceal an effect in made-up recordings, diagnose them, and unseal it.

use super::Outcome;
use super::typed::typed;
use crate::interrupt::Cancellable;
use crate::output::{colour, spinner};
use crate::say::{say, sayln};
use clap::Args;
use lacuna::diagnosed::{Diagnosed, datasets, recordings};
use lacuna::discrepancy::Watch;
use lacuna::discrepancy::diagnose as ladder;
use lacuna::effects;
use lacuna::excitation::{SinusoidRanges, SumOfSinusoids, add_gaussian_noise, rng};
use lacuna::files::uninterrupted;
use lacuna::files::write_whole;
use lacuna::plants::model::{ModelEffect, NewEffect};
use lacuna::plants::{Model, SampledInput, System, rk4};
use lacuna::recordings::{Column, Recording, RecordingSource, write_csv_with_time};
use lacuna::report;
use rand::RngExt;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// Which effect is concealed and how the machine moves; another seed, another case
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder for the model, the recordings and the results
    #[arg(long, default_value = "lacuna-demo")]
    out: PathBuf,
}

/// The model that the diagnosis is given: a motor that lifts an arm.
const MODEL: &str = include_str!("../../../../examples/arm/model.toml");
/// Recordings, samples in each, and their step (s).
const RECORDINGS: u64 = 4;
const SAMPLES: usize = 2000;
const STEP: f64 = 0.005;
/// Noise of the angle sensor (rad).
const NOISE: f64 = 0.002;

/// What may be concealed: class and parameters drawn between two limits.
const CONCEALED: [(&str, &[[f64; 2]]); 6] = [
    ("coulomb_friction", &[[0.15, 0.35], [0.02, 0.02]]),
    ("asymmetric_friction", &[[0.25, 0.4], [0.1, 0.15], [0.02, 0.02]]),
    ("quadratic_drag", &[[0.05, 0.12]]),
    ("constant_force", &[[0.1, 0.3]]),
    ("cubic_stiffness", &[[0.1, 0.25]]),
    ("end_stop", &[[8.0, 15.0], [0.8, 1.0], [1.0, 1.0]]),
];

/// The sealed truth.
struct Truth {
    effect: NewEffect,
    model: Model,
    calibrated: (String, f64, f64),
}

pub fn run(a: &Arguments) -> Outcome {
    let model_file = a.out.join("model.toml");
    write_whole(&model_file, MODEL)?;
    let truth = conceal(a.seed)?;
    sayln!("An effect is concealed in made-up recordings of '{}'.", truth.model.name)?;
    let sources = record(&truth.model, a.seed, &a.out)?;
    sayln!("The diagnosis sees {} and {} recordings:\n", model_file.display(), sources.len())?;

    let model = Model::read(&model_file)?;
    let (training, held_out) = datasets(&model, &recordings(&model, &sources)?, &[])?;
    let bar = spinner(false);
    let progress = |doing: &str| bar.set_message(doing.to_owned());
    let running = Cancellable::begin();
    let watch = Watch::new(&progress, running.token());
    let options = ladder::Options::default();
    let outcome = ladder::diagnose(&model, &training, &held_out, options, &watch);
    bar.finish_and_clear();
    if let Some(cancelled) = running.end() {
        return Ok(cancelled);
    }
    let found = Diagnosed::new(model, &training, outcome?);
    found.write(&a.out, &typed())?;
    say!("{}", report::summary(found.diagnosis(), colour()))?;

    sayln!("\nUnsealed: {}", sealed_in_words(&truth))?;
    let first = found.diagnosis().findings.first();
    let right = first
        .is_some_and(|f| f.class == truth.effect.effect.class && f.channel == truth.effect.channel);
    sayln!("{}", if right { "The finding is right." } else { "The finding is wrong." })?;
    sayln!("Written: {}", a.out.join("report.html").display())?;
    Ok(ExitCode::from(u8::from(!right)))
}

/// Draw an effect and a wrong parameter.
fn conceal(seed: u64) -> Result<Truth, Box<dyn Error>> {
    let mut rng = rng(seed, 0);
    let (class, limits) = CONCEALED[rng.random_range(0..CONCEALED.len())];
    let effect = effects::find(class).ok_or_else(|| format!("'{class}' is in no catalogue"))?;
    let mut model = Model::from_text(MODEL, "model.toml")?;
    let values: Vec<f64> =
        limits.iter().map(|[a, b]| a + (b - a) * rng.random_range(0.0..1.0)).collect();
    let std = vec![None; values.len()];
    let concealed = ModelEffect { effect, channel: 0, other: None, parameters: values, std };
    let effect = NewEffect::of(&model, &concealed);
    model.effects.push(concealed);
    let which = rng.random_range(0..model.parameters.len());
    let p = &mut model.parameters[which];
    let nominal = p.value;
    p.value *= rng.random_range(0.94..1.06);
    let calibrated = (p.name.clone(), nominal, p.value);
    Ok(Truth { effect, model, calibrated })
}

/// Simulate the true machine and write what its sensors see.
fn record(truth: &Model, seed: u64, out: &Path) -> Result<Vec<RecordingSource>, Box<dyn Error>> {
    let folder = out.join("recordings");
    std::fs::create_dir_all(&folder)?;
    let system = System::new(truth);
    let times: Vec<f64> = (0..SAMPLES).map(|k| STEP * k as f64).collect();
    let ranges = SinusoidRanges {
        amplitude: 0.3..=0.9,
        angular_frequency: 0.5..=6.0,
        phase: 0.0..=std::f64::consts::TAU,
    };
    (0..RECORDINGS)
        .map(|k| {
            let mut rng = rng(seed, 1 + k);
            let torque = SumOfSinusoids::random(&mut rng, 1, 4, &ranges)?.sample(&times);
            let input = SampledInput { times: &times, values: &torque, hold: truth.hold };
            let start = [rng.random_range(-0.3..0.3), 0.0];
            let motion = rk4(&system, &system.at_rest(&start), &input, &times, STEP / 4.0)?;
            let mut angle: Vec<f64> = (0..SAMPLES).map(|s| motion.state(s)[0]).collect();
            add_gaussian_noise(&mut angle, NOISE, &mut rng)?;
            let path = folder.join(format!("run{:02}.csv", k + 1));
            let columns = vec![
                Column { name: truth.coordinates[0].name.clone(), values: angle },
                Column { name: truth.inputs[0].name.clone(), values: torque },
            ];
            let recording = Recording { name: String::new(), time: times.clone(), columns };
            let _writing = uninterrupted();
            write_csv_with_time(&path, &recording, &truth.time_column)?;
            Ok(RecordingSource::file(path))
        })
        .collect()
}

fn sealed_in_words(truth: &Truth) -> String {
    let e = &truth.effect;
    let numbers: Vec<String> = e
        .effect
        .parameters
        .iter()
        .zip(&e.parameters)
        .filter(|(p, _)| p.kind == effects::Kind::Number)
        .map(|(p, (value, _, unit))| format!("{} = {value:.4} {unit}", p.name))
        .collect();
    let (name, nominal, value) = &truth.calibrated;
    format!(
        "{} on {} ({}), and {name} is {value:.4} where the model says {nominal}.",
        e.effect.class,
        e.channel,
        numbers.join(", ")
    )
}
