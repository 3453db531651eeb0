//! The weak rows of a channel: y_w = int phi_w r dt from the samples, with the covariance of
//! their errors.

use super::along::Along;
use super::windows::{Window, intervals, windows};
use crate::likelihood::Problem;
use lacuna_occupation::{Functional, SymmetricBanded};

/// Most windows of a channel.
const MOST: usize = 3000;
/// Samples in a row that may be missing, as a share of a window.
const GAP: f64 = 0.125;

/// The weak rows of one recording.
pub(super) struct Rows {
    pub windows: Vec<Window>,
    /// int phi r dt, with the parameters as they are believed.
    pub right: Vec<f64>,
    /// What a unit of each uncertain parameter adds to it, rows x parameters.
    pub by_parameter: Vec<f64>,
    /// Covariance by the noise of the samples.
    pub measured: SymmetricBanded,
    /// Covariance by a white force of density 1.
    pub white: SymmetricBanded,
    /// What the samples of each state that is measured add to the rows, one functional a row.
    pub sensors: Vec<(usize, Vec<Functional>)>,
}

/// What a sensor measures.
#[derive(Clone, Copy, PartialEq)]
enum Seen {
    /// An entry of the machine's state.
    State(usize),
    /// The force on an imposed channel, and by how much the sensor's value changes with a missing
    /// one.
    Force(usize, f64),
}

/// What one sensor measures in one recording.
struct Sensor {
    of: Seen,
    sd: f64,
    /// The samples less the smoothed motion, or what stands in their place in R; not a number
    /// where nothing was measured.
    off: Vec<f64>,
    /// Nearest measured samples at and before, at and after each.
    nearest: [Vec<Option<usize>>; 2],
}

impl Sensor {
    fn all(problem: &Problem, along: &Along) -> Vec<Self> {
        let dataset = problem.dataset;
        let observed = &dataset.recordings[along.recording];
        let states = 0..problem.model.machine_states();
        let sensor = |of: Seen, output: usize, at: &dyn Fn(usize) -> f64| {
            let samples = observed.outputs[output].iter().enumerate();
            let off: Vec<f64> = samples.map(|(k, y)| y - at(k)).collect();
            let nearest = [nearest(off.iter()), {
                let mut back = nearest(off.iter().rev());
                back.reverse();
                let last = off.len() - 1;
                back.into_iter().map(|k| k.map(|k| last - k)).collect()
            }];
            Self { of, sd: dataset.noise_sd(output), off, nearest }
        };
        let position = |state: usize| {
            let output = dataset.output_of_state(state)?;
            Some(sensor(Seen::State(state), output, &|k| along.motion.state(k)[state]))
        };
        let force = |channel: usize| {
            let force = along.measured(channel)?;
            let of = Seen::Force(channel, force.slope);
            Some(sensor(of, force.output, &|k| force.values[k]))
        };
        states.filter_map(position).chain((0..problem.model.channels()).filter_map(force)).collect()
    }

    /// Samples missing in a row about sample `k`.
    fn gap(&self, k: usize) -> usize {
        match [self.nearest[0][k], self.nearest[1][k]] {
            [Some(a), Some(b)] => (b - a).saturating_sub(1),
            _ => usize::MAX,
        }
    }

    /// A functional of all samples as one of the measured ones: what lies between two of them
    /// is on the line that joins them.
    fn of_measured(&self, first: usize, weights: &[f64]) -> Option<Functional> {
        let ends = [first, first + weights.len() - 1];
        let (begin, end) = (self.nearest[0][ends[0]]?, self.nearest[1][ends[1]]?);
        let mut moved = vec![0.0; end + 1 - begin];
        for (k, weight) in (first..).zip(weights) {
            let (a, b) = (self.nearest[0][k]?, self.nearest[1][k]?);
            let share = if a == b { 0.0 } else { (k - a) as f64 / (b - a) as f64 };
            moved[a - begin] += (1.0 - share) * weight;
            moved[b - begin] += share * weight;
        }
        Some(Functional { first: begin, weights: moved })
    }

