//! What a law says of the weak rows.
//!
//! A force `sum_k a_k b_k` along the smoothed motion adds `sum_k a_k int phi_w b_k dt` to the rows of the channel
//! that it acts on, and its reaction to those of the other. What an actuator makes of its input, u', adds
//! `int phi_w dF/du (u' - u) dt`, to first order; the numbers s of a robot's structure add
//! `int phi_w d(F - M q'')/ds dt`. A sensor that shows `y = x + a d(t)` moves the rows as the noise of its
//! samples does: by `a sum_k l_w(k) d(t_k)`.

use super::along::Along;
use super::rows::Rows;
use crate::candidates::{Candidate, Term};
use crate::likelihood::Problem;
use crate::screen::{sensed, servo, structure};
use lacuna_effects::{AnySeriesLaw, Law};
use lacuna_numbers::{Dual, LANES, Number};
use lacuna_plants::Hold;
use lacuna_plants::model::ModelEffect;
use std::sync::OnceLock;

/// One column: of each channel on which it acts, its entries.
pub(super) type Column = Vec<(usize, Vec<f64>)>;

/// The recordings, ready for the columns of any law.
pub(super) struct Columns<'a> {
    pub problem: &'a Problem<'a>,
    pub along: &'a [Along<'a>],
    /// The weak rows of each channel, recording by recording; none where nothing tells them.
    pub rows: &'a [Vec<(usize, Rows)>],
    /// Values of the model's parameters, and the effects that it has.
    pub parameters: &'a [f64],
    pub effects: &'a [ModelEffect],
    /// What was found of each input.
    pub slopes: Slopes,
}

/// dF/du of each input: of each recording, channel by channel at every sample; nothing of a channel that it does not
/// drive. Found when first asked for.
pub(super) struct Slopes(Vec<OnceLock<Vec<Vec<Vec<f64>>>>>);

impl Slopes {
    /// Of so many inputs, none found.
    pub(super) fn new(inputs: usize) -> Self {
        Self((0..inputs).map(|_| OnceLock::new()).collect())
    }
}

/// Root mean square; 0 of nothing.
pub(super) fn rms(values: &[f64]) -> f64 {
    let square: f64 = values.iter().map(|x| x * x).sum();
    (square / values.len().max(1) as f64).sqrt()
}

