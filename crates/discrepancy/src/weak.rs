//! The whitened weak residual in force coordinates.
//!
//! With a test function phi that vanishes at both ends of its window,
//!
//! ```text
//! R_a = int phi_a (M q'' - F) dt = - int phi_a' M q' dt - int phi_a (M' q' + F) dt
//! ```
//!
//! is the missing generalised force seen through phi_a, without a second derivative of any
//! measurement. The smoothed motion enters the right-hand side; what the smoothing took away
//! is added back by `int phi_a'' M (measured - smoothed) dt`, so that the leading term is
//! that of the raw samples and its noise is known exactly:
//!
//! ```text
//! M^-1 R has covariance sigma^2 sum_k phi_a''(k) phi_b''(k) + tau^2 int phi_a phi_b dt
//! ```
//!
//! with tau a white force that stands for everything neither model nor noise explains
//! (errors in the arguments of F, physics not yet named); it is estimated.

use crate::DiagnoseError;
use crate::dataset::Dataset;
use crate::trajectories::SmoothedRecording;
use lacuna_occupation::{BandedCholesky, Functional, Quadrature, SymmetricBanded, TestFunction};
use lacuna_plants::expression::Bound;
use lacuna_plants::model::Equations;
use lacuna_plants::{Hold, Model};
use nalgebra::DMatrix;

/// A vector of the weak regression: recording after recording, channel after channel,
/// window after window, in the units of whitened accelerations.
pub type Column = Vec<f64>;

/// The weak form of a model on recordings.
pub struct WeakForm<'a> {
    model: &'a Model,
    equations: Equations,
    recordings: Vec<WeakRecording>,
    /// Channels whose equation of motion is used: those that are measured.
    channels: Vec<usize>,
    noise_sd: Vec<f64>,
}

struct WeakRecording {
    smoothed: SmoothedRecording,
    /// Functionals of phi, phi' and phi''.
    functionals: [Vec<Functional>; 3],
    /// Unit noise covariances of second-order and first-order rows, and of a white force.
    noise: [SymmetricBanded; 2],
    force: SymmetricBanded,
    /// Mean sample step: a white force of unit density has variance 1/step on samples.
    step: f64,
}

/// Exponent of the test functions.
const EXPONENT: u32 = 4;
/// Windows begin this many times a window's width.
const OVERLAP: usize = 6;
/// Fewest samples in a window.
const FEWEST: usize = 16;

impl<'a> WeakForm<'a> {
    /// Smooth the recordings and set up windows of about `width` seconds.
    ///
    /// # Errors
    /// [`DiagnoseError`] for channels that cannot be smoothed or windows that do not fit.
    pub fn new(model: &'a Model, dataset: &Dataset) -> Result<Self, DiagnoseError> {
        let equations = Equations::of(model);
        let smoothed = dataset
            .recordings
            .iter()
            .map(|r| SmoothedRecording::new(model, dataset, r))
            .collect::<Result<Vec<_>, _>>()?;
        let measured = |&c: &usize| dataset.output_of_state(model.coordinate_index(c)).is_some();
        let channels: Vec<usize> = (0..model.channels()).filter(measured).collect();
        let noise_sd = channels
            .iter()
            .map(|&c| dataset.output_of_state(model.coordinate_index(c)))
            .map(|o| dataset.noise_sd(o.expect("the channel is measured")))
            .collect();
        let width = window_width(model, &smoothed, &channels);
        let recordings = smoothed
            .into_iter()
            .zip(&dataset.recordings)
            .map(|(s, o)| WeakRecording::new(s, width, &o.name))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Self { model, equations, recordings, channels, noise_sd })
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &Model {
        self.model
    }

    /// The smoothed recordings.
    pub fn smoothed(&self) -> impl Iterator<Item = &SmoothedRecording> {
        self.recordings.iter().map(|r| &r.smoothed)
    }

    /// Channels whose equation of motion is used.
    #[must_use]
    pub fn channels(&self) -> &[usize] {
        &self.channels
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.recordings.iter().map(|r| r.windows() * self.channels.len()).sum()
    }

    /// Inverse of the mean mass matrix. It turns forces into accelerations, whose noise is
    /// known; and it must be that of the very parameters of the residual, or masses, gains
    /// and all other forces could shrink to nothing together and leave no residual at all.
    fn mobility(&self, bound: &Bound) -> DMatrix<f64> {
        let n = self.model.coordinates.len();
        let mut mean = DMatrix::zeros(n, n);
        let mut count = 0.0;
        for r in &self.recordings {
            let s = &r.smoothed;
            for k in (0..s.len()).step_by(s.len().div_ceil(200)) {
                let out = self.evaluate(bound, s, k, &self.commands(s, k));
                mean += DMatrix::from_row_slice(n, n, &out[..n * n]);
                count += 1.0;
            }
        }
        (mean / f64::max(count, 1.0)).try_inverse().unwrap_or_else(|| DMatrix::identity(n, n))
    }

