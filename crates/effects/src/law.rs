//! What an effect is: its description and its law.

pub use crate::parameter::{Kind, Parameter, Range};
use crate::{Dimension, Prior};

/// One entry of the catalogue.
#[derive(Debug)]
pub struct Effect {
    /// Name in model files and findings.
    pub class: &'static str,
    /// In words, for reports.
    pub words: &'static str,
    /// The law as a formula, in the names of the parameters.
    pub formula: &'static str,
    /// Physical parameters, in the order of [`ForceLaw::physical`].
    pub parameters: &'static [Parameter],
    /// What the law depends on; of a curve, what it can be over (see [`Effect::variables`]).
    pub depends_on: &'static [Variable],
    /// Which kind of channel it acts on.
    pub acts: Acts,
    /// The law itself.
    pub law: Law,
}

/// What a law can depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variable {
    /// The channel's coordinate, or first-order state.
    Coordinate,
    /// The channel's velocity.
    Velocity,
    /// The coordinate of the other channel.
    OtherCoordinate,
    /// The velocity of the other channel.
    OtherVelocity,
    /// Time.
    Time,
    /// The input it acts on.
    Input,
}

/// Which channels an effect can act on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acts {
    /// Second-order coordinates.
    Coordinates,
    /// First-order states.
    States,
    /// Both.
    CoordinatesAndStates,
    /// Inputs.
    Inputs,
    /// Measured channels.
    Sensors,
}

/// The law of an effect.
#[derive(Clone, Copy, Debug)]
pub enum Law {
    /// A generalised force.
    Force(&'static dyn ForceLaw),
    /// What the actuator makes of a command.
    Input(&'static dyn InputLaw),
    /// What the sensor makes of a coordinate.
    Sensor(&'static dyn SensorLaw),
}

/// Where and when a force law is evaluated. On a first-order state `v` is the state itself,
/// so that friction laws act on it as loss laws.
#[derive(Clone, Copy, Debug, Default)]
pub struct Local {
    /// Time (s).
    pub t: f64,
    /// Coordinate of the channel.
    pub q: f64,
    /// Velocity of the channel.
    pub v: f64,
    /// Coordinate of the other channel, for couplings.
    pub other_q: f64,
    /// Velocity of the other channel, for couplings.
    pub other_v: f64,
}

/// Magnitudes of a channel in the recordings: what priors and grids of shapes are spread over.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scales {
    /// Smallest and largest coordinate.
    pub q: (f64, f64),
    /// Half the range that the coordinate usually covers within an eighth of a recording.
    pub stroke: f64,
    /// Standard deviation of the velocity.
    pub v: f64,
    /// Standard deviation of the acceleration.
    pub acceleration: f64,
    /// Standard deviation of the force that moves it.
    pub force: f64,
    /// The other channel of a coupling: half its range, its velocity and its force.
    pub other: (f64, f64, f64),
    /// Standard deviation and largest absolute value of the input.
    pub input: (f64, f64),
    /// Mean sample step (s).
    pub step: f64,
    /// Begin and end of the recordings' time (s).
    pub time: (f64, f64),
}

impl Scales {
    /// Half the range of the coordinate.
    #[must_use]
    pub fn half_range(&self) -> f64 {
        0.5 * (self.q.1 - self.q.0)
    }

    /// Middle of the range of the coordinate.
    #[must_use]
    pub fn centre(&self) -> f64 {
        0.5 * (self.q.0 + self.q.1)
    }

    /// Rate at which the channel moves through its range (rad/s).
    #[must_use]
    pub fn rate(&self) -> f64 {
        self.v / self.half_range()
    }

    /// Length of the recordings (s).
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.time.1 - self.time.0
    }
}

/// Most amplitudes of a law: the values of a curve.
pub const MOST_AMPLITUDES: usize = crate::unknown_function::KNOTS;

/// A generalised force, linear in its amplitudes.
pub trait ForceLaw: Sync + std::fmt::Debug {
    /// Number of amplitudes, at most [`MOST_AMPLITUDES`]: the first entries of the internal
    /// parameters.
    fn amplitudes(&self) -> usize {
        1
    }

    /// The force per unit of each amplitude, into `basis` (length [`ForceLaw::amplitudes`]).
    fn basis(&self, shape: &[f64], at: &Local, memory: &[f64], basis: &mut [f64]);

    /// Internal parameters (amplitudes, then shape) of physical ones.
    fn internal(&self, physical: &[f64]) -> Vec<f64> {
        physical.to_vec()
    }

    /// Physical parameters of internal ones.
    fn physical(&self, internal: &[f64]) -> Vec<f64> {
        internal.to_vec()
    }

    /// Shapes to screen on recordings of these scales; one empty shape where the law has none,
    /// and no shape at all where it is not to be screened.
    fn shapes(&self, _scales: &Scales) -> Vec<Vec<f64>> {
        vec![vec![]]
    }

    /// Priors of the internal parameters: amplitudes, then shape.
    fn priors(&self, scales: &Scales) -> Vec<Prior>;

