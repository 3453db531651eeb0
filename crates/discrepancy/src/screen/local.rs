//! One recording, and each of its windows, as a linear system.

use crate::likelihood::maps::Maps;
use crate::likelihood::normal::Block;
use crate::likelihood::sweep::{self, Run};
use crate::likelihood::{Fit, FitError, Window};
use crate::trajectories::SmoothedRecording;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// One recording along its fitted trajectory.
pub(super) struct Along {
    pub(super) motion: SmoothedRecording,
    pub(super) maps: Maps,
    pub(super) windows: Vec<Local>,
}

/// One window's linear system.
pub(super) struct Local {
    pub(super) window: Window,
    /// Its number in the recording.
    pub(super) number: usize,
    /// Measured samples of each output, as rows.
    pub(super) columns: sweep::Columns,
    pub(super) states: usize,
    pub(super) unused: usize,
    pub(super) factor: Cholesky<f64, Dyn>,
    /// Solved against theta's columns and the residual.
    pub(super) cross: DMatrix<f64>,
    pub(super) rest: DVector<f64>,
}

/// Linearise one recording of a fit.
pub(super) fn along(fit: &Fit, r: usize, run: &Run) -> Result<Along, FitError> {
    let problem = fit.problem;
    let maps = Maps::along(run, fit.noise.as_deref())?;
    let motion = problem.motion(&fit.hypothesis, r, &maps.path);
    let Run { windows, starts, .. } = *run;
    // What is seen through the filters of this very run.
    let all = Run { filters: &maps.filters, ..*run }.linearise()?;
    let machine = problem.model.machine_states();
    let memory = starts.memory.len();
    let local = |(k, (columns, window)): (usize, (sweep::Columns, &Window))| {
        let (states, unused) = if k == 0 { (machine + memory, 0) } else { (machine, memory) };
        let block = Block::of(&columns, states, unused);
        let factor = block.eliminable()?;
        let (cross, rest) = (factor.solve(&block.cross), factor.solve(&block.state_gradient));
        let window = window.clone();
        Ok(Local { window, number: k, columns, states, unused, factor, cross, rest })
    };
    let all = all.into_iter().zip(windows).enumerate();
    let windows: Result<Vec<Local>, FitError> = all.map(local).collect();
    Ok(Along { motion, maps, windows: windows? })
}

/// Sum of products, in eight sums side by side: one after the other each would wait for the last.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    const SUMS: usize = 8;
    let mut sums = [0.0; SUMS];
    let (x, y) = (a.chunks_exact(SUMS), b.chunks_exact(SUMS));
    let rest: f64 = x.remainder().iter().zip(y.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in x.zip(y) {
        for l in 0..SUMS {
            sums[l] += x[l] * y[l];
        }
    }
    sums.iter().sum::<f64>() + rest
}

pub(super) fn dots(columns: &[Vec<f64>], d: &[f64]) -> DVector<f64> {
    DVector::from_iterator(columns.len(), columns.iter().map(|a| dot(a, d)))
}
