//! What is refused.

/// A slice of the wrong length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{what} must have {expected} entries, found {found}")]
pub struct LengthError {
    /// Which slice.
    pub what: &'static str,
    /// Its length for this model.
    pub expected: usize,
    /// Its length.
    pub found: usize,
}

/// Tables that do not fit together.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TableError {
    /// A table of the wrong length.
    #[error(transparent)]
    Length(#[from] LengthError),
    /// A count of which there is at least one, and at most so many.
    #[error("{what} must be from 1 to {most}, found {found}")]
    Count {
        /// What was counted.
        what: &'static str,
        /// The most there is room for.
        most: usize,
        /// How many there are.
        found: usize,
    },
    /// An index that points beyond its table.
    #[error("{what}: index {found} of a table of {length}")]
    Index {
        /// Which table of indices.
        what: &'static str,
        /// Length of the table it points into.
        length: usize,
        /// The index.
        found: usize,
    },
    /// A box with a side that is not positive and finite.
    #[error(
        "argument {argument} of the box is from {lower} to {upper}: expected lower < upper, both finite"
    )]
    Box {
        /// Which argument, from 0.
        argument: usize,
        /// Its lower end.
        lower: f64,
        /// Its upper end.
        upper: f64,
    },
    /// A number that is not finite.
    #[error("{what} must be finite numbers")]
    NotFinite {
        /// Which table.
        what: &'static str,
    },
}

pub(crate) fn check_length(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), LengthError> {
    if expected == found { Ok(()) } else { Err(LengthError { what, expected, found }) }
}

pub(crate) fn check_count(what: &'static str, most: usize, found: usize) -> Result<(), TableError> {
    if (1..=most).contains(&found) { Ok(()) } else { Err(TableError::Count { what, most, found }) }
}

pub(crate) fn check_indices(
    what: &'static str,
    length: usize,
    indices: impl IntoIterator<Item = u16>,
) -> Result<(), TableError> {
    match indices.into_iter().map(usize::from).find(|&found| found >= length) {
        Some(found) => Err(TableError::Index { what, length, found }),
        None => Ok(()),
    }
}

pub(crate) fn check_finite<'v>(
    what: &'static str,
    values: impl IntoIterator<Item = &'v f64>,
) -> Result<(), TableError> {
    if values.into_iter().all(|v| v.is_finite()) {
        Ok(())
    } else {
        Err(TableError::NotFinite { what })
    }
}
