//! The settings of the regression, measured off the recordings.

use super::columns::Columns;
use super::motion::{Motion, Noise, Stretch};
use super::{Arguments, KernelName};
use crate::commands::check::table::number;
use lacuna::occupation::{
    ExponentialDotProduct, Gaussian, InitialDerivative, KernelSpec, Matern, Polynomial, Quadrature,
    Regression, Smoothness, TestFunction,
};
use serde::Serialize;
use std::error::Error;

/// Default ridge.
pub const LAMBDA: f64 = 1.0;
/// Kernel widths, in standard deviations of each argument.
const WIDTHS: f64 = 2.0;
/// Degree of the polynomial kernel.
const DEGREE: u32 = 3;
/// Exponent of the test functions.
const EXPONENT: u32 = 4;
/// Windows begin this many times a window's length.
const OVERLAP: usize = 8;
/// Fewest samples from one window to the next: windows closer together are nearly combinations
/// of others, and whitening then magnifies what no smooth f and g explain.
const SHORTEST_STRIDE: usize = 5;
/// Steps in the shortest window that is chosen.
const FEWEST_STEPS: f64 = 16.0;
/// Samples beyond the order without which a test function's first moments cannot be exact.
const FEWEST_BEYOND_ORDER: usize = 6;
/// Most windows: the dense system of so many takes seconds and half a gigabyte.
const MOST_WINDOWS: usize = 6000;

/// How the regression is done.
#[derive(Serialize)]
pub struct Settings {
    pub window_s: f64,
    /// Samples from one window to the next.
    pub stride: usize,
    pub windows: usize,
    pub regression: Regression,
    /// Test functions of the proof: the same, but only half overlapping, so that none is nearly
    /// a combination of others and whitening does not magnify the errors of quadrature.
    #[serde(skip)]
    pub proof: TestFunction,
    #[serde(skip)]
    pub notes: Vec<String>,
}

impl Settings {
    pub fn choose(
        a: &Arguments,
        columns: &Columns,
        noise: &Noise,
        training: &Motion,
    ) -> Result<Self, Box<dyn Error>> {
        let deviations = deviations(columns, training)?;
        let kernel = kernel(a.kernel, &deviations, training);
        let step = step(training);
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
        let mut notes = Vec::new();
        let wanted = (samples / OVERLAP).max(SHORTEST_STRIDE);
        let stride = stride(training, samples, wanted);
        if stride > wanted {
            notes.push(format!(
                "windows begin every {stride} samples instead of {wanted}, so that there are no \
                 more than about {MOST_WINDOWS}"
            ));
        }
        let regression = Regression {
            kernel,
            order: columns.order,
            test_function: TestFunction::Compact { exponent: EXPONENT, width: window_s, stride },
            quadrature: Quadrature::Trapezoid,
            lambda: a.lambda * noise_to_motion(columns, noise, training),
            initial_derivative: InitialDerivative::default(),
            whiten: true,
        };
        let windows = count(training, samples, stride);
        let proof = TestFunction::Compact {
            exponent: EXPONENT,
            width: window_s,
            stride: stride.max(samples / 2),
        };
        let settings = Self { window_s, stride, windows, regression, proof, notes };
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

    /// Stretches that hold at least one window.
    pub fn long_enough<'m>(&self, motion: &'m Motion) -> Vec<&'m Stretch> {
        let long = |s: &&Stretch| duration(s) >= self.window_s;
        motion.stretches.iter().filter(long).collect()
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

/// Standard deviation of each argument.
fn deviations(columns: &Columns, training: &Motion) -> Result<Vec<f64>, Box<dyn Error>> {
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
        None => Ok(deviations),
    }
}

fn column_sd(rows: &[f64], columns: usize, column: usize) -> f64 {
    let values = || rows.iter().skip(column).step_by(columns);
    let count = (rows.len() / columns) as f64;
    let mean = values().sum::<f64>() / count;
    (values().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt()
}

fn kernel(name: KernelName, deviations: &[f64], training: &Motion) -> KernelSpec {
    let widths: Vec<f64> = deviations.iter().map(|sd| WIDTHS * sd).collect();
    let d = deviations.len();
    let squares = || {
        training
            .stretches
            .iter()
            .flat_map(move |s| s.data.arguments().chunks_exact(d))
            .map(|x| x.iter().map(|v| v * v).sum::<f64>())
    };
    match name {
        KernelName::Gaussian => Gaussian { widths }.into(),
        KernelName::Matern => Matern { smoothness: Smoothness::FiveHalves, widths }.into(),
        KernelName::Exponential => {
            ExponentialDotProduct { mu: 0.5 * squares().fold(0.0, f64::max) }.into()
        }
        KernelName::Polynomial => {
            let scale = squares().sum::<f64>() / squares().count() as f64;
            Polynomial { degree: DEGREE, offset: 1.0, scale }.into()
        }
    }
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

/// (noise / highest derivative)^2, the geometric mean over the channels: the noise variance over
/// the variance that the kernel expansion should have.
fn noise_to_motion(columns: &Columns, noise: &Noise, training: &Motion) -> f64 {
    let spreads = spreads(columns, training);
    let logs = noise.channels.iter().zip(&spreads).map(|(sd, (_, highest))| (sd / highest).ln());
    (2.0 * logs.sum::<f64>() / noise.channels.len() as f64).exp()
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
