//! Where nothing is missing nothing is found; where a parameter is off, only that is said.

use crate::machines::{Bench, ON_PENDULUM, ON_TANKS, ON_TWO_MASS, diagnosed};
use lacuna_discrepancy::diagnosis::Verdict;
use lacuna_excitation::{add_gaussian_noise, rng};
use lacuna_recordings::Recording;
use rand::RngExt;

fn finds_nothing(bench: Bench, seeds: std::ops::Range<u64>) {
    for seed in seeds {
        let model = bench.model();
        let outcome = diagnosed(&model, &bench.record(&model, seed, 3));
        let d = &outcome.diagnosis;
        let found: Vec<_> = d.findings.iter().map(|f| &f.says).collect();
        assert!(found.is_empty(), "{} seed {seed}: {found:?}", d.model);
        assert_eq!(d.verdict, Verdict::NoMismatch, "{} seed {seed}", d.model);
        // A model that is right is left as it is.
        assert!(d.calibration.is_empty());
        assert!(outcome.augmentation.effects.is_empty());
        assert!(outcome.augmentation.parameters.is_empty());
        for (channel, fit) in &d.fit.held_out {
            let share = fit.rmse_before / fit.noise;
            assert!((0.85..1.1).contains(&share), "{} {channel} {fit:?}", d.model);
            assert_eq!(fit.rmse_after, fit.rmse_before);
        }
    }
}

#[test]
fn of_a_right_pendulum() {
    finds_nothing(ON_PENDULUM, 101..105);
}

#[test]
fn of_a_right_two_mass_system() {
    finds_nothing(ON_TWO_MASS, 110..112);
}

#[test]
fn of_right_tanks() {
    finds_nothing(ON_TANKS, 120..124);
}

/// A parameter 12 % off, its tolerance being 10 %.
fn finds_the_parameter(bench: Bench, seed: u64, name: &str, share: f64) {
    let model = bench.model();
    let mut truth = model.clone();
    let p = truth.parameters.iter_mut().find(|p| p.name == name).expect("a parameter");
    p.value *= share;
    let value = p.value;
    let d = diagnosed(&model, &bench.record(&truth, seed, 3)).diagnosis;
    let found: Vec<_> = d.findings.iter().map(|f| &f.says).collect();
    assert_eq!(d.verdict, Verdict::Miscalibrated, "{name}: {found:?}");
    assert!(d.findings.is_empty());
    let c = &d.calibration[name];
    assert!(c.std > 0.0 && (c.value - value).abs() < 4.0 * c.std, "{name}: {c:?}, truth {value}");
    assert!(c.std < 0.5 * (value - c.nominal).abs(), "{name} is hardly known: {c:?}");
    for (other, c) in d.calibration.iter().filter(|(other, _)| *other != name) {
        assert!((c.value - c.nominal).abs() < 4.0 * c.std, "{other} moved: {c:?}");
    }
    for (channel, fit) in &d.fit.held_out {
        assert!(fit.rmse_after < 1.1 * fit.noise && fit.rmse_after < fit.rmse_before, "{channel}");
    }
}

#[test]
fn but_a_pendulum_heavier_than_the_model_says() {
    finds_the_parameter(ON_PENDULUM, 130, "mgl", 1.12);
}

#[test]
fn but_a_spring_softer_than_the_model_says() {
    finds_the_parameter(ON_TWO_MASS, 131, "k", 0.88);
}

#[test]
fn but_a_valve_wider_than_the_model_says() {
    finds_the_parameter(ON_TANKS, 132, "a1", 1.12);
}

/// What a sensor at the end of its range shows is not measured: no end stop, no friction.
#[test]
fn a_sensor_at_the_end_of_its_range() {
    let bench = ON_PENDULUM;
    let mut recordings = bench.record(&bench.model(), 331, 3);
    let largest = |r: &lacuna_recordings::Recording| {
        r.columns[1].values.iter().fold(f64::NEG_INFINITY, |a, v| a.max(*v))
    };
    let limit = 0.7 * recordings.iter().map(largest).fold(f64::INFINITY, f64::min);
    for value in recordings.iter_mut().flat_map(|r| &mut r.columns[1].values) {
        *value = value.min(limit);
    }
    let d = diagnosed(&bench.model(), &recordings).diagnosis;
    assert_eq!(d.verdict, Verdict::NoMismatch, "{:?}", d.findings);
    let said = d.notes.iter().any(|n| n.contains("At the end of the sensor's range"));
    assert!(said, "{:?}", d.notes);
}

