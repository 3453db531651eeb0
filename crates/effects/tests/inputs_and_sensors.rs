//! What actuators and sensors make of a signal, against closed forms.

mod support;

use lacuna_effects::{SeriesLawIn, find};
use support::series_law;

fn law(class: &str) -> &'static dyn SeriesLawIn<f64> {
    series_law(class).plain()
}

const COMMAND: [f64; 7] = [1.0, 4.0, -2.0, 3.0, 3.0, -5.0, 0.5];

fn even() -> Vec<f64> {
    (0..COMMAND.len()).map(|k| 0.1 * k as f64).collect()
}

fn close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 1e-12, "found {found:?}, expected {expected:?}");
    }
}

#[test]
fn a_delay_of_whole_samples_shifts_the_command() {
    let delayed = |delay| law("input_delay").applied(&[delay], &even(), &COMMAND);
    close(&delayed(0.0), &COMMAND);
    // Before the recording the first command is taken to have been there.
    close(&delayed(0.1), &[1.0, 1.0, 4.0, -2.0, 3.0, 3.0, -5.0]);
    close(&delayed(0.3), &[1.0, 1.0, 1.0, 1.0, 4.0, -2.0, 3.0]);
    close(&delayed(5.0), &[1.0; 7]);
}

#[test]
fn a_delay_of_a_fraction_of_a_sample_is_the_mean_over_the_step() {
    let found = law("input_delay").applied(&[0.03], &even(), &COMMAND);
    // 30 % of each step still sees the command before.
    let mut expected = vec![1.0];
    expected.extend(COMMAND.windows(2).map(|c| 0.3 * c[0] + 0.7 * c[1]));
    close(&found, &expected);
    let found = law("input_delay").applied(&[0.125], &even(), &COMMAND);
    let at = |k: isize| COMMAND[k.max(0) as usize];
    let expected: Vec<f64> = (0..7).map(|k| 0.25 * at(k - 2) + 0.75 * at(k - 1)).collect();
    close(&found, &expected);
}

/// The mean of u(t - d) over each step, by adding up ten thousand slices of it.
#[test]
fn a_delay_on_uneven_samples_is_the_mean_over_each_step() {
    let times = [0.0, 0.05, 0.2, 0.22, 0.5, 0.61, 0.7];
    let held = |t: f64| COMMAND[times.iter().rposition(|&s| s <= t).unwrap_or(0)];
    for delay in [0.013, 0.11, 0.4] {
        let found = law("input_delay").applied(&[delay], &times, &COMMAND);
        for (k, step) in times.windows(2).enumerate() {
            const SLICES: usize = 10_000;
            let h = (step[1] - step[0]) / SLICES as f64;
            let slices = (0..SLICES).map(|s| held(step[0] + (s as f64 + 0.5) * h - delay));
            let mean = slices.sum::<f64>() / SLICES as f64;
            assert!((found[k] - mean).abs() < 2e-3, "step {k}: {} {mean}", found[k]);
        }
    }
}

/// Step response at t_k: the mean over [t_k, t_k + h] of 1 - exp(-t / T).
#[test]
fn a_lag_answers_a_step_with_an_exponential() {
    let (tau, h) = (0.25, 0.1);
    let times: Vec<f64> = (0..12).map(|k| h * f64::from(k)).collect();
    let command: Vec<f64> = (0..12).map(|k| if k < 2 { 0.0 } else { 3.0 }).collect();
    let found = law("actuator_lag").applied(&[tau, 1.0], &times, &command);
    let mean = |k: usize| {
        if k < 2 {
            return 0.0;
        }
        let begin = h * (k - 2) as f64;
        let fall = (-begin / tau).exp() - (-(begin + h) / tau).exp();
        3.0 * (1.0 - tau / h * fall)
    };
    close(&found, &(0..12).map(mean).collect::<Vec<_>>());
}

