//! A robot, as its own file has it.

use super::Finding;
use lacuna_effects::{Acts, Quantity};
use lacuna_plants::Model;
use serde::{Deserialize, Serialize};

/// A robot, as its own file has it: what findings are grouped by.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Robot {
    /// Format of the file: "URDF", "MJCF".
    pub format: String,
    /// The joints that move.
    pub joints: Vec<Joint>,
}

/// A joint of a robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Its name and that of its coordinate.
    pub name: String,
    /// Name of its velocity.
    pub velocity: String,
    /// Name of the input that drives it.
    pub input: String,
    /// The link that it moves.
    pub link: String,
    /// Viscous friction that the file states, N m s/rad or N s/m.
    pub damping: f64,
    /// Dry friction that it states, N m or N.
    pub friction: f64,
    /// Rotor inertia that it states, kg m^2 or kg.
    pub armature: f64,
    /// Stiffness of a spring that it states, N m/rad or N/m.
    pub stiffness: f64,
}

impl Robot {
    /// The robot that a model is of; none of another model.
    #[must_use]
    pub fn of(model: &Model) -> Option<Self> {
        let (file, tree) = (model.robot_file()?, model.dynamics().tree()?);
        let driven = model.coordinates.iter().zip(&model.inputs);
        let leading = tree.leading.iter().map(|&body| &tree.bodies[body]);
        let joints = leading.zip(driven).map(|(body, (coordinate, input))| Joint {
            name: coordinate.name.clone(),
            velocity: coordinate.velocity.clone(),
            input: input.name.clone(),
            link: body.name.clone(),
            damping: body.joint.damping,
            friction: body.joint.friction,
            armature: body.joint.armature,
            stiffness: body.joint.stiffness,
        });
        Some(Self { format: file.format.name().to_owned(), joints: joints.collect() })
    }
}

impl Joint {
    /// Whether a finding is of this joint: of its coordinate, its motor, or the link that it moves.
    #[must_use]
    pub fn has(&self, finding: &Finding) -> bool {
        let channel = finding.channel.as_str();
        match lacuna_effects::find(&finding.class).map(|e| e.acts) {
            Some(Acts::Links) => channel == self.link,
            Some(Acts::Base) => false,
            _ => [&self.name, &self.velocity, &self.input].iter().any(|own| *own == channel),
        }
    }

    /// How much of a quantity the file states; none where files state no such.
    #[must_use]
    pub fn stated(&self, quantity: Quantity) -> Option<f64> {
        match quantity {
            Quantity::Damping => Some(self.damping),
            Quantity::Friction => Some(self.friction),
            Quantity::RotorInertia => Some(self.armature),
            Quantity::Stiffness => Some(self.stiffness),
            Quantity::Force | Quantity::Gain => None,
        }
    }
}
