//! Models: what is believed of a machine. The names, units and tolerances of what its
//! [`Dynamics`] depend on, the effects of the catalogue that act on it, and what recordings of
//! it measure. Read from a text file ([`Model::read`]), or built ([`Model::builder`]).

mod builder;
mod error;
mod force;
mod mass;
mod name;
mod observation;
mod parameter;
mod read;
mod robot;
mod series;
mod servos;
mod steep;
mod structure;
mod system;
mod together;
mod units;
mod write;

pub use crate::input::StepInput;
pub use builder::{BuildError, Builder};
pub use error::{ModelError, Place};
pub use name::NameError;
pub use observation::Observation;
pub use parameter::{Parameter, Uncertainty, UncertaintyError};
pub use robot::{BodyParameters, RobotFile};
pub use series::{SeriesEffect, effective_inputs, sensed};
pub use servos::Servos;
pub use system::{Direction, Step, System, Workspace};
pub use together::{Strand, advance_together};
pub use units::{SaidUnit, same_unit};
pub use write::{Augmentation, NewEffect, quoted};

use crate::Hold;
use crate::dynamics::{Dynamics, Mass};
use crate::expression::FORCE_ON;
use crate::input::{InputPath, MOTION};
use lacuna_effects::{Channel, Effect, Law, Variable};
use lacuna_numbers::Number;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

/// What is believed of a machine.
#[derive(Clone, Debug)]
pub struct Model {
    /// The model's name.
    pub name: String,
    /// Parameters, in the file's order.
    pub parameters: Vec<Parameter>,
    /// Inputs.
    pub inputs: Vec<RecordedInput>,
    /// Second-order coordinates.
    pub coordinates: Vec<Coordinate>,
    /// First-order states.
    pub states: Vec<Quantity>,
    /// Effects written in the file, as found by a diagnosis or by hand.
    pub effects: Vec<ModelEffect>,
    /// What the recordings measure; empty: columns carry the names of channels.
    pub measurements: Vec<Measurement>,
    /// Column of time in the recordings.
    pub time_column: String,
    /// Seconds in one unit of the numbers of that column.
    pub time_seconds: f64,
    /// What the inputs do between samples.
    pub hold: Hold,
    /// What was assumed where the file does not say enough, in sentences.
    pub assumptions: Vec<String>,
    dynamics: Arc<dyn Dynamics>,
    /// What it was read from, if it was.
    source: Option<Arc<Source>>,
}

/// The text of a model file, as it was read.
#[derive(Debug)]
struct Source {
    file: String,
    text: String,
    /// The robot's own file, where the model names one.
    robot: Option<RobotFile>,
    /// The FMU, where the model names one.
    fmu: Option<PathBuf>,
    /// Whether the text says no more than the robot's own file, which was read in its place.
    alone: bool,
}

/// A recorded signal that drives the machine.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedInput {
    /// Its name.
    pub name: String,
    /// Its unit, as written.
    pub unit: String,
    /// Whether an actuator stands between the recorded signal and the machine, so that effects on
    /// inputs (a dead zone, a delay) can act there. None does where the signal is a computed
    /// torque, a reference or a measured disturbance.
    pub actuator: bool,
    /// Standard deviation of what was recorded about what the machine got, each sample apart, in
    /// the input's unit, where it is known; 0: the machine got exactly this.
    pub noise: Option<f64>,
}

impl RecordedInput {
    /// A command to an actuator, of whose noise nothing is known.
    #[must_use]
    pub fn new(name: &str, unit: &str) -> Self {
        Self { name: name.to_owned(), unit: unit.to_owned(), actuator: true, noise: None }
    }

    /// Whether the noise that is stated can be: a finite standard deviation, 0 or more.
    pub(crate) fn has_possible_noise(&self) -> bool {
        self.noise.is_none_or(|std| std >= 0.0 && std.is_finite())
    }
}

/// A named quantity with its unit: a first-order state.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// Its name.
    pub name: String,
    /// Its unit, as written.
    pub unit: String,
}