    /// Number of memory states.
    fn memory(&self) -> usize {
        0
    }

    /// How far from rest, as a standard deviation, the memory may begin.
    fn memory_spread(&self, _shape: &[f64], scales: &Scales, spread: &mut [f64]) {
        spread.fill(0.5 * scales.half_range());
    }

    /// Memory at rest at `at`.
    fn memory_at_rest(&self, _at: &Local, memory: &mut [f64]) {
        memory.fill(0.0);
    }

    /// Time derivative of the memory.
    fn memory_rate(&self, _shape: &[f64], _at: &Local, _memory: &[f64], rate: &mut [f64]) {
        rate.fill(0.0);
    }

    /// The smallest change of shape `k` that leaves a trace on samples so far apart; 0 where
    /// any change does.
    fn resolution(&self, _k: usize, _sample: f64) -> f64 {
        0.0
    }

    /// Whether the opposite force acts on the other channel (actio and reactio).
    fn reacts(&self) -> bool {
        false
    }
}

/// What an actuator makes of the commanded series.
pub trait InputLaw: Sync + std::fmt::Debug {
    /// The effective input, held from each sample to the next, of the commanded one.
    /// `times` increase; the effective value is the mean over each step.
    fn transform(&self, parameters: &[f64], times: &[f64], command: &[f64]) -> Vec<f64>;

    /// Parameters to screen.
    fn shapes(&self, scales: &Scales) -> Vec<Vec<f64>>;

    /// Priors of the parameters.
    fn priors(&self, scales: &Scales) -> Vec<Prior>;

    /// Parameters of an actuator that does as it is told.
    fn ideal(&self) -> Vec<f64> {
        vec![0.0]
    }
}

/// What a sensor makes of the true series.
pub trait SensorLaw: Sync + std::fmt::Debug {
    /// The measured series of the true one.
    fn observe(&self, parameters: &[f64], times: &[f64], truth: &[f64]) -> Vec<f64>;

    /// Priors of the parameters.
    fn priors(&self, scales: &Scales) -> Vec<Prior>;

    /// Parameters of a sensor that tells the truth.
    fn ideal(&self) -> Vec<f64> {
        vec![0.0]
    }
}

/// The smooth sign `tanh(v / v_s)` of the friction laws.
pub(crate) fn smooth_sign(v: f64, smoothing_velocity: f64) -> f64 {
    (v / smoothing_velocity).tanh()
}

/// Amplitude, rate and phase of a sine as a sum that is linear in its amplitudes:
/// `A sin(x + p) = A cos(p) sin(x) + A sin(p) cos(x)`.
pub(crate) fn sine_internal(physical: &[f64]) -> Vec<f64> {
    let [amplitude, rate, phase] = physical else { unreachable!("three parameters") };
    vec![amplitude * phase.cos(), amplitude * phase.sin(), *rate]
}

/// The inverse of [`sine_internal`].
pub(crate) fn sine_physical(internal: &[f64]) -> Vec<f64> {
    let [sine, cosine, rate] = internal else { unreachable!("three parameters") };
    vec![sine.hypot(*cosine), *rate, cosine.atan2(*sine)]
}

/// Default of `smoothing_velocity`: sharp for a machine that moves at about one unit a second.
pub(crate) const SMOOTHING_VELOCITY: Parameter =
    Parameter::new("smoothing_velocity", Dimension::VELOCITY, Range::Positive).or(1e-3);

/// Smoothing velocities that are screened.
pub(crate) fn smoothing_velocities(scales: &Scales) -> [f64; 3] {
    [0.01, 0.04, 0.15].map(|share| share * scales.v)
}

/// Prior of a smoothing velocity.
pub(crate) fn smoothing_prior(scales: &Scales) -> Prior {
    Prior::order(0.03 * scales.v, 2.5, (0.003 * scales.v, 0.4 * scales.v))
}

/// Series value `delay` seconds earlier, averaged over each step, for a held series. Before the
/// series its first value was held.
pub(crate) fn delayed(times: &[f64], held: &[f64], delay: f64) -> Vec<f64> {
    let integral = running_integral(times, held);
    let at = |t: f64| {
        let k = times.partition_point(|&s| s <= t).saturating_sub(1);
        integral[k] + held[k] * (t - times[k])
    };
    let last = times.len().saturating_sub(1);
    (0..times.len())
        .map(|k| {
            let (a, b) = match k {
                _ if last == 0 => return held[0],
                _ if k == last => (times[k], 2.0 * times[k] - times[k - 1]),
                _ => (times[k], times[k + 1]),
            };
            // The difference below would be lost in the digits of a long delay.
            if b - delay <= times[0] {
                return held[0];
            }
            (at(b - delay) - at(a - delay)) / (b - a)
        })
        .collect()
}

/// `int_{t_0}^{t_k} held dt` of a held series.
fn running_integral(times: &[f64], held: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let mut out = vec![0.0];
    for (pair, value) in times.windows(2).zip(held) {
        sum += value * (pair[1] - pair[0]);
        out.push(sum);
    }
    out
}
