//! What is found where the search begins afresh: parameters and a constant force hide it from where it began.

use crate::findings::{classes, number};
use crate::machines::{Driven, ON_SERVO, diagnosed};
use lacuna_discrepancy::diagnosis::Verdict;
use lacuna_excitation::rng;
use lacuna_plants::Model;
use lacuna_recordings::Recording;
use rand::RngExt;
use std::f64::consts::TAU;

const DROOP: f64 = 0.3;
const FRICTION: f64 = 0.1;

/// The parameters swallow the friction as far as they can, and what is left looks like an offset of the sensor.
#[test]
fn a_servo_that_droops_and_sticks() {
    let text = ON_SERVO.text.replace("17.8", "10").replace("value = 0.6", "value = 0.9");
    let truth = format!(
        "{text}\n[[effect]]\nclass = \"constant_force\"\nchannel = \"q\"\nforce = {DROOP}\n\
         [[effect]]\nclass = \"coulomb_friction\"\nchannel = \"q\"\nmagnitude = {FRICTION}\n\
         smoothing_velocity = 0.002"
    );
    let truth = Model::from_text(&truth, "truth.toml").expect("the truth is right");
    let bench = ON_SERVO;
    let d = diagnosed(&bench.model(), &bench.record(&truth, 401, 4)).diagnosis;
    assert_eq!(d.verdict, Verdict::MissingPhysics, "{:?}", d.notes);
    let of = |class: &str| d.findings.iter().find(|f| f.class == class);
    let (Some(droop), Some(friction)) = (of("constant_force"), of("coulomb_friction")) else {
        panic!("{:?}", d.findings.iter().map(|f| &f.says).collect::<Vec<_>>())
    };
    assert_eq!(d.findings.len(), 2);
    // All forces of a servo that logs no torque may be so many times as large, and its inertia with them.
    let (force, magnitude) = (&droop.parameters["force"], &friction.parameters["magnitude"]);
    let ratio = force.value / magnitude.value;
    assert!((ratio / (DROOP / FRICTION) - 1.0).abs() < 0.05, "{} {}", droop.says, friction.says);
    // Friction that turns within a step of the search goes astray there: what is known of it is asked in finer ones.
    let std = magnitude.std;
    assert!(std > 1e-3 * magnitude.value && std < magnitude.value, "{}", friction.says);
    let fit = &d.fit.held_out["q"];
    assert!(fit.rmse_after < 1.2 * fit.noise, "{} over {}", fit.rmse_after, fit.noise);
}

/// A motor drives a pump against a valve; nobody measures its current.
const PUMP: &str = r#"
name = "pump"
[parameters]
L = { value = 0.008, unit = "H", tolerance = 0.1 }
R = { value = 0.4, unit = "Ohm", tolerance = 0.05 }
K = { value = 0.2, unit = "V s/rad", tolerance = 0.03 }
J = { value = 0.003, unit = "kg m^2", tolerance = 0.1 }
b = { value = 0.004, unit = "N m s/rad", tolerance = 0.2 }
D = { value = 1.2e-6, unit = "m^3/rad", tolerance = 0.02 }
C = { value = 2e-7, unit = "m^3/bar", tolerance = 0.1 }
valve = { value = 6e-5, unit = "m^3/(s bar^0.5)", tolerance = 0.05 }
[[input]]
name = "V"
unit = "V"
[[input]]
name = "open"
unit = ""
[[state]]
name = "i"
unit = "A"
derivative = "(V - R*i - K*w)/L"
[[state]]
name = "w"
unit = "rad/s"
derivative = "(K*i - b*w - 1e5*D*p)/J"
[[state]]
name = "p"
unit = "bar"
derivative = "(D*w - valve*open*sqrt(max(p, 0)))/C"
[recordings]
input_hold = "zero-order"
"#;

const WIDTH: f64 = 0.06;
const LEAK: f64 = 2.2;

