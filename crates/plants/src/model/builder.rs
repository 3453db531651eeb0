//! Models that no text describes.

use super::name::{check_name, check_part_name};
use super::{
    Coordinate, Measured, Measurement, Model, NameError, Parameter, Quantity, RecordedInput,
    Uncertainty, UncertaintyError,
};
use crate::Hold;
use crate::dynamics::{
    Differences, Dynamics, Exact, GenericSimulator, Mechanics, Point, Rates, Simulator, Sizes,
};
use std::fmt;
use std::sync::Arc;
use thiserror::Error;

/// What is wrong with a model that is built.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BuildError {
    /// A name that cannot be one, or stands for two things.
    #[error(transparent)]
    Name(#[from] NameError),
    /// Neither a coordinate nor a first-order state.
    #[error("'{model}' has neither a coordinate nor a state: nothing moves")]
    NothingMoves {
        /// The model.
        model: String,
    },
    /// Nothing says how it moves.
    #[error(
        "'{model}' has no dynamics: say how it moves with rates, mechanics, simulator, exact or \
         dynamics"
    )]
    NoDynamics {
        /// The model.
        model: String,
    },
    /// A closure gives more or fewer numbers than there are channels.
    #[error(
        "the {what} must be {expected} numbers, as the model's channels ask for; found {found}"
    )]
    Length {
        /// Of what.
        what: &'static str,
        /// As many as there must be.
        expected: usize,
        /// As many as there are.
        found: usize,
    },
    /// Dynamics for another model.
    #[error("the dynamics are those of another model: expected {expected:?}, found {found:?}")]
    Sizes {
        /// What the model has.
        expected: Sizes,
        /// What the dynamics have.
        found: Sizes,
    },
    /// A parameter without a finite value.
    #[error("the value of '{name}' must be finite; found {found}")]
    Value {
        /// The parameter.
        name: String,
        /// Its value.
        found: f64,
    },
    /// What is believed of a parameter is no standard deviation.
    #[error(transparent)]
    Uncertainty(#[from] UncertaintyError),
    /// Noise of an input that is no standard deviation.
    #[error("the noise of '{name}' is a standard deviation in its unit, 0 or more; found {found}")]
    InputNoise {
        /// The input.
        name: String,
        /// Its noise.
        found: f64,
    },
    /// A measurement of something that the model does not have.
    #[error("column '{column}' measures '{of}', which is none of {}", known.join(", "))]
    Measured {
        /// The column.
        column: String,
        /// What it is said to measure.
        of: String,
        /// What can be measured.
        known: Vec<String>,
    },
    /// A mass matrix that cannot be solved.
    #[error("the mass matrix is singular where all coordinates are 0")]
    SingularMass,
}

/// Makes the dynamics once all sizes are known.
type Make = Box<dyn FnOnce(&Rest) -> Result<Arc<dyn Dynamics>, BuildError>>;

/// A [`Model`] in the making ([`Model::builder`]).
pub struct Builder {
    name: String,
    parameters: Vec<Parameter>,
    inputs: Vec<RecordedInput>,
    coordinates: Vec<Coordinate>,
    states: Vec<Quantity>,
    /// Column, what it measures, unit.
    measurements: Vec<(String, String, String)>,
    time_column: String,
    hold: Hold,
    dynamics: Option<Make>,
}

impl fmt::Debug for Builder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Builder").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Model {
    /// A model that no text describes. Parameters, inputs, coordinates and states are numbered in
    /// the order in which they are declared; the dynamics find them so ([`Point`]).
    ///
    /// ```
    /// use lacuna_plants::Model;
    /// // J theta'' = tau - k sin theta, as accelerations.
    /// let model = Model::builder("pendulum")
    ///     .parameter("J", 0.12, "kg m^2", 0.1)
    ///     .parameter("k", 0.9, "N m", 0.1)
    ///     .input("tau", "N m")
    ///     .coordinate("theta", "omega", "rad")
    ///     .rates(|at| [(at.inputs[0] - at.parameters[1] * at.coordinates[0].sin()) / at.parameters[0]])
    ///     .build()?;
    /// assert_eq!(model.force_unit(0), "rad/s^2");
    /// # Ok::<(), lacuna_plants::model::BuildError>(())
    /// ```
    #[must_use]
    pub fn builder(name: &str) -> Builder {
        Builder {
            name: name.to_owned(),
            parameters: vec![],
            inputs: vec![],
            coordinates: vec![],
            states: vec![],
            measurements: vec![],
            time_column: "t".to_owned(),
            hold: Hold::default(),
            dynamics: None,
        }
    }
}