    fn commands(&self, s: &SmoothedRecording, k: usize) -> Vec<f64> {
        let m = self.model.inputs.len();
        s.commands[k * m..(k + 1) * m].to_vec()
    }

    /// Mass matrix and forces at sample `k` under input `u`.
    fn evaluate(&self, bound: &Bound, s: &SmoothedRecording, k: usize, u: &[f64]) -> Vec<f64> {
        self.evaluate_at(bound, s.state(k), u, s.times[k])
    }

    fn evaluate_at(&self, bound: &Bound, state: &[f64], u: &[f64], t: f64) -> Vec<f64> {
        let mut variables = state.to_vec();
        variables.extend_from_slice(u);
        variables.push(t);
        let mut out = vec![0.0; self.equations.outputs()];
        self.equations.evaluate(bound, &variables, &mut out);
        out
    }

    /// The residual under `parameters` and the model's own effects.
    #[must_use]
    pub fn residual(&self, parameters: &[f64]) -> Column {
        let bound = self.equations.bind(parameters);
        self.column(&self.mobility(&bound), |r| self.raw_residual(r, &bound))
    }

    /// Residual of one recording: a vector of windows for each force channel.
    fn raw_residual(&self, r: &WeakRecording, bound: &Bound) -> Vec<Vec<f64>> {
        let s = &r.smoothed;
        let (n, channels, samples) = (self.model.coordinates.len(), self.model.channels(), s.len());
        let m = self.model.inputs.len();
        let effective = self.centred(self.model.effective_inputs(&s.times, &s.commands));
        let mut momentum = vec![vec![0.0; samples]; channels];
        let mut force = self.own_effects(s);
        let mut innovation = vec![vec![0.0; samples]; channels];
        for k in 0..samples {
            let u = &effective[k * m..(k + 1) * m];
            let here = self.evaluate(bound, s, k, u);
            let mass_rate = self.mass_rate(bound, s, k, u);
            let v = &s.state(k)[n..2 * n];
            for i in 0..channels {
                force[i][k] += here[n * n + i];
                if i >= n {
                    momentum[i][k] = s.state(k)[i + n];
                    innovation[i][k] = s.innovations[i][k];
                    continue;
                }
                for j in 0..n {
                    momentum[i][k] += here[i * n + j] * v[j];
                    force[i][k] += mass_rate[i * n + j] * v[j];
                    innovation[i][k] += here[i * n + j] * s.innovations[j][k];
                }
            }
        }
        let [phi, slope, curvature] = &r.functionals;
        (0..channels)
            .map(|i| {
                (0..r.windows())
                    .map(|a| {
                        let smooth = -slope[a].apply(&momentum[i]) - phi[a].apply(&force[i]);
                        let raw = if i < n {
                            curvature[a].apply(&innovation[i])
                        } else {
                            -slope[a].apply(&innovation[i])
                        };
                        smooth + raw
                    })
                    .collect()
            })
            .collect()
    }

    /// A held input as quadrature on the samples must see it: half a step around each sample
    /// belongs to the value before it. Without this every held input looks half a step early.
    fn centred(&self, mut inputs: Vec<f64>) -> Vec<f64> {
        let m = self.model.inputs.len();
        if self.model.hold == Hold::ZeroOrder {
            for k in (m..inputs.len()).rev() {
                inputs[k] = 0.5 * (inputs[k] + inputs[k - m]);
            }
        }
        inputs
    }

    /// Rate of change of the mass matrix along the motion, by a central difference.
    fn mass_rate(&self, bound: &Bound, s: &SmoothedRecording, k: usize, u: &[f64]) -> Vec<f64> {
        const STEP: f64 = 1e-5;
        let n = self.model.coordinates.len();
        let x = s.state(k);
        let moved = |share: f64| {
            let mut state = x.to_vec();
            for i in 0..n {
                state[i] += share * x[n + i];
            }
            self.evaluate_at(bound, &state, u, s.times[k])
        };
        let (ahead, behind) = (moved(STEP), moved(-STEP));
        (0..n * n).map(|e| (ahead[e] - behind[e]) / (2.0 * STEP)).collect()
    }

