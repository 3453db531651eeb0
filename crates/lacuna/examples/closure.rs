//! A model that is a closure, diagnosed end to end.
//!
//! A motor turns a hanging arm. It is believed to obey
//!
//! ```text
//! J theta'' = tau - b theta' - k sin theta
//! ```
//!
//! and the real one, made up here, has dry friction as well:
//!
//! ```text
//! J theta'' = tau - b theta' - k sin theta - F tanh(theta' / w)
//! ```
//!
//! | symbol | meaning | value |
//! | --- | --- | --- |
//! | theta, omega = theta' | angle and angular velocity (rad, rad/s); theta alone is measured | |
//! | tau | torque of the motor (N m) | drawn |
//! | J, b, k | inertia, viscous friction, moment of weight | 0.05 kg m^2, 0.03 N m s/rad, 0.4 N m |
//! | F, w | dry friction and the speed within which it turns; concealed | 0.06 N m, 0.2 rad/s |
//!
//! The steps: describe the model ([`believed`]), bring in recordings ([`recordings`]), diagnose
//! ([`diagnosed`]), and take up what was found in the model ([`main`]).
//! Run it with `cargo run --release -p lacuna --example closure`.

use lacuna::discrepancy::diagnose::{Options, Outcome, diagnose, split};
use lacuna::discrepancy::{Dataset, Watch};
use lacuna::excitation::{SinusoidRanges, SumOfSinusoids, add_gaussian_noise, rng};
use lacuna::plants::dynamics::Point;
use lacuna::plants::model::BuildError;
use lacuna::plants::{Model, SampledInput, System, rk4};
use lacuna::recordings::{Column, Recording};
use lacuna::report;
use std::error::Error;

/// F (N m): what the diagnosis should find.
pub const FRICTION: f64 = 0.06;
/// w (rad/s).
const SMOOTHING: f64 = 0.2;
/// Recordings, samples in each, and their step (s).
const RECORDINGS: u64 = 3;
const SAMPLES: usize = 1000;
const STEP: f64 = 0.01;
/// Noise of the encoder (rad).
const NOISE: f64 = 1e-3;

/// What both machines have in common: tau - b omega - k sin theta.
fn torque(at: &Point<'_>) -> f64 {
    let (theta, omega, tau) = (at.coordinates[0], at.velocities[0], at.inputs[0]);
    let (b, k) = (at.parameters[1], at.parameters[2]);
    tau - b * omega - k * theta.sin()
}

/// The machine with this sum of torques. J is believed to 10 % (one standard deviation), and so
/// are b and k: a diagnosis calibrates them before it calls anything missing.
fn machine(
    name: &str,
    torque: impl Fn(&Point<'_>) -> f64 + Send + Sync + 'static,
) -> Result<Model, BuildError> {
    Model::builder(name)
        .parameter("J", 0.05, "kg m^2", 0.1)
        .parameter("b", 0.03, "N m s/rad", 0.1)
        .parameter("k", 0.4, "N m", 0.1)
        .input("tau", "N m")
        .coordinate("theta", "omega", "rad")
        .mechanics(|at| [at.parameters[0]], move |at| [torque(at)])
        .build()
}

/// The model.
///
/// # Errors
/// None: its names are names, and its closures give as many numbers as it has channels.
pub fn believed() -> Result<Model, BuildError> {
    machine("arm", torque)
}

/// What the encoder and the driver's log would hold of the real machine.
///
/// # Errors
/// None that this machine makes.
pub fn recordings() -> Result<Vec<Recording>, Box<dyn Error>> {
    let omega = |at: &Point<'_>| at.velocities[0];
    let truth = machine("truth", move |at| torque(at) - FRICTION * (omega(at) / SMOOTHING).tanh())?;
    let system = System::new(&truth);
    let time: Vec<f64> = (0..SAMPLES).map(|k| STEP * k as f64).collect();
    let ranges = SinusoidRanges {
        amplitude: 0.1..=0.3,
        angular_frequency: 0.5..=6.0,
        phase: 0.0..=std::f64::consts::TAU,
    };
    let record = |run: u64| {
        let mut rng = rng(212, run);
        let tau = SumOfSinusoids::random(&mut rng, 1, 4, &ranges)?.sample(&time);
        let input = SampledInput { times: &time, values: &tau, hold: truth.hold };
        let motion = rk4(&system, &[0.2, 0.0], &input, &time, STEP / 8.0)?;
        let mut theta: Vec<f64> = (0..SAMPLES).map(|k| motion.state(k)[0]).collect();
        add_gaussian_noise(&mut theta, NOISE, &mut rng)?;
        let column = |name: &str, values| Column { name: name.to_owned(), values };
        let columns = vec![column("tau", tau), column("theta", theta)];
        Ok(Recording { name: format!("run{run}"), time: time.clone(), columns })
    };
    (0..RECORDINGS).map(record).collect()
}

/// Diagnose a model on recordings, some of them (or of the only one) kept for proof.
///
/// # Errors
/// Recordings that do not fit the model.
pub fn diagnosed(model: &Model, recordings: &[Recording]) -> Result<Outcome, Box<dyn Error>> {
    let (training, held_out) = split(&Dataset::new(model, recordings)?);
    Ok(diagnose(model, &training, &held_out, Options::default(), &Watch::default())?)
}

/// Find what the closure leaves out, and run the closure with it.
///
/// # Errors
/// Those of the steps.
pub fn main() -> Result<(), Box<dyn Error>> {
    let model = believed()?;
    let outcome = diagnosed(&model, &recordings()?)?;
    println!("{}", report::summary(&outcome.diagnosis, false));
    println!("Concealed: dry friction of {FRICTION} N m on theta.\n");

    // The closure stays as it is: the findings are text beside it, and are read onto it.
    let text = model.augmented_text(&outcome.augmentation)?;
    println!("{text}");
    let augmented = model.with_text(&text, "augmented.toml")?;
    let mut rates = [0.0; 2];
    lacuna::plants::Plant::derivative(
        &System::new(&augmented),
        0.0,
        &[0.0, 1.0],
        &[0.0],
        &mut rates,
    );
    println!("From theta = 0 and omega = 1 rad/s it now slows down at {:.3} rad/s^2.", -rates[1]);
    Ok(())
}