impl Builder {
    /// A parameter, with the relative standard deviation of what is believed of it; 0 is known
    /// exactly. Its name may be that of a part, `elbow.damping`.
    #[must_use]
    pub fn parameter(self, name: &str, value: f64, unit: &str, tolerance: f64) -> Self {
        self.believed(name, value, unit, Uncertainty::Relative(tolerance))
    }

    /// A parameter, with the standard deviation of what is believed of it in its own unit; 0 is
    /// known exactly. It is how a parameter is uncertain that is 0: a load of 0 kg.
    ///
    /// ```
    /// use lacuna_plants::Model;
    /// let model = Model::builder("lift")
    ///     .parameter_with_std("load", 0.0, "kg", 0.5)
    ///     .input("lift", "N")
    ///     .coordinate("z", "vz", "m")
    ///     .rates(|at| [at.inputs[0] / (3.0 + at.parameters[0]) - 9.81])
    ///     .build()?;
    /// assert_eq!(model.parameters[0].std(), 0.5);
    /// # Ok::<(), lacuna_plants::model::BuildError>(())
    /// ```
    #[must_use]
    pub fn parameter_with_std(self, name: &str, value: f64, unit: &str, std: f64) -> Self {
        self.believed(name, value, unit, Uncertainty::Absolute(std))
    }

    fn believed(mut self, name: &str, value: f64, unit: &str, uncertainty: Uncertainty) -> Self {
        let (name, unit) = (name.to_owned(), unit.to_owned());
        self.parameters.push(Parameter { name, value, unit, uncertainty });
        self
    }

    /// An input: a command to an actuator ([`Builder::no_actuator`]), of whose noise nothing is known
    /// ([`Builder::input_noise`]).
    #[must_use]
    pub fn input(mut self, name: &str, unit: &str) -> Self {
        self.inputs.push(RecordedInput::new(name, unit));
        self
    }

    /// The input declared last drives the machine as it was recorded, no actuator between: a computed
    /// torque, a reference, a measured disturbance. Without an input it says nothing.
    #[must_use]
    pub fn no_actuator(mut self) -> Self {
        if let Some(input) = self.inputs.last_mut() {
            input.actuator = false;
        }
        self
    }

    /// What was recorded of the input declared last differs from what the machine got by noise of
    /// this standard deviation, in the input's unit; 0: by none. Without an input it says nothing.
    #[must_use]
    pub fn input_noise(mut self, std: f64) -> Self {
        if let Some(input) = self.inputs.last_mut() {
            input.noise = Some(std);
        }
        self
    }

    /// A second-order coordinate, the name of its velocity, and its unit.
    #[must_use]
    pub fn coordinate(mut self, name: &str, velocity: &str, unit: &str) -> Self {
        let (name, velocity, unit) = (name.to_owned(), velocity.to_owned(), unit.to_owned());
        self.coordinates.push(Coordinate {
            name,
            velocity,
            unit,
            force_unit: None,
            imposed: false,
        });
        self
    }

    /// The unit of the generalised force of the coordinate declared last, for where the units of
    /// parameters and inputs do not say it ([`Model::force_unit`]). Without a coordinate it says
    /// nothing.
    #[must_use]
    pub fn force_unit(mut self, unit: &str) -> Self {
        if let Some(coordinate) = self.coordinates.last_mut() {
            coordinate.force_unit = Some(unit.to_owned());
        }
        self
    }

