//! The equations of motion linearised along a fitted trajectory, step by step.
//!
//! ```text
//! d_{k+1} = A_k d_k + B_k r_k + E_k v_k,    y_k = C_k d_k + D_k r_k
//! ```
//!
//! where r is a small force on each channel, v a small change of each input, and y what the
//! outputs change by. D is 0 but for outputs that hold the force on an imposed coordinate. The
//! derivatives are exact: those of the Runge-Kutta step itself. Where noise
//! drives the machine the trajectory is the filtered one, and the filter is made along with it.

use super::chain::Sensing;
use super::end::Diverged;
use super::filter::{Filter, Making};
use super::lanes::Lanes;
use super::sweep::{Run, piece_length};
use super::{ProcessNoise, Window};
use lacuna_numbers::{Dual, LANES, Linear, Number};
use lacuna_plants::InputPath;
use lacuna_plants::model::{
    Direction, Measured, StepInput, Strand, System, Workspace, advance_together,
};
use pulp::Simd;
use rayon::prelude::*;
use std::ops::Range;

/// A recording's maps from sample to sample.
#[derive(Clone)]
pub struct Maps {
    /// The first sample that they are of.
    first: usize,
    /// Length of d: the machine's state and the memory of effects.
    pub width: usize,
    /// Columns of one map: d, forces, inputs.
    pub(super) columns: usize,
    /// Maps, row-major `width x columns`, one a sample.
    pub(super) steps: Vec<f64>,
    /// Outputs by the machine's state, and where forces show in them at once by the whole state and
    /// the forces; row-major, one a sample; empty where all are entries of the state.
    slopes: Vec<f64>,
    /// Number of a row's entries.
    seen: usize,
    /// The entry of the state that each output is.
    entries: Vec<Option<usize>>,
    /// The first column that stands for an input.
    first_input: usize,
    /// One over the noise of each output.
    weights: Vec<f64>,
    /// The whole state at each sample, corrected by what was measured there.
    pub path: Vec<f64>,
    /// Inputs after the effects of the fit.
    pub inputs: Vec<f64>,
    /// The filter of each window; none where no noise drives the machine.
    pub filters: Vec<Filter>,
}

/// What drives the linearised motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// A force on a channel.
    Force(usize),
    /// A change of an input.
    Input(usize),
}

/// Small changes of a recording's motion, [`LANES`] of them side by side.
pub struct Driven {
    /// One value of each at every sample: what acts until the next.
    pub series: Vec<Lanes>,
    /// What acts at the sample itself, where outputs show forces at once; else empty.
    pub at_once: Vec<Lanes>,
    /// Where they drive the motion, and each one's share of its value there.
    pub places: Vec<(Drive, Lanes)>,
    /// A series of its own for each place, in place of the one for all; else empty.
    pub apart: Vec<Vec<Lanes>>,
    /// Outputs that show the values as they are.
    pub seen: Vec<usize>,
}

impl Maps {
    /// Run through the windows of a recording, filtering where noise drives the machine, and
    /// linearise every step. Filters that the run has are not used: new ones are made.
    ///
    /// # Errors
    /// [`Diverged`].
    pub fn along(run: &Run, noise: Option<&ProcessNoise>) -> Result<Self, Diverged> {
        let width = run.problem.model.machine_states() + run.starts.memory.len();
        Self::not_knowing(run, noise, &vec![0.0; width])
    }

    /// The same where the state's entries have these variances at the beginning of each window. Without memory,
    /// which runs on from window to window, pieces of the recording are run through side by side.
    ///
    /// # Errors
    /// [`Diverged`].
    pub(super) fn not_knowing(
        run: &Run,
        noise: Option<&ProcessNoise>,
        variances: &[f64],
    ) -> Result<Self, Diverged> {
        let problem = run.problem;
        let observed = run.observed();
        let (model, machine) = (problem.model, problem.model.machine_states());
        let width = variances.len();
        let first_input = width + model.channels();
        let columns = first_input + model.inputs.len();
        let seen = if problem.observation.sees_forces() { first_input } else { machine };
        let inputs = problem.effective_inputs(&run.hypothesis.effects, observed);
        let entry = |o: &crate::Output| if let Measured::State(i) = o.of { Some(i) } else { None };
        let mut maps = Self {
            first: 0,
            width,
            columns,
            steps: vec![],
            slopes: vec![],
            seen,
            entries: problem.dataset.outputs.iter().map(entry).collect(),
            first_input,
            weights: problem.weights.clone(),
            path: vec![],
            inputs: inputs.to_vec(),
            filters: vec![],
        };
        let length = piece_length(run.windows.len(), &run.starts.memory);
        let pieces = run.windows.par_chunks(length).zip(run.starts.machine.par_chunks(length));
        let pieces =
            pieces.map(|p| Linearising::new(run, (noise, variances), &inputs, &maps).through(p));
        let pieces: Result<Vec<Self>, Diverged> = pieces.collect();
        maps.steps = vec![0.0; observed.len() * width * columns];
        pieces?.into_iter().for_each(|piece| maps.take(piece));
        Ok(maps)
    }

