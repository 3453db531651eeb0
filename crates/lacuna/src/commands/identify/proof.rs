//! What the identified model leaves unexplained, on training and on held-out recordings.
//!
//! Whitened by its noise covariance S = L L^T, the weak form of channel i has the residual
//!
//! ```text
//! L^-1 (Y_i - int phi (f_i + g_i u) dt)     relative to     L^-1 Y_i
//! ```
//!
//! of which the measurement noise alone leaves sigma_i sqrt(rows).

use super::settings::Settings;
use lacuna::identification::Columns;
use lacuna::identification::{Motion, Noise, Stretch};
use lacuna::occupation::{BandedCholesky, Functional, IdentifiedModel};
use nalgebra::DMatrix;
use rayon::prelude::*;
use serde::Serialize;
use std::error::Error;

/// An input with a smaller share of its own does not show its effectiveness.
const TOO_SMALL: f64 = 0.02;
/// A residual above this explains next to nothing.
const NOTHING: f64 = 0.9;
/// A residual above this, and this many times that of the noise, asks for a reason.
const COARSE: f64 = 0.05;
const FAR: f64 = 10.0;
/// More held-out samples than this outside the training's range are said.
const MUCH_OUTSIDE: f64 = 0.05;
/// A held-out residual this many times the training's was learned by heart.
const BY_HEART: f64 = 2.0;

/// Relative weak residual of one channel.
#[derive(Clone, Serialize)]
pub struct Residual {
    pub channel: String,
    /// rms of (Y - prediction) over rms of Y, whitened.
    pub relative: f64,
    /// What the measurement noise alone leaves of a perfect model.
    pub noise: f64,
}

#[derive(Serialize)]
pub struct Proof {
    pub training: Vec<Residual>,
    pub held_out: Vec<Residual>,
    /// Share of each input that neither the state nor the other inputs explain.
    pub own_share: Vec<f64>,
    /// Share of the held-out samples of which an argument lies outside the training's range.
    pub outside: f64,
}

impl Proof {
    pub fn of(
        model: &IdentifiedModel,
        settings: &Settings,
        columns: &Columns,
        noise: &Noise,
        training: &[&Stretch],
        held_out: &Motion,
    ) -> Result<Self, Box<dyn Error>> {
        let held = settings.long_enough(held_out);
        if held.is_empty() {
            return Err(format!(
                "what is kept for proof ({}) is shorter than the test functions; give longer \
                 recordings or a shorter --window",
                held_out.names.join(", ")
            )
            .into());
        }
        Ok(Self {
            training: residuals(model, settings, columns, noise, training)?,
            held_out: residuals(model, settings, columns, noise, &held)?,
            own_share: own_shares(settings, training)?,
            outside: outside(training, &held),
        })
    }

    /// What to mind.
    pub fn warnings(&self, columns: &Columns) -> Vec<String> {
        let mut out = Vec::new();
        if self.outside > MUCH_OUTSIDE {
            out.push(format!(
                "{:.0} % of the held-out samples lie outside the range of the training recordings, \
                 where f and g are not known",
                100.0 * self.outside
            ));
        }
        for (training, held) in self.training.iter().zip(&self.held_out) {
            if held.relative > NOTHING {
                out.push(format!(
                    "next to nothing of '{}' is explained on what was held out; is an input or a \
                     channel missing, or is the order wrong?",
                    held.channel
                ));
            } else if held.relative > BY_HEART * training.relative.max(held.noise) {
                out.push(format!(
                    "'{}' is explained much worse on what was held out than in training: more \
                     recordings, or a larger --lambda, help",
                    held.channel
                ));
            }
        }
        for residual in &self.training {
            if residual.relative > COARSE.max(FAR * residual.noise) {
                out.push(format!(
                    "much more is left of '{}' than the noise: does the input run on between \
                     samples (--input-hold linear), is the sampling fine enough, does something \
                     unrecorded act on it?",
                    residual.channel
                ));
            }
        }
        for (input, share) in columns.inputs.iter().zip(&self.own_share) {
            if *share < TOO_SMALL {
                out.push(format!(
                    "the effectiveness of '{input}' cannot be told from the drift or other inputs: \
                     only {:.1} % of it is not explained by the state and other inputs; excite it \
                     independently",
                    100.0 * share
                ));
            }
        }
        out
    }
}

fn residuals(
    model: &IdentifiedModel,
    settings: &Settings,
    columns: &Columns,
    noise: &Noise,
    stretches: &[&Stretch],
) -> Result<Vec<Residual>, Box<dyn Error>> {
    let n = columns.channels.len();
    let (mut left, mut observed, mut rows) = (vec![0.0; n], vec![0.0; n], 0);
    for stretch in stretches {
        let times = stretch.data.times();
        let weights = settings.proof.functionals(times, Settings::QUADRATURE, 0)?;
        let sides = settings.proof.right_hand_sides(
            times,
            Settings::QUADRATURE,
            settings.order,
            Settings::INITIAL,
        )?;
        let whitener = BandedCholesky::of_functionals(&sides)?;
        let predicted = predicted(model, stretch)?;
        rows += sides.len();
        for i in 0..n {
            let mut seen = apply(&sides, stretch.data.coordinates(), n, i);
            let explained = apply(&weights, &predicted, n, i);
            let mut rest: Vec<f64> = seen.iter().zip(&explained).map(|(y, p)| y - p).collect();
            whitener.solve_lower_in_place(&mut seen)?;
            whitener.solve_lower_in_place(&mut rest)?;
            observed[i] += seen.iter().map(|v| v * v).sum::<f64>();
            left[i] += rest.iter().map(|v| v * v).sum::<f64>();
        }
    }
    let residual = |(i, channel): (usize, &String)| Residual {
        channel: channel.clone(),
        relative: (left[i] / observed[i]).sqrt(),
        noise: noise.channels[i] * (rows as f64 / observed[i]).sqrt(),
    };
    Ok(columns.channels.iter().enumerate().map(residual).collect())
}

