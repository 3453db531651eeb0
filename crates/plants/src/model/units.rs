//! Units of generalised forces and of effects, as far as the model's own units say them.
//!
//! The equations of a coordinate are
//!
//! ```text
//! sum_j M_ij a_j = F_i
//! ```
//!
//! and an effect is one more term of F_i. A parameter or input that stands in F_i with the
//! coefficient 1 or -1 is in the unit of F_i; a parameter that stands so in M_ij is, times the unit
//! of a_j, too. Any other coefficient says nothing, as a number in the equations may carry a unit
//! of its own: `pi/180`, `9.81`, or the 1 of a mass of 1 kg. Where several say the unit and
//! disagree, or none says it, the unit is [`UNKNOWN`], unless the model states it.
//!
//! Whether a coefficient is 1 is tried out, so that equations need not be text: at two places that
//! have nothing in common, the entry must change by as much as the parameter or input does.

use super::{Coordinate, Model};
use crate::dynamics::Mass;
use lacuna_effects::{Dimension, Effect, InServo, Law, Variable};
use lacuna_units::{Product, Unit, convert_factor};

/// Stands for the unit of a generalised force that the model's units do not say.
const UNKNOWN: &str = "force";
/// Units of force that are written by their names, where nothing but the name differs.
const NAMED: [&str; 2] = ["N", "N m"];

/// What a parameter or input says of the unit of a generalised force.
#[derive(Clone, Debug, PartialEq)]
pub struct SaidUnit {
    /// The parameter or input.
    pub by: String,
    /// The unit of the force that it implies.
    pub unit: String,
}

impl Model {
    /// Unit of a channel's generalised force, in which the equations are read: `N m`,
    /// `kg mm/s^2` where masses are in kg and lengths in mm, `V` where an input in volts is a term
    /// of it. It is what the model states, or else what the units of its parameters and inputs say
    /// ([`Model::said_force_units`]); where these say nothing, or not all the same, `force`. That
    /// of a first-order state is its unit per second. Where the dynamics give accelerations alone
    /// ([`Mass::Unit`]), it is that of the acceleration.
    #[must_use]
    pub fn force_unit(&self, channel: usize) -> String {
        let Some(coordinate) = self.coordinates.get(channel) else {
            return per_second(&self.states[channel - self.coordinates.len()].unit);
        };
        if self.dynamics.mass() == Mass::Unit {
            return acceleration(coordinate).to_string();
        }
        if let Some(stated) = &coordinate.force_unit {
            return stated.clone();
        }
        let said = self.said_force_units(channel);
        match said.split_first() {
            Some((first, rest)) if rest.iter().all(|s| same_unit(&s.unit, &first.unit)) => {
                first.unit.clone()
            }
            _ => UNKNOWN.to_owned(),
        }
    }

    /// What each parameter and input whose unit is known says of the unit of a coordinate's
    /// generalised force; empty for a first-order state.
    #[must_use]
    pub fn said_force_units(&self, channel: usize) -> Vec<SaidUnit> {
        let n = self.coordinates.len();
        if channel >= n || self.dynamics.mass() == Mass::Unit {
            return vec![];
        }
        let places = [Place::new(self, 0), Place::new(self, 1)];
        let mut said = vec![];
        for source in self.sources() {
            let Some(unit) = known(source.unit) else { continue };
            let ones = places.each_ref().map(|place| place.ones(self, source.at));
            let one = |entry: usize| ones[0][entry] && ones[1][entry];
            let masses = (0..n)
                .filter(|j| one(channel * n + j))
                .map(|j| unit.clone().times(&acceleration(&self.coordinates[j]), 1.0));
            let force = one(n * n + channel).then(|| unit.clone());
            for unit in masses.chain(force) {
                said.push(SaidUnit { by: source.name.to_owned(), unit: named(&unit) });
            }
        }
        said
    }

