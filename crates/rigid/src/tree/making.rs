//! A robot's tree: what moves it, and what is part of what.

use super::{Body, Joint, Part, Tree, together};
use crate::Inertia;
use crate::algebra::{Pose, Vector, from_z};
use crate::joints::{JointKind, Role, Step, roles};
use crate::robot::{Moves, Robot, RobotError, RobotJoint};
use std::collections::{HashMap, HashSet};

/// A body in the making, with all that is found to be fixed to it.
struct Making {
    /// The joint of the robot whose coordinate it has, and whether it leads it.
    leader: usize,
    leads: bool,
    name: String,
    fixed: Vec<Part>,
    parent: Option<usize>,
    joint: Joint,
    inertia: Inertia<f64>,
    link_pose: Pose,
}

/// A body, none being the ground, and a frame that stands so in that of its link.
type Place = (Option<usize>, Pose);

impl Robot {
    /// The bodies that move when some joints are held still, each where it says: what hangs from a
    /// fixed joint or one that is held is part of its parent. Of a joint of several coordinates one may be
    /// held by its name.
    ///
    /// # Errors
    /// [`RobotError`]: what is held but does not exist, joints that are tied to others in ways that are not
    /// simulated, friction, rotors and springs of joints of several coordinates, coordinates that are called
    /// the same, a robot of which nothing moves.
    pub fn tree(&self, held: &[(String, f64)]) -> Result<Tree, RobotError> {
        let holdable = self.holdable();
        let all: HashSet<&str> = holdable.iter().map(String::as_str).collect();
        if let Some((name, _)) = held.iter().find(|(name, _)| !all.contains(&**name)) {
            let known = self.movable().join(", ");
            let message = format!("'{name}' is none of its joints: {known}");
            return Err(RobotError { line: None, message });
        }
        // The first counts where one is named twice.
        let held: HashMap<&str, f64> = held.iter().rev().map(|(name, at)| (&**name, *at)).collect();
        self.check_couplings(&held)?;
        let mut bodies = self.bodies(&held)?;
        if bodies.is_empty() {
            let message = "no joint moves: nothing can be simulated".to_owned();
            return Err(RobotError { line: None, message });
        }
        let leading = number(&mut bodies);
        self.check_names(&bodies)?;
        Ok(Tree { bodies: bodies.into_iter().map(Making::done).collect(), leading })
    }

    /// What moves, from the ground outwards.
    fn bodies(&self, held: &HashMap<&str, f64>) -> Result<Vec<Making>, RobotError> {
        let (hanging, roles) = (self.hanging(), roles(self, held));
        let mut growing = Growing { robot: self, held, bodies: vec![] };
        // Links whose joints are to come, with the body that they are a part of and where they stand in
        // it. Not by recursion: a file may be a chain of thousands.
        let mut open: Vec<(usize, Place)> =
            self.roots().into_iter().map(|link| (link, (None, Pose::SAME))).collect();
        while let Some((link, place)) = open.pop() {
            let mut below = vec![];
            for &number in &hanging[link] {
                let joint = &self.joints[number];
                let here = growing.hang(number, roles[number], place)?;
                below.push((joint.child, here));
            }
            open.extend(below.into_iter().rev());
        }
        Ok(growing.bodies)
    }

    /// A joint of several coordinates may have one that is called as another joint.
    fn check_names(&self, bodies: &[Making]) -> Result<(), RobotError> {
        let mut seen = HashSet::new();
        let twice = bodies.iter().find(|making| !seen.insert(&*making.joint.name));
        let Some(Making { joint, .. }) = twice else { return Ok(()) };
        let of = |other: &&RobotJoint| other.coordinates().contains(&joint.name);
        let names: Vec<&RobotJoint> = self.joints.iter().filter(of).collect();
        let message = format!(
            "'{}' is what coordinates of the joints '{}' are called: give one another name",
            joint.name,
            names.iter().map(|j| &*j.name).collect::<Vec<_>>().join("' and '")
        );
        Err(RobotError { line: names.last().map(|j| j.line), message })
    }
}

