//! What can keep a diagnosis from being made.

use lacuna_plants::{ModelError, SimulationError};
use lacuna_recordings::{
    RecordingError, SignalError, UnitError, did_you_mean, in_samples, nearest,
};
use thiserror::Error;

/// Why recordings and a model cannot be diagnosed.
#[derive(Debug, Error)]
pub enum DiagnoseError {
    /// The model file is wrong.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A simulation cannot be finished.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// Whoever asked for the diagnosis wants it no more.
    #[error("cancelled")]
    Cancelled,
    /// A name that the catalogue or the model does not have.
    #[error(
        "there is no {what} '{found}'{}; there are {}",
        did_you_mean(near),
        known.join(", ")
    )]
    Unknown {
        /// What kind of name it is.
        what: &'static str,
        /// The name.
        found: String,
        /// The nearest that there is.
        near: Option<String>,
        /// All that there are.
        known: Vec<String>,
    },
    /// There is no recording.
    #[error("no recording is given")]
    NoRecordings,
    /// No column is a channel of the model.
    #[error(
        "{recording}: no column measures a channel of the model; its columns are {}{}; name them \
         like the model's {}, or add [[measurement]] entries to the model",
        columns.join(", "),
        meant(columns, channels),
        channels.join(", ")
    )]
    NothingMeasured {
        /// The recording.
        recording: String,
        /// Its columns.
        columns: Vec<String>,
        /// What the model has to be measured.
        channels: Vec<String>,
    },
    /// An imposed coordinate whose position no column measures.
    #[error(
        "{recording}: the motion of '{channel}' is imposed, and no column measures its position; \
         the columns are {}; name one of them '{channel}', or add a [[measurement]] of it to the \
         model",
        columns.join(", ")
    )]
    NotImposed {
        /// The recording.
        recording: String,
        /// Its columns.
        columns: Vec<String>,
        /// The imposed coordinate.
        channel: String,
    },
    /// A recording is too short.
    #[error("{recording}: {} {} too few, at least {needed} are needed", in_samples(*found), if *found == 1 { "is" } else { "are" })]
    TooShort {
        /// The recording.
        recording: String,
        /// Its samples.
        found: usize,
        /// Samples that are needed.
        needed: usize,
    },
    /// A channel's signal cannot be used.
    #[error("{recording}: channel '{channel}': {source}")]
    Signal {
        /// The recording.
        recording: String,
        /// The channel.
        channel: String,
        /// What is wrong.
        source: SignalError,
    },
    /// Units do not fit.
    #[error("{recording}: column '{column}': {source}")]
    Unit {
        /// The recording.
        recording: String,
        /// The column.
        column: String,
        /// What is wrong.
        source: Box<UnitError>,
    },
    /// Time leaps.
    #[error(
        "{recording}: time leaps from {from} s to {to} s after row {after_row} (from 0), over \
         {missing} steps; mend the time column, or select the part before or after with #rows="
    )]
    Leap {
        /// The recording.
        recording: String,
        /// Row before the leap, from 0.
        after_row: usize,
        /// Its time (s).
        from: f64,
        /// Time of the next row (s).
        to: f64,
        /// Steps between the two.
        missing: usize,
    },
    /// Held-out recordings measure other channels than those that are fitted.
    #[error(
        "{recording}: the held-out recordings measure {}, the others {}; give both the same columns",
        found.join(", "),
        expected.join(", ")
    )]
    OtherOutputs {
        /// The first held-out recording.
        recording: String,
        /// Channels of the recordings that are fitted.
        expected: Vec<String>,
        /// Its channels.
        found: Vec<String>,
    },
    /// A measured channel never changes.
    #[error(
        "the column for '{channel}' has one value in all recordings: a sensor that is stuck, or \
         the wrong column; nothing can be diagnosed from it"
    )]
    Constant {
        /// The channel.
        channel: String,
    },
    /// The model cannot be simulated on the recordings.
    #[error(
        "the model '{model}' cannot be run along the recordings: it diverges, or leaves the range \
         in which its expressions are defined, even over the shortest windows; check its \
         parameters, the units of the columns, and with `lacuna simulate` where it leaves them"
    )]
    Diverges {
        /// The model.
        model: String,
    },
    /// An identified model without names.
    #[error(
        "the identified model does not name its columns, so that none can be found in a \
         recording; `lacuna identify --out` writes the names"
    )]
    Unnamed,
    /// An identified model of another form than q^(s) = f + g u with the state for argument.
    #[error(
        "a model of order 1 or 2 whose arguments are its coordinates or its state can be run; \
         found order {order} with {coordinates} coordinates and {arguments} arguments"
    )]
    Form {
        /// Order of the model.
        order: usize,
        /// Number of its coordinates.
        coordinates: usize,
        /// Number of its arguments.
        arguments: usize,
    },
    /// A channel that no column measures and nothing that is measured depends on.
    #[error(
        "no column measures '{channel}', and what is measured does not tell where it is: record it, or \
         take it out of the model"
    )]
    Unmeasured {
        /// The channel.
        channel: String,
    },
}

/// The column that is probably meant for a channel; nothing where none is near.
fn meant(columns: &[String], channels: &[String]) -> String {
    let near = |channel: &str| nearest(channel, columns.iter().map(String::as_str));
    let pair = channels.iter().find_map(|channel| Some((channel, near(channel)?)));
    pair.map_or_else(String::new, |(channel, column)| {
        format!(" (did you mean '{channel}' by '{column}'?)")
    })
}
