//! `<equality>` and `<tendon>`: what ties joints to each other.

use super::bodies::Bodies;
use super::defaults::{ClassId, Defaults, Part};
use crate::joints::Mimic;
use crate::robot::{Coupling, Moves, RobotError};
use crate::xml::Element;
use std::collections::HashMap;

/// Numbers of a `polycoef`.
const NUMBERS: usize = 5;

/// Ties between bodies. Each is followed through all bodies between its ends.
const MOST: usize = 1000;

pub(super) fn read<'a>(
    root: Element<'a>,
    bodies: &mut Bodies,
    defaults: &Defaults<'a>,
) -> Result<Vec<Coupling>, RobotError> {
    let mut ties = Ties::new(root, bodies);
    for element in root.children("tendon").flat_map(Element::elements) {
        let part = defaults.part(element, "tendon", ClassId::MAIN)?;
        ties.tendon(&part)?;
    }
    for element in root.children("equality").flat_map(Element::elements) {
        let part = defaults.part(element, "equality", ClassId::MAIN)?;
        if part.get("active") != Some("false") {
            ties.equality(&part)?;
        }
    }
    let (followers, couplings) = (ties.followers, ties.couplings);
    for (follower, mimic) in followers {
        bodies.joints[follower].follows = Some(mimic);
    }
    Ok(couplings)
}

struct Ties<'b, 'a> {
    bodies: &'b Bodies<'b, 'a>,
    followers: HashMap<usize, Mimic>,
    joints: HashMap<&'b str, usize>,
    links: HashMap<&'b str, usize>,
    tendons: HashMap<&'a str, Element<'a>>,
    /// The joint that carries each link, and that joint's parent.
    carriers: Vec<Option<(usize, usize)>>,
    /// Whether a joint is in a coupling: it need not be held twice.
    tied: Vec<bool>,
    couplings: Vec<Coupling>,
    between_bodies: usize,
}

impl<'b, 'a> Ties<'b, 'a> {
    fn new(root: Element<'a>, bodies: &'b Bodies<'b, 'a>) -> Self {
        let mut carriers = vec![None; bodies.links.len()];
        for (number, joint) in bodies.joints.iter().enumerate() {
            carriers[joint.child] = Some((number, joint.parent));
        }
        let tendons = root.children("tendon").flat_map(Element::elements);
        Self {
            bodies,
            followers: HashMap::new(),
            joints: bodies.joints.iter().enumerate().map(|(k, j)| (&*j.name, k)).collect(),
            links: bodies.links.iter().enumerate().map(|(k, l)| (&*l.name, k)).collect(),
            tendons: tendons.filter_map(|t| Some((t.get("name")?, t))).collect(),
            carriers,
            tied: vec![false; bodies.joints.len()],
            couplings: vec![],
            between_bodies: 0,
        }
    }

    /// A tendon that only leads an actuator's force pushes nothing itself.
    fn tendon(&mut self, part: &Part) -> Result<(), RobotError> {
        let acts = ["stiffness", "damping", "frictionloss", "armature"];
        for name in acts {
            let Some(holder) = part.holder(name) else { continue };
            if holder.list(name)?.iter().any(|x| *x != 0.0) {
                let joints = self.of_tendon(part.own)?;
                let what = format!(
                    "{} in <tendon> with its {name} acts between joints",
                    part.own.called()
                );
                self.tie(part.own, what, joints);
            }
        }
        Ok(())
    }

    fn equality(&mut self, part: &Part) -> Result<(), RobotError> {
        let element = part.own;
        let joints = match element.tag() {
            "joint" => {
                let both = self.two(element, "joint", |ties, of, name| {
                    named(&ties.joints, of, ("joint", name))
                })?;
                if self.follow(part, &both)? {
                    return Ok(());
                }
                both
            }
            "tendon" => {
                let both = self.two(element, "tendon", |ties, of, name| {
                    ties.of_tendon(named(&ties.tendons, of, ("tendon", name))?)
                })?;
                both.concat()
            }
            "connect" | "weld" if element.get("body1").is_some() => self.between(element)?,
            _ => {
                let message = format!(
                    "{} in <equality> is not simulated, and which joints it ties is not known: leave it out",
                    element.called()
                );
                return Err(element.error(message));
            }
        };
        let what = format!("{} in <equality> ties joints to each other", element.called());
        self.tie(element, what, joints);
        Ok(())
    }