/// A tree that grows from the ground outwards.
struct Growing<'r> {
    robot: &'r Robot,
    held: &'r HashMap<&'r str, f64>,
    bodies: Vec<Making>,
}

impl Growing<'_> {
    /// Hang the child of a joint up, which the parent of stands in a place; where it then stands.
    fn hang(
        &mut self,
        number: usize,
        role: Role,
        (body, pose): Place,
    ) -> Result<Place, RobotError> {
        let joint = &self.robot.joints[number];
        let place = (body, pose.then(&joint.pose));
        match (role, joint.moves) {
            (Role::Still(at), _) => {
                if at != 0.0 && matches!(joint.moves, Moves::Several(_)) {
                    return Err(several_held(joint));
                }
                Ok(self.fix(joint, (body, place.1.then(&joint.moved(at)))))
            }
            (Role::Leads, Moves::By(kind)) => {
                let moving = Moving::leading(number, &joint.name, (kind, joint.axis));
                Ok(self.carry(joint, moving, place))
            }
            (Role::Follows(mimic), Moves::By(kind)) => {
                let moving = Moving::leading(mimic.leader, &joint.name, (kind, joint.axis));
                let ratio = (mimic.multiplier, mimic.offset);
                Ok(self.carry(joint, Moving { leads: false, ratio, ..moving }, place))
            }
            (_, Moves::Several(several)) => {
                self.chain((number, joint), &several.steps(joint.axis), place)
            }
            (_, Moves::Fixed) => Ok(self.fix(joint, place)),
        }
    }

    /// Take a joint's child as a part of the body that it stands in.
    fn fix(&mut self, joint: &RobotJoint, (body, pose): Place) -> Place {
        let part = &self.robot.links[joint.child];
        if let Some(body) = body {
            let (name, inertia) = (part.name.clone(), part.inertia);
            self.bodies[body].fixed.push(Part { name, is_apart: false, inertia, pose });
        }
        (body, pose)
    }

    /// A body that a joint of one coordinate moves, of its child alone.
    fn carry(&mut self, joint: &RobotJoint, moving: Moving, place: Place) -> Place {
        let link = &self.robot.links[joint.child];
        self.begin(joint, moving, place, (link.name.clone(), link.inertia));
        (Some(self.bodies.len() - 1), Pose::SAME)
    }

    /// The bodies that the coordinates of a joint move, the last of which is its child.
    fn chain(
        &mut self,
        (number, joint): (usize, &RobotJoint),
        steps: &[Step],
        mut place: Place,
    ) -> Result<Place, RobotError> {
        check_bare(joint)?;
        let (link, names) = (&self.robot.links[joint.child], joint.coordinates());
        let held: Vec<Option<f64>> = names.iter().map(|n| self.held.get(&**n).copied()).collect();
        let Some(last) = held.iter().rposition(Option::is_none) else {
            let still = steps.iter().zip(held.into_iter().flatten());
            place.1 = still.fold(place.1, |pose, (step, at)| pose.then(&step.moved(joint, at)));
            return Ok(self.fix(joint, place));
        };
        for (k, ((step, name), held)) in steps.iter().zip(&names).zip(held).enumerate() {
            if let Some(at) = held {
                place.1 = place.1.then(&step.moved(joint, at));
                continue;
            }
            let moving = Moving::leading(number, name, (step.kind, step.axis));
            let of = match k == last {
                true => (link.name.clone(), link.inertia),
                false => (format!("{}/{name}", link.name), Inertia::none()),
            };
            self.begin(joint, moving, place, of);
            place = (Some(self.bodies.len() - 1), Pose::SAME);
        }
        // Inertia is told in the frame of the child, which stands behind what is held after the last.
        if let Some(child) = self.bodies.last_mut() {
            child.link_pose = child.link_pose.then(&place.1);
        }
        Ok((place.0, Pose::SAME))
    }

    /// Begin a body that is moved about or along an axis.
    fn begin(
        &mut self,
        joint: &RobotJoint,
        Moving { leader, leads, name, kind, axis, ratio }: Moving,
        (parent, place): Place,
        (link, inertia): (String, Inertia<f64>),
    ) {
        let pose = match parent {
            Some(b) => self.bodies[b].link_pose.then(&place),
            None => place,
        };
        let RobotJoint {
            damping,
            friction,
            armature,
            stiffness,
            spring_reference,
            servo,
            line,
            ..
        } = *joint;
        let aligned = Pose { rotation: from_z(axis), translation: joint.anchor };
        let joint = Joint {
            name: name.to_owned(),
            of: joint.name.clone(),
            coordinate: 0,
            ratio: ratio.0,
            offset: ratio.1,
            kind,
            pose: pose.then(&aligned),
            damping,
            friction,
            armature,
            stiffness,
            spring_reference,
            servo,
            line,
        };
        self.bodies.push(Making {
            leader,
            leads,
            name: link,
            fixed: vec![],
            parent,
            joint,
            inertia,
            link_pose: aligned.inverse(),
        });
    }
}