    /// What a piece of the recording has found.
    fn take(&mut self, piece: Self) {
        let at = piece.first * self.width * self.columns;
        self.steps[at..at + piece.steps.len()].copy_from_slice(&piece.steps);
        if !piece.slopes.is_empty() {
            let at = piece.first * self.entries.len() * self.seen;
            self.slopes.resize(at, 0.0);
            self.slopes.extend(piece.slopes);
        }
        self.path.extend(piece.path);
        self.filters.extend(piece.filters);
    }

    /// Rows of C at a sample, in units of the noise: one of `width` an output.
    fn rows(&self, k: usize, rows: &mut Vec<f64>) {
        let count = self.entries.len();
        rows.clear();
        rows.resize(count * self.width, 0.0);
        for (o, row) in rows.chunks_exact_mut(self.width).enumerate() {
            match self.entries[o] {
                Some(i) => row[i] = self.weights[o],
                None => {
                    let slopes = self.slopes_at(k, o);
                    row.iter_mut().zip(slopes).for_each(|(r, c)| *r = c * self.weights[o]);
                }
            }
        }
    }

    /// Derivatives of an output at a sample that is no entry of the state.
    #[inline(always)]
    fn slopes_at(&self, k: usize, output: usize) -> &[f64] {
        let at = ((k - self.first) * self.entries.len() + output) * self.seen;
        &self.slopes[at..at + self.seen]
    }

    /// The map of the step that follows a sample, row-major `width x columns`.
    pub(super) fn step(&self, k: usize) -> &[f64] {
        let size = self.width * self.columns;
        let at = (k - self.first) * size;
        &self.steps[at..at + size]
    }

    /// Number of its columns.
    pub(super) fn stride(&self) -> usize {
        self.columns
    }

    /// Rows of C of every sample of a range.
    pub(super) fn all_rows(&self, range: &Range<usize>) -> Vec<f64> {
        let (mut all, mut rows) = (vec![], vec![]);
        for k in range.clone() {
            self.rows(k, &mut rows);
            all.extend_from_slice(&rows);
        }
        all
    }

    /// What small changes make of the outputs in a range, from no change at its beginning: `visit`
    /// is told the sample and, output by output, what each of the `driven` changes there, in units
    /// of the noise; in units of the innovations' standard deviation where a filter corrects for
    /// what it sees. All act in the same places.
    #[inline(always)]
    pub fn respond<S: Simd>(
        &self,
        simd: S,
        range: &Range<usize>,
        filter: Option<&Filter>,
        driven: &[Driven],
        mut visit: impl FnMut(usize, &[Lanes]),
    ) {
        let (n, c, m, p) = (self.width, self.columns, driven.len(), self.entries.len());
        let (mut d, mut next) = (vec![Lanes::ZERO; n * m], vec![Lanes::ZERO; n * m]);
        let (mut y, mut seen) = (vec![Lanes::ZERO; p * m], vec![Lanes::ZERO; p]);
        let place = |drive: &Drive| match *drive {
            Drive::Force(channel) => n + channel,
            Drive::Input(j) => self.first_input + j,
        };
        let places: Vec<usize> = driven[0].places.iter().map(|(drive, _)| place(drive)).collect();
        let mut forces = vec![Lanes::ZERO; places.len()];
        for (at, k) in range.clone().enumerate() {
            let map = self.step(k);
            for (g, driven) in driven.iter().enumerate() {
                let d = &mut d[g * n..(g + 1) * n];
                self.observe(simd, k, d, |o, change| y[o * m + g] = change);
                if let Some(now) = driven.at_once.get(k) {
                    for (&p, (_, share)) in places.iter().zip(&driven.places) {
                        let mut force = Lanes::ZERO;
                        force.add_product(simd, now, share);
                        self.observe_at_once(k, p, |o, slope| {
                            y[o * m + g].add_scaled(simd, &force, slope);
                        });
                    }
                }
                for &o in &driven.seen {
                    y[o * m + g].add_scaled(simd, &driven.series[k], self.weights[o]);
                }
                if let Some(filter) = filter {
                    for (o, seen) in seen.iter_mut().enumerate() {
                        // What the outputs change by is taken away from the innovations.
                        *seen = y[o * m + g] * -1.0;
                    }
                    filter.correct(at, &seen, d);
                }
                for (p, (force, (_, share))) in forces.iter_mut().zip(&driven.places).enumerate() {
                    let series = driven.apart.get(p).unwrap_or(&driven.series);
                    *force = Lanes::ZERO;
                    force.add_product(simd, &series[k], share);
                }
                let next = &mut next[g * n..(g + 1) * n];
                for (i, next) in next.iter_mut().enumerate() {
                    let row = &map[i * c..(i + 1) * c];
                    let mut sum = Lanes::ZERO;
                    for (a, x) in row[..n].iter().zip(&*d) {
                        sum.add_scaled(simd, x, *a);
                    }
                    for (&p, force) in places.iter().zip(&forces) {
                        sum.add_scaled(simd, force, row[p]);
                    }
                    *next = sum;
                }
            }
            if let Some(filter) = filter {
                filter.whiten_sample(at, &mut y);
            }
            visit(at, &y);
            std::mem::swap(&mut d, &mut next);
        }
    }

