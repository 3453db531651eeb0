//! A motor that turns an arm, and what would be recorded of it.

use lacuna::excitation::{SinusoidRanges, SumOfSinusoids, add_gaussian_noise, rng};
use lacuna::plants::integrate::rk4_sampled;
use lacuna::plants::{Model, System};
use lacuna::recordings::{Column, Recording};

const STEP: f64 = 0.01;
pub const NOISE: f64 = 1e-3;

pub const MODEL: &str = r#"# A motor that turns an arm.
name = "arm"

[parameters]
J = { value = 0.05, unit = "kg m^2", tolerance = 0.1 }
b = { value = 0.03, unit = "N m s/rad", tolerance = 0.1 }
mgl = { value = 0.4, unit = "N m", tolerance = 0.1 }

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
"#;

/// So many rows of a run of the arm: its angle with noise, and the torque of a stream of random numbers.
pub fn record(truth: &Model, (seed, run): (u64, u64), rows: usize) -> Recording {
    let mut rng = rng(seed, run);
    let ranges = SinusoidRanges {
        amplitude: 0.1..=0.3,
        angular_frequency: 0.5..=6.0,
        phase: 0.0..=std::f64::consts::TAU,
    };
    let time: Vec<f64> = (0..rows).map(|k| STEP * k as f64).collect();
    let torque = SumOfSinusoids::random(&mut rng, 1, 4, &ranges).unwrap().sample(&time);
    let system = System::new(truth);
    let start = system.at_rest(&[0.2, 0.0]);
    let motion = rk4_sampled(&system, &start, &time, &torque, truth.hold, 8).unwrap();
    let mut angle: Vec<f64> = (0..rows).map(|k| motion.state(k)[0]).collect();
    add_gaussian_noise(&mut angle, NOISE, &mut rng).unwrap();
    let columns = vec![
        Column { name: "q".to_owned(), values: angle },
        Column { name: "tau".to_owned(), values: torque },
    ];
    Recording { name: String::new(), time, columns }
}
