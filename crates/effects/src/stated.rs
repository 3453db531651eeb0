//! What robots' own files, and simulators, know of an effect.

/// A quantity that the file of a robot can state of a joint or of the motor that drives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Viscous friction.
    Damping,
    /// Dry friction.
    Friction,
    /// Inertia of the rotor.
    RotorInertia,
    /// Stiffness of a spring that is at rest at 0.
    Stiffness,
    /// A force that never changes: a spring that is at rest elsewhere.
    Force,
    /// What the motor's command is multiplied by.
    Gain,
}

/// An effect as such a quantity: all of it, or the part that can be said so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stated {
    /// The quantity.
    pub quantity: Quantity,
    /// What the first of the effect's parameters count in it.
    pub weights: &'static [f64],
    /// What of the law is more than the quantity says; nothing where it says all.
    pub lost: Option<&'static str>,
}

impl Stated {
    /// All of a law whose first parameter is the quantity.
    #[must_use]
    pub const fn all(quantity: Quantity) -> Self {
        Self { quantity, weights: &[1.0], lost: None }
    }

    /// Dry friction that is more than its magnitude, which these weights make of its parameters.
    #[must_use]
    pub(crate) const fn friction(weights: &'static [f64], lost: &'static str) -> Self {
        Self { quantity: Quantity::Friction, weights, lost: Some(lost) }
    }

    /// The quantity of parameters, and its standard deviation by theirs, as of independent ones.
    #[must_use]
    pub fn of(&self, parameters: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
        let weighted = self.weights.iter().zip(parameters);
        let (value, variance) = weighted.fold((0.0, 0.0), |(sum, variance), (w, (value, std))| {
            (sum + w * value, variance + (w * std).powi(2))
        });
        (value, variance.sqrt())
    }
}
