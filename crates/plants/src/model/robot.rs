//! What a model that is a robot's says beside the robot's own file.

use super::Model;
use crate::dynamics::PARTS;
use lacuna_rigid::{Format, InertialParameters};
use std::path::PathBuf;

/// A robot's own file, as it was read.
#[derive(Debug)]
pub struct RobotFile {
    /// Where it is.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
    /// The format of it.
    pub format: Format,
    /// Gravity that it states, or that holds where it states none, m/s^2, in the root's frame.
    pub stated_gravity: [f64; 3],
    /// Gravity in the model.
    pub gravity: [f64; 3],
}

/// The parameters of a robot's body and its joint.
#[derive(Clone, Debug)]
pub struct BodyParameters<T> {
    /// Inertia of the link with all that is fixed to it.
    pub inertia: InertialParameters<T>,
    /// Viscous friction of the joint.
    pub damping: T,
    /// Dry friction of it.
    pub friction: T,
    /// Inertia of its rotor.
    pub armature: T,
    /// Stiffness of a spring in it.
    pub stiffness: T,
}

impl Model {
    /// The robot's own file, where the model names one.
    #[must_use]
    pub fn robot_file(&self) -> Option<&RobotFile> {
        self.source.as_ref()?.robot.as_ref()
    }

    /// What is known of each parameter (its value, its name), body by body, in the order of the
    /// dynamics' [tree](crate::dynamics::Dynamics::tree); nothing where the model is no robot's.
    pub fn by_body<T: Clone>(&self, of_parameters: &[T]) -> Vec<BodyParameters<T>> {
        let bodies = self.dynamics.tree().map_or(0, |tree| tree.bodies.len());
        let of_body = |p: &[T]| {
            let at = |k: usize| p[k].clone();
            BodyParameters {
                inertia: InertialParameters {
                    mass: at(0),
                    centre: std::array::from_fn(|k| at(1 + k)),
                    inertia: std::array::from_fn(|k| at(4 + k)),
                },
                damping: at(10),
                friction: at(11),
                armature: at(12),
                stiffness: at(13),
            }
        };
        of_parameters.chunks_exact(PARTS.len()).take(bodies).map(of_body).collect()
    }
}
