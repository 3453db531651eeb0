//! The test functions of the proof, measured off the recordings.

use super::Arguments;
use lacuna::identification::Columns;
use lacuna::identification::{Motion, Stretch};
use lacuna::occupation::{InitialDerivative, Quadrature, TestFunction};
use lacuna::table::number;
use serde::Serialize;
use std::error::Error;

/// Exponent of the test functions.
const EXPONENT: u32 = 4;
/// Fewest samples from one window to the next: windows closer together are nearly combinations
/// of others, and whitening then magnifies what no smooth f and g explain.
const SHORTEST_STRIDE: usize = 5;
/// Steps in the shortest window that is chosen.
const FEWEST_STEPS: f64 = 16.0;
/// Fewest samples in a window that is given: on shorter ones, with free initial values, nearly any
/// smooth curve is as good as the model.
const SHORTEST_WINDOW: usize = 24;
/// Samples beyond the order without which a test function's first moments cannot be exact.
const FEWEST_BEYOND_ORDER: usize = 6;
/// Most windows.
const MOST_WINDOWS: usize = 6000;

/// How residuals are judged.
#[derive(Serialize)]
pub struct Settings {
    pub window_s: f64,
    /// Order s of the dynamics.
    #[serde(skip)]
    pub order: usize,
    /// Test functions of the proof, half overlapping, so that none is nearly a combination of others and whitening
    /// does not magnify the errors of quadrature.
    #[serde(skip)]
    pub proof: TestFunction,
}

impl Settings {
    pub fn choose(
        a: &Arguments,
        columns: &Columns,
        training: &Motion,
    ) -> Result<Self, Box<dyn Error>> {
        check_moving(columns, training)?;
        let step = step(training);
        check_given(a, columns, step)?;
        let window_s = match a.window {
            Some(seconds) => seconds,
            None => window(columns, training, step),
        };
        let samples = (window_s / step).round().max(1.0) as usize;
        let needed = columns.order + FEWEST_BEYOND_ORDER;
        if samples + 1 < needed {
            return Err(format!(
                "the window of {} s holds {} samples, at least {needed} are needed; give a longer \
                 --window",
                number(window_s),
                samples + 1
            )
            .into());
        }
        let stride = stride(training, samples, (samples / 2).max(SHORTEST_STRIDE));
        let proof = TestFunction::Compact { exponent: EXPONENT, width: window_s, stride };
        let settings = Self { window_s, order: columns.order, proof };
        if settings.long_enough(training).is_empty() {
            return Err(format!(
                "no stretch of the recordings is as long as the test functions of {} s; give a \
                 shorter --window",
                number(window_s)
            )
            .into());
        }
        Ok(settings)
    }

    /// Quadrature of the proof.
    pub const QUADRATURE: Quadrature = Quadrature::Trapezoid;
    /// Compact test functions need none; it is named where functionals are made.
    pub const INITIAL: InitialDerivative = InitialDerivative::ForwardDifference;

    /// Stretches that hold at least one window.
    pub fn long_enough<'m>(&self, motion: &'m Motion) -> Vec<&'m Stretch> {
        let long = |s: &&Stretch| duration(s) >= self.window_s;
        motion.stretches.iter().filter(long).collect()
    }
}

/// Refuses widths and windows that do not suit the recordings.
fn check_given(a: &Arguments, columns: &Columns, step: f64) -> Result<(), String> {
    let arguments = &columns.arguments;
    if !a.widths.is_empty() && a.widths.len() != arguments.len() {
        return Err(format!(
            "--widths: expected {}, one for each of {}; found {}",
            arguments.len(),
            arguments.join(", "),
            a.widths.len()
        ));
    }
    // A window of a whole number of steps may fall short of its last sample by rounding.
    let samples = |window: f64| (window / step * (1.0 + 1e-9)) as usize + 1;
    match a.window.map(|window| (window, samples(window))) {
        Some((window, found)) if found < SHORTEST_WINDOW => Err(format!(
            "--window: {} s hold {found} samples, at least {SHORTEST_WINDOW} are needed",
            number(window)
        )),
        _ => Ok(()),
    }
}

fn duration(s: &Stretch) -> f64 {
    let times = s.data.times();
    times[times.len() - 1] - times[0]
}

fn step(training: &Motion) -> f64 {
    let total: f64 = training.stretches.iter().map(duration).sum();
    let steps: usize = training.stretches.iter().map(|s| s.data.samples() - 1).sum();
    total / steps as f64
}

/// Refuses arguments that never change.
fn check_moving(columns: &Columns, training: &Motion) -> Result<(), Box<dyn Error>> {
    let d = columns.arguments.len();
    let all: Vec<f64> =
        training.stretches.iter().flat_map(|s| s.data.arguments()).copied().collect();
    let deviations: Vec<f64> = (0..d).map(|i| column_sd(&all, d, i)).collect();
    match deviations.iter().position(|sd| *sd <= 0.0) {
        Some(i) => Err(format!(
            "{}: '{}' never changes; leave it out by naming the others with --channels",
            training.names[0], columns.arguments[i]
        )
        .into()),
        None => Ok(()),
    }
}

fn column_sd(rows: &[f64], columns: usize, column: usize) -> f64 {
    let values = || rows.iter().skip(column).step_by(columns);
    let count = (rows.len() / columns) as f64;
    let mean = values().sum::<f64>() / count;
    (values().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt()
}

/// Sums of squares over all stretches, by channel: of the highest derivative, and the variance
/// of the one below.
fn spreads(columns: &Columns, training: &Motion) -> Vec<(f64, f64)> {
    let n = columns.channels.len();
    let concat = |of: fn(&Stretch) -> &Vec<f64>| -> Vec<f64> {
        training.stretches.iter().flat_map(of).copied().collect()
    };
    let (below, highest) = (concat(|s| &s.below), concat(|s| &s.highest));
    let rms = |i: usize| {
        let values = highest.iter().skip(i).step_by(n);
        (values.map(|v| v * v).sum::<f64>() / (highest.len() / n) as f64).sqrt()
    };
    (0..n).map(|i| (column_sd(&below, n, i), rms(i))).collect()
}

/// Half of the fastest channel's typical period, so that windows see within a swing.
fn window(columns: &Columns, training: &Motion, step: f64) -> f64 {
    let typical = |(below, highest): &(f64, f64)| below / highest;
    let fastest = spreads(columns, training).iter().map(typical).fold(f64::INFINITY, f64::min);
    let longest = training.stretches.iter().map(duration).fold(0.0, f64::max);
    let wanted = std::f64::consts::PI * fastest;
    let samples = (wanted / step).round().max(FEWEST_STEPS).min((0.25 * longest / step).floor());
    samples * step
}

fn count(training: &Motion, samples: usize, stride: usize) -> usize {
    let windows = |s: &Stretch| match s.data.samples().checked_sub(samples) {
        Some(room) => room.div_ceil(stride),
        None => 0,
    };
    training.stretches.iter().map(windows).sum()
}

/// The smallest stride from `wanted` on with no more than [`MOST_WINDOWS`] windows.
fn stride(training: &Motion, samples: usize, wanted: usize) -> usize {
    let fine = count(training, samples, 1);
    wanted.max(fine.div_ceil(MOST_WINDOWS))
}