/// Noise that is correlated from sample to sample is neither a law nor a random force.
#[test]
fn noise_of_a_colour() {
    const KEPT: f64 = 0.9;
    const DEVIATION: f64 = 4e-3;
    for bench in [ON_PENDULUM, ON_TWO_MASS] {
        let mut rng = rng(333, 0);
        let mut recordings = bench.record(&bench.model(), 333, 3);
        for column in recordings.iter_mut().flat_map(|r| &mut r.columns[1..]) {
            let mut white = vec![0.0; column.values.len()];
            let new = DEVIATION * (1.0 - KEPT * KEPT).sqrt();
            add_gaussian_noise(&mut white, new, &mut rng).expect("a deviation");
            let mut noise = 0.0;
            for (value, new) in column.values.iter_mut().zip(white) {
                noise = KEPT * noise + new;
                *value += noise;
            }
        }
        let d = diagnosed(&bench.model(), &recordings).diagnosis;
        assert_eq!(d.verdict, Verdict::NoMismatch, "{} {:?}", d.model, d.findings);
        assert!(d.driving.forces.is_empty(), "{:?}", d.driving);
        let said = d.notes.iter().any(|n| n.contains("it is correlated over"));
        assert!(said, "{} {:?}", d.model, d.notes);
    }
}

/// From sample to sample the drive is as good as noise: no line tells what was lost with a row.
const ROUGH: Bench = Bench { amplitude: (2.0, 4.0), frequency: (60.0, 250.0), ..ON_PENDULUM };

/// Recordings of which some rows were dropped.
fn with_rows_lost(mut recordings: Vec<Recording>, seed: u64) -> Vec<Recording> {
    for (k, r) in recordings.iter_mut().enumerate() {
        let mut rng = rng(seed, 1000 + k as u64);
        let kept: Vec<bool> = r.time.iter().map(|_| rng.random_bool(0.95)).collect();
        let keep = |values: &mut Vec<f64>| {
            let mut marks = kept.iter();
            values.retain(|_| marks.next().copied().unwrap_or(true));
        };
        keep(&mut r.time);
        r.columns.iter_mut().for_each(|c| keep(&mut c.values));
    }
    recordings
}

/// Rows that were dropped take commands with them: what those did to the machine is no physics.
#[test]
fn of_a_machine_some_of_whose_rows_are_lost() {
    let model = ROUGH.model();
    for seed in 140..148 {
        let recordings = with_rows_lost(ROUGH.record(&model, seed, 3), seed);
        let d = diagnosed(&model, &recordings).diagnosis;
        assert!(d.data.dropped > 50);
        let found: Vec<_> = d.findings.iter().map(|f| &f.says).collect();
        assert!(found.is_empty(), "seed {seed}: {found:?}");
        assert_eq!(d.verdict, Verdict::NoMismatch, "seed {seed}");
        assert!(d.driving.forces.is_empty(), "seed {seed}: {:?}", d.driving);
    }
}

/// Nor does it hide a parameter that is off: predictions begin anew behind what was lost.
#[test]
fn a_parameter_of_a_machine_some_of_whose_rows_are_lost() {
    let model = ROUGH.model();
    let mut truth = model.clone();
    truth.parameters[0].value *= 1.2;
    for seed in 150..153 {
        let recordings = with_rows_lost(ROUGH.record(&truth, seed, 3), seed);
        let d = diagnosed(&model, &recordings).diagnosis;
        assert_eq!(d.verdict, Verdict::Miscalibrated, "seed {seed}: {:?}", d.driving);
        let c = &d.calibration["J"];
        assert!((c.value - 0.06).abs() < 4.0 * c.std && c.std < 0.002, "seed {seed}: {c:?}");
        for fit in d.fit.held_out.values() {
            assert!(fit.rmse_after < 1.1 * fit.noise, "seed {seed}: {fit:?}");
        }
        let said = d.notes.iter().any(|n| n.contains("begin anew"));
        assert!(said, "seed {seed}: {:?}", d.notes);
    }
}