    /// What each output sees of a change of the state at a sample, in units of its noise.
    #[inline(always)]
    fn observe<S: Simd>(&self, simd: S, k: usize, d: &[Lanes], mut each: impl FnMut(usize, Lanes)) {
        for (o, weight) in self.weights.iter().enumerate() {
            let mut change = Lanes::ZERO;
            match self.entries[o] {
                Some(i) => change.add_scaled(simd, &d[i], *weight),
                None => {
                    for (x, c) in d.iter().zip(self.slopes_at(k, o)) {
                        change.add_scaled(simd, x, c * weight);
                    }
                }
            }
            each(o, change);
        }
    }

    /// What each output that is no entry of the state sees at once of the force in a column, in
    /// units of its noise.
    #[inline(always)]
    fn observe_at_once(&self, k: usize, column: usize, mut each: impl FnMut(usize, f64)) {
        for (o, weight) in self.weights.iter().enumerate() {
            if self.entries[o].is_none() {
                each(o, self.slopes_at(k, o)[column] * weight);
            }
        }
    }
}

/// Maps in the making.
struct Linearising<'r> {
    run: &'r Run<'r>,
    noise: Option<&'r ProcessNoise>,
    variances: &'r [f64],
    /// The effective inputs.
    inputs: &'r [f64],
    system: System,
    chunks: Vec<Chunk>,
    maps: Maps,
}

/// [`LANES`] directions from `first` on.
struct Chunk {
    first: usize,
    system: System<Dual>,
    workspace: Workspace<Dual>,
    state: Vec<Dual>,
}

impl Chunk {
    fn new(run: &Run, first: usize, width: usize) -> Self {
        let (problem, h) = (run.problem, run.hypothesis);
        let (model, zero) = (problem.model, Dual::constant(0.0));
        let driven = (0..model.channels()).map(Direction::Force);
        let driven = driven.chain((0..model.inputs.len()).map(Direction::Input)).enumerate();
        let directions: Vec<(Direction, usize)> = driven
            .map(|(k, direction)| (direction, (width + k).wrapping_sub(first)))
            .filter(|(_, lane)| *lane < LANES)
            .collect();
        let system = System::along(model, &h.parameters, &h.effects, &directions, problem.sample);
        Self { first, workspace: system.workspace(), system, state: vec![zero; width] }
    }

    fn seed(&self, value: f64, entry: usize) -> Dual {
        Dual::among(value, entry, self.first)
    }

    fn strand<'s>(&'s mut self, inputs: StepInput<'s, Dual>) -> Strand<'s, Dual> {
        let Self { system, workspace, state, .. } = self;
        Strand { system, workspace, inputs, state }
    }
}

impl<'r> Linearising<'r> {
    /// The filters' noise, and the variances of the state's entries where windows begin.
    fn new(
        run: &'r Run<'r>,
        (noise, variances): (Option<&'r ProcessNoise>, &'r [f64]),
        inputs: &'r [f64],
        maps: &Maps,
    ) -> Self {
        let chunks =
            (0..maps.columns.div_ceil(LANES)).map(|c| Chunk::new(run, c * LANES, maps.width));
        let (chunks, h) = (chunks.collect(), run.hypothesis);
        let system = System::with(run.problem.model, &h.parameters, &h.effects);
        Self { run, noise, variances, inputs, system, chunks, maps: maps.clone() }
    }

    /// Run through windows one after the other, each from its own state.
    fn through(mut self, (windows, starts): (&[Window], &[Vec<f64>])) -> Result<Maps, Diverged> {
        let machine = self.run.problem.model.machine_states();
        let end = windows.last().map_or(0, |w| w.range.end);
        self.maps.first = windows.first().map_or(0, |w| w.range.start);
        let size = self.maps.width * self.maps.columns;
        self.maps.steps = vec![0.0; (end - self.maps.first) * size];
        let mut memory = self.run.starts.memory.clone();
        for (w, x) in windows.iter().zip(starts) {
            let mut state: Vec<f64> = x.iter().chain(&memory).copied().collect();
            self.window(w, &mut state)?;
            memory.copy_from_slice(&state[machine..]);
        }
        Ok(self.maps)
    }