fn apply(functionals: &[Functional], rows: &[f64], columns: usize, column: usize) -> Vec<f64> {
    functionals.iter().map(|f| f.apply_column(rows, columns, column)).collect()
}

/// f + g u along a stretch, N x n.
fn predicted(model: &IdentifiedModel, stretch: &Stretch) -> Result<Vec<f64>, Box<dyn Error>> {
    let (n, m, d) = (model.dimension(), model.inputs(), model.arguments());
    let (arguments, inputs) = (stretch.data.arguments(), stretch.data.inputs());
    let mut out = vec![0.0; stretch.data.samples() * n];
    out.par_chunks_exact_mut(n).enumerate().try_for_each(|(k, f)| {
        let mut g = vec![0.0; n * m];
        model.evaluate(&arguments[k * d..(k + 1) * d], f, &mut g)?;
        for (i, value) in f.iter_mut().enumerate() {
            let u = &inputs[k * m..(k + 1) * m];
            *value += g[i * m..(i + 1) * m].iter().zip(u).map(|(g, u)| g * u).sum::<f64>();
        }
        Ok::<(), lacuna::occupation::EvaluationError>(())
    })?;
    Ok(out)
}

/// Share of held-out samples with an argument outside the range of training.
fn outside(training: &[&Stretch], held_out: &[&Stretch]) -> f64 {
    let d = training[0].data.argument_count();
    let mut range = vec![(f64::INFINITY, f64::NEG_INFINITY); d];
    for x in training.iter().flat_map(|s| s.data.arguments().chunks_exact(d)) {
        for ((low, high), v) in range.iter_mut().zip(x) {
            (*low, *high) = (low.min(*v), high.max(*v));
        }
    }
    let leaves = |x: &&[f64]| x.iter().zip(&range).any(|(v, (low, high))| v < low || v > high);
    let samples = || held_out.iter().flat_map(|s| s.data.arguments().chunks_exact(d));
    samples().filter(leaves).count() as f64 / samples().count() as f64
}

/// Share of each input, seen through the test functions, that is left when a constant, the
/// arguments, their products and the other inputs are taken off by least squares: from the
/// inverse of the columns' Gram matrix, whose condition it tells input by input.
fn own_shares(settings: &Settings, stretches: &[&Stretch]) -> Result<Vec<f64>, Box<dyn Error>> {
    /// Diagonal added to the Gram matrix of columns of unit length.
    const RIDGE: f64 = 1e-12;
    let m = stretches[0].data.input_count();
    let columns = weak_columns(settings, stretches)?;
    let (p, rows) = (columns.len(), columns[0].len());
    let size = |c: &[f64]| c.iter().map(|v| v * v).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
    let unit = DMatrix::from_fn(rows, p, |a, c| columns[c][a] / size(&columns[c]));
    let gram = unit.tr_mul(&unit) + RIDGE * DMatrix::<f64>::identity(p, p);
    let inverse = gram.clone().cholesky().ok_or("the inputs or channels are not finite")?.inverse();
    let share = |j: usize| {
        let c = p - m + j;
        // The first column is the constant: what varies is what it does not explain.
        let varies = (1.0 - gram[(0, c)].powi(2)).max(0.0).sqrt();
        let own = inverse[(c, c)].recip().sqrt();
        if varies > RIDGE.sqrt() { (own / varies).min(1.0) } else { 0.0 }
    };
    Ok((0..m).map(share).collect())
}

/// int phi (1, x, x x^T, u) dt, one column a function; arguments about their mean.
fn weak_columns(
    settings: &Settings,
    stretches: &[&Stretch],
) -> Result<Vec<Vec<f64>>, Box<dyn Error>> {
    let (d, m) = (stretches[0].data.argument_count(), stretches[0].data.input_count());
    let samples: usize = stretches.iter().map(|s| s.data.samples()).sum();
    let all = stretches.iter().flat_map(|s| s.data.arguments().chunks_exact(d));
    let mut mean = vec![0.0; d];
    all.for_each(|x| mean.iter_mut().zip(x).for_each(|(sum, v)| *sum += v / samples as f64));
    let mut columns = vec![Vec::new(); 1 + d + d * (d + 1) / 2 + m];
    let width = columns.len();
    for s in stretches {
        let functionals = settings.proof.functionals(s.data.times(), Settings::QUADRATURE, 0)?;
        let mut features = Vec::with_capacity(s.data.samples() * width);
        for (k, x) in s.data.arguments().chunks_exact(d).enumerate() {
            let x: Vec<f64> = x.iter().zip(&mean).map(|(v, mean)| v - mean).collect();
            features.push(1.0);
            features.extend_from_slice(&x);
            (0..d).for_each(|i| features.extend((0..=i).map(|j| x[i] * x[j])));
            features.extend_from_slice(&s.data.inputs()[k * m..(k + 1) * m]);
        }
        for (c, column) in columns.iter_mut().enumerate() {
            column.extend(apply(&functionals, &features, width, c));
        }
    }
    Ok(columns)
}