    /// The functional's value on what the samples are off the smoothed motion.
    fn correction(&self, f: &Functional) -> f64 {
        let off = &self.off[f.first..f.end()];
        f.weights.iter().zip(off).filter(|(_, off)| !off.is_nan()).map(|(w, off)| w * off).sum()
    }
}

/// Index of the last number so far.
fn nearest<'a>(series: impl Iterator<Item = &'a f64>) -> Vec<Option<usize>> {
    let mut last = None;
    let mut at = |(k, value): (usize, &f64)| {
        if !value.is_nan() {
            last = Some(k);
        }
        last
    };
    series.enumerate().map(&mut at).collect()
}

/// Intervals of the windows of a channel.
pub(super) fn window_intervals(problem: &Problem, all: &[Along], channel: usize) -> usize {
    let (model, dataset) = (problem.model, problem.dataset);
    let n = model.coordinates.len();
    let rms = |value: &dyn Fn(&Along, usize) -> f64| {
        let each = all.iter().flat_map(|a| (0..a.motion.len()).map(move |k| (a, k)));
        let (mut sum, mut count) = (0.0, 0.0);
        for (a, k) in each {
            let v = value(a, k);
            if v.is_finite() {
                sum += v * v;
                count += 1.0;
            }
        }
        (sum / f64::max(count, 1.0)).sqrt()
    };
    let sd = |state: usize| dataset.output_of_state(state).map(|o| dataset.noise_sd(o));
    let force = rms(&|a, k| a.inertia(k, channel));
    let step = problem.sample;
    let masses: Vec<f64> = (0..n).map(|j| rms(&|a, k| a.mass(k, channel, j))).collect();
    let noise = |w: &[Vec<f64>; 3]| {
        let size = |d: usize| w[d].iter().map(|w| w * w).sum::<f64>().sqrt() / step.powi(d as i32);
        if channel >= n {
            return sd(channel + n).unwrap_or(0.0) * size(1);
        }
        let of = |j: usize| {
            let position = sd(j).unwrap_or(0.0) * size(2);
            masses[j] * sd(j + n).map_or(position, |sd| position.min(sd * size(1)))
        };
        let force = all[0]
            .measured(channel)
            .map_or(0.0, |force| dataset.noise_sd(force.output) / force.slope.abs() * size(0));
        (0..n).map(|j| of(j).powi(2)).sum::<f64>().sqrt().hypot(force)
    };
    let entry = problem.model.velocity_index(channel);
    let centre = mean(all, |a, k| a.motion.state(k)[entry]);
    let speed = rms(&|a, k| a.motion.state(k)[entry] - centre);
    let change = rms(&|a, k| a.motion.rate(k, entry));
    let half_period = std::f64::consts::PI * speed / change / step;
    let shortest = all.iter().map(|a| a.motion.len()).min().unwrap_or(0);
    let most = if half_period.is_finite() { half_period as usize } else { usize::MAX };
    intervals(noise, force, most.min(shortest / 6))
}

fn mean(all: &[Along], value: impl Fn(&Along, usize) -> f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for a in all {
        for k in 0..a.motion.len() {
            sum += value(a, k);
            count += 1.0;
        }
    }
    sum / f64::max(count, 1.0)
}

