//! Identification from more motions than fit into memory: sums over parts of the data, in any place.
//!
//! ```text
//! f_i(x) = phi_i0(x) . c_i0,   g_ij(x) = phi_ij(x) . c_ij,   c ~ N(0, a^2 I)
//! int phi_a (f_i(x) + g_i(x) u) dt = Y_ai + e_ai,   e ~ N(0, sigma_i^2 S)
//! ```
//!
//! Kernels, widths, amplitudes, landmarks and how samples are smoothed are chosen once, on a sample of the motions. Each
//! motion is then a few equations, whitened: its smoothed samples are the arguments x, its samples or rates make Y, under
//! compact test functions. The equations enter by their inner products alone, and these add up.
//!
//! | on paper | in code | shape |
//! | --- | --- | --- |
//! | what was chosen, features phi | [`Stream`] | n (1 + m) functions |
//! | Phi_i^T Phi_i, Phi_i^T Y_i, Y_i . Y_i | [`Sums`], of each row an [`evidence::Normal`](super::evidence::Normal) | P x P, P, 1 |
//! | posterior of c, sigma | [`Stream::solve`] | |
//!
//! Unlike [`Identification::identify`] it does not go on along the model's own trajectories: what the smoother makes of the
//! samples' noise stays in the arguments, however many motions there are.

use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

use super::basis::Basis;
use super::choice::{RowChoice, side_by_side};
use super::data::{Data, states_of, thin};
use super::evidence::{Normal, Posterior};
use super::field::{Field, Term};
use super::inputs::at_samples;
use super::motion::{InputPath, Motion};
use super::report::{Report, Seen};
use super::smoothing::{Channel, Smooth};
use super::{Identification, IdentificationError, Identified, LANDMARK_SHARE, TERM_LIMITS};
use crate::quadrature::Quadrature;
use crate::regression::{Equations, FitError, WeakForm};
use crate::sample::sample;
use crate::test_function::{InitialDerivative, TestFunction};
use crate::trajectory::TrajectoryData;

/// Samples, about, of the motions on which kernels are chosen.
const CHOOSING_SAMPLES: usize = 4000;
/// Motions whose kernel values are in memory at a time.
const GROUP: usize = 32;
/// Exponent of the test functions.
const EXPONENT: u32 = 4;
/// Test functions are as wide as this share of the windows on which kernels were chosen ...
const SHARE: f64 = 0.5;
/// ... and hold at least so many steps from sample to sample.
const FEWEST_STEPS: f64 = 10.0;
/// Test functions that overlap at any time.
const OVERLAP: f64 = 6.0;
/// Variance that landmarks may leave, however much data there is: with less they are not told apart by their values.
const LEAST_LEFT: f64 = 1e-10;
/// Rounds in which noise and coefficients are found, each with the other.
const ROUNDS: usize = 4;
/// What is left is lost in rounding below this share of the right-hand sides' square.
const ROUNDING: f64 = 1e-13;

/// What was chosen on a sample; makes sums of motions, and a model of sums.
#[derive(Debug, Clone)]
pub struct Stream {
    saved: Saved,
    /// Without coefficients.
    field: Field,
}

/// What another process needs.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Saved {
    order: usize,
    path: InputPath,
    lambda: Option<f64>,
    /// Coordinates, inputs, arguments.
    shape: [usize; 3],
    rates: bool,
    channels: Vec<Channel>,
    rate_noise: Vec<Option<f64>>,
    width: f64,
    window_seconds: f64,
    rows: Vec<RowChoice>,
    /// Of f_1, g_11, ..., f_2, ...
    landmarks: Vec<Vec<f64>>,
    candidates: Vec<f64>,
    few_candidates: Vec<f64>,
}

/// Inner products of the equations of some motions.
#[derive(Debug, Clone, PartialEq)]
pub struct Sums {
    rows: Vec<Normal>,
    /// Number of motions.
    pub motions: usize,
    /// Number of their samples.
    pub samples: usize,
}

