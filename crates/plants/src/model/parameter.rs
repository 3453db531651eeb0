//! Parameters: what a model believes of them, and how sure it is.

use thiserror::Error;

/// A parameter of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// What the model believes.
    pub value: f64,
    /// Its unit, as written.
    pub unit: String,
    /// How sure the model is of the value.
    pub uncertainty: Uncertainty,
}

/// How sure a model is of a parameter, as one standard deviation; 0 is known exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Uncertainty {
    /// Relative to the parameter's value: `tolerance` in a model file.
    Relative(f64),
    /// In the parameter's unit: `std` in a model file.
    Absolute(f64),
}

/// A standard deviation that is none.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum UncertaintyError {
    /// A relative one that is negative or not finite.
    #[error("the tolerance of '{name}' is a relative standard deviation, 0 or more; found {found}")]
    Tolerance {
        /// The parameter.
        name: String,
        /// Its tolerance.
        found: f64,
    },
    /// An absolute one that is negative or not finite.
    #[error(
        "the std of '{name}' is a standard deviation in its own unit, 0 or more; found {found}"
    )]
    Std {
        /// The parameter.
        name: String,
        /// Its standard deviation.
        found: f64,
    },
    /// A relative one of a parameter that is 0.
    #[error(
        "a tolerance is relative, and '{name}' is 0: {found} of it is nothing; say how far off it \
         may be in its own unit, std = ..."
    )]
    OfZero {
        /// The parameter.
        name: String,
        /// Its tolerance.
        found: f64,
    },
}

impl Parameter {
    /// Standard deviation of what is believed, in the parameter's unit.
    #[must_use]
    pub fn std(&self) -> f64 {
        match self.uncertainty {
            Uncertainty::Relative(tolerance) => tolerance * self.value.abs(),
            Uncertainty::Absolute(std) => std,
        }
    }

    /// The same relative to the value; infinite where the value is 0 and uncertain.
    #[must_use]
    pub fn tolerance(&self) -> f64 {
        match self.uncertainty {
            Uncertainty::Relative(tolerance) => tolerance,
            Uncertainty::Absolute(0.0) => 0.0,
            Uncertainty::Absolute(std) => std / self.value.abs(),
        }
    }

    /// Check that what is believed can be.
    pub(super) fn check(&self) -> Result<(), UncertaintyError> {
        let name = || self.name.clone();
        let possible = |std: f64| std >= 0.0 && std.is_finite();
        match self.uncertainty {
            Uncertainty::Relative(found) if !possible(found) => {
                Err(UncertaintyError::Tolerance { name: name(), found })
            }
            Uncertainty::Relative(found) if found > 0.0 && self.value == 0.0 => {
                Err(UncertaintyError::OfZero { name: name(), found })
            }
            Uncertainty::Absolute(found) if !possible(found) => {
                Err(UncertaintyError::Std { name: name(), found })
            }
            _ => Ok(()),
        }
    }
}
