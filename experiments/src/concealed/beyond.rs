//! Draws of the laws beyond the catalogue.

use rand_chacha::ChaCha8Rng;

use super::effects::{log_uniform, sign, uniform};
use super::off_formula::Law;
use super::scales::ChannelScale;

/// Kinds of laws, so that each comes as often.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// LuGre friction.
    LuGre,
    /// Dahl friction.
    Dahl,
    /// Friction that grows with the load.
    LoadFriction,
    /// An end stop with damping.
    DampedStop,
    /// An end stop with Hertz's exponent.
    HertzianStop,
    /// Drag with exponent 1.6.
    PowerDrag,
    /// A softening spring.
    SofteningSpring,
    /// A force at one place.
    Bump,
    /// A level that runs over.
    Overflow,
}

impl Kind {
    /// Whether it can act on a coordinate, and whether on a rotor's speed, and whether on a level.
    pub fn acts(self) -> [bool; 3] {
        match self {
            Self::Overflow => [false, false, true],
            Self::PowerDrag | Self::Dahl => [true, true, false],
            _ => [true, false, false],
        }
    }

    /// Draw a law of this kind for a channel.
    pub fn draw(self, c: ChannelScale, rng: &mut ChaCha8Rng) -> Law {
        let strength = log_uniform(rng, 0.12, 0.4) * c.force;
        let (half, v) = (c.half_range(), c.velocity);
        match self {
            Self::LuGre => {
                let stiffness = strength / (uniform(rng, 0.003, 0.02) * half);
                Law::LuGre {
                    stiffness,
                    damping: uniform(rng, 0.4, 1.2) * (stiffness * c.mass).sqrt(),
                    coulomb: strength,
                    static_: uniform(rng, 1.2, 1.8) * strength,
                    stribeck_velocity: uniform(rng, 0.1, 0.3) * v,
                }
            }
            Self::Dahl => Law::Dahl {
                stiffness: strength / (uniform(rng, 0.01, 0.06) * half),
                coulomb: strength,
            },
            Self::LoadFriction => Law::LoadFriction {
                magnitude: 0.5 * strength,
                share: uniform(rng, 0.1, 0.3),
                smoothing_velocity: uniform(rng, 0.005, 0.02) * v,
            },
            Self::DampedStop | Self::HertzianStop => self.stop(c, strength, rng),
            Self::PowerDrag => Law::PowerDrag { coefficient: 0.8 * strength / v.powf(1.6) },
            Self::SofteningSpring => {
                let (stiffness, scale) =
                    (3.0 * strength / half, uniform(rng, 0.25, 0.6) * half.max(c.centre().abs()));
                match sign(rng) > 0.0 {
                    true => Law::RationalSpring { stiffness, scale },
                    false => Law::SaturatingSpring { stiffness, scale },
                }
            }
            Self::Bump => Law::Bump {
                force: 2.5 * sign(rng) * strength,
                centre: c.centre() + sign(rng) * uniform(rng, 0.0, 0.5) * half,
                width: uniform(rng, 0.12, 0.25) * half,
            },
            Self::Overflow => {
                let share = uniform(rng, 0.3, 0.6);
                Law::Overflow {
                    rate: uniform(rng, 4.0, 10.0) * strength / ((1.0 - share) * half),
                    level: c.centre() + share * half,
                }
            }
        }
    }

    fn stop(self, c: ChannelScale, strength: f64, rng: &mut ChaCha8Rng) -> Law {
        let (side, share) = (sign(rng), uniform(rng, 0.45, 0.75));
        let depth = (1.0 - share) * c.half_range();
        let position = c.centre() + side * share * c.half_range();
        let push = uniform(rng, 2.5, 6.0) * strength;
        if self == Self::HertzianStop {
            let stiffness = push / depth.powf(1.5);
            let damping = uniform(rng, 0.1, 0.6) / c.velocity;
            return Law::HertzianStop { stiffness, damping, position, side };
        }
        let stiffness = push / depth;
        let damping = uniform(rng, 0.1, 0.5) * 2.0 * (stiffness * c.mass).sqrt();
        Law::DampedStop { stiffness, damping, position, side }
    }
}