    /// The motion of the coordinate declared last is imposed from outside ([`Model::imposed`]): its
    /// position must be recorded. Without a coordinate it says nothing.
    #[must_use]
    pub fn imposed(mut self) -> Self {
        if let Some(coordinate) = self.coordinates.last_mut() {
            coordinate.imposed = true;
        }
        self
    }

    /// A first-order state.
    #[must_use]
    pub fn state(mut self, name: &str, unit: &str) -> Self {
        self.states.push(Quantity { name: name.to_owned(), unit: unit.to_owned() });
        self
    }

    /// A column of the recordings that measures a coordinate, velocity, state, input or, as
    /// `force on x`, the force on an imposed coordinate x, in a unit of its own (empty: that of the quantity). Columns with the names of channels need not be
    /// declared.
    #[must_use]
    pub fn measurement(mut self, column: &str, of: &str, unit: &str) -> Self {
        self.measurements.push((column.to_owned(), of.to_owned(), unit.to_owned()));
        self
    }

    /// The column of time in the recordings; `t` where it is not said.
    #[must_use]
    pub fn time_column(mut self, name: &str) -> Self {
        name.clone_into(&mut self.time_column);
        self
    }

    /// What the inputs do between samples; held where it is not said.
    #[must_use]
    pub fn hold(mut self, hold: Hold) -> Self {
        self.hold = hold;
        self
    }

    /// It moves as a closure says: `n` accelerations, then the rates of the `s` first-order
    /// states. Without a mass matrix, effects act on accelerations; derivatives are differences
    /// ([`Differences`]).
    #[must_use]
    pub fn rates<R: AsRef<[f64]> + 'static>(
        self,
        rates: impl Fn(&Point<'_>) -> R + Send + Sync + 'static,
    ) -> Self {
        self.made(move |rest| {
            let found = rates(&rest.point()).as_ref().len();
            expect("rates", rest.sizes.channels(), found)?;
            Ok(Arc::new(Differences::new(Rates(rates), rest.sizes)))
        })
    }