/// Sines of drawn frequencies, evenly spread over their logarithms, with such a root mean square.
fn sines(rng: &mut impl RngExt, time: &[f64], range: (f64, f64), rms: f64) -> Vec<f64> {
    const COUNT: usize = 10;
    let mut wave = vec![0.0; time.len()];
    for _ in 0..COUNT {
        let frequency = rng.random_range(range.0.ln()..range.1.ln()).exp();
        let phase = rng.random_range(0.0..TAU);
        let sine = time.iter().map(|t| (TAU * frequency * t + phase).sin() / frequency.powf(0.25));
        wave.iter_mut().zip(sine).for_each(|(w, s)| *w += s);
    }
    let size = (wave.iter().map(|w| w * w).sum::<f64>() / wave.len() as f64).sqrt();
    wave.iter().map(|w| w / size * rms).collect()
}

/// Levels that are held about `every` seconds.
fn levels(rng: &mut impl RngExt, time: &[f64], every: f64, reach: f64) -> Vec<f64> {
    let (mut wave, mut until, mut level) = (vec![], 0.0, 0.0);
    for &t in time {
        if t >= until {
            until = t + every * rng.random_range(0.5..1.5);
            level = rng.random_range(-reach..reach);
        }
        wave.push(level);
    }
    wave
}

/// A recording of it: one of voltage and valve is moved in levels, the other by sines, or both.
fn recorded(truth: &Model, run: u64) -> Recording {
    const STEP: f64 = 0.005;
    const SAMPLES: usize = 2400;
    let mut rng = rng(13, run);
    let time: Vec<f64> = (0..SAMPLES).map(|k| STEP * k as f64).collect();
    let (volts, opens) = match run {
        0 => (sines(&mut rng, &time, (0.2, 8.0), 3.5), levels(&mut rng, &time, 0.6, 0.16)),
        1 => (levels(&mut rng, &time, 0.8, 7.0), sines(&mut rng, &time, (0.3, 5.0), 0.1)),
        2 => (sines(&mut rng, &time, (0.1, 3.0), 4.0), levels(&mut rng, &time, 1.1, 0.2)),
        _ => (levels(&mut rng, &time, 0.4, 5.0), sines(&mut rng, &time, (0.2, 8.0), 0.09)),
    };
    let input = |k: usize| [24.0 + volts[k], (0.22 + opens[k]).clamp(0.01, 0.8)];
    let commands: Vec<f64> = (0..SAMPLES).flat_map(input).collect();
    let driven = Driven { truth, time: &time, commands: &commands, late: 0.0 };
    driven.recorded(run, &[8.0, 90.0, 15.0], &[("w", 1, 0.25), ("p", 2, 0.04)], &mut rng)
}

/// An overflow says the most by itself, and beside it nothing says what is left; behind it is a valve that opens late and a
/// pump that leaks.
#[test]
fn what_says_the_most_by_itself_hides_two() {
    let truth = format!(
        "{PUMP}\n[[effect]]\nclass = \"dead_zone\"\nchannel = \"open\"\nhalf_width = {WIDTH}\n\
         [[effect]]\nclass = \"linear_loss\"\nchannel = \"p\"\nrate = {LEAK}"
    );
    let truth = truth
        .replace("value = 0.003,", "value = 0.00318,")
        .replace("value = 2e-7", "value = 1.86e-7")
        .replace("value = 6e-5", "value = 6.12e-5")
        .replace("value = 0.4,", "value = 0.408,");
    let truth = Model::from_text(&truth, "truth.toml").expect("the truth is right");
    let model = Model::from_text(PUMP, "model.toml").expect("the model is right");
    let recordings: Vec<Recording> = (0..4).map(|run| recorded(&truth, run)).collect();
    let d = diagnosed(&model, &recordings).diagnosis;
    assert_eq!(classes(&d), ["dead_zone", "linear_loss"]);
    let width = number(&d, "dead_zone", "half_width");
    let rate = number(&d, "linear_loss", "rate");
    assert!((width / WIDTH - 1.0).abs() < 0.02, "{width}");
    assert!((rate / LEAK - 1.0).abs() < 0.02, "{rate}");
}
