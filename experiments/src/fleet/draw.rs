//! A machine of a drawn fleet: an arm whose parameters and dry friction are those of its make, more or less, and
//! perhaps something that no other has.

use lacuna_excitation::{SinusoidRanges, SumOfSinusoids, add_gaussian_noise, rng};
use lacuna_plants::integrate::rk4_sampled;
use lacuna_plants::{Model, System};
use lacuna_recordings::{Column, Recording};
use serde::{Deserialize, Serialize};

use crate::StudyError;
use crate::concealed::ConcealedError;

/// Recordings of a machine, the last for proof.
pub const RECORDINGS: usize = 3;
const ROWS: usize = 400;
const STEP: f64 = 0.01;
/// Runge-Kutta steps from sample to sample.
const SUBSTEPS: usize = 8;
/// Noise of the measured angle (rad).
const NOISE: f64 = 1e-3;
/// Parameters of the make: inertia, damping, weight times its arm; dry friction.
const MAKE: [f64; 4] = [0.05, 0.03, 0.4, 0.06];
/// Relative standard deviations of machines about them.
const SPREAD: [f64; 4] = [0.03, 0.03, 0.03, 0.08];

/// How a machine is unlike the others.
#[derive(Clone, Copy, Debug, Deserialize, Eq, Ord, PartialEq, PartialOrd, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Difference {
    /// It does not rub.
    NoFriction,
    /// It rubs 1.6 times as much.
    MoreFriction,
    /// A cubic spring acts on it.
    Spring,
    /// Its inertia is 1.25 times as large.
    Inertia,
}

impl Difference {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::NoFriction, Self::MoreFriction, Self::Spring, Self::Inertia];
}

/// The model of all machines: with the parameters of the make, and no friction.
pub fn model() -> String {
    text(MAKE)
}

fn text([inertia, damping, weight, _]: [f64; 4]) -> String {
    format!(
        r#"name = "arm"
[parameters]
J = {{ value = {inertia}, unit = "kg m^2", tolerance = 0.1 }}
b = {{ value = {damping}, unit = "N m s/rad", tolerance = 0.1 }}
mgl = {{ value = {weight}, unit = "N m", tolerance = 0.1 }}
[[input]]
name = "tau"
unit = "N m"
[[coordinate]]
name = "q"
velocity = "dq"
unit = "rad"
[mechanics]
mass = [["J"]]
force = ["tau - b*dq - mgl*sin(q)"]
"#
    )
}

/// The recordings of a machine, from a random stream of its own.
///
/// # Errors
/// None but of the machine's own text, which is right.
pub fn recordings(
    (seed, machine): (u64, u64),
    difference: Option<Difference>,
) -> Result<Vec<Recording>, StudyError> {
    let mut rng = rng(seed, machine);
    let mut unit = [0.0; 4];
    add_gaussian_noise(&mut unit, 1.0, &mut rng)?;
    let mut own = [0, 1, 2, 3].map(|k| MAKE[k] * (1.0 + SPREAD[k] * unit[k]));
    let mut spring = "";
    match difference {
        Some(Difference::NoFriction) => own[3] = 0.0,
        Some(Difference::MoreFriction) => own[3] *= 1.6,
        Some(Difference::Spring) => {
            spring = "[[effect]]\nclass = \"cubic_stiffness\"\nchannel = \"q\"\nstiffness = 0.2\n";
        }
        Some(Difference::Inertia) => own[0] *= 1.25,
        None => {}
    }
    let friction = format!(
        "[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"q\"\nmagnitude = {}\nsmoothing_velocity = 0.02\n",
        own[3]
    );
    let text = format!("{}{friction}{spring}", text(own));
    let truth = Model::from_text(&text, "machine.toml").map_err(ConcealedError::from)?;
    (0..RECORDINGS).map(|_| record(&truth, &mut rng)).collect()
}

fn record(truth: &Model, rng: &mut impl rand::Rng) -> Result<Recording, StudyError> {
    let ranges = SinusoidRanges {
        amplitude: 0.1..=0.3,
        angular_frequency: 0.5..=6.0,
        phase: 0.0..=std::f64::consts::TAU,
    };
    let time: Vec<f64> = (0..ROWS).map(|k| STEP * k as f64).collect();
    let torque = SumOfSinusoids::random(rng, 1, 4, &ranges)?.sample(&time);
    let system = System::new(truth);
    let start = system.at_rest(&[0.2, 0.0]);
    let motion = rk4_sampled(&system, &start, &time, &torque, truth.hold, SUBSTEPS)?;
    let mut angle: Vec<f64> = (0..ROWS).map(|k| motion.state(k)[0]).collect();
    add_gaussian_noise(&mut angle, NOISE, rng)?;
    let column = |name: &str, values| Column { name: name.to_owned(), values };
    let columns = vec![column("q", angle), column("tau", torque)];
    Ok(Recording { name: String::new(), time, columns })
}
