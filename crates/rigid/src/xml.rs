//! Elements of an XML text with the lines they stand in.

mod patch;

pub(crate) use patch::{Patch, comment, computed, numbers};

use crate::RobotError;
use roxmltree::{Document, Node};
use std::collections::HashMap;

/// A text that is XML.
pub(crate) struct Source<'t> {
    document: Document<'t>,
    /// Where lines end: to count them anew for each of many elements would be too slow.
    ends: Vec<usize>,
}

impl<'t> Source<'t> {
    pub fn parse(text: &'t str) -> Result<Self, RobotError> {
        let document = Document::parse(text).map_err(|e| {
            RobotError::at(e.pos().row, format!("this is no XML that can be read: {e}"))
        })?;
        Ok(Self { document, ends: text.match_indices('\n').map(|(at, _)| at).collect() })
    }

    /// The element that holds all others.
    pub fn root(&self) -> Element<'_> {
        Element { node: self.document.root_element(), ends: &self.ends }
    }
}

#[derive(Clone, Copy)]
pub(crate) struct Element<'a> {
    node: Node<'a, 'a>,
    ends: &'a [usize],
}

impl<'a> Element<'a> {
    pub fn tag(self) -> &'a str {
        self.node.tag_name().name()
    }

    /// Where its text begins.
    pub fn start(self) -> usize {
        self.node.range().start
    }

    pub fn line(self) -> u32 {
        let before = self.ends.partition_point(|at| *at < self.node.range().start);
        u32::try_from(before + 1).unwrap_or(u32::MAX)
    }

    /// `<joint> 'elbow'`.
    pub fn called(self) -> String {
        let tag = self.tag();
        let mut named =
            self.node.ancestors().filter_map(|n| Some((n.tag_name(), n.attribute("name")?)));
        match (self.get("name"), named.next()) {
            (Some(name), _) => format!("<{tag}> '{name}'"),
            (None, Some((of, name))) => format!("<{tag}> of {} '{name}'", of.name()),
            (None, None) => format!("<{tag}>"),
        }
    }

    /// The same if it is called so.
    pub fn expect(self, format: &str, tag: &str) -> Result<Self, RobotError> {
        if self.tag() == tag {
            return Ok(self);
        }
        Err(self.error(format!("{format} file holds a <{tag}>; found <{}>", self.tag())))
    }

    pub fn error(self, message: impl Into<String>) -> RobotError {
        RobotError::at(self.line(), message)
    }

    /// The elements in it.
    pub fn elements(self) -> impl DoubleEndedIterator<Item = Self> + 'a {
        let of = move |node| Self { node, ends: self.ends };
        self.node.children().filter(Node::is_element).map(of)
    }

    /// The elements in it, in those, and so on.
    pub fn descendants(self) -> impl Iterator<Item = Self> + 'a {
        let of = move |node| Self { node, ends: self.ends };
        self.node.descendants().filter(Node::is_element).map(of)
    }

    /// The names of its attributes.
    pub fn attributes(self) -> impl Iterator<Item = &'a str> {
        self.node.attributes().map(|a| a.name())
    }

    pub fn children(self, tag: &'static str) -> impl DoubleEndedIterator<Item = Self> + 'a {
        self.elements().filter(move |e| e.tag() == tag)
    }

    pub fn child(self, tag: &'static str) -> Option<Self> {
        self.children(tag).next()
    }

    pub fn required_child(self, tag: &'static str) -> Result<Self, RobotError> {
        self.child(tag).ok_or_else(|| self.error(format!("{} lacks its <{tag}>", self.called())))
    }

    pub fn get(self, name: &str) -> Option<&'a str> {
        self.node.attribute(name)
    }

    pub fn attribute(self, name: &str) -> Result<&'a str, RobotError> {
        self.get(name)
            .ok_or_else(|| self.error(format!("{} lacks its attribute '{name}'", self.called())))
    }

    /// The numbers of an attribute.
    pub fn numbers<const N: usize>(self, name: &str) -> Result<[f64; N], RobotError> {
        let many = || if N == 1 { "a number".to_owned() } else { format!("{N} numbers") };
        let all = finite(self.attribute(name)?).and_then(|all| all.try_into().ok());
        all.ok_or_else(|| self.must_be(name, &many()))
    }

    /// The same, however many there are.
    pub fn list(self, name: &str) -> Result<Vec<f64>, RobotError> {
        finite(self.attribute(name)?).ok_or_else(|| self.must_be(name, "numbers"))
    }

    /// What an attribute of this element must be, and is not.
    pub fn must_be(self, name: &str, what: &str) -> RobotError {
        let found = self.get(name).unwrap_or_default();
        self.error(format!("'{name}' of {} must be {what}; found \"{found}\"", self.called()))
    }
}

fn finite(text: &str) -> Option<Vec<f64>> {
    let parsed: Option<Vec<f64>> = text.split_whitespace().map(|n| n.parse().ok()).collect();
    parsed.filter(|all| all.iter().all(|n| n.is_finite()))
}

/// The numbers of an attribute of an element that may lack it, or not be there.
pub(crate) fn numbers_or<const N: usize>(
    element: Option<Element>,
    name: &str,
    otherwise: [f64; N],
) -> Result<[f64; N], RobotError> {
    match element.filter(|e| e.get(name).is_some()) {
        Some(element) => element.numbers(name),
        None => Ok(otherwise),
    }
}

/// The same of a number of `of` that may not be below 0.
pub(crate) fn positive_or(
    element: Option<Element>,
    (of, name): (Element, &str),
    otherwise: f64,
) -> Result<f64, RobotError> {
    let [number] = numbers_or(element, name, [otherwise])?;
    if number >= 0.0 {
        return Ok(number);
    }
    let message = format!("{name} of {} must be 0 or more; found {number}", of.called());
    Err(element.unwrap_or(of).error(message))
}

/// No inertia about an axis may be below 0.
pub(crate) fn check_diagonal(element: Element, [x, y, z]: [f64; 3]) -> Result<(), RobotError> {
    if x.min(y).min(z) >= 0.0 {
        return Ok(());
    }
    let called = element.called();
    Err(element.error(format!("inertia of {called} must be 0 or more: xx {x}, yy {y}, zz {z}")))
}

/// Names with their lines, of which none may be there twice.
pub(crate) fn check_twice<'a>(
    what: &str,
    all: impl Iterator<Item = (&'a str, u32)>,
) -> Result<(), RobotError> {
    let mut seen = HashMap::new();
    for (name, line) in all {
        if let Some(first) = seen.insert(name, line) {
            let message = format!("{what} '{name}' is there twice: the first is in line {first}");
            return Err(RobotError::at(line, message));
        }
    }
    Ok(())
}