/// On uneven steps, the exact solution of T u' = c - u carried along by hand.
#[test]
fn a_lag_follows_the_exact_solution_on_uneven_steps() {
    let times = [0.0, 0.05, 0.2, 0.22, 0.5, 0.61, 0.7];
    let tau = 0.12;
    let found = law("actuator_lag").applied(&[tau, 1.0], &times, &COMMAND);
    let mut state = COMMAND[0];
    for (k, step) in times.windows(2).enumerate() {
        let h = step[1] - step[0];
        // int u' dt = u(end) - u(begin) = (c - mean) h / T.
        let end = COMMAND[k] + (state - COMMAND[k]) * (-h / tau).exp();
        let mean = COMMAND[k] - (end - state) * tau / h;
        assert!((found[k] - mean).abs() < 1e-12, "{k}: {} {mean}", found[k]);
        state = end;
    }
    // A lag much faster than the samples changes nothing.
    close(&law("actuator_lag").applied(&[1e-16, 1.0], &times, &COMMAND), &COMMAND);
}

#[test]
fn gain_dead_zone_and_saturation_obey_their_formulas() {
    let of = |class: &str, p: f64| law(class).applied(&[p], &even(), &COMMAND);
    close(&of("gain_error", 0.8), &[0.8, 3.2, -1.6, 2.4, 2.4, -4.0, 0.4]);
    close(&of("dead_zone", 1.5), &[0.0, 2.5, -0.5, 1.5, 1.5, -3.5, 0.0]);
    close(&of("saturation", 2.5), &[1.0, 2.5, -2.0, 2.5, 2.5, -2.5, 0.5]);
}

#[test]
fn neutral_parameters_leave_the_command_alone() {
    for (class, neutral) in [("gain_error", 1.0), ("dead_zone", 0.0), ("input_delay", 0.0)] {
        close(&law(class).applied(&[neutral], &even(), &COMMAND), &COMMAND);
    }
    close(&law("saturation").applied(&[5.0], &even(), &COMMAND), &COMMAND);
}

/// Screening refines a shape between the values of its grid: one value alone would be taken
/// as it is.
#[test]
fn every_input_law_is_screened_over_a_range() {
    let scales = lacuna_effects::Scales {
        q: (-1.0, 1.0),
        v: 1.0,
        input: (2.0, 5.0),
        step: 0.01,
        time: (0.0, 10.0),
        ..lacuna_effects::Scales::default()
    };
    for class in ["gain_error", "dead_zone", "saturation", "input_delay", "actuator_lag"] {
        let effect = find(class).expect("in the catalogue");
        assert!((effect.shapes)(&scales).len() > 1, "{class}");
    }
}

#[test]
fn a_recording_of_one_sample_is_no_trouble() {
    for class in ["gain_error", "dead_zone", "saturation", "input_delay", "actuator_lag"] {
        let parameters = if class == "actuator_lag" { vec![1.0, 1.0] } else { vec![1.0] };
        let found = law(class).applied(&parameters, &[0.0], &[0.7]);
        let expected = if class == "dead_zone" { 0.0 } else { 0.7 };
        close(&found, &[expected]);
    }
}

#[test]
fn sensors_obey_their_formulas() {
    let of = |class: &str, p: f64| law(class).applied(&[p], &even(), &COMMAND);
    close(&of("sensor_scale", 1.1), &[1.1, 4.4, -2.2, 3.3, 3.3, -5.5, 0.55]);
    close(&of("sensor_dead_zone", 1.5), &[0.0, 2.5, -0.5, 1.5, 1.5, -3.5, 0.0]);
    close(&of("sensor_bias", -0.5), &[0.5, 3.5, -2.5, 2.5, 2.5, -5.5, 0.0]);
}

/// A straight line seen late is the same line lower; whole samples shift any series.
#[test]
fn a_sensor_delay_shows_the_past() {
    let times: Vec<f64> = vec![0.0, 0.1, 0.25, 0.3, 0.55];
    let line: Vec<f64> = times.iter().map(|t| 2.0 + 3.0 * t).collect();
    let expected: Vec<f64> = times.iter().map(|t| 2.0 + 3.0 * (t - 0.07)).collect();
    close(&law("sensor_delay").applied(&[0.07], &times, &line), &expected);
    let shifted = law("sensor_delay").applied(&[0.2], &even(), &COMMAND);
    close(&shifted[2..], &COMMAND[..5]);
    close(&law("sensor_delay").applied(&[0.0], &even(), &COMMAND), &COMMAND);
}