/// A second-order coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Coordinate {
    /// Its name.
    pub name: String,
    /// Name of its velocity.
    pub velocity: String,
    /// Its unit, as written.
    pub unit: String,
    /// Unit of its generalised force, where the model states it ([`Model::force_unit`]).
    pub force_unit: Option<String>,
    /// Whether its motion is imposed from outside ([`Model::imposed`]).
    pub imposed: bool,
}

/// An effect of the catalogue in this model.
#[derive(Clone, Debug)]
pub struct ModelEffect {
    /// The catalogue's entry.
    pub effect: &'static Effect,
    /// Index of the channel it acts on: a force channel, an input, a state of the machine or a link of
    /// a robot, whichever [`Law`] it has.
    pub channel: usize,
    /// The other force channel of a coupling, or the input that a force law depends on.
    pub other: Option<usize>,
    /// Physical values of the parameters, in the catalogue's order ([`Effect::values`]).
    pub parameters: Vec<f64>,
    /// Their standard deviations, where the file gives them.
    pub std: Vec<Option<f64>>,
}

impl ModelEffect {
    /// What it depends on: of a curve, the variable that it is over.
    #[must_use]
    pub fn depends_on(&self) -> &'static [Variable] {
        self.effect.variables(&self.parameters)
    }

    /// The variable that a curve is over; none for a formula.
    #[must_use]
    pub fn over(&self) -> Option<Variable> {
        self.effect.over(&self.parameters)
    }
}

/// What a column of the recordings measures.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// The column.
    pub column: String,
    /// Unit of the column; empty: that of the quantity.
    pub unit: String,
    /// What it measures.
    pub of: Measured,
    /// The text after `of =`.
    pub text: String,
}

/// What a column can measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measured {
    /// An entry of the machine's state: coordinates, then velocities, then first-order states.
    State(usize),
    /// An input.
    Input(usize),
    /// The force on an imposed coordinate ([`Model::imposed`]).
    Force(usize),
    /// An output of the dynamics' own ([`Dynamics::outputs`]): in a model file, an expression.
    Output(usize),
}

impl Model {
    /// What simulates it.
    #[must_use]
    pub fn dynamics(&self) -> &dyn Dynamics {
        &*self.dynamics
    }

    /// Whether it was read from a text, which says all of it.
    #[must_use]
    pub fn is_text(&self) -> bool {
        self.source.is_some()
    }