    /// The inputs that a law on a force channel may name: those that drive it in this model, and
    /// those that drive nothing, which were given for something that the model leaves out.
    #[must_use]
    pub fn inputs_about(&self, channel: usize) -> Vec<usize> {
        let places = [Place::new(self, 0), Place::new(self, 1)];
        let masses = self.coordinates.len() * self.coordinates.len();
        let drives = |j: usize| {
            let moved = places.each_ref().map(|place| place.coefficients(self, At::Input(j)));
            move |rate: usize| moved.iter().any(|by| by[rate] != 0.0)
        };
        let about = |j: &usize| {
            let drives = drives(*j);
            drives(masses + channel) || !(masses..masses + self.channels()).any(drives)
        };
        (0..self.inputs.len()).filter(about).collect()
    }

    /// Inputs and parameters; what is written of an input is nearest to what is read of a force.
    fn sources(&self) -> impl Iterator<Item = Source<'_>> {
        let inputs = self.inputs.iter().enumerate().map(|(j, input)| Source {
            name: &input.name,
            unit: &input.unit,
            at: At::Input(j),
        });
        let parameters = self.parameters.iter().enumerate().map(|(k, p)| Source {
            name: &p.name,
            unit: &p.unit,
            at: At::Parameter(k),
        });
        inputs.chain(parameters)
    }

    /// Units of the physical values of an effect on a channel or input of this model, given the other
    /// one that it names; a curve is taken as over the coordinate.
    #[must_use]
    pub fn effect_units(
        &self,
        effect: &Effect,
        channel: usize,
        other: Option<usize>,
    ) -> Vec<String> {
        self.effect_units_over(effect, (channel, other), Variable::Coordinate)
    }

    /// The same, of a curve over this variable.
    #[must_use]
    pub fn effect_units_over(
        &self,
        effect: &Effect,
        (channel, other): (usize, Option<usize>),
        over: Variable,
    ) -> Vec<String> {
        let (force, coordinate, input) = match effect.law {
            Law::Force(_) => {
                let index = self.coordinate_index(channel);
                let named = other.filter(|_| effect.names_input());
                let input = named.map_or_else(String::new, |j| self.inputs[j].unit.clone());
                (self.force_unit(channel), self.state_unit(index), input)
            }
            Law::Input(_) => {
                let limits = self.in_servo(effect, channel) == Some(InServo::Force);
                let servo = self.servo_of(channel).filter(|_| limits);
                let unit = match servo {
                    Some((_, servo)) => self.force_unit(servo.coordinate),
                    None => self.inputs[channel].unit.clone(),
                };
                (String::new(), String::new(), unit)
            }
            Law::Sensor(_) => (String::new(), self.state_unit(channel), String::new()),
            Law::Structure(_) => Default::default(),
        };
        let first_order = matches!(effect.law, Law::Force(_)) && !self.is_coordinate(channel);
        let text = |p: &lacuna_effects::Parameter| {
            let mut unit = p.unit.over(over);
            if first_order && unit == Dimension::VELOCITY {
                unit = Dimension::COORDINATE;
            }
            unit.text(&force, &coordinate, &input)
        };
        effect.values().map(text).collect()
    }
}

/// A parameter or input.
struct Source<'m> {
    name: &'m str,
    unit: &'m str,
    at: At,
}

#[derive(Clone, Copy)]
enum At {
    Parameter(usize),
    Input(usize),
}

/// A place at which the equations are tried, where nothing is 0 and no two values are alike.
struct Place {
    parameters: Vec<f64>,
    variables: Vec<f64>,
    rates: Vec<f64>,
}

