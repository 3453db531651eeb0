//! The plants: each a plain model file beside this one, and how it is driven.
//!
//! A new plant is a model file, an entry of [`PLANTS`], and nothing else.

mod chain;

pub use chain::draw as draw_chain;

use super::drive::{Drive, Loop, Signal};

/// A plant of the proof.
#[derive(Debug)]
pub struct PlantSpec {
    /// Text of its model file with ordinary parameters; each case draws its own around them.
    pub model: &'static str,
    /// Ways to drive it, one of which a case draws.
    pub drives: &'static [Drive],
    /// Range of each entry of the machine's state (coordinates, velocities, first-order states)
    /// at the beginning.
    pub start: &'static [[f64; 2]],
    /// Time between samples (s).
    pub step: f64,
    /// Samples of a recording.
    pub samples: usize,
    /// First-order states that some machines of the kind do not measure.
    pub inner: &'static [&'static str],
    /// Classes of the catalogue that make physical sense on a first-order state.
    pub on_states: &'static [(&'static str, &'static [&'static str])],
    /// Classes that make no sense on this plant's coordinates or inputs.
    pub without: &'static [&'static str],
    /// Joints of a robot, whose own file is drawn; 0 is none.
    pub joints: usize,
}

/// A plant without its particulars.
const PLAIN: PlantSpec = PlantSpec {
    model: "",
    drives: &[],
    start: &[],
    step: 0.01,
    samples: 1200,
    inner: &[],
    on_states: &[],
    without: &[],
    joints: 0,
};

const MOTION: Signal = signal([0.15, 0.45], [0.6, 6.0]);
/// As many as a robot has joints.
static MOTIONS: [Signal; 5] = [MOTION; 5];
static STARTS: [[f64; 2]; 10] = [[-0.2, 0.2]; 10];

const fn moves(references: &'static [Signal]) -> [Drive; 1] {
    [Drive::ComputedTorque { stiffness: 60.0, damping: 12.0, references }]
}
static MOVES: [[Drive; 1]; 4] = [
    moves(MOTIONS.split_at(2).0),
    moves(MOTIONS.split_at(3).0),
    moves(MOTIONS.split_at(4).0),
    moves(&MOTIONS),
];

/// A robot of so many joints, two to five, that computed torque moves.
const fn robot(joints: usize) -> PlantSpec {
    PlantSpec {
        model: include_str!("chain.toml"),
        drives: &MOVES[joints - 2],
        start: STARTS.split_at(2 * joints).0,
        step: 0.005,
        samples: 1500,
        joints,
        ..PLAIN
    }
}

const fn signal(amplitude: [f64; 2], band: [f64; 2]) -> Signal {
    Signal { terms: 4, offset: 0.0, amplitude, band }
}

/// What acts on a level or a temperature.
const LEVEL: &[&str] = &["linear_loss", "quadratic_loss", "step_change", "periodic_disturbance"];
/// What acts on the speed of a rotor.
const ROTOR: &[&str] = &[
    "coulomb_friction",
    "asymmetric_friction",
    "quadratic_loss",
    "constant_force",
    "step_change",
    "periodic_disturbance",
];
/// The input is a road, no actuator.
const NO_ACTUATOR: &[&str] =
    &["gain_error", "dead_zone", "saturation", "input_delay", "actuator_lag", "cogging"];

/// Robots.
pub static ROBOTS: &[PlantSpec] = &[robot(2), robot(3), robot(4), robot(5)];

