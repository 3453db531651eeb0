//! From recordings to what the regression is given: which columns are what, outliers left out, motion smoothed.

mod columns;
mod conditioning;
mod motion;

pub use columns::{Asked, ColumnUnit, Columns};
pub use conditioning::Conditioning;
pub use motion::{Motion, Noise, Stretch};

use crate::occupation::InputPath;
use crate::recordings::InputHold;

/// What inputs do between samples, for smoothing and resampling.
#[must_use]
pub fn input_hold(path: InputPath) -> InputHold {
    match path {
        InputPath::Held => InputHold::ZeroOrder,
        InputPath::Linear | InputPath::Smooth => InputHold::Linear,
    }
}