    /// It moves as two closures say: the mass matrix (row-major, `n x n`), and `n` generalised
    /// forces followed by the rates of the `s` first-order states. Derivatives are differences
    /// ([`Differences`]).
    #[must_use]
    pub fn mechanics<A: AsRef<[f64]> + 'static, B: AsRef<[f64]> + 'static>(
        self,
        mass: impl Fn(&Point<'_>) -> A + Send + Sync + 'static,
        force: impl Fn(&Point<'_>) -> B + Send + Sync + 'static,
    ) -> Self {
        self.made(move |rest| {
            let (at, n) = (rest.point(), rest.sizes.coordinates);
            expect("entries of the mass matrix", n * n, mass(&at).as_ref().len())?;
            expect("forces", rest.sizes.channels(), force(&at).as_ref().len())?;
            Ok(Arc::new(Differences::new(Mechanics { mass, force }, rest.sizes)))
        })
    }

    /// It moves as a program says that computes in plain numbers.
    #[must_use]
    pub fn simulator(self, simulator: impl Simulator) -> Self {
        self.made(|rest| Ok(Arc::new(Differences::new(simulator, rest.sizes))))
    }

    /// It moves as a program says that computes in any number: with exact derivatives.
    #[must_use]
    pub fn exact(self, simulator: impl GenericSimulator) -> Self {
        self.made(|rest| Ok(Arc::new(Exact::new(simulator, rest.sizes))))
    }

    /// It moves as these dynamics do.
    #[must_use]
    pub fn dynamics(self, dynamics: Arc<dyn Dynamics>) -> Self {
        self.made(move |rest| {
            let (expected, found) = (rest.sizes, dynamics.sizes());
            if expected == found {
                Ok(dynamics)
            } else {
                Err(BuildError::Sizes { expected, found })
            }
        })
    }

    fn made(
        mut self,
        make: impl FnOnce(&Rest) -> Result<Arc<dyn Dynamics>, BuildError> + 'static,
    ) -> Self {
        self.dynamics = Some(Box::new(make));
        self
    }

    /// The model.
    ///
    /// # Errors
    /// [`BuildError`]: names that are none or stand for two things, values out of range, no
    /// dynamics or such of other sizes, a mass matrix that is singular at rest.
    pub fn build(mut self) -> Result<Model, BuildError> {
        self.check_names()?;
        self.check_values()?;
        if self.coordinates.is_empty() && self.states.is_empty() {
            return Err(BuildError::NothingMoves { model: self.name });
        }
        let Some(make) = self.dynamics.take() else {
            return Err(BuildError::NoDynamics { model: self.name });
        };
        let dynamics = make(&self.rest())?;
        let mut model = Model {
            name: self.name,
            parameters: self.parameters,
            inputs: self.inputs,
            coordinates: self.coordinates,
            states: self.states,
            effects: vec![],
            measurements: vec![],
            time_column: self.time_column,
            time_seconds: 1.0,
            hold: self.hold,
            assumptions: vec![],
            dynamics,
            source: None,
        };
        for declared in self.measurements {
            let measurement = measurement(&model, declared)?;
            model.measurements.push(measurement);
        }
        if model.is_singular_at_rest() { Err(BuildError::SingularMass) } else { Ok(model) }
    }

    fn check_names(&self) -> Result<(), NameError> {
        let mut taken: Vec<String> = vec![];
        for Parameter { name, .. } in &self.parameters {
            check_part_name(name, &taken)?;
            taken.push(name.clone());
        }
        let coordinates = self.coordinates.iter().flat_map(|c| [&c.name, &c.velocity]);
        let states = self.states.iter().map(|s| &s.name);
        let inputs = self.inputs.iter().map(|i| &i.name);
        for name in coordinates.chain(states).chain(inputs) {
            check_name(name, &taken)?;
            taken.push(name.clone());
        }
        Ok(())
    }

    fn check_values(&self) -> Result<(), BuildError> {
        for parameter in &self.parameters {
            if !parameter.value.is_finite() {
                let (name, found) = (parameter.name.clone(), parameter.value);
                return Err(BuildError::Value { name, found });
            }
            parameter.check()?;
        }
        match self.inputs.iter().find(|input| !input.has_possible_noise()) {
            Some(input) => {
                let (name, found) = (input.name.clone(), input.noise.unwrap_or_default());
                Err(BuildError::InputNoise { name, found })
            }
            None => Ok(()),
        }
    }

    fn rest(&self) -> Rest {
        let sizes = Sizes {
            parameters: self.parameters.len(),
            coordinates: self.coordinates.len(),
            states: self.states.len(),
            inputs: self.inputs.len(),
        };
        let parameters = self.parameters.iter().map(|p| p.value).collect();
        Rest { sizes, parameters, variables: vec![0.0; sizes.variables()] }
    }
}

/// Where everything but the parameters is 0.
struct Rest {
    sizes: Sizes,
    parameters: Vec<f64>,
    variables: Vec<f64>,
}

impl Rest {
    fn point(&self) -> Point<'_> {
        Point::new(self.sizes, &self.parameters, &self.variables)
    }
}

fn expect(what: &'static str, expected: usize, found: usize) -> Result<(), BuildError> {
    if expected == found { Ok(()) } else { Err(BuildError::Length { what, expected, found }) }
}

fn measurement(
    model: &Model,
    (column, of, unit): (String, String, String),
) -> Result<Measurement, BuildError> {
    let states = (0..model.machine_states()).map(|i| (model.state_name(i), Measured::State(i)));
    let inputs = model.inputs.iter().enumerate().map(|(j, i)| (&*i.name, Measured::Input(j)));
    let forces = model.imposed().map(|c| (model.force_name(c), Measured::Force(c)));
    let named = states.chain(inputs).map(|(name, of)| (name.to_owned(), of));
    let known: Vec<_> = named.chain(forces).collect();
    match known.iter().find(|(name, _)| *name == of) {
        Some(&(_, measured)) => Ok(Measurement { column, unit, of: measured, text: of }),
        None => {
            let known = known.into_iter().map(|(name, _)| name).collect();
            Err(BuildError::Measured { column, of, known })
        }
    }
}
