//! Forces that obey none of the catalogue's formulas: what real machines do.
//!
//! | law | force on coordinate q with velocity v |
//! | --- | --- |
//! | LuGre friction | `-(s0 z + s1 z')`, `z' = v - s0 abs(v) z / g(v)`, `g = F_c + (F_s - F_c) exp(-(v/v_s)^2)` |
//! | Dahl friction | `-s0 z`, `z' = v - s0 abs(v) z / F_c` |
//! | load-dependent friction | `-(F + c abs(load)) tanh(v / v_0)` |
//! | damped end stop | `-(k d + c d')`, never pulling, d the depth |
//! | Hertzian end stop | `-k d^1.5 (1 + c d')`, never pulling |
//! | drag | `-c abs(v)^1.6 sign v` |
//! | softening spring | `-k q / (1 + (q/q_s)^2)` or `-k q_s tanh(q/q_s)` |
//! | bump | `A exp(-((q - c)/w)^2)` |
//! | overflow | `-k max(q - q_0, 0)` on a level |
//!
//! Sources: Canudas de Wit et al., IEEE Trans. Automatic Control 40(3), 1995 (LuGre); Dahl, The
//! Aerospace Corporation TOR-0158, 1968; Hunt and Crossley, J. Applied Mechanics 42(2), 1975.

/// What a law sees.
#[derive(Clone, Copy, Debug, Default)]
pub struct At {
    /// Coordinate, or first-order state.
    pub q: f64,
    /// Velocity; on a first-order state the state itself, as in the catalogue.
    pub v: f64,
    /// Generalised force that the model's own physics put on the channel.
    pub load: f64,
}

/// A law with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)] // The parameters are those of the table above.
pub enum Law {
    LuGre { stiffness: f64, damping: f64, coulomb: f64, static_: f64, stribeck_velocity: f64 },
    Dahl { stiffness: f64, coulomb: f64 },
    LoadFriction { magnitude: f64, share: f64, smoothing_velocity: f64 },
    DampedStop { stiffness: f64, damping: f64, position: f64, side: f64 },
    HertzianStop { stiffness: f64, damping: f64, position: f64, side: f64 },
    PowerDrag { coefficient: f64 },
    RationalSpring { stiffness: f64, scale: f64 },
    SaturatingSpring { stiffness: f64, scale: f64 },
    Bump { force: f64, centre: f64, width: f64 },
    Overflow { rate: f64, level: f64 },
}

/// Exponent of the drag.
const DRAG_EXPONENT: f64 = 1.6;
/// Exponent of Hertz's contact.
const HERTZ_EXPONENT: f64 = 1.5;

impl Law {
    /// Name of the class, which the catalogue may not have.
    pub fn class(&self) -> &'static str {
        match self {
            Self::LuGre { .. } => "lugre_friction",
            Self::Dahl { .. } => "dahl_friction",
            Self::LoadFriction { .. } => "load_dependent_friction",
            Self::DampedStop { .. } => "damped_end_stop",
            Self::HertzianStop { .. } => "hertzian_end_stop",
            Self::PowerDrag { .. } => "power_drag",
            Self::RationalSpring { .. } | Self::SaturatingSpring { .. } => "softening_spring",
            Self::Bump { .. } => "force_bump",
            Self::Overflow { .. } => "overflow",
        }
    }

    /// Classes that count as its name: the nearest ones of the catalogue.
    pub fn nearest(&self) -> &'static [&'static str] {
        match self {
            Self::LuGre { .. } | Self::Dahl { .. } | Self::LoadFriction { .. } => &[
                "coulomb_friction",
                "stribeck_friction",
                "asymmetric_friction",
                "hysteresis",
                "lugre_friction",
                "load_friction",
                "maxwell_slip",
                "dahl_friction",
                "presliding_friction",
            ],
            Self::DampedStop { .. } | Self::HertzianStop { .. } => {
                &["end_stop", "damped_end_stop", "hertzian_end_stop"]
            }
            Self::PowerDrag { .. } => {
                &["quadratic_drag", "viscous_friction", "quadratic_loss", "linear_loss"]
            }
            Self::RationalSpring { .. } | Self::SaturatingSpring { .. } => {
                &["cubic_stiffness", "linear_stiffness", "gravity_torque"]
            }
            Self::Bump { .. } => &[],
            Self::Overflow { .. } => &["end_stop"],
        }
    }

    /// Whether it acts on the coordinate, and whether on the velocity.
    pub fn depends_on(&self) -> (bool, bool) {
        match self {
            Self::LuGre { .. }
            | Self::Dahl { .. }
            | Self::LoadFriction { .. }
            | Self::PowerDrag { .. } => (false, true),
            Self::DampedStop { .. } | Self::HertzianStop { .. } => (true, true),
            Self::RationalSpring { .. }
            | Self::SaturatingSpring { .. }
            | Self::Bump { .. }
            | Self::Overflow { .. } => (true, false),
        }
    }

    /// Where on the coordinate it acts, if not everywhere; a bump within two of its widths.
    pub fn region(&self) -> Option<[f64; 2]> {
        let beyond = |position: f64, side: f64| match side > 0.0 {
            true => [position, f64::INFINITY],
            false => [f64::NEG_INFINITY, position],
        };
        match *self {
            Self::DampedStop { position, side, .. } | Self::HertzianStop { position, side, .. } => {
                Some(beyond(position, side))
            }
            Self::Overflow { level, .. } => Some(beyond(level, 1.0)),
            Self::Bump { centre, width, .. } => Some([centre - 2.0 * width, centre + 2.0 * width]),
            _ => None,
        }
    }

    /// Number of memory states: the bristle's deflection.
    pub fn memory(&self) -> usize {
        usize::from(matches!(self, Self::LuGre { .. } | Self::Dahl { .. }))
    }

    /// The force; the rate of the memory `z` goes into `rate`.
    pub fn force(&self, at: At, z: &[f64], rate: &mut [f64]) -> f64 {
        let At { q, v, load } = at;
        match *self {
            Self::LuGre { stiffness, damping, coulomb, static_, stribeck_velocity } => {
                let level =
                    coulomb + (static_ - coulomb) * (-(v / stribeck_velocity).powi(2)).exp();
                rate[0] = v - stiffness * v.abs() * z[0] / level;
                -(stiffness * z[0] + damping * rate[0])
            }
            Self::Dahl { stiffness, coulomb } => {
                rate[0] = v - stiffness * v.abs() * z[0] / coulomb;
                -stiffness * z[0]
            }
            Self::LoadFriction { magnitude, share, smoothing_velocity } => {
                -(magnitude + share * load.abs()) * (v / smoothing_velocity).tanh()
            }
            Self::DampedStop { stiffness, damping, position, side } => {
                stop(side * (q - position), side * v, side, |depth, speed| {
                    stiffness * depth + damping * speed
                })
            }
            Self::HertzianStop { stiffness, damping, position, side } => {
                stop(side * (q - position), side * v, side, |depth, speed| {
                    stiffness * depth.powf(HERTZ_EXPONENT) * (1.0 + damping * speed)
                })
            }
            Self::PowerDrag { coefficient } => {
                -coefficient * v.abs().powf(DRAG_EXPONENT) * v.signum()
            }
            Self::RationalSpring { stiffness, scale } => {
                -stiffness * q / (1.0 + (q / scale).powi(2))
            }
            Self::SaturatingSpring { stiffness, scale } => -stiffness * scale * (q / scale).tanh(),
            Self::Bump { force, centre, width } => force * (-((q - centre) / width).powi(2)).exp(),
            Self::Overflow { rate, level } => -rate * (q - level).max(0.0),
        }
    }
}