impl Rows {
    /// The rows of `channel` in one recording of `samples` in all, by windows of so many
    /// intervals; none where there is none or their covariance cannot be computed.
    pub(super) fn new(
        problem: &Problem,
        along: &Along,
        channel: usize,
        (intervals, samples): (usize, usize),
        parameters: usize,
    ) -> Option<Self> {
        let motion = along.motion;
        let sensors: Vec<Sensor> = Sensor::all(problem, along)
            .into_iter()
            .filter(|s| matters(problem, along, channel, s.of))
            .collect();
        let most = MOST * motion.len() / samples;
        let wide = ((GAP * intervals as f64) as usize).max(1);
        let all = windows(&motion.times, intervals, most, |k| {
            sensors.iter().any(|s| s.gap(k) > wide) || !along.residual(k, channel).is_finite()
        });
        let mut this = Self {
            windows: vec![],
            right: vec![],
            by_parameter: vec![],
            measured: SymmetricBanded::zeros(0, 0),
            white: SymmetricBanded::zeros(0, 0),
            sensors: vec![],
        };
        let mut noise: Vec<Vec<Functional>> = vec![vec![]; sensors.len()];
        let mut plain = Vec::new();
        let n = problem.model.coordinates.len();
        for window in all {
            let functionals = functionals(along, channel, n, &sensors, &window);
            let Some(functionals) = functionals else { continue };
            let mut right = mean_force(along, channel, problem.sample, &window);
            for ((sensor, f), all) in sensors.iter().zip(functionals).zip(&mut noise) {
                right += sensor.correction(&f);
                all.push(f);
            }
            let mut by = vec![0.0; parameters];
            for (k, w) in (window.first..).zip(&window.weights[0]) {
                for (by, slope) in by.iter_mut().zip(along.by_parameters(k, channel)) {
                    *by += w * slope;
                }
            }
            this.right.push(right);
            this.by_parameter.extend(by);
            plain.push(Functional { first: window.first, weights: window.weights[0].clone() });
            this.windows.push(window);
        }
        let step = problem.sample;
        let nothing = SymmetricBanded::zeros(plain.len(), 0);
        this.white = nothing.plus(&SymmetricBanded::covariance(&plain).ok()?, 1.0 / step).ok()?;
        this.measured = nothing;
        for (sensor, functionals) in sensors.iter().zip(&noise) {
            let own = SymmetricBanded::covariance(functionals).ok()?;
            this.measured = this.measured.plus(&own, sensor.sd * sensor.sd).ok()?;
        }
        this.sensors = sensors
            .iter()
            .zip(noise)
            .filter_map(|(sensor, functionals)| match sensor.of {
                Seen::State(state) => Some((state, functionals)),
                Seen::Force(..) => None,
            })
            .collect();
        (!this.windows.is_empty()).then_some(this)
    }
}

/// Whether the residual of a channel moves with what a sensor measures.
fn matters(problem: &Problem, along: &Along, channel: usize, of: Seen) -> bool {
    let state = match of {
        Seen::State(state) => state,
        Seen::Force(on, _) => return on == channel,
    };
    let n = problem.model.coordinates.len();
    let coordinate = if (n..2 * n).contains(&state) { state - n } else { state };
    let at = |k: usize| {
        along.by_state(k, channel, state) != 0.0
            || problem.model.coordinate_index(channel) == coordinate
            || (coordinate < n
                && (along.mass(k, channel, coordinate) != 0.0
                    || along.by_state(k, channel, coordinate + n) != 0.0))
    };
    (0..along.motion.len()).any(at)
}

/// int phi R dt along the smoothed motion, inputs held or along straight lines.
fn mean_force(along: &Along, channel: usize, step: f64, window: &Window) -> f64 {
    let [plain, slope, _] = &window.weights;
    let rows = (window.first..).zip(plain.iter().zip(slope));
    // The corrected trapezoid sum of an integrand that jumps at samples.
    rows.map(|(k, (w, s))| {
        w * along.residual(k, channel) + step / 12.0 * s * along.jump(k, channel)
    })
    .sum()
}