impl Identification {
    /// Chooses kernels and landmarks on a sample of motions that have `samples` samples in all: more data tell more, and
    /// get more landmarks.
    ///
    /// # Errors
    /// As [`Identification::identify`].
    pub fn stream(
        &self,
        motions: &[Motion],
        samples: usize,
    ) -> Result<Stream, IdentificationError> {
        self.validate(motions)?;
        let length = motions.iter().map(Motion::samples).sum::<usize>() / motions.len();
        let few: Vec<Motion> = sample(motions.len(), CHOOSING_SAMPLES.div_ceil(length))
            .map(|k| motions[k].clone())
            .collect();
        let data = Data::of(self, &few)?;
        let rows = self.chosen(&data)?.rows;
        let shape = [data.dimension, data.inputs, data.centre.len()];
        let smooth = Smooth::all(motions, &data.channels, &data.rate_noise)?;
        let arguments = |s: &Smooth| arguments_of(s, self.order, shape);
        let all: Vec<f64> = smooth.iter().flat_map(arguments).collect();
        let candidates = thin(&all, shape[2]);
        let seen: usize = few.iter().map(Motion::samples).sum();
        let share = LANDMARK_SHARE * (seen as f64 / samples.max(seen) as f64).sqrt();
        let landmarks = rows.iter().flat_map(|row| {
            row.blocks.iter().enumerate().map(|(b, block)| {
                let left = (share * block.posterior_sd / block.amplitude).powi(2).max(LEAST_LEFT);
                let most = TERM_LIMITS[b.min(1)].min(self.most_landmarks);
                Basis::choose(block.kernel.clone(), &candidates, left, most).landmarks
            })
        });
        let landmarks = landmarks.collect();
        Stream::restore(Saved {
            order: self.order,
            path: self.input_path,
            lambda: self.lambda,
            shape,
            rates: self.order > 1 && data.rate_noise.iter().all(Option::is_some),
            width: width(motions, data.window_seconds),
            window_seconds: data.window_seconds,
            rows,
            landmarks,
            candidates,
            few_candidates: data.few_candidates,
            channels: data.channels,
            rate_noise: data.rate_noise,
        })
    }
}

/// Width of the test functions, in seconds.
fn width(motions: &[Motion], window: f64) -> f64 {
    let duration = |m: &Motion| m.times()[m.samples() - 1] - m.times()[0];
    let shortest = motions.iter().map(duration).fold(f64::INFINITY, f64::min);
    let step = |m: &Motion| duration(m) / (m.samples() - 1) as f64;
    let longest_step = motions.iter().map(step).fold(0.0, f64::max);
    (SHARE * window.min(shortest)).max(FEWEST_STEPS * longest_step)
}

/// x at the samples, N x d.
fn arguments_of(smooth: &Smooth, order: usize, [n, _, d]: [usize; 3]) -> Vec<f64> {
    let states = states_of(smooth, order, n);
    states.chunks_exact(n * order).flat_map(|z| &z[..d]).copied().collect()
}

impl Stream {
    fn restore(saved: Saved) -> Result<Self, IdentificationError> {
        let [n, m, d] = saved.shape;
        let mut landmarks = saved.landmarks.iter();
        let mut terms = Vec::new();
        for (i, row) in saved.rows.iter().enumerate() {
            for (b, block) in row.blocks.iter().enumerate() {
                let points = landmarks.next().cloned().unwrap_or_default();
                let basis = Basis::of_landmarks(block.kernel.clone(), points)
                    .ok_or(IdentificationError::NoEvidence)?;
                terms.push(Term::new(i, b, basis, block.amplitude, &saved.candidates));
            }
        }
        if terms.len() != n * (1 + m) {
            return Err(IdentificationError::OtherStream {
                what: "functions",
                expected: n * (1 + m),
                found: terms.len(),
            });
        }
        Ok(Self { field: Field { dimension: n, arguments: d, terms }, saved })
    }

