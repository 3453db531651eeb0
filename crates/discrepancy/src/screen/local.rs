//! One recording, and each of its windows, as a linear system.

use crate::dataset::Observed;
use crate::likelihood::maps::Maps;
use crate::likelihood::normal::{Block, Eliminated, Memory};
use crate::likelihood::sweep::{Columns, Run};
use crate::likelihood::{Fit, FitError, Window};
use crate::trajectories::SmoothedRecording;
use nalgebra::{DMatrix, DVector};

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
    /// Normal equations of theta, its states eliminated.
    pub(super) eliminated: Eliminated,
    /// By how much the states move with theta, and where theta stays.
    pub(super) cross: DMatrix<f64>,
    pub(super) rest: DVector<f64>,
    /// Of each measured value, sample by sample: its output, its derivatives by states and by
    /// theta, its residual.
    pub(super) rows: Rows,
}

/// Measured values of a window, sample by sample.
pub(super) struct Rows {
    /// Where each sample's rows begin.
    begin: Vec<usize>,
    outputs: Vec<usize>,
    width: usize,
    values: Vec<f64>,
}

impl Rows {
    /// Of columns, output by output; `states` of them and then `unused` before those of theta.
    fn of(
        observed: &Observed,
        w: &Window,
        columns: &Columns,
        (states, unused): (usize, usize),
    ) -> Self {
        let by: Vec<&Vec<f64>> = columns.by[..states]
            .iter()
            .chain(&columns.by[states + unused..])
            .chain(std::iter::once(&columns.residual))
            .collect();
        let measured = |o: usize, k: usize| observed.outputs[o][k].is_finite();
        let count = |o: usize| w.range.clone().filter(|&k| measured(o, k)).count();
        let outputs = observed.outputs.len();
        // The next row of each output.
        let mut next: Vec<usize> = (0..outputs)
            .scan(0, |from, o| Some(std::mem::replace(from, *from + count(o))))
            .collect();
        let mut rows = Self { begin: vec![0], outputs: vec![], width: by.len(), values: vec![] };
        for k in w.range.clone() {
            for o in (0..outputs).filter(|&o| measured(o, k)) {
                rows.outputs.push(o);
                rows.values.extend(by.iter().map(|column| column[next[o]]));
                next[o] += 1;
            }
            rows.begin.push(rows.outputs.len());
        }
        rows
    }

    /// Rows of a sample of the window: output, values.
    #[inline(always)]
    pub(super) fn at(&self, at: usize) -> impl Iterator<Item = (usize, &[f64])> {
        let range = self.begin[at]..self.begin[at + 1];
        let values = &self.values[range.start * self.width..range.end * self.width];
        self.outputs[range].iter().copied().zip(values.chunks_exact(self.width))
    }

    /// Values in a row.
    pub(super) fn width(&self) -> usize {
        self.width
    }
}

/// Linearise one recording of a fit; forces are those along the fit's path, or the `measured` one. What nobody
/// measured, and what a filter has corrected already, is the fit's.
pub(super) fn along(fit: &Fit, r: usize, run: &Run, measured: bool) -> Result<Along, FitError> {
    let problem = fit.problem;
    let maps = Maps::along(run, fit.noise.as_deref())?;
    let measured = measured && fit.noise.is_none() && problem.hidden().is_empty();
    let motion = match measured {
        true => problem.measured_motion(&fit.hypothesis.effects, r),
        false => problem.motion(&fit.hypothesis, r, &maps.path),
    };
    let Run { windows, starts, .. } = *run;
    // What is seen through the filters of this very run.
    let filtered = Run { filters: &maps.filters, ..*run };
    let all = filtered.linearise_in_pieces(problem.dataset.recordings.len())?;
    let machine = problem.model.machine_states();
    let memory = starts.memory.len();
    let local = |(k, (columns, window)): (usize, (Columns, &Window))| {
        let (states, unused) = if k == 0 { (machine + memory, 0) } else { (machine, memory) };
        let eliminated = Block::of(&columns, (states, unused), Memory::default()).eliminated(0.0);
        let cross = eliminated.by_theta();
        let rest = eliminated.states(&DVector::zeros(cross.ncols()));
        let rows = Rows::of(run.observed(), window, &columns, (states, unused));
        let window = window.clone();
        Local { window, number: k, eliminated, cross, rest, rows }
    };
    let all = all.into_iter().zip(windows).enumerate();
    Ok(Along { motion, maps, windows: all.map(local).collect() })
}
