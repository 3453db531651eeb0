//! How far a model is off: its prediction over short windows against the truth, in units of the
//! noise.
//!
//! Each window starts from the state that fits it best (linearised), as a diagnosis would choose
//! it. The *calibrated* gap is what is left when the parameters, too, are moved to their best
//! values with the tolerance of the model file as a Gaussian prior: an effect whose calibrated gap is
//! nothing can be told from a wrong parameter by nobody.

use lacuna_plants::Model;

use super::windows::{Output, Shown, Windows};
use crate::StudyError;

/// Gaps, in noise standard deviations: root mean square over all windows, greatest output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// With the parameters as they are.
    pub raw: f64,
    /// With the parameters at their best.
    pub calibrated: f64,
    /// With the parameters at their best whatever their tolerance.
    pub free: f64,
}

/// The gap between a model and motions of the truth; the motions have the same times.
///
/// # Errors
/// [`StudyError::Simulation`] where the model diverges within a window.
pub fn gap(believed: &Model, shown: &[Shown], outputs: &[Output]) -> Result<Gap, StudyError> {
    let windows = Windows::linearised(believed, shown, outputs, &[])?;
    let nothing = vec![0.0; windows.parameters()];
    let greatest = |at: &[f64]| windows.misfit(at).into_iter().fold(0.0, f64::max);
    Ok(Gap {
        raw: greatest(&nothing),
        calibrated: greatest(&windows.best(None, Some(&nothing)).at),
        free: greatest(&windows.best(None, None).at),
    })
}