/// How a body is moved.
struct Moving<'a> {
    leader: usize,
    leads: bool,
    /// What the coordinate is called.
    name: &'a str,
    kind: JointKind,
    axis: Vector<f64>,
    /// How far it goes where its coordinate goes by 1, and where it is where that is at 0.
    ratio: (f64, f64),
}

impl<'a> Moving<'a> {
    fn leading(leader: usize, name: &'a str, (kind, axis): (JointKind, Vector<f64>)) -> Self {
        Self { leader, leads: true, name, kind, axis, ratio: (1.0, 0.0) }
    }
}

impl Step {
    fn moved(&self, joint: &RobotJoint, at: f64) -> Pose {
        self.kind.moved(self.axis, joint.anchor, at)
    }
}

/// Number the coordinates in the order of the bodies that lead them, which are returned.
fn number(bodies: &mut [Making]) -> Vec<usize> {
    let (mut leading, mut of_leader) = (vec![], HashMap::new());
    for (place, body) in bodies.iter_mut().enumerate().filter(|(_, body)| body.leads) {
        body.joint.coordinate = leading.len();
        of_leader.insert(body.leader, leading.len());
        leading.push(place);
    }
    for body in bodies.iter_mut().filter(|body| !body.leads) {
        body.joint.coordinate = of_leader[&body.leader];
    }
    leading
}

/// Along which of its coordinates a file's friction, rotor or spring acts is not known.
fn check_bare(joint: &RobotJoint) -> Result<(), RobotError> {
    let stated = [
        ("damping", joint.damping),
        ("dry friction", joint.friction),
        ("armature", joint.armature),
        ("stiffness", joint.stiffness),
    ];
    let (Some((what, value)), Moves::Several(several)) =
        (stated.into_iter().find(|(_, value)| *value != 0.0), joint.moves)
    else {
        return Ok(());
    };
    let message = format!(
        "joint '{0}' is {1} and states {what} {value}, which is not simulated: leave it out, or hold the joint \
         still with locked = [\"{0}\"]",
        joint.name,
        several.called()
    );
    Err(RobotError::at(joint.line, message))
}

fn several_held(joint: &RobotJoint) -> RobotError {
    let names = joint.coordinates().join("\", \"");
    let message = format!(
        "joint '{}' has several coordinates: say where each is held, \"{names}\"",
        joint.name
    );
    RobotError::at(joint.line, message)
}

impl Making {
    fn done(self) -> Body {
        let Self { name, fixed, parent, joint, inertia: own, link_pose, .. } = self;
        let inertia = together(own, &fixed);
        Body { name, fixed, parent, joint, inertia, own, link_pose }
    }
}
