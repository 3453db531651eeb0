//! What is wanted of a file, and what a file gave.

use lacuna_units::names::nearest;

use crate::error::RecordingError;
use crate::recording::Recording;

/// Whether a column of a name is wanted.
type Choice<'a> = Box<dyn Fn(&str) -> bool + 'a>;

/// Which columns of a file are wanted. What nobody wants is not kept in memory.
#[derive(Default)]
pub struct Wanted<'a> {
    /// Name of the column of time.
    pub time: &'a str,
    keeps: Option<Choice<'a>>,
    needed: Vec<String>,
    held: Vec<String>,
}

impl<'a> Wanted<'a> {
    /// Every column that holds numbers.
    pub fn all(time: &'a str) -> Self {
        Self { time, ..Self::default() }
    }

    /// The columns of which `keeps` is true, where the file has them.
    pub fn only(time: &'a str, keeps: impl Fn(&str) -> bool + 'a) -> Self {
        Self { time, keeps: Some(Box::new(keeps)), ..Self::default() }
    }

    /// And columns without which the file is of no use.
    #[must_use]
    pub fn needing(mut self, names: impl IntoIterator<Item = String>) -> Self {
        self.needed.extend(names);
        self
    }

    /// Of these, columns that keep a sample until the next one where they are brought to other times; others
    /// run along straight lines.
    #[must_use]
    pub fn holding(mut self, names: impl IntoIterator<Item = String>) -> Self {
        self.held.extend(names);
        self
    }

    /// Whether the column `name` is wanted.
    pub fn keeps(&self, name: &str) -> bool {
        self.keeps.as_ref().is_none_or(|keeps| keeps(name)) || self.needed.iter().any(|n| n == name)
    }

    /// Whether the column `name` keeps a sample until the next one.
    pub(crate) fn holds(&self, name: &str) -> bool {
        self.held.iter().any(|n| n == name)
    }

    /// That no column is missing which is needed.
    pub(crate) fn check_needed(
        &self,
        recording: &str,
        names: &[&str],
    ) -> Result<(), RecordingError> {
        let Some(wanted) = self.needed.iter().find(|n| **n != self.time && !names.contains(&&***n))
        else {
            return Ok(());
        };
        Err(RecordingError::NoSuchColumn {
            recording: recording.into(),
            wanted: wanted.clone(),
            suggestion: nearest(wanted, names.iter().copied()).map(Into::into),
            available: names.iter().map(|&n| n.into()).collect(),
        })
    }
}

/// What was read of a file.
#[derive(Clone, Debug)]
pub struct Log {
    /// The columns that are wanted; a reader that has to look at all of them may keep more.
    pub recording: Recording,
    /// Names of the other columns that hold numbers.
    pub others: Vec<String>,
    /// Clocks of what was read, the one of the rows first; none where the file has one column of times.
    pub clocks: Vec<Clock>,
}

impl From<Recording> for Log {
    fn from(recording: Recording) -> Self {
        Self { recording, others: vec![], clocks: vec![] }
    }
}

/// The times of one topic of a log, and how they were brought to those of the rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Clock {
    /// The topic.
    pub topic: String,
    /// Whether times are the stamps in the messages' headers, else those at which they were logged.
    pub stamped: bool,
    /// Number of samples.
    pub samples: usize,
    /// Usual step, s.
    pub step: f64,
    /// What was added to the stamps, s: 0 where their clock is that of the log.
    pub offset: f64,
    /// Median of the delay between stamp and logging, s, after `offset` was added; 0 without stamps.
    pub delay: f64,
    /// Messages that had the time of another one, of which the last was kept.
    pub repeated: usize,
}