/// The push of a stop, against its side, at a depth that grows with a speed.
fn stop(depth: f64, speed: f64, side: f64, push: impl Fn(f64, f64) -> f64) -> f64 {
    if depth <= 0.0 { 0.0 } else { -side * push(depth, speed).max(0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sliding steadily, the bristles of both friction models carry their friction level.
    #[test]
    fn bristles_settle_at_the_friction_level() {
        let lugre = Law::LuGre {
            stiffness: 1e3,
            damping: 3.0,
            coulomb: 2.0,
            static_: 3.0,
            stribeck_velocity: 0.1,
        };
        let dahl = Law::Dahl { stiffness: 1e3, coulomb: 2.0 };
        for (law, v, level) in [(lugre, 1.0, 2.0), (lugre, 0.01, 2.99), (dahl, -0.3, -2.0)] {
            let (mut z, mut rate) = ([0.0], [0.0]);
            for _ in 0..200_000 {
                law.force(At { v, ..At::default() }, &z, &mut rate);
                z[0] += 1e-5 * rate[0];
            }
            let force = law.force(At { v, ..At::default() }, &z, &mut rate);
            assert!((force + level).abs() < 0.02, "{law:?}: {force}");
        }
    }

    #[test]
    fn stops_push_and_never_pull() {
        for (position, side) in [(0.5, 1.0), (-0.5, -1.0), (0.2, -1.0)] {
            let damped = Law::DampedStop { stiffness: 100.0, damping: 50.0, position, side };
            let hertz = Law::HertzianStop { stiffness: 100.0, damping: 0.2, position, side };
            let at = |depth: f64, v: f64| At { q: position + side * depth, v: side * v, load: 0.0 };
            for law in [damped, hertz] {
                assert_eq!(law.force(at(-0.1, 1.0), &[], &mut []), 0.0);
                assert!(law.force(at(0.1, 0.0), &[], &mut []) * side < 0.0);
                assert!(law.force(at(0.1, -9.0), &[], &mut []) * side <= 0.0);
                let [low, high] = law.region().unwrap();
                assert!((low..high).contains(&at(0.1, 0.0).q), "{law:?}");
            }
        }
    }

    #[test]
    fn a_soft_spring_is_linear_at_first() {
        for law in [
            Law::RationalSpring { stiffness: 2.0, scale: 1.0 },
            Law::SaturatingSpring { stiffness: 2.0, scale: 1.0 },
        ] {
            let force = |q: f64| law.force(At { q, ..At::default() }, &[], &mut []);
            assert!((force(1e-3) + 2e-3).abs() < 1e-8);
            assert!(force(2.0) > -2.0 * 2.0 * 0.6);
        }
    }
}