    /// All that another process needs to make the same sums, as JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string(&self.saved).expect("numbers and strings become JSON")
    }

    /// What [`Stream::to_json`] made.
    ///
    /// # Errors
    /// What is wrong where the text is no JSON of a stream.
    pub fn from_json(text: &str) -> Result<Self, String> {
        let saved: Saved = serde_json::from_str(text).map_err(|error| error.to_string())?;
        Self::restore(saved).map_err(|error| error.to_string())
    }

    /// The sums of no motion.
    pub fn none(&self) -> Sums {
        let columns =
            |i: usize| -> usize { self.terms(i).map(|term| term.basis.rank()).sum::<usize>() };
        let rows = (0..self.field.dimension).map(|i| Normal::new(columns(i))).collect();
        Sums { rows, motions: 0, samples: 0 }
    }

    /// Adds motions, in their order, on one thread.
    ///
    /// # Errors
    /// A motion of another shape than the sample's, one that is too short, and values that are not finite; the sums are
    /// then of no use.
    pub fn add(&self, sums: &mut Sums, motions: &[Motion]) -> Result<(), IdentificationError> {
        let [n, m, _] = self.saved.shape;
        let measured = self.saved.rates || self.saved.rate_noise.iter().any(Option::is_some);
        let other = |motion: &Motion| {
            (motion.dimension(), motion.input_count(), motion.rates().is_some()) != (n, m, measured)
        };
        if let Some(motion) = motions.iter().position(other) {
            return Err(IdentificationError::Shape { motion });
        }
        motions.chunks(GROUP).try_for_each(|group| self.add_group(sums, group))
    }

    fn add_group(&self, sums: &mut Sums, motions: &[Motion]) -> Result<(), IdentificationError> {
        let equations = self.equations(motions)?;
        let right = equations.right_hand_sides().map_err(FitError::from)?;
        for (i, normal) in sums.rows.iter_mut().enumerate() {
            let parts: Vec<Mat<f64>> = self.terms(i).map(|term| design(term, &equations)).collect();
            let mut design = side_by_side(&parts.iter().collect::<Vec<_>>());
            equations.whiten(&mut design).map_err(FitError::from)?;
            normal.add(design.as_ref(), right.col_as_slice(i));
        }
        sums.motions += motions.len();
        sums.samples += motions.iter().map(Motion::samples).sum::<usize>();
        Ok(())
    }

    fn terms(&self, i: usize) -> impl Iterator<Item = &Term> {
        self.field.terms.iter().filter(move |term| term.row == i)
    }

    fn equations(&self, motions: &[Motion]) -> Result<Equations, IdentificationError> {
        let saved = &self.saved;
        let smooth = Smooth::all(motions, &saved.channels, &saved.rate_noise)?;
        let mut equations = Equations::new(saved.shape);
        for (index, (motion, smooth)) in motions.iter().zip(&smooth).enumerate() {
            let regressed = motion.rates().filter(|_| saved.rates).unwrap_or(motion.coordinates());
            let data = TrajectoryData::new(
                motion.times().to_vec(),
                arguments_of(smooth, saved.order, saved.shape),
                at_samples(motion, saved.path),
                regressed.to_vec(),
            )?;
            equations.append(&self.weak_form(motion.times()), index, &data)?;
        }
        Ok(equations)
    }

    /// Measured rates are integrated once, coordinates as often as the order says.
    fn weak_form(&self, times: &[f64]) -> WeakForm {
        let saved = &self.saved;
        let steps = times.len() - 1;
        let duration = times[steps] - times[0];
        let width = saved.width.min(duration);
        let stride = (width / duration * steps as f64 / OVERLAP).round().max(1.0) as usize;
        WeakForm {
            order: if saved.rates { 1 } else { saved.order },
            test_function: TestFunction::Compact { exponent: EXPONENT, width, stride },
            quadrature: Quadrature::Trapezoid,
            initial_derivative: InitialDerivative::default(),
            whiten: true,
        }
    }

    /// The most probable f and g, with their standard deviations.
    ///
    /// # Errors
    /// Sums of nothing or of another stream, and numbers that overflow.
    pub fn solve(&self, sums: &Sums) -> Result<Identified, IdentificationError> {
        self.check(sums)?;
        let saved = &self.saved;
        let mut field = self.field.clone();
        let (mut covariances, mut noise) = (Vec::new(), Vec::new());
        for (i, normal) in sums.rows.iter().enumerate() {
            let found = self.row(i, normal)?;
            let mut coefficients = found.posterior.coefficients.as_slice();
            for term in field.terms.iter_mut().filter(|term| term.row == i) {
                let own;
                (own, coefficients) = coefficients.split_at(term.basis.rank());
                term.amplitude = saved.lambda.map_or(term.amplitude, |l| found.sigma / l.sqrt());
                term.set(own);
            }
            covariances.push(found.posterior.factor.inverse());
            noise.push(found.sigma);
        }
        let covariances: Vec<MatRef<'_, f64>> = covariances.iter().map(Mat::as_ref).collect();
        let model = super::model_of(saved.order, saved.shape, &field, &covariances);
        let coordinates = saved.channels.iter().map(|channel| channel.noise_sd);
        let seen = Seen {
            field: &field,
            candidates: &saved.candidates,
            few_candidates: &saved.few_candidates,
            window_seconds: saved.window_seconds,
            windows: sums.motions,
            samples: sums.samples,
            iterations: 0,
            noise_sd: match saved.rates {
                true => coordinates.chain(noise.iter().copied()).collect(),
                false => noise.clone(),
            },
            equations_sd: &noise,
        };
        let report = Report::of(&seen, &saved.rows, &model);
        Ok(Identified { model, report })
    }

    fn check(&self, sums: &Sums) -> Result<(), IdentificationError> {
        if sums.motions == 0 {
            return Err(IdentificationError::NoMotion);
        }
        self.none().check_like(sums)
    }

    /// Coefficients of a row under the noise that they leave.
    fn row(&self, i: usize, normal: &Normal) -> Result<Row, IdentificationError> {
        let saved = &self.saved;
        let judged = saved.rate_noise[i].filter(|_| saved.rates);
        let mut sigma = judged.unwrap_or(saved.channels[i].noise_sd);
        let least = (ROUNDING * normal.square / normal.equations as f64).sqrt();
        let amplitudes = Term::priors(self.terms(i));
        let free = normal.equations - amplitudes.len().min(normal.equations / 2);
        let mut round = 0;
        loop {
            let prior = match saved.lambda {
                Some(lambda) => vec![sigma / lambda.sqrt(); amplitudes.len()],
                None => amplitudes.clone(),
            };
            let posterior =
                normal.posterior(&prior, sigma).map_err(|_| IdentificationError::NoEvidence)?;
            round += 1;
            if round == ROUNDS {
                return Ok(Row { posterior, sigma });
            }
            let left = normal.left(&posterior.coefficients).max(0.0);
            sigma = (left / free as f64).sqrt().max(least).max(f64::MIN_POSITIVE);
        }
    }
}