/// All other plants.
pub static PLANTS: &[PlantSpec] = &[
    PlantSpec {
        model: include_str!("pendulum.toml"),
        drives: &[Drive::Open(&[signal([0.3, 0.8], [0.5, 5.0])])],
        start: &[[-0.6, 0.6], [-0.5, 0.5]],
        step: 0.006,
        samples: 2000,
        ..PLAIN
    },
    PlantSpec {
        model: include_str!("duffing.toml"),
        drives: &[Drive::Open(&[signal([0.15, 0.5], [0.6, 4.0])])],
        start: &[[-1.0, 1.0], [-0.5, 0.5]],
        ..PLAIN
    },
    PlantSpec {
        model: include_str!("stage.toml"),
        drives: &[
            Drive::Regulated(&[Loop {
                input: 0,
                coordinate: 0,
                stiffness: 400.0,
                damping: 52.0,
                reference: signal([0.02, 0.08], [0.5, 6.0]),
            }]),
            Drive::Open(&[signal([3.0, 9.0], [0.8, 8.0])]),
        ],
        start: &[[-0.05, 0.05], [-0.05, 0.05]],
        step: 0.005,
        samples: 2400,
        ..PLAIN
    },
    PlantSpec {
        model: include_str!("two_mass.toml"),
        drives: &[Drive::Open(&[signal([0.25, 0.7], [0.8, 12.0])])],
        start: &[[-0.2, 0.2], [-0.2, 0.2], [-0.2, 0.2], [-0.2, 0.2]],
        step: 0.004,
        samples: 2500,
        ..PLAIN
    },
    PlantSpec {
        model: include_str!("two_link.toml"),
        drives: &[
            Drive::ComputedTorque {
                stiffness: 60.0,
                damping: 12.0,
                references: &[signal([0.2, 0.6], [0.5, 4.0]), signal([0.2, 0.6], [0.5, 5.0])],
            },
            Drive::Regulated(&[
                Loop {
                    input: 0,
                    coordinate: 0,
                    stiffness: 260.0,
                    damping: 38.0,
                    reference: signal([0.2, 0.6], [0.5, 4.0]),
                },
                Loop {
                    input: 1,
                    coordinate: 1,
                    stiffness: 24.0,
                    damping: 2.6,
                    reference: signal([0.2, 0.6], [0.5, 5.0]),
                },
            ]),
        ],
        start: &[[-0.4, 0.4], [-0.4, 0.4], [-0.2, 0.2], [-0.2, 0.2]],
        step: 0.005,
        samples: 2000,
        ..PLAIN
    },
    PlantSpec {
        model: include_str!("dc_motor.toml"),
        drives: &[Drive::Open(&[signal([1.0, 3.5], [0.6, 9.0])])],
        start: &[[-0.3, 0.3], [-2.0, 2.0]],
        step: 0.005,
        samples: 2400,
        on_states: &[("w", ROTOR)],
        ..PLAIN
    },
    PlantSpec {
        model: include_str!("tanks.toml"),
        drives: &[Drive::Open(&[Signal {
            terms: 4,
            offset: 5.0,
            amplitude: [0.5, 1.3],
            band: [0.003, 0.03],
        }])],
        start: &[[0.25, 0.5], [0.25, 0.5]],
        step: 2.0,
        samples: 1500,
        on_states: &[("h1", LEVEL), ("h2", LEVEL)],
        ..PLAIN
    },
    PlantSpec {
        model: include_str!("crane.toml"),
        drives: &[Drive::Regulated(&[Loop {
            input: 0,
            coordinate: 0,
            stiffness: 140.0,
            damping: 70.0,
            reference: signal([0.1, 0.35], [0.5, 4.5]),
        }])],
        start: &[[-0.1, 0.1], [-0.3, 0.3], [-0.1, 0.1], [-0.1, 0.1]],
        samples: 1600,
        ..PLAIN
    },
    PlantSpec {
        model: include_str!("quarter_car.toml"),
        drives: &[Drive::Open(&[signal([0.004, 0.016], [3.0, 45.0])])],
        start: &[[-0.01, 0.01], [-0.01, 0.01], [-0.05, 0.05], [-0.05, 0.05]],
        step: 0.004,
        samples: 2500,
        without: NO_ACTUATOR,
        ..PLAIN
    },
    PlantSpec {
        model: include_str!("quadcopter_pitch.toml"),
        drives: &[Drive::Regulated(&[Loop {
            input: 0,
            coordinate: 0,
            stiffness: 1.5,
            damping: 0.6,
            reference: signal([0.08, 0.25], [0.6, 6.0]),
        }])],
        start: &[[-0.2, 0.2], [-0.2, 0.2], [-0.05, 0.05]],
        step: 0.005,
        samples: 2400,
        inner: &["thrust"],
        ..PLAIN
    },
    PlantSpec {
        model: include_str!("gantry.toml"),
        drives: &[Drive::ComputedTorque {
            stiffness: 40.0,
            damping: 9.0,
            references: &[signal([0.05, 0.2], [0.5, 5.0]), signal([0.2, 0.6], [0.5, 5.0])],
        }],
        start: &[[-0.1, 0.1], [-0.4, 0.4], [-0.1, 0.1], [-0.2, 0.2]],
        step: 0.005,
        samples: 2000,
        ..PLAIN
    },
    PlantSpec {
        model: include_str!("heated_block.toml"),
        drives: &[Drive::Open(&[Signal {
            terms: 4,
            offset: 40.0,
            amplitude: [4.0, 12.0],
            band: [0.005, 0.08],
        }])],
        start: &[[40.0, 70.0], [35.0, 50.0]],
        step: 1.0,
        samples: 1500,
        on_states: &[("T1", LEVEL), ("T2", LEVEL)],
        ..PLAIN
    },
];