/// What the samples' errors add to a row, to first order: one functional a sensor.
///
/// ```text
/// int phi (R(x) - R(x^)) dt = int [(phi M)'' + phi R_q - (phi R_v)'] (q - q^) dt      (coordinates)
///                           = int [-phi' + phi R_h] (h - h^) dt                       (its own state)
///                           = int phi / (dh/dr) (y - y^) dt                           (a measured force)
/// ```
fn functionals(
    along: &Along,
    channel: usize,
    n: usize,
    sensors: &[Sensor],
    window: &Window,
) -> Option<Vec<Functional>> {
    let (first, len) = (window.first, window.weights[0].len());
    let samples = first..first + len;
    let [plain, slope, curvature] = &window.weights;
    let by = |state: usize| -> Vec<f64> {
        samples.clone().zip(plain).map(|(k, w)| w * along.by_state(k, channel, state)).collect()
    };
    let weights = |sensor: &Sensor| -> Vec<f64> {
        let state = match sensor.of {
            Seen::State(state) => state,
            Seen::Force(_, slope) => return plain.iter().map(|w| w / slope).collect(),
        };
        let share = share_of_rate(sensors, n, window, state);
        if state >= 2 * n {
            let own = if channel + n == state { 1.0 } else { 0.0 };
            return by(state).iter().zip(slope).map(|(b, s)| b - own * s).collect();
        }
        if state >= n {
            // -(phi M)' + phi R_v on the rate.
            let j = state - n;
            let mass = Inertia::of(along, channel, j, samples.clone());
            let each = by(state).into_iter().zip(plain.iter().zip(slope)).enumerate();
            let moved = |(i, (b, (p, s))): (usize, (f64, (&f64, &f64)))| {
                share * (b - s * mass.value[i] - p * mass.rate(i))
            };
            return each.map(moved).collect();
        }
        let mass = Inertia::of(along, channel, state, samples.clone());
        let rate = difference(along, &samples, &by(state + n));
        let direct = by(state);
        let at = |i: usize| {
            let inertia = curvature[i] * mass.value[i]
                + 2.0 * slope[i] * mass.rate(i)
                + plain[i] * mass.curvature(i);
            direct[i] + (1.0 - share) * (inertia - rate[i])
        };
        (0..len).map(at).collect()
    };
    sensors.iter().map(|s| s.of_measured(first, &weights(s))).collect()
}

/// Share of what moves with a coordinate's rate that is read off its rate sensor: by their
/// variances.
fn share_of_rate(sensors: &[Sensor], n: usize, window: &Window, state: usize) -> f64 {
    let j = if (n..2 * n).contains(&state) { state - n } else { state };
    let sd = |state: usize| sensors.iter().find(|s| s.of == Seen::State(state)).map(|s| s.sd);
    let size = |d: usize| window.weights[d].iter().map(|w| w * w).sum::<f64>();
    match (sd(j), sd(j + n)) {
        (Some(position), Some(rate)) if j < n => {
            let (p, r) = (position * position * size(2), rate * rate * size(1));
            p / (p + r)
        }
        _ => 0.0,
    }
}

/// An entry of the mass matrix over a window.
struct Inertia {
    value: Vec<f64>,
    step: f64,
}

impl Inertia {
    fn of(along: &Along, channel: usize, j: usize, samples: std::ops::Range<usize>) -> Self {
        let times = &along.motion.times;
        let step = (times[samples.end - 1] - times[samples.start]) / (samples.len() - 1) as f64;
        Self { value: samples.map(|k| along.mass(k, channel, j)).collect(), step }
    }

    /// Neighbours of an entry within the window.
    fn about(&self, i: usize) -> [f64; 3] {
        let i = i.clamp(1, self.value.len() - 2);
        [self.value[i - 1], self.value[i], self.value[i + 1]]
    }

    fn rate(&self, i: usize) -> f64 {
        let [before, _, after] = self.about(i);
        (after - before) / (2.0 * self.step)
    }

    fn curvature(&self, i: usize) -> f64 {
        let [before, here, after] = self.about(i);
        (before - 2.0 * here + after) / (self.step * self.step)
    }
}

/// Derivative in time of a series over a window, which vanishes at both ends.
fn difference(along: &Along, samples: &std::ops::Range<usize>, series: &[f64]) -> Vec<f64> {
    let last = series.len() - 1;
    let times = &along.motion.times[samples.clone()];
    let at = |i: usize| {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
        (series[b] - series[a]) / (times[b] - times[a]) * 0.5 * (b - a) as f64
    };
    (0..=last).map(at).collect()
}