    /// Forces of the effects that the model has already.
    fn own_effects(&self, s: &SmoothedRecording) -> Vec<Vec<f64>> {
        let mut force = vec![vec![0.0; s.len()]; self.model.channels()];
        for e in &self.model.effects {
            let lacuna_effects::Law::Force(law) = e.effect.law else { continue };
            let internal = law.internal(&e.parameters);
            let (amplitudes, shape) = internal.split_at(law.amplitudes());
            let series = s.basis(law, shape, e.channel, e.other);
            for (amplitude, basis) in amplitudes.iter().zip(series) {
                for (k, b) in basis.iter().enumerate() {
                    force[e.channel][k] += amplitude * b;
                    if let (true, Some(other)) = (law.reacts(), e.other) {
                        force[other][k] -= amplitude * b;
                    }
                }
            }
        }
        force
    }

    /// The column of a force given as one series a recording on `channel`, the opposite on
    /// `reaction`, on the masses that `parameters` give.
    #[must_use]
    pub fn force_column(
        &self,
        parameters: &[f64],
        channel: usize,
        reaction: Option<usize>,
        series: impl Fn(&SmoothedRecording) -> Vec<f64>,
    ) -> Column {
        let mobility = self.mobility(&self.equations.bind(parameters));
        self.column(&mobility, |r| {
            let values = series(&r.smoothed);
            let seen: Vec<f64> = r.functionals[0].iter().map(|f| f.apply(&values)).collect();
            let mut raw = vec![vec![0.0; r.windows()]; self.model.channels()];
            if let Some(other) = reaction {
                raw[other] = seen.iter().map(|v| -v).collect();
            }
            raw[channel] = seen;
            raw
        })
    }

    /// The column of what other inputs change: `F(u') - F(u)` under `parameters`, where
    /// `inputs` gives u' for a recording.
    #[must_use]
    pub fn input_column(
        &self,
        parameters: &[f64],
        inputs: impl Fn(&SmoothedRecording) -> Vec<f64>,
    ) -> Column {
        let bound = self.equations.bind(parameters);
        let (n, m) = (self.model.coordinates.len(), self.model.inputs.len());
        self.column(&self.mobility(&bound), |r| {
            let s = &r.smoothed;
            let other = self.centred(inputs(s));
            let effective = self.centred(self.model.effective_inputs(&s.times, &s.commands));
            let mut change = vec![vec![0.0; s.len()]; self.model.channels()];
            for k in 0..s.len() {
                let range = k * m..(k + 1) * m;
                let with = self.evaluate(&bound, s, k, &other[range.clone()]);
                let without = self.evaluate(&bound, s, k, &effective[range]);
                for (i, series) in change.iter_mut().enumerate() {
                    series[k] = with[n * n + i] - without[n * n + i];
                }
            }
            change.iter().map(|c| r.functionals[0].iter().map(|f| f.apply(c)).collect()).collect()
        })
    }

    /// The columns of the parameters with a tolerance: what a unit of each adds to the
    /// explained force, about `parameters`.
    #[must_use]
    pub fn parameter_columns(&self, parameters: &[f64]) -> Vec<(usize, Column)> {
        let free = (0..parameters.len()).filter(|&k| self.model.parameters[k].std() > 0.0);
        free.map(|k| {
            let h = 1e-4 * self.model.parameters[k].std();
            let moved = |sign: f64| {
                let mut p = parameters.to_vec();
                p[k] += sign * h;
                self.residual(&p)
            };
            let (up, down) = (moved(1.0), moved(-1.0));
            let column = up.iter().zip(&down).map(|(u, d)| -(u - d) / (2.0 * h)).collect();
            (k, column)
        })
        .collect()
    }

    /// Assemble a column from what each recording shows on every force channel: turned to
    /// accelerations, in units of the channel's noise.
    fn column(
        &self,
        mobility: &DMatrix<f64>,
        raw: impl Fn(&WeakRecording) -> Vec<Vec<f64>>,
    ) -> Column {
        let n = self.model.coordinates.len();
        let mut out = Vec::with_capacity(self.rows());
        for r in &self.recordings {
            let raw = raw(r);
            for (&c, sd) in self.channels.iter().zip(&self.noise_sd) {
                if c < n {
                    out.extend((0..r.windows()).map(|a| {
                        let sum: f64 = (0..n).map(|j| mobility[(c, j)] * raw[j][a]).sum();
                        sum / sd
                    }));
                } else {
                    out.extend(raw[c].iter().map(|v| v / sd));
                }
            }
        }
        out
    }

