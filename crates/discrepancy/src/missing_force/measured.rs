//! The measured force on an imposed coordinate: what the model says of it falls short by the missing
//! force itself, and no acceleration is needed.

use crate::likelihood::Problem;

/// What is measured of the force on an imposed coordinate along one recording.
pub(super) struct MeasuredForce {
    /// The output.
    pub output: usize,
    /// By how much the output changes with a force that is missing from the model.
    pub slope: f64,
    /// The output; where nothing was measured, on the straight line between its neighbours.
    pub values: Vec<f64>,
}

impl MeasuredForce {
    /// That of a channel; none of a free one, and where nothing shows its force.
    pub(super) fn of(problem: &Problem, recording: usize, channel: usize) -> Option<Self> {
        let (output, slope) = problem.outputs_of_force(channel).next()?;
        let observed = &problem.dataset.recordings[recording];
        let values = joined(&observed.times, &observed.outputs[output]);
        Some(Self { output, slope, values })
    }

    /// The force at a sample, up to what stands beside it in the output.
    pub(super) fn force(&self, k: usize) -> f64 {
        -self.values[k] / self.slope
    }
}

/// A series whose gaps are straight lines; beyond its first and last number it is none.
fn joined(times: &[f64], values: &[f64]) -> Vec<f64> {
    let mut joined = values.to_vec();
    let known: Vec<usize> = (0..values.len()).filter(|&k| values[k].is_finite()).collect();
    for ends in known.windows(2) {
        let (a, b) = (ends[0], ends[1]);
        for k in a + 1..b {
            let share = (times[k] - times[a]) / (times[b] - times[a]);
            joined[k] = values[a] + share * (values[b] - values[a]);
        }
    }
    joined
}
