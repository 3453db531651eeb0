//! A joint that another moves: its coordinate is `multiplier * that one's + offset`.

use super::Several;
use crate::robot::{Moves, Robot, RobotError};
use std::collections::HashMap;

/// What a joint follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mimic {
    /// The joint it follows, by its number.
    pub leader: usize,
    /// How far it goes where that goes by 1.
    pub multiplier: f64,
    /// Where it is where that is at 0.
    pub offset: f64,
    /// Where that stands in the file.
    pub line: u32,
}

impl Mimic {
    /// Of one that follows a joint that follows another itself.
    fn by_way_of(self, of_leader: Self) -> Self {
        let offset = self.multiplier * of_leader.offset + self.offset;
        Self { multiplier: self.multiplier * of_leader.multiplier, offset, ..of_leader }
    }
}

/// What part a joint has in how a robot moves.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Role {
    /// It is held still, at a coordinate.
    Still(f64),
    /// Its coordinates are its own.
    Leads,
    /// It follows one that leads.
    Follows(Mimic),
}

/// The roles of all joints where some are held.
pub(crate) fn roles(robot: &Robot, held: &HashMap<&str, f64>) -> Vec<Role> {
    let mut roles: Vec<Option<Role>> = vec![None; robot.joints.len()];
    for first in 0..roles.len() {
        // Not by recursion: each of thousands may follow the next.
        let (mut at, mut followers) = (first, vec![]);
        let mut role = loop {
            let joint = &robot.joints[at];
            let own = match (held.get(&*joint.name), joint.moves, joint.follows) {
                (Some(at), ..) => Some(Role::Still(*at)),
                (None, Moves::Fixed, _) => Some(Role::Still(0.0)),
                (None, _, None) => Some(Role::Leads),
                (None, _, Some(_)) => roles[at],
            };
            match (own, joint.follows) {
                (None, Some(mimic)) => {
                    followers.push((at, mimic));
                    at = mimic.leader;
                }
                (own, _) => break own.unwrap_or(Role::Leads),
            }
        };
        roles[at] = Some(role);
        while let Some((follower, mimic)) = followers.pop() {
            role = following(mimic, role);
            roles[follower] = Some(role);
        }
    }
    roles.into_iter().flatten().collect()
}

/// The role of a joint whose leader has another. One that its leader does not move stands still.
fn following(mimic: Mimic, leader: Role) -> Role {
    let follows = match leader {
        Role::Still(at) => return Role::Still(mimic.multiplier * at + mimic.offset),
        Role::Leads => mimic,
        Role::Follows(of_leader) => mimic.by_way_of(of_leader),
    };
    if follows.multiplier == 0.0 { Role::Still(follows.offset) } else { Role::Follows(follows) }
}

/// Joints of one coordinate follow others of one, and none follows itself.
pub(crate) fn check(robot: &Robot) -> Result<(), RobotError> {
    // Of each joint, the one whose way along leaders came to it first.
    let mut reached = vec![None; robot.joints.len()];
    for (first, joint) in robot.joints.iter().enumerate() {
        let (mut at, mut here) = (first, joint);
        while reached[at].is_none() {
            reached[at] = Some(first);
            let Some(mimic) = here.follows else { break };
            let leader = &robot.joints[mimic.leader];
            for end in [here, leader] {
                if let Moves::Several(several) = end.moves {
                    return Err(RobotError::at(mimic.line, of_one(&end.name, several)));
                }
            }
            if reached[mimic.leader] == Some(first) {
                let message = format!(
                    "joint '{}' follows itself, by way of the joints that follow it: one must lead",
                    leader.name
                );
                return Err(RobotError::at(mimic.line, message));
            }
            (at, here) = (mimic.leader, leader);
        }
    }
    Ok(())
}

fn of_one(name: &str, several: Several) -> String {
    format!(
        "joint '{name}' is {}: a joint of one coordinate follows another of one, leave its <mimic> out",
        several.called()
    )
}
