//! `<default>` classes: what elements do not say themselves.

use crate::robot::RobotError;
use crate::xml::{Element, numbers_or, positive_or};
use std::collections::HashMap;

/// Classes within each other. The file's own way to say things is two or three deep.
const DEEPEST: usize = 100;

/// What all actuators are called in classes: MuJoCo has one default for them, by whichever name it is stated.
pub(super) const ACTUATOR: &str = "general";

const ACTUATORS: [&str; 11] = [
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "orientation",
    "pid",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "dcmotor",
];

/// The classes of a file; the first is what holds where none is named.
pub(super) struct Defaults<'a> {
    classes: Vec<Class<'a>>,
    places: HashMap<&'a str, usize>,
}

/// A class by its number.
#[derive(Clone, Copy)]
pub(super) struct ClassId(usize);

impl ClassId {
    pub const MAIN: Self = Self(0);
}

#[derive(Default)]
struct Class<'a> {
    parent: Option<usize>,
    /// The element that states an attribute of elements of a tag.
    stated: HashMap<(&'a str, &'a str), Element<'a>>,
}

impl<'a> Defaults<'a> {
    pub fn read(root: Element<'a>) -> Result<Self, RobotError> {
        let mut defaults =
            Self { classes: vec![Class::default()], places: HashMap::from([("main", 0)]) };
        let mut open: Vec<_> = root.children("default").map(|e| (e, 0, 1)).collect();
        open.reverse();
        while let Some((element, class, depth)) = open.pop() {
            if depth > DEEPEST {
                let message = format!("classes are more than {DEEPEST} deep in each other");
                return Err(element.error(message));
            }
            let mut inner = vec![];
            for child in element.elements() {
                if child.tag() == "default" {
                    inner.push((child, defaults.begun(child, class)?, depth + 1));
                } else {
                    let tag = child.tag();
                    let tag = if ACTUATORS.contains(&tag) { ACTUATOR } else { tag };
                    let stated = child.attributes().map(|name| ((tag, name), child));
                    defaults.classes[class].stated.extend(stated);
                }
            }
            open.extend(inner.into_iter().rev());
        }
        Ok(defaults)
    }

    fn begun(&mut self, element: Element<'a>, parent: usize) -> Result<usize, RobotError> {
        let name = element.attribute("class")?;
        let place = self.classes.len();
        if self.places.insert(name, place).is_some() {
            return Err(element.error(format!("class '{name}' is there twice")));
        }
        self.classes.push(Class { parent: Some(parent), ..Class::default() });
        Ok(place)
    }

    /// The class that an attribute of an element names, or else the one it is in.
    pub fn class(
        &self,
        element: Element,
        attribute: &str,
        otherwise: ClassId,
    ) -> Result<ClassId, RobotError> {
        let Some(name) = element.get(attribute) else { return Ok(otherwise) };
        self.places.get(name).map(|place| ClassId(*place)).ok_or_else(|| {
            let message = format!(
                "{} names the class '{name}', which there is not: it is a <default class=\"...\">",
                element.called()
            );
            element.error(message)
        })
    }

    /// An element with what its class, or else the one that holds there, says of elements of a tag.
    pub fn part<'s>(
        &'s self,
        own: Element<'a>,
        tag: &'a str,
        class: ClassId,
    ) -> Result<Part<'s, 'a>, RobotError> {
        Ok(Part { own, tag, class: Some((self, self.class(own, "class", class)?)) })
    }
}

/// An element with what its class says of it.
#[derive(Clone, Copy)]
pub(super) struct Part<'s, 'a> {
    pub own: Element<'a>,
    /// What such elements are called in classes.
    tag: &'a str,
    class: Option<(&'s Defaults<'a>, ClassId)>,
}

impl<'a> Part<'_, 'a> {
    /// An element that no class says anything of.
    pub fn alone(own: Element<'a>) -> Self {
        Self { own, tag: own.tag(), class: None }
    }

    /// The first attribute that is stated of some, and where: the element's own, or else those of its
    /// class, or of the class that this is in.
    pub fn stated<'n>(&self, names: &[&'n str]) -> Option<(Element<'a>, &'n str)> {
        let of = |element: Option<Element<'a>>, name| Some((element?, name));
        let own = |name: &&'n str| of(Some(self.own).filter(|e| e.get(name).is_some()), *name);
        names.iter().find_map(own).or_else(|| {
            self.classes().find_map(|class| {
                let in_class = |name| class.stated.get(&(self.tag, name)).copied();
                names.iter().find_map(|name| of(in_class(name), *name))
            })
        })
    }

    /// All places where an attribute is stated, what counts most first.
    pub fn all_stated(&self, name: &str) -> Vec<Element<'a>> {
        let own = Some(self.own).filter(|e| e.get(name).is_some());
        let in_class = |class: &Class<'a>| class.stated.get(&(self.tag, name)).copied();
        own.into_iter().chain(self.classes().filter_map(in_class)).collect()
    }

    /// The classes of the element, outwards.
    fn classes(&self) -> impl Iterator<Item = &Class<'a>> {
        let first = self.class.map(|(_, ClassId(class))| class);
        let all = self.class.map_or(&[][..], |(defaults, _)| &defaults.classes);
        std::iter::successors(first, |&class| all[class].parent).map(|class| &all[class])
    }

    /// Where an attribute is stated.
    pub fn holder(&self, name: &str) -> Option<Element<'a>> {
        self.stated(&[name]).map(|(element, _)| element)
    }

    pub fn get(&self, name: &str) -> Option<&'a str> {
        self.holder(name)?.get(name)
    }

    pub fn numbers_or<const N: usize>(
        &self,
        name: &str,
        otherwise: [f64; N],
    ) -> Result<[f64; N], RobotError> {
        numbers_or(self.holder(name), name, otherwise)
    }

    /// A number that may not be below 0; 0 where nothing is said.
    pub fn positive(&self, name: &str) -> Result<f64, RobotError> {
        self.positive_or(name, 0.0)
    }

    pub fn positive_or(&self, name: &str, otherwise: f64) -> Result<f64, RobotError> {
        positive_or(self.holder(name), (self.own, name), otherwise)
    }

    /// What is not simulated must not be stated.
    pub fn check_unset(&self, name: &str, why: &str) -> Result<(), RobotError> {
        match self.holder(name) {
            Some(element) if element.list(name)?.iter().all(|x| *x > 0.0) => {
                Err(element.error(format!("{name} of {}: {why}", self.own.called())))
            }
            _ => Ok(()),
        }
    }
}
