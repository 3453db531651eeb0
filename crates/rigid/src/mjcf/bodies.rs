//! `<worldbody>`: bodies within bodies, and the joints between them.

use super::defaults::{ClassId, Defaults, Part};
use super::frames::pose;
use super::inertia;
use super::joints;
use super::settings::{EXPAND, Settings};
use crate::Inertia;
use crate::algebra::Pose;
use crate::joints::Several;
use crate::robot::{Ends, Link, Moves, RobotError, RobotJoint};
use crate::xml::Element;

/// Links and joints: the first link is the world.
pub(super) struct Bodies<'s, 'a> {
    pub links: Vec<Link>,
    pub joints: Vec<RobotJoint>,
    /// The coordinate of each joint where the file places bodies.
    pub references: Vec<f64>,
    settings: &'s Settings,
    defaults: &'s Defaults<'a>,
    /// MuJoCo's numbers of the body and of the joint that come next.
    next: (usize, usize),
}

/// An element of a body with the class that holds there, and the frame that it is told in, as that
/// stands in the body's.
#[derive(Clone, Copy)]
struct Content<'a> {
    element: Element<'a>,
    class: ClassId,
    frame: Pose,
}

/// A body whose turn is to come.
struct Open<'a> {
    body: Content<'a>,
    parent: usize,
    /// Whether any joint moves its parent.
    moving: bool,
}

impl<'s, 'a> Bodies<'s, 'a> {
    pub fn read(
        root: Element<'a>,
        settings: &'s Settings,
        defaults: &'s Defaults<'a>,
    ) -> Result<Self, RobotError> {
        let Some(first) = root.child("worldbody") else {
            return Err(root.error("there is no <worldbody>: nothing can be simulated"));
        };
        let world = Link { name: "world".to_owned(), inertia: Inertia::none(), line: first.line() };
        let mut all = Self {
            links: vec![world],
            joints: vec![],
            references: vec![],
            settings,
            defaults,
            next: (1, 0),
        };
        let mut open = vec![];
        for world in root.children("worldbody") {
            let class = defaults.class(world, "childclass", ClassId::MAIN)?;
            open.extend(within(&all.contents(world, class)?, (0, false)));
        }
        open.reverse();
        // Not by recursion: a file may be a chain of thousands.
        while let Some(next) = open.pop() {
            let inner = all.body(&next)?;
            open.extend(inner.into_iter().rev());
        }
        Ok(all)
    }

    /// What a body holds, in the file's order and with what is in its `<frame>`s.
    fn contents(&self, of: Element<'a>, class: ClassId) -> Result<Vec<Content<'a>>, RobotError> {
        let inside = |of: Element<'a>, class, frame| {
            of.elements().rev().map(move |element| Content { element, class, frame })
        };
        let mut open: Vec<_> = inside(of, class, Pose::SAME).collect();
        let mut contents = vec![];
        while let Some(content) = open.pop() {
            let element = content.element;
            match element.tag() {
                "frame" => {
                    let class = self.defaults.class(element, "childclass", content.class)?;
                    let own = pose(&Part::alone(element), self.settings)?;
                    open.extend(inside(element, class, content.frame.then(&own)));
                }
                "body" | "joint" | "freejoint" | "geom" | "inertial" | "site" | "camera"
                | "light" => contents.push(content),
                tag => {
                    let message = format!("<{tag}> in {} is not read. {EXPAND}", of.called());
                    return Err(element.error(message));
                }
            }
        }
        Ok(contents)
    }

    /// Take up a body, and find those in it.
    fn body(&mut self, open: &Open<'a>) -> Result<Vec<Open<'a>>, RobotError> {
        let Content { element, class, frame } = open.body;
        let name = named(element, "body", &mut self.next.0);
        let class = self.defaults.class(element, "childclass", class)?;
        let contents = self.contents(element, class)?;
        let joints = tagged(&contents, &["joint", "freejoint"]);
        let moving = open.moving || !joints.is_empty();
        // Nobody feels the weight of what stands still, of which files often say nothing.
        let inertia = if moving { self.inertia(element, &contents)? } else { Inertia::none() };
        let pose = frame.then(&pose(&Part::alone(element), self.settings)?);
        let link = Link { name, inertia, line: element.line() };
        self.carry(link, &joints, (open.parent, pose))?;
        Ok(within(&contents, (self.links.len() - 1, moving)).collect())
    }

    fn inertia(
        &self,
        body: Element<'a>,
        contents: &[Content<'a>],
    ) -> Result<Inertia<f64>, RobotError> {
        let why = "compensated gravity is not simulated";
        Part::alone(body).check_unset("gravcomp", why)?;
        let geoms = tagged(contents, &["geom"]);
        let geoms = geoms.iter().map(|c| Ok((self.part(c)?, c.frame)));
        let geoms = geoms.collect::<Result<Vec<_>, RobotError>>()?;
        inertia::of_body(body, &geoms, self.settings)
    }

    fn part(&self, content: &Content<'a>) -> Result<Part<'s, 'a>, RobotError> {
        self.defaults.part(content.element, content.element.tag(), content.class)
    }

    /// Hang a link up by its joints, the first next to the parent, with links of no mass between them.
    fn carry(
        &mut self,
        link: Link,
        joints: &[Content<'a>],
        (mut parent, mut pose): (usize, Pose),
    ) -> Result<(), RobotError> {
        for (k, content) in joints.iter().enumerate() {
            let part = self.part(content)?;
            let name = named(part.own, "joint", &mut self.next.1);
            if k + 1 < joints.len() {
                let name = format!("{}/{name}", link.name);
                self.links.push(Link { name, inertia: Inertia::none(), line: part.own.line() });
            } else {
                self.links.push(link.clone());
            }
            let ends = Ends { parent, child: self.links.len() - 1, pose };
            let joint = joints::read(&part, (name, content.frame), ends, self.settings)?;
            let free = joint.moves == Moves::Several(Several::Floating);
            if free && (parent, joints.len()) != (0, 1) {
                let message = format!(
                    "{} is free: it moves a body of the world, and is all that moves that",
                    part.own.called()
                );
                return Err(part.own.error(message));
            }
            self.joints.push(joint);
            self.references.push(joints::reference(&part, self.settings)?);
            (parent, pose) = (self.links.len() - 1, Pose::SAME);
        }
        if joints.is_empty() {
            let ends = Ends { parent, child: self.links.len(), pose };
            self.joints.push(joints::fixed(&link, ends));
            self.references.push(0.0);
            self.links.push(link);
        }
        Ok(())
    }
}

/// The name of an element, or its tag with its number.
pub(super) fn named(element: Element, tag: &str, next: &mut usize) -> String {
    let number = *next;
    *next += 1;
    element.get("name").map_or_else(|| format!("{tag}{number}"), str::to_owned)
}

fn tagged<'a>(contents: &[Content<'a>], tags: &[&str]) -> Vec<Content<'a>> {
    contents.iter().filter(|c| tags.contains(&c.element.tag())).copied().collect()
}

/// The bodies among what a body holds.
fn within<'a>(
    contents: &[Content<'a>],
    (parent, moving): (usize, bool),
) -> impl Iterator<Item = Open<'a>> + use<'a> {
    tagged(contents, &["body"]).into_iter().map(move |body| Open { body, parent, moving })
}
