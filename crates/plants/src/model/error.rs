//! What can be wrong with a model file, with the place in it.

use std::fmt;

/// An error in a model file: what, where, and the line itself.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelError {
    /// The file.
    pub file: String,
    /// Where in the file; without it the whole file is meant.
    pub place: Option<Place>,
    /// What is wrong and what to do.
    pub message: String,
}

/// A place in a text file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Characters that are meant.
    pub width: usize,
    /// The line's text.
    pub text: String,
}

impl Place {
    /// The place of the bytes `start..end` of `source`.
    #[must_use]
    pub fn of(source: &str, start: usize, end: usize) -> Self {
        let floor = |mut at: usize| {
            at = at.min(source.len());
            while !source.is_char_boundary(at) {
                at -= 1;
            }
            at
        };
        let (start, end) = (floor(start), floor(end.max(start)));
        let begin = source[..start].rfind('\n').map_or(0, |k| k + 1);
        let stop = source[begin..].find('\n').map_or(source.len(), |k| begin + k);
        Self {
            line: source[..start].matches('\n').count() + 1,
            column: source[begin..start].chars().count() + 1,
            width: source[start..end.min(stop).max(start)].chars().count().max(1),
            text: source[begin..stop].trim_end().to_owned(),
        }
    }

    /// The first word and all that follows of a line, counted from 1.
    #[must_use]
    pub fn of_line(source: &str, line: usize) -> Self {
        let text = source.lines().nth(line.saturating_sub(1)).unwrap_or_default();
        let (indented, words) = (text.chars().take_while(|c| c.is_whitespace()), text.trim());
        let width = words.chars().count().max(1);
        Self { line, column: indented.count() + 1, width, text: text.trim_end().to_owned() }
    }
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(place) = &self.place else {
            return write!(f, "{}: {}", self.file, self.message);
        };
        let Place { line, column, width, text } = place;
        let gutter = line.to_string();
        let margin = " ".repeat(gutter.len());
        writeln!(f, "{}:{line}:{column}: {}", self.file, self.message)?;
        writeln!(f, " {gutter} | {text}")?;
        write!(f, " {margin} | {}{}", " ".repeat(column - 1), "^".repeat(*width))
    }
}

impl std::error::Error for ModelError {}
