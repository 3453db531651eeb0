//! What actuators make of commands and sensors of outputs, in any kind of number.

use super::{Direction, Model, ModelEffect};
use lacuna_effects::{AnySeriesLaw, Law, SeriesLawIn};
use lacuna_numbers::{Dual, Number};

/// An input or sensor effect with its parameters set.
#[derive(Clone, Debug)]
pub struct SeriesEffect<T: Number = f64> {
    /// The input, or the entry of the machine's state, that it acts on.
    pub channel: usize,
    law: &'static dyn SeriesLawIn<T>,
    parameters: Vec<T>,
}

/// The law of an effect on the inputs of a model, unless it acts within a servo.
fn input_law(model: &Model, e: &ModelEffect) -> Option<&'static dyn AnySeriesLaw> {
    match e.effect.law {
        Law::Input(law) if model.in_servo(e.effect, e.channel).is_none() => Some(law),
        _ => None,
    }
}

/// The law of an effect on a sensor.
fn sensor_law(e: &ModelEffect) -> Option<&'static dyn AnySeriesLaw> {
    if let Law::Sensor(law) = e.effect.law { Some(law) } else { None }
}

impl SeriesEffect {
    /// Of some effects those that act on the inputs of a model, in their order.
    #[must_use]
    pub fn inputs(model: &Model, effects: &[ModelEffect]) -> Vec<Self> {
        Self::all(effects, |e| input_law(model, e))
    }

    /// The sensor effects among some, in their order.
    #[must_use]
    pub fn sensors(effects: &[ModelEffect]) -> Vec<Self> {
        Self::all(effects, sensor_law)
    }

    fn all(
        effects: &[ModelEffect],
        law: impl Fn(&ModelEffect) -> Option<&'static dyn AnySeriesLaw>,
    ) -> Vec<Self> {
        let of = |e: &ModelEffect| {
            let (law, parameters) = (law(e)?.plain(), e.parameters.clone());
            Some(Self { channel: e.channel, law, parameters })
        };
        effects.iter().filter_map(of).collect()
    }
}

impl SeriesEffect<Dual> {
    /// Of some effects those that act on the inputs of a model, with derivatives by those of their parameters
    /// that are among the directions, each in its lane.
    #[must_use]
    pub fn inputs_along(
        model: &Model,
        effects: &[ModelEffect],
        directions: &[(Direction, usize)],
    ) -> Vec<Self> {
        Self::all_along(effects, directions, |e| input_law(model, e))
    }

    /// The sensor effects, likewise.
    #[must_use]
    pub fn sensors_along(effects: &[ModelEffect], directions: &[(Direction, usize)]) -> Vec<Self> {
        Self::all_along(effects, directions, sensor_law)
    }

    fn all_along(
        effects: &[ModelEffect],
        directions: &[(Direction, usize)],
        law: impl Fn(&ModelEffect) -> Option<&'static dyn AnySeriesLaw>,
    ) -> Vec<Self> {
        let of = |(index, e): (usize, &ModelEffect)| {
            let law = law(e)?.dual();
            let parameters = e.internal_along(Direction::of_effect(directions, index));
            Some(Self { channel: e.channel, law, parameters })
        };
        effects.iter().enumerate().filter_map(of).collect()
    }
}

impl<T: Number> SeriesEffect<T> {
    /// What becomes of a series.
    #[must_use]
    pub fn applied(&self, times: &[f64], series: &[T]) -> Vec<T> {
        self.law.applied(&self.parameters, times, series)
    }
}

/// What those sensors among some that measure an entry of the machine's state make of its series.
#[must_use]
pub fn sensed<T: Number>(
    sensors: &[SeriesEffect<T>],
    state: usize,
    times: &[f64],
    series: Vec<T>,
) -> Vec<T> {
    let own = sensors.iter().filter(|s| s.channel == state);
    own.fold(series, |series, sensor| sensor.applied(times, &series))
}

/// What input effects make of the commands to `m` actuators (row-major).
#[must_use]
pub fn effective_inputs<T: Number>(
    effects: &[SeriesEffect<T>],
    m: usize,
    times: &[f64],
    mut commands: Vec<T>,
) -> Vec<T> {
    for e in effects {
        let column: Vec<T> = commands.iter().skip(e.channel).step_by(m).copied().collect();
        for (k, value) in e.applied(times, &column).into_iter().enumerate() {
            commands[k * m + e.channel] = value;
        }
    }
    commands
}
