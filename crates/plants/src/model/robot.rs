//! What a model that is a robot's says beside the robot's own file.

use super::Model;
use crate::dynamics::{INERTIAL, PARTS};
use lacuna_rigid::{Format, InertialParameters};
use std::path::PathBuf;

/// A robot's own file, as it was read.
#[derive(Debug)]
pub struct RobotFile {
    /// Where it is, unless its text stands in the model file.
    pub path: Option<PathBuf>,
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
    pub fn by_body<T: Copy>(&self, of_parameters: &[T]) -> Vec<BodyParameters<T>> {
        let bodies = self.dynamics.tree().map_or(0, |tree| tree.bodies.len());
        let of_body = |&[own @ .., damping, friction, armature, stiffness]: &[T; PARTS.len()]| {
            let inertia = InertialParameters::of_entries(&own);
            BodyParameters { inertia, damping, friction, armature, stiffness }
        };
        of_parameters.as_chunks().0.iter().take(bodies).map(of_body).collect()
    }

    /// The same of the inertia of each part that is told apart from the link that it is fixed to, in the order of
    /// [`lacuna_rigid::Tree::apart`].
    pub fn by_part<T: Copy>(&self, of_parameters: &[T]) -> Vec<InertialParameters<T>> {
        let Some(tree) = self.dynamics.tree() else { return vec![] };
        let of_parts = of_parameters.get(PARTS.len() * tree.bodies.len()..).unwrap_or_default();
        let parts = of_parts.as_chunks::<INERTIAL>().0.iter().take(tree.apart().count());
        parts.map(InertialParameters::of_entries).collect()
    }
}