struct Row {
    posterior: Posterior,
    sigma: f64,
}

/// int phi_a phi(x) u_b dt of every functional, a row each.
fn design(term: &Term, equations: &Equations) -> Mat<f64> {
    let occupation = &equations.occupation;
    let (m, rank) = (occupation.input_count(), term.basis.rank());
    let mut values = Vec::new();
    term.basis.kernel_values(occupation.arguments(), &mut values);
    let mut rows = vec![0.0; equations.count() * rank];
    let functionals = occupation.functionals().iter();
    for (functional, row) in functionals.zip(rows.chunks_exact_mut(rank.max(1))) {
        for (k, weight) in (functional.first..).zip(&functional.weights) {
            let factor = weight * term.input(&occupation.inputs()[k * m..(k + 1) * m]);
            let values = &values[k * rank..(k + 1) * rank];
            row.iter_mut().zip(values).for_each(|(sum, value)| *sum += factor * value);
        }
    }
    term.basis.to_features(MatRef::from_row_major_slice(&rows, equations.count(), rank))
}

impl Sums {
    /// Adds what others have summed; a sum of sums depends, in its last bits, on the order in which they are added.
    ///
    /// # Errors
    /// Sums of another stream.
    pub fn merge(&mut self, other: &Self) -> Result<(), IdentificationError> {
        self.check_like(other)?;
        self.rows.iter_mut().zip(&other.rows).for_each(|(row, other)| row.merge(other));
        self.motions += other.motions;
        self.samples += other.samples;
        Ok(())
    }

    /// That others are of equations of the same coefficients.
    fn check_like(&self, other: &Self) -> Result<(), IdentificationError> {
        let size = |sums: &Self| sums.rows.iter().map(|row| row.moment.len()).collect::<Vec<_>>();
        let (own, others) = (size(self), size(other));
        if own == others {
            return Ok(());
        }
        let (expected, found) = (own.iter().sum(), others.iter().sum());
        Err(IdentificationError::OtherStream { what: "coefficients", expected, found })
    }

    /// Memory that they take, in bytes.
    pub fn bytes(&self) -> usize {
        let numbers = |row: &Normal| row.moment.len() * (row.moment.len() + 1);
        self.rows.iter().map(numbers).sum::<usize>() * size_of::<f64>()
    }

    /// The sums as bytes, little-endian: numbers of motions, samples and rows, and of each row its [`Normal::write`].
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for count in [self.motions, self.samples, self.rows.len()] {
            bytes.extend((count as u64).to_le_bytes());
        }
        self.rows.iter().for_each(|row| row.write(&mut bytes));
        bytes
    }

    /// What [`Sums::to_bytes`] made.
    ///
    /// # Errors
    /// Bytes that end too soon or too late.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, IdentificationError> {
        let cut = || IdentificationError::NoSums { found: bytes.len() };
        let (head, mut rest) = bytes.split_at_checked(24).ok_or_else(cut)?;
        let counts: Vec<usize> = head
            .as_chunks::<8>()
            .0
            .iter()
            .map(|count| u64::from_le_bytes(*count) as usize)
            .collect();
        let mut rows = Vec::new();
        while !rest.is_empty() {
            let row;
            (row, rest) = Normal::read(rest).ok_or_else(cut)?;
            rows.push(row);
        }
        if rows.len() != counts[2] {
            return Err(cut());
        }
        Ok(Self { rows, motions: counts[0], samples: counts[1] })
    }
}
