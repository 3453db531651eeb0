//! Changes of an XML text by byte ranges: all else stays as it was written.

use super::Element;
use std::ops::Range;

/// What is to be put in the place of some ranges of a text.
pub(crate) struct Patch<'t> {
    text: &'t str,
    pieces: Vec<(Range<usize>, String)>,
}

impl<'t> Patch<'t> {
    /// Of the text that the elements are of.
    pub fn new(text: &'t str) -> Self {
        Self { text, pieces: vec![] }
    }

    /// The changed text.
    pub fn done(mut self) -> String {
        // What is put in the same place stays in order.
        self.pieces.sort_by_key(|(range, _)| (range.start, range.end));
        let (mut out, mut at) = (String::with_capacity(self.text.len()), 0);
        for (range, piece) in &self.pieces {
            out.push_str(&self.text[at..range.start]);
            out.push_str(piece);
            at = range.end;
        }
        out + &self.text[at..]
    }

    /// Give an attribute a value, in the place of its old one or behind the others.
    pub fn set(&mut self, element: Element, name: &str, value: &str) {
        if let Some(range) = self.value(element, name) {
            self.pieces.push((range, value.to_owned()));
            return;
        }
        let end = self.head_end(element);
        self.pieces.push((end..end, format!(" {name}=\"{value}\"")));
    }

    /// Take attributes away, each with the space before it.
    pub fn remove(&mut self, element: Element, names: &[&str]) {
        for attribute in element.node.attributes().filter(|a| names.contains(&a.name())) {
            let Range { start, end } = attribute.range();
            let before = self.text[..start].trim_end().len();
            self.pieces.push((before..end, String::new()));
        }
    }

    /// Put elements or comments in front of an element, each in a line of its own if that one is.
    pub fn before(&mut self, element: Element, parts: &[String]) {
        let start = element.node.range().start;
        let gap = self.gap(start).unwrap_or_default();
        let text: String = parts.iter().map(|part| format!("{part}{gap}")).collect();
        self.pieces.push((start..start, text));
    }

    /// Put elements or comments first into an element.
    pub fn first_in(&mut self, of: Element, parts: &[String]) {
        let Some(first) = of.node.children().find(|n| n.is_element()) else {
            return self.only_in(of, parts);
        };
        let gap = self.gap(first.range().start).unwrap_or_default();
        let head = self.head_end(of);
        let at = self.text[head..].find('>').map_or(head, |length| head + length + 1);
        self.pieces.push((at..at, joined(&gap, parts)));
    }

    /// Put elements or comments last into an element.
    pub fn last_in(&mut self, of: Element, parts: &[String]) {
        let Some(last) = of.node.children().rfind(|n| n.is_element()) else {
            return self.only_in(of, parts);
        };
        let gap = self.gap(last.range().start).unwrap_or_default();
        let at = last.range().end;
        self.pieces.push((at..at, joined(&gap, parts)));
    }

    /// Put elements or comments into one that holds no element.
    fn only_in(&mut self, of: Element, parts: &[String]) {
        let Range { start, end } = of.node.range();
        let (outer, inner) = match self.gap(start) {
            Some(gap) => (gap.clone(), gap + "  "),
            None => Default::default(),
        };
        let inside = joined(&inner, parts);
        match self.text[start..end].strip_suffix("/>") {
            Some(head) => {
                let at = start + head.trim_end().len();
                let tag: &str = head[1..].split_whitespace().next().unwrap_or_default();
                self.pieces.push((at..end, format!(">{inside}{outer}</{tag}>")));
            }
            None => {
                let at = start + self.text[start..end].rfind("</").unwrap_or_default();
                let broken = self.text[..at].trim_end().len();
                let outer = if broken < at { "" } else { outer.as_str() };
                self.pieces.push((broken..broken, format!("{inside}{outer}")));
            }
        }
    }

    /// Where the value of an attribute stands, between its quotes.
    fn value(&self, element: Element, name: &str) -> Option<Range<usize>> {
        let attribute = element.node.attributes().find(|a| a.name() == name)?;
        let Range { start, end } = attribute.range();
        let quote = self.text[..end].chars().next_back()?;
        let open = self.text[start..end].find(quote)?;
        Some(start + open + 1..end - 1)
    }

    /// Behind the last attribute of an element, or its tag.
    fn head_end(&self, element: Element) -> usize {
        let start = element.node.range().start;
        let ends = |c: char| c.is_whitespace() || c == '/' || c == '>';
        let tag = self.text[start..].find(ends).map_or(start, |length| start + length);
        element.node.attributes().map(|a| a.range().end).fold(tag, usize::max)
    }

    /// The end of a line and the space at the begin of the next, where nothing else stands before a place.
    fn gap(&self, at: usize) -> Option<String> {
        let line = self.text[..at].rfind('\n')?;
        let margin = &self.text[line + 1..at];
        let end = if self.text[..line].ends_with('\r') { "\r\n" } else { "\n" };
        margin.trim().is_empty().then(|| format!("{end}{margin}"))
    }
}

fn joined(gap: &str, parts: &[String]) -> String {
    parts.iter().map(|part| format!("{gap}{part}")).collect()
}

/// A comment that says something.
pub(crate) fn comment(says: &str) -> String {
    // Two dashes end one.
    format!("<!-- {} -->", says.replace("--", "- -"))
}

/// Numbers that are read as what they are.
pub(crate) fn numbers(all: &[f64]) -> String {
    let one = |x: &f64| match x.abs() {
        size if size == 0.0 || (1e-5..1e16).contains(&size) => x.to_string(),
        _ => format!("{x:e}"),
    };
    all.iter().map(one).collect::<Vec<_>>().join(" ")
}

/// The same of what was computed: without the last digit, which is that of rounding.
pub(crate) fn computed(all: &[f64]) -> String {
    let rounded = |x: &f64| format!("{x:.14e}").parse().unwrap_or(*x);
    numbers(&all.iter().map(rounded).collect::<Vec<_>>())
}
