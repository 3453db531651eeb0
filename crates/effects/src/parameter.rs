//! The physical parameters of an effect, and which of its values belongs to which.

use crate::{Dimension, Effect, Variable};

/// A physical parameter of an effect.
#[derive(Debug)]
pub struct Parameter {
    /// Name in model files.
    pub name: &'static str,
    /// Its unit in terms of its channel's.
    pub unit: Dimension,
    /// Values that make sense.
    pub range: Range,
    /// Value where a model file gives none; without one the parameter must be given.
    pub default: Option<f64>,
    /// What it holds.
    pub kind: Kind,
    /// Whether it says something of the machine, and not only of how the formula is written.
    pub physical: bool,
}

impl Parameter {
    /// A number that must be given.
    #[must_use]
    pub const fn new(name: &'static str, unit: Dimension, range: Range) -> Self {
        Self { name, unit, range, default: None, kind: Kind::Number, physical: true }
    }

    /// The same, with a value for files that leave it out.
    #[must_use]
    pub const fn or(self, default: f64) -> Self {
        Self { default: Some(default), ..self }
    }

    /// The same for a number of the formula, such as the width of a smooth edge: sentences leave
    /// it out.
    #[must_use]
    pub const fn of_the_formula(self) -> Self {
        Self { physical: false, ..self }
    }

    /// A side: 1 for that of larger coordinates, -1 for the other, 0 for what the law makes of it.
    #[must_use]
    pub const fn side(name: &'static str) -> Self {
        Self { kind: Kind::Side, ..Self::new(name, Dimension::NUMBER, Range::Any).or(0.0) }
    }

    /// So many numbers of one unit and range.
    #[must_use]
    pub const fn numbers(name: &'static str, unit: Dimension, range: Range, count: usize) -> Self {
        Self { kind: Kind::Numbers(count), ..Self::new(name, unit, range) }
    }

    /// The variable that a curve is over.
    #[must_use]
    pub const fn variable(name: &'static str) -> Self {
        let this = Self::new(name, Dimension::NUMBER, Range::NonNegative);
        Self { kind: Kind::Variable, ..this }
    }
}

/// What a parameter holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One number.
    Number,
    /// One number that is a choice, not a quantity: 1, -1 or 0. It is never told as a value.
    Side,
    /// So many numbers, such as the values of a curve at its knots.
    Numbers(usize),
    /// A variable, as its index in [`Effect::depends_on`]. Model files call it by its name.
    Variable,
}

impl Kind {
    /// How many physical values a parameter of this kind stands for.
    #[must_use]
    pub const fn values(self) -> usize {
        match self {
            Self::Number | Self::Side | Self::Variable => 1,
            Self::Numbers(count) => count,
        }
    }
}

/// Values that make physical sense.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Any finite number.
    Any,
    /// Zero or more: a friction that drives is no friction.
    NonNegative,
    /// More than zero.
    Positive,
}

impl Range {
    /// Whether the range holds a value.
    #[must_use]
    pub fn contains(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Any => true,
                Self::NonNegative => value >= 0.0,
                Self::Positive => value > 0.0,
            }
    }
}

impl Effect {
    /// The parameter that each physical value belongs to: as [`Effect::parameters`], but one
    /// with several numbers stands there as often.
    pub fn values(&self) -> impl Iterator<Item = &'static Parameter> {
        self.parameters.iter().flat_map(|p| std::iter::repeat_n(p, p.kind.values()))
    }

    /// What the law with these physical values depends on: of a curve, the variable that it is
    /// over.
    #[must_use]
    pub fn variables(&self, physical: &[f64]) -> &'static [Variable] {
        let choice = self.values().position(|p| p.kind == Kind::Variable);
        let Some(&index) = choice.and_then(|k| physical.get(k)) else { return self.depends_on };
        self.depends_on.get(index as usize..).and_then(|rest| rest.get(..1)).unwrap_or_default()
    }

    /// The variable that a curve with these physical values is over; none for a formula.
    #[must_use]
    pub fn over(&self, physical: &[f64]) -> Option<Variable> {
        let is_curve = self.parameters.iter().any(|p| p.kind == Kind::Variable);
        self.variables(physical).first().copied().filter(|_| is_curve)
    }
}
