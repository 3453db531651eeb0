//! Position servos: what a motor makes of the position that it is told to take.
//!
//! ```text
//! tau = clamp(k_p e - k_d v, -tau_max, tau_max),    e = d - clamp(d, -b/2, b/2),    d = u - q
//! ```
//!
//! | on paper | in code | unit |
//! | --- | --- | --- |
//! | commanded position u | the input of the servo | that of the coordinate |
//! | coordinate q, velocity v | the coordinate that it drives | |
//! | force tau on it | [`BoundServo::force`] | that of the coordinate's generalised force |
//! | gain k_p, damping k_d | its first two parameters | force per coordinate, per velocity |
//! | most force tau_max, play b | those that follow, each where there is one | force, coordinate |
//!
//! Behind the parameters of all dynamics may stand what a model leaves out of its servos, [`SERVO`] numbers of
//! each: half the width of a dead band of e beside the play, and one over a limit of tau; 0 where there is none.

use super::Point;
use lacuna_numbers::Number;

/// Numbers of what a model leaves out of a servo.
pub const SERVO: usize = 2;

/// A position servo: where it stands, and what it is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Servo {
    /// The coordinate that it drives.
    pub coordinate: usize,
    /// The input that it follows.
    pub input: usize,
    /// Whether the model knows how much force it has at most.
    pub saturates: bool,
    /// Whether the model knows of play between it and the coordinate.
    pub plays: bool,
}

impl Servo {
    /// Number of its parameters.
    pub(crate) fn parameters(self) -> usize {
        2 + usize::from(self.saturates) + usize::from(self.plays)
    }

    /// The servos with their parameters, one after the other, and with what is left out of them, if anything is.
    pub(crate) fn bound<T: Number>(
        all: &[Self],
        mut parameters: &[T],
        left_out: &[T],
    ) -> Vec<BoundServo<T>> {
        let mut left_out = left_out.chunks_exact(SERVO);
        let mut bound = |servo: &Self| {
            let (own, rest) = parameters.split_at(servo.parameters());
            parameters = rest;
            servo.with(own, left_out.next())
        };
        all.iter().map(&mut bound).collect()
    }

    fn with<T: Number>(self, own: &[T], left_out: Option<&[T]>) -> BoundServo<T> {
        let zero = T::constant(0.0);
        let (gains, rest) = own.split_at(2);
        let limit = rest.first().filter(|_| self.saturates).map(|limit| limit.max(zero));
        let play = rest.last().filter(|_| self.plays).map(|play| (*play * 0.5).max(zero));
        let (band, inverse) = left_out.map_or((zero, zero), |numbers| (numbers[0], numbers[1]));
        let band = (band.value() > 0.0 || band.moves()).then_some(band);
        let other = (inverse.value() > 0.0).then(|| T::constant(1.0) / inverse);
        let Self { coordinate, input, .. } = self;
        BoundServo {
            coordinate,
            input,
            gain: gains[0],
            damping: gains[1],
            limit: of_both(limit, other, T::min),
            half_width: of_both(play, band, |a, b| a + b),
        }
    }
}

fn of_both<T>(a: Option<T>, b: Option<T>, both: impl Fn(T, T) -> T) -> Option<T> {
    match (a, b) {
        (Some(a), Some(b)) => Some(both(a, b)),
        (one, other) => one.or(other),
    }
}

/// A servo with its parameters set.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoundServo<T> {
    pub coordinate: usize,
    input: usize,
    gain: T,
    damping: T,
    limit: Option<T>,
    /// Half the width of the band in which it does not feel its error.
    half_width: Option<T>,
}

impl<T: Number> BoundServo<T> {
    /// How far its coordinate is from the command.
    #[inline(always)]
    pub fn off(&self, at: &Point<T>) -> T {
        at.inputs[self.input] - at.coordinates[self.coordinate]
    }

    /// The force on its coordinate.
    #[inline(always)]
    pub fn force(&self, at: &Point<T>) -> T {
        let off = self.off(at);
        let error = match self.half_width {
            Some(half_width) => off - off.clamp(-half_width, half_width),
            None => off,
        };
        let force = self.gain * error - self.damping * at.velocities[self.coordinate];
        match self.limit {
            Some(limit) => force.clamp(-limit, limit),
            None => force,
        }
    }

    /// The same in plain numbers.
    #[inline(always)]
    pub fn value(&self) -> BoundServo<f64> {
        let Self { coordinate, input, .. } = *self;
        BoundServo {
            coordinate,
            input,
            gain: self.gain.value(),
            damping: self.damping.value(),
            limit: self.limit.map(T::value),
            half_width: self.half_width.map(T::value),
        }
    }
}