    /// Run through a window from a whole state, which is left at its end.
    fn window(&mut self, w: &Window, state: &mut [f64]) -> Result<(), Diverged> {
        let run = self.run;
        let (problem, observed) = (run.problem, run.observed());
        let inputs = problem.inputs_along(w, self.inputs, run.substeps.count);
        let outputs = problem.dataset.outputs.len();
        let m = problem.model.input_width();
        let mut filter = self.noise.map(|noise| Making::new(self.variances, noise));
        let mut sensing = Sensing::new(problem, observed, &run.hypothesis.effects, w);
        let (mut rows, mut y) = (vec![], vec![0.0; outputs]);
        // What drives a step, and how long it lasts: mostly as long as the one before it.
        let (mut lasting, mut driven) = (f64::NAN, vec![]);
        for (at, k) in w.range.clone().enumerate() {
            let u = &self.maps.inputs[k * m..(k + 1) * m];
            self.system.impose(u, state);
            problem.observation.evaluate(&self.system, observed.times[k], state, u, &mut y);
            self.slopes(k, state);
            if let Some(filter) = &mut filter {
                let innovations = sensing.innovations(k, &y);
                self.maps.rows(k, &mut rows);
                filter.measure(&rows, innovations);
                filter.correct(state);
            }
            self.maps.path.extend_from_slice(state);
            if k + 1 == observed.len() {
                break;
            }
            self.step((at, k), &inputs, state)?;
            if let (Some(filter), Some(noise)) = (&mut filter, self.noise) {
                let dt = observed.times[k + 1] - observed.times[k];
                if dt != lasting {
                    (lasting, driven) = (dt, noise.driven(self.maps.width, dt));
                }
                filter.step(self.maps.step(k), self.maps.columns, &driven);
            }
        }
        self.maps.filters.extend(filter.map(Making::done));
        Ok(())
    }

    /// Advance the state from a sample to the next, with the derivatives of that step.
    fn step(
        &mut self,
        (at, k): (usize, usize),
        inputs: &InputPath<f64>,
        state: &mut [f64],
    ) -> Result<(), Diverged> {
        let (run, maps) = (self.run, &mut self.maps);
        let times = &run.observed().times;
        let (size, row) = (maps.width * maps.columns, k - maps.first);
        let map = &mut maps.steps[row * size..(row + 1) * size];
        let span = (times[k], times[k + 1]);
        for chunk in &mut self.chunks {
            for (i, x) in state.iter().enumerate() {
                chunk.state[i] = chunk.seed(*x, i);
            }
        }
        let chunks = self.chunks.iter_mut();
        let mut strands: Vec<Strand<Dual>> =
            chunks.map(|chunk| chunk.strand(inputs.step_in(at))).collect();
        advance_together(&mut strands, span, run.substeps);
        for chunk in &self.chunks {
            let lanes = LANES.min(maps.columns - chunk.first);
            for (row, x) in map.chunks_exact_mut(maps.columns).zip(&chunk.state) {
                row[chunk.first..chunk.first + lanes].copy_from_slice(&x.tangent[..lanes]);
            }
        }
        for (x, moved) in state.iter_mut().zip(&self.chunks[0].state) {
            *x = moved.value;
        }
        run.check(k + 1, state)
    }

    /// Derivatives of the outputs that are not entries of the state.
    fn slopes(&mut self, k: usize, state: &[f64]) {
        let maps = &mut self.maps;
        if maps.entries.iter().all(Option::is_some) {
            return;
        }
        let (problem, count) = (self.run.problem, maps.entries.len());
        let m = problem.model.input_width();
        let u: Vec<Dual> =
            maps.inputs[k * m..(k + 1) * m].iter().map(|&u| Dual::constant(u)).collect();
        let mut y = vec![Dual::constant(0.0); count];
        let seen = maps.seen;
        let at = k - maps.first;
        maps.slopes.resize((at + 1) * count * seen, 0.0);
        for chunk in self.chunks.iter().take_while(|c| c.first < seen) {
            let seeded = state.iter().enumerate().map(|(i, x)| chunk.seed(*x, i));
            let mut x: Vec<Dual> = seeded.collect();
            chunk.system.impose(&u, &mut x);
            let t = self.run.observed().times[k];
            problem.observation.evaluate(&chunk.system, t, &x, &u, &mut y);
            let last = (chunk.first + LANES).min(seen);
            for (o, y) in y.iter().enumerate() {
                let row = (at * count + o) * seen;
                for i in chunk.first..last {
                    maps.slopes[row + i] = y.tangent[i - chunk.first];
                }
            }
        }
    }
}