impl Place {
    fn new(model: &Model, which: usize) -> Self {
        let (golden, apart) = (0.618_033_988_749_895, 0.414_213_562_373_095 * which as f64);
        let share = |k: usize| 0.2 + 0.6 * (golden * (k + 1) as f64 + apart).fract();
        let around = |(k, p): (usize, &super::Parameter)| {
            (if p.value == 0.0 { 1.0 } else { p.value }) * (0.5 + share(k))
        };
        let parameters: Vec<_> = model.parameters.iter().enumerate().map(around).collect();
        let begin = parameters.len();
        let sizes = model.dynamics.sizes();
        let variables = (0..sizes.variables()).map(|k| share(begin + k)).collect();
        let mut place = Self { parameters, variables, rates: vec![0.0; sizes.rates()] };
        place.rates = place.evaluated(model);
        place
    }

    fn evaluated(&self, model: &Model) -> Vec<f64> {
        let mut rates = vec![0.0; self.rates.len()];
        model.dynamics.bind(&self.parameters).evaluate_once(&self.variables, &mut rates);
        rates
    }

    /// Which entries of the mass matrix and of the forces change by as much, up to rounding, as
    /// this parameter or input does.
    fn ones(&self, model: &Model, at: At) -> Vec<bool> {
        let rounding = f64::EPSILON.sqrt();
        let is_one = |coefficient: f64| (coefficient.abs() - 1.0).abs() < rounding;
        self.coefficients(model, at).into_iter().map(is_one).collect()
    }

    /// By how much every rate changes with this parameter or input.
    fn coefficients(&self, model: &Model, at: At) -> Vec<f64> {
        let (mut parameters, mut variables) = (self.parameters.clone(), self.variables.clone());
        let moved = match at {
            At::Parameter(k) => &mut parameters[k],
            At::Input(j) => &mut variables[model.machine_states() + j],
        };
        let step = 0.25 * *moved;
        *moved += step;
        let there = Self { parameters, variables, rates: self.rates.clone() }.evaluated(model);
        there.iter().zip(&self.rates).map(|(there, here)| (there - here) / step).collect()
    }
}

/// The unit of an acceleration.
fn acceleration(coordinate: &Coordinate) -> Product {
    product(&coordinate.unit).times(&Product::symbol("s"), -2.0)
}

/// A unit that is written and known.
fn known(unit: &str) -> Option<Product> {
    Unit::parse(unit).ok().and_then(|_| Product::parse(unit).ok())
}

fn product(unit: &str) -> Product {
    Product::parse(unit).unwrap_or_else(|_| Product::symbol(unit))
}

/// A unit of force by its name, if it has one.
fn named(unit: &Product) -> String {
    let text = unit.to_string();
    NAMED.into_iter().find(|name| same_unit(name, &text)).map_or(text, str::to_owned)
}

/// Whether two units differ in nothing but how they are written; those that are not known are
/// compared as products of symbols.
#[must_use]
pub fn same_unit(a: &str, b: &str) -> bool {
    match (Unit::parse(a), Unit::parse(b)) {
        (Ok(a), Ok(b)) => {
            convert_factor(&a, &b).is_ok_and(|factor| (factor - 1.0).abs() < f64::EPSILON.sqrt())
        }
        _ => product(a) == product(b),
    }
}

/// What a value in the unit `from` is multiplied by to be in `to`; none where they are no units of one kind.
pub(super) fn factor(from: &str, to: &str) -> Option<f64> {
    convert_factor(&Unit::parse(from).ok()?, &Unit::parse(to).ok()?).ok()
}

/// Radians of a unit of angle, metres of a unit of length, 1 of any other.
pub(super) fn si(unit: &str) -> f64 {
    // Most coordinates are in these.
    if matches!(unit, "rad" | "m") {
        return 1.0;
    }
    factor(unit, "rad").or_else(|| factor(unit, "m")).unwrap_or(1.0)
}

/// Whether a unit is one of speed, or none that is known.
pub(super) fn may_be_speed(unit: &str) -> bool {
    let speed = || ["m/s", "rad/s"].iter().any(|speed| factor(unit, speed).is_some());
    Unit::parse(unit).is_err() || unit.is_empty() || speed()
}

/// The unit of a rate.
pub(super) fn per_second(unit: &str) -> String {
    Dimension::VELOCITY.text("", unit, "")
}