    /// The whitener for white forces of standard deviations `tau`, one a used channel, in
    /// units of the channel's noise.
    ///
    /// # Errors
    /// [`DiagnoseError::Weak`] when a covariance cannot be factored.
    pub fn whitener(&self, tau: &[f64]) -> Result<Whitener, DiagnoseError> {
        let n = self.model.coordinates.len();
        let mut factors = Vec::new();
        for r in &self.recordings {
            for (&c, tau) in self.channels.iter().zip(tau) {
                let noise = &r.noise[usize::from(c >= n)];
                let mut covariance = noise.plus(&r.force, tau * tau / r.step).map_err(weak)?;
                let ridge = BandedCholesky::RELATIVE_RIDGE * covariance.largest_diagonal();
                covariance.add_diagonal(ridge);
                factors.push(covariance.cholesky().map_err(weak)?);
            }
        }
        Ok(Whitener { factors })
    }

    /// Rows of a column that belong to each used channel: (channel, rows) in the order of the
    /// column.
    #[must_use]
    pub fn segments(&self) -> Vec<(usize, std::ops::Range<usize>)> {
        let mut at = 0;
        let mut out = Vec::new();
        for r in &self.recordings {
            for &c in &self.channels {
                out.push((c, at..at + r.windows()));
                at += r.windows();
            }
        }
        out
    }
}

fn weak(e: impl std::fmt::Display) -> DiagnoseError {
    DiagnoseError::Weak { reason: e.to_string() }
}

impl WeakRecording {
    fn new(smoothed: SmoothedRecording, width: f64, name: &str) -> Result<Self, DiagnoseError> {
        let times = &smoothed.times;
        let step = (times[times.len() - 1] - times[0]) / (times.len() - 1) as f64;
        let samples = ((width / step).round() as usize).clamp(FEWEST, times.len() / 4);
        let test = TestFunction::Compact {
            exponent: EXPONENT,
            width: samples as f64 * step,
            stride: (samples / OVERLAP).max(1),
        };
        let functionals = |derivative| {
            test.functionals(times, Quadrature::Trapezoid, derivative)
                .map_err(|e| DiagnoseError::Weak { reason: format!("{name}: {e}") })
        };
        let functionals = [functionals(0)?, functionals(1)?, functionals(2)?];
        let covariance = |k: usize| SymmetricBanded::covariance(&functionals[k]).map_err(weak);
        let noise = [covariance(2)?, covariance(1)?];
        let force = covariance(0)?;
        Ok(Self { functionals, noise, force, step, smoothed })
    }

    fn windows(&self) -> usize {
        self.functionals[0].len()
    }
}

/// Width of the windows: a third of the fastest channel's typical time, so that windows see
/// within a swing and not across several.
fn window_width(model: &Model, smoothed: &[SmoothedRecording], channels: &[usize]) -> f64 {
    let n = model.coordinates.len();
    let typical = |c: usize| {
        let (mut slow, mut fast) = (0.0, 0.0);
        for s in smoothed {
            // A level's mean is no motion.
            let level = |k: usize| s.state(k)[c + n];
            let mean = (0..s.len()).map(level).sum::<f64>() / s.len() as f64;
            for k in 1..s.len() {
                if c < n {
                    slow += s.state(k)[n + c].powi(2);
                    fast += s.accelerations[k * n + c].powi(2);
                } else {
                    let dt = s.times[k] - s.times[k - 1];
                    fast += ((level(k) - level(k - 1)) / dt).powi(2);
                    slow += (level(k) - mean).powi(2);
                }
            }
        }
        (slow / f64::max(fast, f64::MIN_POSITIVE)).sqrt()
    };
    const SHARE: f64 = 0.3;
    let fastest = channels.iter().map(|&c| typical(c)).fold(f64::INFINITY, f64::min);
    SHARE * std::f64::consts::TAU * fastest
}

/// Factors of the noise covariance: one a recording and used channel.
pub struct Whitener {
    factors: Vec<BandedCholesky>,
}

impl Whitener {
    /// `L^-1 column`.
    #[must_use]
    pub fn whiten(&self, column: &[f64]) -> Column {
        let mut out = column.to_vec();
        let mut at = 0;
        for factor in &self.factors {
            let range = at..at + factor.size();
            at = range.end;
            factor.solve_lower_in_place(&mut out[range]).expect("the column has as many rows");
        }
        out
    }

    /// Log determinant of the covariance.
    #[must_use]
    pub fn log_determinant(&self) -> f64 {
        let log = |f: &BandedCholesky| (0..f.size()).map(|a| f.get(a, a).ln()).sum::<f64>();
        2.0 * self.factors.iter().map(log).sum::<f64>()
    }
}
