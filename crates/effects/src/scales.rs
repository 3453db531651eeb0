//! Magnitudes of a channel in the recordings.

/// Periods in the recordings up to which a grid covers the frequencies of what repeats.
pub const GRID: f64 = 80.0;
/// Periods over the range of a coordinate up to which a grid covers the wavenumbers of what repeats over it.
pub const PITCHES: f64 = 20.0;
/// Spectral lines beyond these that are told of a channel.
pub const LINES: usize = 16;

/// Magnitudes of a channel in the recordings: what priors and grids of shapes are spread over.
#[derive(Clone, Copy, Debug)]
pub struct Scales {
    /// Smallest and largest coordinate.
    pub q: (f64, f64),
    /// Radians or metres of a unit of the coordinate ([`crate::Channel::si`]).
    pub si: f64,
    /// Half the range that the coordinate usually covers within an eighth of a recording.
    pub stroke: f64,
    /// Standard deviation of the velocity.
    pub v: f64,
    /// Standard deviation of the acceleration.
    pub acceleration: f64,
    /// Standard deviation of the force that moves it.
    pub force: f64,
    /// What the force moves by itself: its inertia in the model, 1 of a first-order state.
    pub inertia: f64,
    /// The other channel of a coupling: half its range, its velocity and its force.
    pub other: (f64, f64, f64),
    /// The difference of its coordinate and that of the other channel: half its range, and the
    /// standard deviation of its rate.
    pub apart: (f64, f64),
    /// Standard deviation and largest absolute value of the input, or of the one that a force law
    /// names.
    pub input: (f64, f64),
    /// Mean sample step (s).
    pub step: f64,
    /// Begin and end of the recordings' time (s).
    pub time: (f64, f64),
    /// Angular frequencies that stand out of what the motion needs beside the model, beyond those that a grid covers,
    /// the strongest first; 0 where there are no more.
    pub lines: [f64; LINES],
    /// Wavenumbers over the coordinate that stand out likewise.
    pub pitches: [f64; LINES],
    /// Of a link: the mass of all of the robot that moves (kg), and how far from its joint it reaches (m).
    pub link: (f64, f64),
}

impl Default for Scales {
    /// Nothing moves, in radians or metres.
    fn default() -> Self {
        Self {
            q: (0.0, 0.0),
            si: 1.0,
            stroke: 0.0,
            v: 0.0,
            acceleration: 0.0,
            force: 0.0,
            inertia: 0.0,
            other: (0.0, 0.0, 0.0),
            apart: (0.0, 0.0),
            input: (0.0, 0.0),
            step: 0.0,
            time: (0.0, 0.0),
            lines: [0.0; LINES],
            pitches: [0.0; LINES],
            link: (0.0, 0.0),
        }
    }
}

impl Scales {
    /// Half the range of the coordinate.
    #[must_use]
    pub fn half_range(&self) -> f64 {
        0.5 * (self.q.1 - self.q.0)
    }

    /// Middle of the range of the coordinate.
    #[must_use]
    pub fn centre(&self) -> f64 {
        0.5 * (self.q.0 + self.q.1)
    }

    /// Rate at which the channel moves through its range (rad/s).
    #[must_use]
    pub fn rate(&self) -> f64 {
        self.v / self.half_range()
    }

    /// Usual size of the input: half of its largest, so that one with an offset has one as well.
    #[must_use]
    pub fn usual_input(&self) -> f64 {
        0.5 * self.input.1
    }

    /// Length of the recordings (s).
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.time.1 - self.time.0
    }
}