impl Columns<'_> {
    /// The columns of each of several terms of one candidate, one an amplitude; none where it does not act on
    /// what the rows tell.
    pub(super) fn of(&self, candidate: &Candidate, shapes: &[Vec<f64>]) -> Vec<Vec<Column>> {
        match candidate.effect.law {
            Law::Force(law) => {
                let places =
                    self.problem.model.places(candidate.effect, candidate.channel, candidate.other);
                let mut all: Vec<Vec<Column>> = vec![];
                for along in self.along {
                    let mut number = 0;
                    along.motion.bases(
                        law,
                        shapes.iter().map(Vec::as_slice),
                        &places,
                        |shape, series| {
                            let passed_on = law.plain().passed_on(shape);
                            let reaction = candidate.other.filter(|_| law.reacts());
                            let sides: Vec<(usize, f64)> =
                                std::iter::once((candidate.channel, 1.0))
                                    .chain(reaction.map(|o| (o, -passed_on)))
                                    .collect();
                            if all.len() == number {
                                all.push(vec![vec![]; series.len()]);
                            }
                            for (column, series) in all[number].iter_mut().zip(&series) {
                                for &(c, sign) in &sides {
                                    self.add(column, along.recording, c, |k| sign * series[k]);
                                }
                            }
                            number += 1;
                        },
                    );
                }
                all
            }
            Law::Input(_) if self.is_in_servo(candidate) => {
                let mut all = vec![vec![vec![]]; shapes.len()];
                for along in self.along {
                    for (columns, shape) in all.iter_mut().zip(shapes) {
                        let Some(change) = self.in_servo(candidate, shape, along) else { continue };
                        let at = |k: usize| change.at[k];
                        self.add(&mut columns[0], along.recording, change.coordinate, at);
                    }
                }
                all
            }
            Law::Input(law) => {
                let j = candidate.channel;
                let mut all = vec![vec![vec![]]; shapes.len()];
                for along in self.along {
                    let (slopes, u) = (self.slopes(along, j), self.input(along, j));
                    for (columns, shape) in all.iter_mut().zip(shapes) {
                        let mut made = law.plain().applied(shape, &along.motion.times, &u);
                        made.iter_mut().zip(&u).for_each(|(made, u)| *made -= u);
                        self.add_input(&mut columns[0], (along, slopes), made);
                    }
                }
                all
            }
            Law::Structure(law) => {
                let numbers =
                    self.problem.model.structure_of(candidate.effect.acts, candidate.channel);
                let mut each: Vec<Column> = vec![vec![]; numbers.len()];
                for along in self.along {
                    for first in numbers.clone().step_by(LANES) {
                        let lanes = LANES.min(numbers.end - first);
                        let known = (self.parameters, self.effects);
                        let model = self.problem.model;
                        for (c, lane, series) in
                            structure::forces(model, known, (first, lanes), along.motion)
                        {
                            let column = &mut each[first - numbers.start + lane];
                            self.add(column, along.recording, c, |k| series[k]);
                        }
                    }
                }
                let mix = |shape: &Vec<f64>| {
                    let slopes = structure::slopes(law, shape);
                    slopes.column_iter().map(|s| combined(&each, s.as_slice())).collect()
                };
                shapes.iter().map(mix).collect()
            }
            Law::Sensor(law) => {
                let ideal = candidate.effect.nature.ideal[0];
                let mut column: Column = vec![];
                for along in self.along {
                    let state = candidate.channel;
                    let truth: Vec<f64> =
                        (0..along.motion.len()).map(|k| along.motion.state(k)[state]).collect();
                    let by = sensed(law, ideal, &along.motion.times, &truth);
                    self.add_sensed(&mut column, along.recording, state, &by);
                }
                shapes.iter().map(|_| vec![column.clone()]).collect()
            }
        }
    }

    /// The column of an input itself.
    pub(super) fn of_input(&self, j: usize) -> Column {
        let mut column = vec![];
        for along in self.along {
            let slopes = self.slopes(along, j);
            self.add_input(&mut column, (along, slopes), self.input(along, j));
        }
        column
    }

    /// The entries of a series in an input's place.
    fn add_input(
        &self,
        column: &mut Column,
        (along, slopes): (&Along, &[Vec<f64>]),
        made: Vec<f64>,
    ) {
        let made = self.at_samples(made);
        for (c, slopes) in slopes.iter().enumerate() {
            if !slopes.is_empty() {
                self.add(column, along.recording, c, |k| slopes[k] * made[k]);
            }
        }
    }

    fn input(&self, along: &Along, j: usize) -> Vec<f64> {
        let m = self.problem.model.input_width();
        along.motion.inputs.iter().skip(j).step_by(m).copied().collect()
    }

    /// Mean over the samples of an input of `log |du'/du|`, of what several laws with their amplitudes make of it
    /// together on a channel; relative to the input, nothing is smaller than `least`.
    pub(super) fn log_slope(
        &self,
        (j, c): (usize, usize),
        laws: &[(&Term, &[f64])],
        least: f64,
    ) -> f64 {
        const STEP: f64 = 1e-4;
        let (mut sum, mut count) = (0.0, 0);
        for along in self.along {
            let u = self.input(along, j);
            let [made, more] = [1.0, 1.0 + STEP].map(|by| self.made((along, c), (j, by), laws));
            let least = (least * rms(&u)).max(f64::MIN_POSITIVE);
            for ((more, made), u) in more.iter().zip(made).zip(&u) {
                let moved = ((more - made) / STEP).abs();
                sum += (moved.max(least) / u.abs().max(least)).ln();
            }
            count += u.len();
        }
        sum / count.max(1) as f64
    }

    /// What laws make of an input, were it so many times as large: its own, and what forces that depend on it add
    /// to it on a channel.
    fn made(
        &self,
        (along, c): (&Along, usize),
        (j, by): (usize, f64),
        laws: &[(&Term, &[f64])],
    ) -> Vec<f64> {
        let m = self.problem.model.input_width();
        let mut motion = along.motion.clone();
        motion.inputs.iter_mut().skip(j).step_by(m).for_each(|u| *u *= by);
        let u: Vec<f64> = motion.inputs.iter().skip(j).step_by(m).copied().collect();
        let slopes = &self.slopes(along, j)[c];
        let mut all = u.clone();
        for (Term { candidate, shape }, amplitudes) in laws {
            match candidate.effect.law {
                // It acts behind the input.
                Law::Input(_) if self.is_in_servo(candidate) => {}
                Law::Input(law) => {
                    let of = law.plain().applied(shape, &motion.times, &u);
                    let share = amplitudes[0];
                    for ((all, of), u) in all.iter_mut().zip(of).zip(&u) {
                        *all += share * (of - u);
                    }
                }
                Law::Force(law) => {
                    let places = self.problem.model.places(
                        candidate.effect,
                        candidate.channel,
                        candidate.other,
                    );
                    let shapes = std::iter::once(shape.as_slice());
                    motion.bases(law, shapes, &places, |_, series| {
                        for (a, series) in amplitudes.iter().zip(series) {
                            let forces = series.iter().zip(slopes);
                            for (all, (force, slope)) in all.iter_mut().zip(forces) {
                                *all += if *slope == 0.0 { 0.0 } else { a * force / slope };
                            }
                        }
                    });
                }
                Law::Sensor(_) | Law::Structure(_) => {}
            }
        }
        all
    }

    /// Whether a law acts within servos.
    fn is_in_servo(&self, candidate: &Candidate) -> bool {
        self.problem.model.in_servo(candidate.effect, candidate.channel).is_some()
    }

    /// What such a law changes along a recording.
    fn in_servo(
        &self,
        candidate: &Candidate,
        shape: &[f64],
        along: &Along,
    ) -> Option<servo::Change> {
        let term = Term { candidate: *candidate, shape: shape.to_vec() };
        let known = (self.parameters, self.effects);
        servo::change(self.problem.model, known, &term, along.motion)
    }

    /// Share of the power of an input, or of the force of its servo, that a law takes away from it, or adds.
    pub(super) fn taken_from_input(
        &self,
        (candidate, law): (&Candidate, &dyn AnySeriesLaw),
        shape: &[f64],
    ) -> f64 {
        let j = candidate.channel;
        let (mut taken, mut all) = (0.0, 0.0);
        let power = |series: &[f64]| series.iter().map(|x| x * x).sum::<f64>();
        for along in self.along {
            if let Some(change) = self.in_servo(candidate, shape, along) {
                taken += power(&change.at);
                all += power(&change.force);
                continue;
            }
            let u = self.input(along, j);
            let made = law.plain().applied(shape, &along.motion.times, &u);
            taken += made.iter().zip(&u).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            all += power(&u);
        }
        taken / f64::max(all, f64::MIN_POSITIVE)
    }

    /// The inputs that drive each channel and no other.
    pub(super) fn inputs_that_drive_one(&self) -> Vec<Vec<usize>> {
        let model = self.problem.model;
        let mut of = vec![vec![]; model.channels()];
        for j in 0..model.inputs.len() {
            let drives = |c: &usize| self.along.iter().any(|a| !self.slopes(a, j)[*c].is_empty());
            let driven: Vec<usize> = (0..model.channels()).filter(drives).collect();
            if let [c] = driven[..] {
                of[c].push(j);
            }
        }
        of
    }

    /// Add what a change of one sensor's samples does to the rows of all channels in one recording.
    fn add_sensed(&self, column: &mut Column, recording: usize, state: usize, change: &[f64]) {
        for c in 0..self.rows.len() {
            let Some((first, rows)) = self.in_recording(c, recording) else { continue };
            let own = rows.sensors.iter().find(|(of, _)| *of == state);
            let Some((_, functionals)) = own else { continue };
            let entries = &mut self.entries(column, c)[first..];
            for (entry, f) in entries.iter_mut().zip(functionals) {
                let weighted = f.weights.iter().zip(&change[f.first..f.end()]);
                *entry += weighted.map(|(w, x)| w * x).sum::<f64>();
            }
        }
    }

    /// The rows of a channel in one recording, with the number of those before.
    fn in_recording(&self, c: usize, recording: usize) -> Option<(usize, &Rows)> {
        let before = self.rows[c].iter().position(|(r, _)| *r == recording)?;
        let first = self.rows[c][..before].iter().map(|(_, r)| r.windows.len()).sum();
        Some((first, &self.rows[c][before].1))
    }

    /// The entries of a column on a channel, in all recordings.
    fn entries<'c>(&self, column: &'c mut Column, c: usize) -> &'c mut Vec<f64> {
        let at = column.iter().position(|(channel, _)| *channel == c).unwrap_or_else(|| {
            let count = self.rows[c].iter().map(|(_, rows)| rows.windows.len()).sum();
            column.push((c, vec![0.0; count]));
            column.len() - 1
        });
        &mut column[at].1
    }

    /// Add what a force on a channel does to its rows in one recording.
    fn add(&self, column: &mut Column, recording: usize, c: usize, force: impl Fn(usize) -> f64) {
        let Some((first, rows)) = self.in_recording(c, recording) else { return };
        let entries = &mut self.entries(column, c)[first..];
        for (entry, window) in entries.iter_mut().zip(&rows.windows) {
            let weighted = (window.first..).zip(&window.weights[0]);
            *entry += weighted.map(|(k, w)| w * force(k)).sum::<f64>();
        }
    }

    /// A series of inputs as the forces at the samples know it: the mean of before and after, where it is held.
    fn at_samples(&self, mut series: Vec<f64>) -> Vec<f64> {
        if self.problem.model.hold == Hold::ZeroOrder {
            for k in (1..series.len()).rev() {
                series[k] = 0.5 * (series[k - 1] + series[k]);
            }
        }
        series
    }

    /// dF/du of one input in a recording, as [`Slopes`] has it.
    fn slopes(&self, along: &Along, j: usize) -> &[Vec<f64>] {
        let all = || self.along.iter().map(|along| self.by_input(along, j)).collect();
        let at = self.along.iter().position(|a| a.recording == along.recording);
        at.map_or(&[], |at| &self.slopes.0[j].get_or_init(all)[at])
    }

    /// dF/du of one input at every sample, channel by channel; nothing of a channel that it does not drive.
    fn by_input(&self, along: &Along, j: usize) -> Vec<Vec<f64>> {
        let model = self.problem.model;
        let (n, m, motion) = (model.coordinates.len(), model.inputs.len(), along.motion);
        let states = model.machine_states();
        let constants = |x: &[f64]| -> Vec<Dual> { x.iter().map(|&x| Dual::constant(x)).collect() };
        let parameters = model.with_structure(self.parameters, self.effects);
        let dynamics = model.dynamics();
        let bound = dynamics.bind_dual(&constants(&parameters));
        let mut room = bound.room();
        let mut rates = vec![Dual::constant(0.0); dynamics.sizes().rates()];
        let mut slopes = vec![vec![0.0; motion.len()]; model.channels()];
        let width = model.input_width();
        for k in 0..motion.len() {
            let mut variables = constants(motion.state(k));
            variables.extend(constants(&motion.inputs[k * width..k * width + m]));
            variables.push(Dual::constant(motion.times[k]));
            variables[states + j] = Dual::direction(variables[states + j].value, 0);
            bound.evaluate(&mut room, &variables, &mut rates);
            for (slopes, force) in slopes.iter_mut().zip(&rates[n * n..]) {
                slopes[k] = force.tangent[0];
            }
        }
        for slopes in slopes.iter_mut().filter(|s| s.iter().all(|s| *s == 0.0)) {
            slopes.clear();
        }
        slopes
    }
}

/// A sum of columns with these factors.
fn combined(columns: &[Column], factors: &[f64]) -> Column {
    let mut sum: Column = vec![];
    for (column, factor) in columns.iter().zip(factors) {
        for (c, entries) in column {
            match sum.iter_mut().find(|(channel, _)| channel == c) {
                Some((_, total)) => {
                    total.iter_mut().zip(entries).for_each(|(t, e)| *t += factor * e);
                }
                None => sum.push((*c, entries.iter().map(|e| factor * e).collect())),
            }
        }
    }
    sum
}