    /// Have the first of two joints follow the second, unless it follows another already or not by a straight
    /// line, `q_1 - r_1 = a + b (q_2 - r_2)`; r is where the file places bodies. Whether it does.
    fn follow(&mut self, part: &Part, joints: &[usize]) -> Result<bool, RobotError> {
        let numbers = part.holder("polycoef").map_or(Ok(vec![]), |of| of.list("polycoef"))?;
        if numbers.len() > NUMBERS {
            return Err(part.own.must_be("polycoef", "5 numbers or fewer"));
        }
        let at = |k: usize, otherwise| numbers.get(k).copied().unwrap_or(otherwise);
        let straight = (2..NUMBERS).all(|k| at(k, 0.0) == 0.0);
        let of_one = |&j: &usize| matches!(self.bodies.joints[j].moves, Moves::By(_));
        let &[follower, leader] = joints else { return Ok(false) };
        if !straight || !joints.iter().all(of_one) || self.followers.contains_key(&follower) {
            return Ok(false);
        }
        let (a, multiplier, reference) = (at(0, 0.0), at(1, 1.0), &self.bodies.references);
        let offset = reference[follower] + a - multiplier * reference[leader];
        let mimic = Mimic { leader, multiplier, offset, line: part.own.line() };
        self.followers.insert(follower, mimic);
        Ok(true)
    }

    /// What `joint1` and `joint2`, or others of two, name; the second may be absent.
    fn two<T>(
        &self,
        element: Element,
        kind: &str,
        find: impl Fn(&Self, Element, &str) -> Result<T, RobotError>,
    ) -> Result<Vec<T>, RobotError> {
        let (first, second) = (format!("{kind}1"), format!("{kind}2"));
        let mut found = vec![find(self, element, element.attribute(&first)?)?];
        if let Some(name) = element.get(&second) {
            found.push(find(self, element, name)?);
        }
        Ok(found)
    }

    /// The joints of a tendon that is a sum of them.
    fn of_tendon(&self, tendon: Element) -> Result<Vec<usize>, RobotError> {
        if tendon.tag() != "fixed" {
            let message = format!("{} is not simulated: leave it out", tendon.called());
            return Err(tendon.error(message));
        }
        let joint = |of: Element| named(&self.joints, of, ("joint", of.attribute("joint")?));
        tendon.children("joint").map(joint).collect()
    }

    /// The joints that lie between the two bodies of a tie.
    fn between(&mut self, element: Element) -> Result<Vec<usize>, RobotError> {
        self.between_bodies += 1;
        if self.between_bodies > MOST {
            let message =
                format!("more than {MOST} ties between bodies in <equality> are not read");
            return Err(element.error(message));
        }
        let ends =
            self.two(element, "body", |ties, of, name| named(&ties.links, of, ("body", name)))?;
        let path = |end: usize| {
            let above = |(_, parent): &(usize, usize)| self.carriers[*parent];
            let mut path: Vec<_> = std::iter::successors(self.carriers[end], above).collect();
            path.reverse();
            path
        };
        let (one, other) = (path(ends[0]), ends.get(1).map_or_else(Vec::new, |end| path(*end)));
        let shared = one.iter().zip(&other).take_while(|(a, b)| a == b).count();
        Ok(one[shared..].iter().chain(&other[shared..]).map(|(joint, _)| *joint).collect())
    }

    fn tie(&mut self, element: Element, what: String, mut joints: Vec<usize>) {
        joints.retain(|&joint| !std::mem::replace(&mut self.tied[joint], true));
        self.couplings.push(Coupling { what, joints, line: element.line() });
    }
}

/// What a name stands for.
fn named<T: Copy>(
    all: &HashMap<&str, T>,
    element: Element,
    (kind, name): (&str, &str),
) -> Result<T, RobotError> {
    all.get(name).copied().ok_or_else(|| {
        let message = format!("{} names the {kind} '{name}', which there is not", element.called());
        element.error(message)
    })
}
