//! What an effect is: its description, its law, what is believed of its parameters.

use crate::{Kin, Law, Parameter, Prior, Scales, Stated};

/// One entry of the catalogue.
#[derive(Debug)]
pub struct Effect {
    /// Name in model files and findings.
    pub class: &'static str,
    /// In words, for reports.
    pub words: &'static str,
    /// The law as a formula, in the names of the parameters.
    pub formula: &'static str,
    /// Physical parameters, in the order of [`ForceLaw::physical`](crate::ForceLaw::physical).
    pub parameters: &'static [Parameter],
    /// What the law depends on; of a curve, what it can be over (see [`Effect::variables`]).
    pub depends_on: &'static [Variable],
    /// Which kind of channel it acts on.
    pub acts: Acts,
    /// The law itself.
    pub law: Law,
    /// Priors of the parameters on a channel of these magnitudes: of a force law of the internal
    /// and of one of structure the internal ones, amplitudes, then shape.
    pub priors: fn(&Scales) -> Vec<Prior>,
    /// Shapes (of an input law parameters) spread so that one of them is near enough to any
    /// other to begin from; one empty shape where the law has none ([`one_shape`]), and no shape
    /// at all where it is not to be looked for.
    pub shapes: fn(&Scales) -> Vec<Vec<f64>>,
    /// What else is known of it.
    pub nature: Nature,
}

impl Effect {
    /// The class that a diagnosis names: its own, or that whose law it is in another formula.
    #[must_use]
    pub fn named_class(&self) -> &'static str {
        self.nature.variation_of.map_or(self.class, |of| of.class)
    }

    /// Whether it names another channel: one that it depends on, or acts on as well.
    #[must_use]
    pub fn couples(&self) -> bool {
        self.depends_on_another() || self.reacts()
    }

    /// Whether it names an input that it depends on.
    #[must_use]
    pub fn names_input(&self) -> bool {
        self.depends_on.contains(&Variable::OtherInput)
    }

    /// Whether it is the same law seen from either of its channels.
    #[must_use]
    pub fn is_mutual(&self) -> bool {
        self.depends_on_another() && self.reacts()
    }

    fn depends_on_another(&self) -> bool {
        let another = [Variable::OtherCoordinate, Variable::OtherVelocity];
        self.depends_on.iter().any(|v| another.contains(v))
    }

    fn reacts(&self) -> bool {
        matches!(self.law, Law::Force(law) if law.reacts())
    }
}

/// What is known of an effect beside its law. Most have the [`Nature::PLAIN`] one.
#[derive(Clone, Copy, Debug)]
pub struct Nature {
    /// The family of laws of which a channel has one at most.
    pub kin: Option<Kin>,
    /// The effect whose law it is in another formula: what is told of it is that one's class.
    pub variation_of: Option<&'static Effect>,
    /// Whether it is nothing on one side of an edge, so that it acts wherever it is not 0.
    pub edge: bool,
    /// The simpler law that it is beside a constant force, at least where what sets it apart is not seen.
    pub biased: Option<Biased>,
    /// The parameter that is the time at which it begins, if it does.
    pub onset: Option<&'static str>,
    /// Parameters with which a sensor tells the truth.
    pub ideal: &'static [f64],
    /// How far from rest, as a standard deviation, the memory may begin, given its shape.
    pub memory_spread: fn(&[f64], &Scales, &mut [f64]),
    /// Whether it can be with parameters that their own bounds admit: friction does not drive. None where it always
    /// can.
    pub possible: Option<fn(&[f64], &Scales) -> bool>,
    /// Value of its first parameter with which it does nothing: 0 of a force, 1 of a gain, infinite of a limit.
    pub absent: f64,
    /// Of a law between two coordinates the law that each of them has where they do not act on each other;
    /// its parameters are the first of this one's.
    pub apart: Option<&'static Effect>,
    /// Where it acts if its input is the command of a position servo; none: on the command itself.
    pub in_servo: Option<InServo>,
    /// What the file of a robot can say of it, on a joint or its input; of effects on structure their
    /// numbers say it ([`crate::StructureLaw::numbers`]).
    pub stated: Option<Stated>,
}

impl Nature {
    /// No family, no edge, no beginning; memory begins within a quarter of the range.
    pub const PLAIN: Self = Self {
        kin: None,
        variation_of: None,
        edge: false,
        biased: None,
        onset: None,
        ideal: &[0.0],
        memory_spread: |_, scales, spread| spread.fill(0.5 * scales.half_range()),
        possible: None,
        absent: 0.0,
        apart: None,
        in_servo: None,
        stated: None,
    };
}

/// A law beside a constant force.
#[derive(Clone, Copy, Debug)]
pub struct Biased {
    /// The law.
    pub effect: &'static Effect,
    /// Its physical parameters and the force, of those of the law that they are together.
    pub numbers: fn(&[f64]) -> (Vec<f64>, f64),
}

impl Biased {
    /// A law in proportion to its variable, about where it rests: what it is together has its size and that place first.
    pub(crate) const fn about(effect: &'static Effect) -> Self {
        Self { effect, numbers: |p| (vec![p[0]], p[0] * p[1]) }
    }
}

/// Where within a position servo an effect on its command acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InServo {
    /// On the error of position: the first parameter is half the width of a band in which it is not felt.
    Error,
    /// On its force: the first parameter is the most that there is.
    Force,
}

/// What a law can depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variable {
    /// The channel's coordinate, or first-order state.
    Coordinate,
    /// The channel's velocity.
    Velocity,
    /// The channel's acceleration: the law adds to the mass matrix.
    Acceleration,
    /// The coordinate of the other channel.
    OtherCoordinate,
    /// The velocity of the other channel.
    OtherVelocity,
    /// Time.
    Time,
    /// The input it acts on.
    Input,
    /// The input that a force law names.
    OtherInput,
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
    /// Second-order coordinates, and first-order states that are speeds.
    CoordinatesAndSpeeds,
    /// Inputs.
    Inputs,
    /// Measured channels.
    Sensors,
    /// Links of a robot that move.
    Links,
    /// What a robot stands on.
    Base,
}

impl Acts {
    /// Where it acts, in a sentence, on a channel of this name: `on elbow`, `on link forearm`.
    #[must_use]
    pub fn at(self, channel: &str) -> String {
        match self {
            Self::Links => format!("on link {channel}"),
            Self::Base => format!("of the {channel}"),
            _ => format!("on {channel}"),
        }
    }
}

/// The one channel of [`Acts::Base`].
pub const BASE: &str = "base";

/// The one shape of a law that has no shape parameters.
#[must_use]
pub fn one_shape(_scales: &Scales) -> Vec<Vec<f64>> {
    vec![vec![]]
}
