//! What a force law sees of the machine.

use lacuna_numbers::Number;

/// Where a channel's coordinate and velocity stand in the machine's state. On a first-order
/// state both are the state itself, so that friction laws act on it as loss laws. Of an input that
/// a law names both are its place among the inputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// Place of the coordinate.
    pub q: usize,
    /// Place of the velocity.
    pub v: usize,
    /// Radians of a unit of the coordinate where that is an angle, metres where it is a length; 1 of any other.
    pub si: f64,
}

impl Channel {
    /// One channel alone, in a state of its coordinate and velocity.
    pub const ALONE: [Self; 1] = [Self { q: 0, v: 1, si: 1.0 }];

    /// An input that a law names.
    #[must_use]
    pub const fn input(place: usize) -> Self {
        Self { q: place, v: place, si: 1.0 }
    }
}

/// Where and when a force law is evaluated, in any kind of number.
#[derive(Clone, Copy, Debug)]
pub struct At<'a, T = f64> {
    /// Time (s).
    pub t: f64,
    /// Time from sample to sample (s): what begins or ends at a time is told by recordings to
    /// one sample only, and so is its derivative. 0 where nothing is sampled.
    pub sample: f64,
    /// The machine's state.
    pub state: &'a [T],
    /// The channel that the law acts on, then the others, or the input, that it names.
    pub channels: &'a [Channel],
    /// The machine's inputs, as the actuators apply them.
    pub inputs: &'a [T],
    /// The law's own memory.
    pub memory: &'a [T],
    /// Acceleration of the channel, where the motion is given. It is 0 where the equations of
    /// motion are yet to be solved for it: there a law's inertia is part of the mass matrix.
    pub acceleration: T,
}

impl<'a, T: Number> At<'a, T> {
    /// At this time and state, without inputs and memory.
    pub fn new(t: f64, state: &'a [T], channels: &'a [Channel]) -> Self {
        let acceleration = T::constant(0.0);
        Self { t, sample: 0.0, state, channels, inputs: &[], memory: &[], acceleration }
    }

    /// Coordinate of the channel.
    #[inline(always)]
    #[must_use]
    pub fn q(&self) -> T {
        self.state[self.channels[0].q]
    }

    /// The channel's coordinate as an angle in radians, whatever its unit (as a length in metres), see
    /// [`Channel::si`].
    #[inline(always)]
    #[must_use]
    pub fn angle(&self) -> T {
        self.q() * self.channels[0].si
    }

    /// Velocity of the channel.
    #[inline(always)]
    #[must_use]
    pub fn v(&self) -> T {
        self.state[self.channels[0].v]
    }

    /// Coordinate of the `k`-th of the other channels.
    #[inline(always)]
    #[must_use]
    pub fn other_q(&self, k: usize) -> T {
        self.state[self.channels[k + 1].q]
    }

    /// Velocity of the `k`-th of the other channels.
    #[inline(always)]
    #[must_use]
    pub fn other_v(&self, k: usize) -> T {
        self.state[self.channels[k + 1].v]
    }

    /// The input that the law names.
    #[inline(always)]
    #[must_use]
    pub fn input(&self) -> T {
        self.inputs[self.channels[1].q]
    }
}
