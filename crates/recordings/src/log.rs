//! What is wanted of a file, and what a file gave.

use std::collections::BTreeSet;
use std::ops::Bound;

use lacuna_units::names::nearest;

use crate::error::RecordingError;
use crate::recording::Recording;

/// Which columns of a file are wanted. What nobody wants is not kept in memory.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Name of the column of time.
    pub time: String,
    /// Seconds in one unit of the numbers of that column. Times whose format says their unit are in seconds
    /// whatever this is.
    pub seconds: f64,
    /// Without it, every column.
    only: Option<BTreeSet<String>>,
    needed: Vec<String>,
    measured: Vec<String>,
    held: BTreeSet<String>,
}

impl Wanted {
    /// Every column that holds numbers.
    pub fn all(time: &str) -> Self {
        Self {
            time: time.into(),
            seconds: 1.0,
            only: None,
            needed: vec![],
            measured: vec![],
            held: BTreeSet::new(),
        }
    }

    /// The columns of these names, where the file has them.
    pub fn only(time: &str, names: impl IntoIterator<Item = String>) -> Self {
        Self { only: Some(names.into_iter().collect()), ..Self::all(time) }
    }

    /// With times in a unit of so many seconds.
    #[must_use]
    pub fn counting(self, seconds: f64) -> Self {
        Self { seconds, ..self }
    }

    /// And columns without which the file is of no use.
    #[must_use]
    pub fn needing(mut self, names: impl IntoIterator<Item = String>) -> Self {
        let names: Vec<String> = names.into_iter().collect();
        if let Some(only) = &mut self.only {
            only.extend(names.iter().cloned());
        }
        self.needed.extend(names);
        self
    }

    /// Of these, what is measured, of which one column at least has to be there. Of a file with several
    /// clocks the rows are at the times of a measurement.
    #[must_use]
    pub fn measuring(mut self, names: impl IntoIterator<Item = String>) -> Self {
        self.measured.extend(names);
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
        self.only.as_ref().is_none_or(|only| only.contains(name))
    }

    /// Whether a column may be wanted whose name begins with `start`.
    pub(crate) fn keeps_some(&self, start: &str) -> bool {
        self.only.as_ref().is_none_or(|only| {
            let next = only.range::<str, _>((Bound::Included(start), Bound::Unbounded)).next();
            next.is_some_and(|name| name.starts_with(start))
        })
    }

    /// Whether the column `name` is measured; any is where nothing else is said.
    pub(crate) fn measures(&self, name: &str) -> bool {
        self.measured.is_empty() || self.measured.iter().any(|m| m == name)
    }

    /// Whether the column `name` keeps a sample until the next one.
    pub(crate) fn holds(&self, name: &str) -> bool {
        self.held.contains(name)
    }

    /// That no column is missing which is needed, nor all that are measured.
    pub(crate) fn check(&self, recording: &str, names: &[&str]) -> Result<(), RecordingError> {
        let available = || names.iter().map(|&n| n.into()).collect();
        if let Some(wanted) =
            self.needed.iter().find(|n| **n != self.time && !names.contains(&&***n))
        {
            return Err(RecordingError::NoSuchColumn {
                recording: recording.into(),
                wanted: wanted.clone(),
                suggestion: nearest(wanted, names.iter().copied()).map(Into::into),
                available: available(),
            });
        }
        if self.measured.is_empty() || names.iter().any(|name| self.measures(name)) {
            return Ok(());
        }
        Err(RecordingError::NothingMeasured {
            recording: recording.into(),
            measured: self.measured.clone(),
            available: available(),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_begins_a_wanted_name_is_looked_at() {
        let wanted = Wanted::only("t", ["/b.x".to_owned()]).needing(["/a/c.y".to_owned()]);
        for (start, some) in [("/b.", true), ("/a/c.", true), ("/a.", false), ("/b.x.", false)] {
            assert_eq!(wanted.keeps_some(start), some, "{start}");
        }
        assert!(wanted.keeps("/b.x") && wanted.keeps("/a/c.y") && !wanted.keeps("/b"));
        assert!(Wanted::all("t").keeps_some("/c."));
    }
}
