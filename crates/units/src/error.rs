//! What is wrong with a unit, or with two.

use crate::Dimension;
use crate::names::did_you_mean;
use thiserror::Error;

/// A text that is no unit, or two units that do not fit.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum UnitError {
    /// Nothing is written.
    #[error("expected a unit, found an empty text; a plain number has the unit '1'")]
    Empty,
    /// A name that is not in the table, with or without a prefix.
    #[error("unit '{text}': '{name}' is not a known unit{}", did_you_mean(suggestion))]
    Unknown {
        /// The whole text.
        text: String,
        /// The name.
        name: String,
        /// The nearest known one, where one is near.
        suggestion: Option<String>,
    },
    /// Something else than the grammar allows.
    #[error("unit '{text}', character {position}: expected {expected}, found {found}")]
    Syntax {
        /// The whole text.
        text: String,
        /// Place in the text, in characters from 1.
        position: usize,
        /// What may stand there.
        expected: &'static str,
        /// What stands there.
        found: String,
    },
    /// A factor beyond the numbers that a computer has.
    #[error("unit '{text}' is beyond the range of numbers")]
    Range {
        /// The whole text.
        text: String,
    },
    /// A product by a space after a division.
    #[error(
        "unit '{text}' can be read in two ways; write a/(b c) or a c/b with parentheses where \
         several units divide"
    )]
    Ambiguous {
        /// The whole text.
        text: String,
    },
    /// The two units measure different things.
    #[error("cannot convert '{from}' ({from_dimension}) to '{to}' ({to_dimension})")]
    Incompatible {
        /// Unit of the values.
        from: String,
        /// Its dimension.
        from_dimension: Box<Dimension>,
        /// Unit wanted.
        to: String,
        /// Its dimension.
        to_dimension: Box<Dimension>,
    },
    /// A factor alone cannot convert between temperature scales with different zeros.
    #[error("'{from}' and '{to}' have different zeros: no factor alone converts them")]
    Offset {
        /// Unit of the values.
        from: String,
        /// Unit wanted.
        to: String,
    },
}
