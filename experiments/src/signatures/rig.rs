//! What moves in the pictures: a joint that turns back and forth beside another one, and a level that
//! rises and falls.

use lacuna_charts::Axis;
use lacuna_effects::{Acts, At, Channel, Effect, Scales, Variable};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Angular frequency of the motion (rad/s).
const FREQUENCY: f64 = 2.0;
/// What hangs on a link: mass of all of its robot that moves (kg), and how far it reaches (m).
const LINK: (f64, f64) = (5.0, 0.15);
/// Where a state has the channel and the other one.
const CHANNELS: [Channel; 2] = [Channel::ALONE[0], Channel { q: 2, v: 3, si: 1.0 }];
/// The same for a law that names the input.
const WITH_INPUT: [Channel; 2] = [CHANNELS[0], Channel::input(0)];
/// The one number that a first-order state is.
const STATE: [Channel; 2] = [Channel { q: 0, v: 0, si: 1.0 }, Channel { q: 2, v: 2, si: 1.0 }];

/// What moves, in numbers and words.
#[derive(Debug)]
pub struct Rig {
    /// Magnitudes.
    pub scales: Scales,
    /// What moves, its unit, and the unit of what moves it.
    pub channel: [&'static str; 3],
    /// What moves it.
    pub force: &'static str,
    first_order: bool,
}

impl Rig {
    /// The one that suits an effect.
    #[must_use]
    pub fn of(effect: &Effect) -> Self {
        if effect.acts == Acts::States { Self::level() } else { Self::joint() }
    }

    /// A joint that turns by half a turn either way.
    #[must_use]
    pub fn joint() -> Self {
        let (reach, speed, torque) = (PI, FREQUENCY * PI, 1.0);
        let scales = Scales {
            q: (-reach, reach),
            stroke: reach,
            v: FRAC_1_SQRT_2 * speed,
            acceleration: FRAC_1_SQRT_2 * FREQUENCY * speed,
            force: torque,
            inertia: torque / (FRAC_1_SQRT_2 * FREQUENCY * speed),
            other: (reach, FRAC_1_SQRT_2 * speed, torque),
            apart: (reach, FRAC_1_SQRT_2 * speed),
            input: (7.0, 10.0),
            step: 0.05,
            time: (0.0, 10.0),
            link: LINK,
            ..Scales::default()
        };
        let channel = ["position", "rad", "N m"];
        Self { scales, channel, force: "torque", first_order: false }
    }

    /// A level between 0 and 1 m.
    fn level() -> Self {
        let (reach, flow) = (0.5, 0.01);
        let scales = Scales {
            q: (0.0, 2.0 * reach),
            stroke: reach,
            v: FRAC_1_SQRT_2 * reach,
            acceleration: flow,
            force: flow,
            inertia: 1.0,
            other: (reach, FRAC_1_SQRT_2 * reach, flow),
            apart: (reach, FRAC_1_SQRT_2 * reach),
            ..Self::joint().scales
        };
        let channel = ["level", "m", "m/s"];
        Self { scales, channel, force: "rate", first_order: true }
    }

    /// The axis of a variable.
    #[must_use]
    pub fn axis(&self, variable: Variable) -> Axis {
        let [name, unit, _] = self.channel;
        let per = |k: &str| format!("{unit}/s{k}");
        match variable {
            Variable::Coordinate => Axis::linear(name, unit),
            Variable::Velocity => Axis::linear("velocity", &per("")),
            Variable::Acceleration => Axis::linear("acceleration", &per("\u{b2}")),
            Variable::OtherCoordinate => Axis::linear(&format!("{name} of the other"), unit),
            Variable::OtherVelocity => Axis::linear("velocity of the other", &per("")),
            Variable::Time => Axis::linear("time", "s"),
            Variable::Input | Variable::OtherInput => Axis::linear("command", "V"),
        }
    }

    /// The axis of what moves it.
    #[must_use]
    pub fn force_axis(&self) -> Axis {
        Axis::linear(self.force, self.channel[2])
    }

    /// The least and the greatest value that a variable has.
    #[must_use]
    pub fn range(&self, variable: Variable) -> (f64, f64) {
        let s = &self.scales;
        let both = |most: f64| (-most, most);
        match variable {
            Variable::Coordinate | Variable::OtherCoordinate => s.q,
            Variable::Velocity | Variable::OtherVelocity => both(s.v / FRAC_1_SQRT_2),
            Variable::Acceleration => both(s.acceleration / FRAC_1_SQRT_2),
            Variable::Time => s.time,
            Variable::Input | Variable::OtherInput => both(s.input.1),
        }
    }

    /// A moment of a motion at rest in its middle.
    #[must_use]
    pub fn rest(&self) -> Moment {
        let q = self.scales.centre();
        Moment { q, other_q: q, ..Moment::default() }
    }

    /// A motion to and fro, as far and as fast as shares of the usual one say, at so many samples a cycle.
    #[must_use]
    pub fn cycles(
        &self,
        (stroke, speed): (f64, f64),
        cycles: usize,
        samples: usize,
    ) -> Vec<Moment> {
        let (w, reach) = (speed * FREQUENCY, stroke * self.scales.half_range());
        let moment = |k: usize| {
            let turned = std::f64::consts::TAU * k as f64 / samples as f64;
            let (sin, cos) = turned.sin_cos();
            Moment {
                t: turned / w,
                q: self.scales.centre() + reach * sin,
                v: reach * w * cos,
                acceleration: -reach * w * w * sin,
                ..self.rest()
            }
        };
        (0..=cycles * samples).map(moment).collect()
    }
}

/// What a force law sees at one moment.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moment {
    /// Time (s).
    pub t: f64,
    /// Coordinate, or first-order state.
    pub q: f64,
    /// Velocity.
    pub v: f64,
    /// Acceleration.
    pub acceleration: f64,
    /// Coordinate of the other channel.
    pub other_q: f64,
    /// Velocity of the other channel.
    pub other_v: f64,
    /// The input that a law names.
    pub input: f64,
}

impl Moment {
    /// The same with another value of a variable.
    #[must_use]
    pub fn with(self, variable: Variable, value: f64) -> Self {
        match variable {
            Variable::Coordinate => Self { q: value, ..self },
            Variable::Velocity => Self { v: value, ..self },
            Variable::Acceleration => Self { acceleration: value, ..self },
            Variable::OtherCoordinate => Self { other_q: value, ..self },
            Variable::OtherVelocity => Self { other_v: value, ..self },
            Variable::Time => Self { t: value, ..self },
            Variable::Input | Variable::OtherInput => Self { input: value, ..self },
        }
    }

    /// The state that it stands for.
    #[must_use]
    pub fn state(&self) -> [f64; 4] {
        [self.q, self.v, self.other_q, self.other_v]
    }

    /// As a law of an effect sees it, with this state and memory.
    #[must_use]
    pub fn at<'a>(
        &'a self,
        rig: &Rig,
        effect: &Effect,
        state: &'a [f64],
        memory: &'a [f64],
    ) -> At<'a> {
        let channels: &[Channel] = match (rig.first_order, effect.names_input()) {
            (true, _) => &STATE,
            (false, true) => &WITH_INPUT,
            (false, false) => &CHANNELS,
        };
        let inputs = std::slice::from_ref(&self.input);
        At { memory, inputs, acceleration: self.acceleration, ..At::new(self.t, state, channels) }
    }
}
