//! What cannot be compiled.

use lacuna_realtime::TableError;

/// Why a model is not compiled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CompileError {
    /// A box of another dimension than the model.
    #[error("the box needs {expected} sides, one an argument; found {found}")]
    Sides {
        /// Arguments of the model.
        expected: usize,
        /// Sides given.
        found: usize,
    },
    /// A side without inside.
    #[error(
        "argument {argument} (counted from 0) of the box runs from {lower} to {upper}: expected finite numbers, the \
         lower one first"
    )]
    Empty {
        /// Which argument, from 0.
        argument: usize,
        /// Its lower end.
        lower: f64,
        /// Its upper end.
        upper: f64,
    },
    /// A tolerance out of range.
    #[error("the tolerance must be from {least:e} to {most}, found {found}")]
    Tolerance {
        /// The least that double precision can keep.
        least: f64,
        /// The most that is worth a bound.
        most: f64,
        /// The tolerance given.
        found: f64,
    },
    /// More arguments than there is room for.
    #[error("a model of at most {most} arguments can be compiled, found {found}")]
    Arguments {
        /// The most.
        most: usize,
        /// Arguments of the model.
        found: usize,
    },
    /// The model is not finite on the box.
    #[error("the model is not finite at {point:?}, which is in the box")]
    NotFinite {
        /// Where.
        point: Vec<f64>,
    },
    /// Tables that do not fit together, in a file that was changed by hand.
    #[error(transparent)]
    Table(#[from] TableError),
}