    /// Number of force channels: coordinates, then first-order states.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.coordinates.len() + self.states.len()
    }

    /// Length of the machine's state (effects' memory apart): coordinates, velocities, states.
    #[must_use]
    pub fn machine_states(&self) -> usize {
        2 * self.coordinates.len() + self.states.len()
    }

    /// Coordinates whose motion is imposed: an actuator moves them along a recorded path with
    /// whatever force f that takes, as a test rig moves a damper. With the other coordinates,
    ///
    /// ```text
    /// M q'' = F + r + f
    /// ```
    ///
    /// where f is 0 on a coordinate that is free. On an imposed one q, q' and q'' are known, and
    /// what the model says is f, "force on q": positive where it pushes towards larger q, so that
    /// a spring is held at q > 0 by a positive force. `-force on q` is what the machine does to its
    /// actuator.
    pub fn imposed(&self) -> impl Iterator<Item = usize> + '_ {
        self.coordinates.iter().enumerate().filter(|(_, c)| c.imposed).map(|(i, _)| i)
    }

    /// The inputs that an actuator makes: what is commanded, and not a measured disturbance.
    pub fn actuators(&self) -> impl Iterator<Item = usize> + '_ {
        self.inputs.iter().enumerate().filter(|(_, input)| input.actuator).map(|(j, _)| j)
    }

    /// Whether a force channel is a coordinate whose motion is imposed.
    #[must_use]
    pub fn is_imposed(&self, channel: usize) -> bool {
        self.coordinates.get(channel).is_some_and(|c| c.imposed)
    }

    /// Whether an entry of the machine's state is the position or velocity of an imposed
    /// coordinate.
    #[must_use]
    pub fn is_imposed_state(&self, index: usize) -> bool {
        let n = self.coordinates.len();
        index < 2 * n && self.is_imposed(index % n)
    }

    /// Length of a row of inputs: the inputs, then position, velocity and acceleration of each
    /// imposed coordinate.
    #[must_use]
    pub fn input_width(&self) -> usize {
        self.inputs.len() + MOTION * self.imposed().count()
    }

    /// Where the motion of an imposed coordinate begins in a row of inputs; none of a free one.
    #[must_use]
    pub fn motion_index(&self, coordinate: usize) -> Option<usize> {
        let place = self.imposed().position(|c| c == coordinate)?;
        Some(self.inputs.len() + MOTION * place)
    }

    /// Sampled rows of inputs along the steps between the samples of a range, each taken in
    /// `substeps` Runge-Kutta steps.
    #[must_use]
    pub fn inputs_along<'s, T: Number>(
        &self,
        series: (&[f64], &'s [T]),
        range: Range<usize>,
        substeps: usize,
    ) -> InputPath<'s, T> {
        let width = (self.inputs.len(), self.imposed().count());
        self.hold.along_motion(series, range, width, substeps)
    }

    /// Name of a force channel.
    #[must_use]
    pub fn channel_name(&self, channel: usize) -> &str {
        match self.coordinates.get(channel) {
            Some(coordinate) => &coordinate.name,
            None => &self.states[channel - self.coordinates.len()].name,
        }
    }

    /// Whether a force channel is a second-order coordinate.
    #[must_use]
    pub fn is_coordinate(&self, channel: usize) -> bool {
        channel < self.coordinates.len()
    }

    /// Whether something on a channel may rub: a coordinate does, and a first-order state that is a speed,
    /// or of whose unit nothing is known. A level, a temperature or a current has no direction of motion.
    #[must_use]
    pub fn may_rub(&self, channel: usize) -> bool {
        self.is_coordinate(channel)
            || units::may_be_speed(&self.states[channel - self.coordinates.len()].unit)
    }

    /// Index in the machine's state of a channel's coordinate or first-order state.
    #[must_use]
    pub fn coordinate_index(&self, channel: usize) -> usize {
        if self.is_coordinate(channel) { channel } else { channel + self.coordinates.len() }
    }

    /// Index in the machine's state of a channel's velocity; a first-order state is its own,
    /// see [`lacuna_effects::Channel`].
    #[must_use]
    pub fn velocity_index(&self, channel: usize) -> usize {
        channel + self.coordinates.len()
    }

    /// Where a channel's coordinate and velocity stand in the machine's state.
    #[must_use]
    pub fn place(&self, channel: usize) -> Channel {
        let (q, v) = (self.coordinate_index(channel), self.velocity_index(channel));
        let si = self.coordinates.get(channel).map_or(1.0, |c| units::si(&c.unit));
        Channel { q, v, si }
    }

    /// The places of the channel of a force effect and of the other one, or the input, that it names.
    #[must_use]
    pub fn places(&self, effect: &Effect, channel: usize, other: Option<usize>) -> Vec<Channel> {
        let of_other = |o| if effect.names_input() { Channel::input(o) } else { self.place(o) };
        std::iter::once(self.place(channel)).chain(other.map(of_other)).collect()
    }

    /// What measurements call the force on a coordinate.
    #[must_use]
    pub fn force_name(&self, coordinate: usize) -> String {
        format!("{FORCE_ON}{}", self.channel_name(coordinate))
    }

    /// Name of an entry of the machine's state.
    #[must_use]
    pub fn state_name(&self, index: usize) -> &str {
        let n = self.coordinates.len();
        match index {
            i if i < n => &self.coordinates[i].name,
            i if i < 2 * n => &self.coordinates[i - n].velocity,
            i => &self.states[i - 2 * n].name,
        }
    }

    /// Unit of an entry of the machine's state.
    #[must_use]
    pub fn state_unit(&self, index: usize) -> String {
        let n = self.coordinates.len();
        match index {
            i if i < n => self.coordinates[i].unit.clone(),
            i if i < 2 * n => units::per_second(&self.coordinates[i - n].unit),
            i => self.states[i - 2 * n].unit.clone(),
        }
    }

    /// Unit in which the values of a column of the recordings are taken: that of its measurement, or of
    /// the channel or input of its name; none where it is neither.
    #[must_use]
    pub fn column_unit(&self, column: &str) -> Option<String> {
        let of = |measured| match measured {
            Measured::State(i) => self.state_unit(i),
            Measured::Input(j) => self.inputs[j].unit.clone(),
            Measured::Force(c) => self.force_unit(c),
            Measured::Output(_) => String::new(),
        };
        if let Some(m) = self.measurements.iter().find(|m| m.column == column) {
            return Some(if m.unit.is_empty() { of(m.of) } else { m.unit.clone() });
        }
        let state = (0..self.machine_states()).find(|&i| self.state_name(i) == column);
        let input = || self.inputs.iter().position(|i| i.name == column);
        state.map(Measured::State).or_else(|| input().map(Measured::Input)).map(of)
    }

    /// Name of a variable of a force channel; a first-order state has no velocity, and of
    /// another channel nothing is known here.
    #[must_use]
    pub fn variable_name(&self, channel: usize, variable: Variable) -> Option<&str> {
        match variable {
            Variable::Coordinate => Some(self.channel_name(channel)),
            Variable::Velocity => self.coordinates.get(channel).map(|c| c.velocity.as_str()),
            Variable::Time => Some(&self.time_column),
            Variable::Acceleration
            | Variable::OtherCoordinate
            | Variable::OtherVelocity
            | Variable::Input
            | Variable::OtherInput => None,
        }
    }

    /// Name of what an effect acts on.
    #[must_use]
    pub fn effect_channel_name(&self, effect: &Effect, channel: usize) -> &str {
        match effect.law {
            Law::Force(_) => self.channel_name(channel),
            Law::Input(_) => &self.inputs[channel].name,
            Law::Sensor(_) => self.state_name(channel),
            Law::Structure(_) => self.structures(effect).get(channel).copied().unwrap_or_default(),
        }
    }

    /// Whether the mass matrix cannot be solved where all coordinates are 0. A mass may be an input
    /// (a recorded payload): only what is singular whatever the inputs is a mistake. Elsewhere the
    /// matrix may be undefined for other reasons: nothing but a vanishing determinant is its fault.
    fn is_singular_at_rest(&self) -> bool {
        if self.dynamics.mass() == Mass::Unit || self.coordinates.is_empty() {
            return false;
        }
        let system = System::new(self);
        let rest = system.at_rest(&vec![0.0; self.machine_states()]);
        // Numbers that no mass matrix makes vanish by chance.
        let driven = (0..self.inputs.len()).map(|j| 1.0 + 0.618 * (j + 1) as f64).collect();
        let inputs = [vec![0.0; self.inputs.len()], driven];
        inputs.iter().all(|u| system.mass_determinant(&rest, u) == 0.0)
    }

    /// Name of the other channel, or of the input, that a force effect names.
    #[must_use]
    pub fn effect_other_name(&self, effect: &Effect, other: usize) -> &str {
        if effect.names_input() { &self.inputs[other].name } else { self.channel_name(other) }
    }

    /// Nominal parameter values.
    #[must_use]
    pub fn values(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.value).collect()
    }

    /// The effective inputs (row-major, as `commands`, with imposed motion) after the input effects of this model.
    #[must_use]
    pub fn effective_inputs(&self, times: &[f64], commands: &[f64]) -> Vec<f64> {
        let effects = SeriesEffect::inputs(self, &self.effects);
        effective_inputs(&effects, self.input_width(), times, commands.to_vec())
    }

    /// What the sensors make of an entry of the machine's state.
    #[must_use]
    pub fn observed(&self, state: usize, times: &[f64], truth: Vec<f64>) -> Vec<f64> {
        sensed(&SeriesEffect::sensors(&self.effects), state, times, truth)
    }
}
