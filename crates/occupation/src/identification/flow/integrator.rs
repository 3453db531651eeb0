//! Trajectories of one window.

use std::sync::Arc;

use super::super::field::Field;
use super::super::inputs::input_at;
use super::super::matrix::{Transition, identity, multiply};
use super::super::motion::{InputPath, Motion};
use super::accumulation::Accumulation;
use super::{Flow, Run, Setting, Shot};

/// Works out trajectories of one window from one initial state after another.
pub(crate) struct Integrator<'f> {
    flow: Flow<'f>,
    setting: &'f Setting,
    motion: Arc<Motion>,
    steps: usize,
    /// Inputs at the ends and middles of all steps of an interval, one interval after the other.
    inputs: Vec<f64>,
    stages: [Vec<f64>; 4],
    trial: Vec<f64>,
    z: Vec<f64>,
    next: Vec<f64>,
    /// Whether stage 0 and the first node's matrix are those of `self.z` already: of the last step's end.
    carried: bool,
    nodes: Nodes,
    transition: Transition,
}

/// Ends and middles of the steps of one interval, where integrals over it have their nodes (Simpson's rule).
pub(super) struct Nodes {
    states: Vec<f64>,
    matrices: Vec<f64>,
    /// Psi(end of the interval, node).
    pub to_end: Vec<f64>,
    /// Kernel values of all landmarks, where a design is wanted.
    pub values: Vec<f64>,
    /// Room for two matrices.
    room: [Vec<f64>; 2],
}

impl<'f> Integrator<'f> {
    pub fn new(field: &'f Field, setting: &'f Setting, shot: &Shot) -> Self {
        let (states, motion) = (setting.states(), Arc::clone(&shot.motion));
        let count = 2 * shot.steps + 1;
        let zeros = || vec![0.0; states];
        let square = states * states;
        let nodes = Nodes {
            states: vec![0.0; count * states],
            matrices: vec![0.0; count * square],
            to_end: vec![0.0; count * square],
            values: Vec::new(),
            room: [vec![0.0; square], vec![0.0; square]],
        };
        Self {
            flow: Flow::new(field),
            setting,
            steps: shot.steps,
            inputs: inputs(&motion, setting.path, shot.steps),
            motion,
            stages: std::array::from_fn(|_| zeros()),
            trial: zeros(),
            z: zeros(),
            next: zeros(),
            carried: false,
            nodes,
            transition: Transition::new(states),
        }
    }

    fn intervals(&self) -> usize {
        self.motion.samples() - 1
    }

    /// Length of the steps of interval k.
    fn width(&self, k: usize) -> f64 {
        let times = self.motion.times();
        (times[k + 1] - times[k]) / self.steps as f64
    }

    /// Where the input at node `node` of interval k stands.
    fn input(&self, k: usize, node: usize) -> std::ops::Range<usize> {
        let m = self.motion.input_count();
        let first = (k * (2 * self.steps + 1) + node) * m;
        first..first + m
    }

    /// Step j of interval k of the classical Runge-Kutta method, from `self.z` to `self.next`; stage 0 holds z' at the start.
    fn step(&mut self, k: usize, j: usize) {
        let h = self.width(k);
        if !self.carried {
            let u = self.input(k, 2 * j);
            self.flow.slope(&self.z, &self.inputs[u], &mut self.stages[0]);
        }
        for (stage, share, node) in [(1, 0.5, 1), (2, 0.5, 1), (3, 1.0, 2)] {
            let u = self.input(k, 2 * j + node);
            let before = self.z.iter().zip(&self.stages[stage - 1]);
            self.trial.iter_mut().zip(before).for_each(|(y, (z, d))| *y = z + share * h * d);
            self.flow.slope(&self.trial, &self.inputs[u], &mut self.stages[stage]);
        }
        let [a, b, c, d] = &self.stages;
        for (i, next) in self.next.iter_mut().enumerate() {
            *next = self.z[i] + h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]);
        }
    }

    /// Stage 1 becomes z' at the end of the step.
    fn end_slope(&mut self, k: usize, j: usize) {
        let u = self.input(k, 2 * j + 2);
        self.flow.slope(&self.next, &self.inputs[u], &mut self.stages[1]);
    }

    /// Goes on to the next step, which starts as the last one of interval k ended, with its end slope.
    fn go_on(&mut self, j: usize) {
        std::mem::swap(&mut self.z, &mut self.next);
        // A held input may jump from one interval to the next.
        self.carried = j + 1 < self.steps || self.setting.path != InputPath::Held;
        self.stages.swap(0, 1);
    }

    /// Writes the states at the samples; false where the trajectory leaves the data.
    pub fn states(&mut self, initial: &[f64], states: &mut Vec<f64>) -> bool {
        states.clear();
        states.extend_from_slice(initial);
        self.z.copy_from_slice(initial);
        self.carried = false;
        for k in 0..self.intervals() {
            for j in 0..self.steps {
                self.step(k, j);
                std::mem::swap(&mut self.z, &mut self.next);
                if self.setting.is_lost(&self.z) {
                    return false;
                }
            }
            states.extend_from_slice(&self.z);
        }
        true
    }

    /// States at the samples, and at these shares of every interval, ascending: cubics with the slopes of the
    /// Runge-Kutta steps. None where the trajectory leaves the data.
    pub fn between(&mut self, initial: &[f64], shares: &[f64]) -> Option<[Vec<f64>; 2]> {
        let count = initial.len();
        let mut inner = Vec::with_capacity(self.intervals() * shares.len() * count);
        self.z.copy_from_slice(initial);
        self.carried = false;
        let mut states = initial.to_vec();
        for k in 0..self.intervals() {
            let h = self.width(k);
            for j in 0..self.steps {
                self.step(k, j);
                if self.setting.is_lost(&self.next) {
                    return None;
                }
                self.end_slope(k, j);
                let place = |share: &f64| share * self.steps as f64 - j as f64;
                let [start, end, ..] = &self.stages;
                for s in shares.iter().map(place).filter(|s| (0.0..1.0).contains(s)) {
                    let at = |i: usize| {
                        hermite([self.z[i], self.next[i]], [h * start[i], h * end[i]], s)
                    };
                    inner.extend((0..count).map(at));
                }
                self.go_on(j);
            }
            states.extend_from_slice(&self.z);
        }
        Some([states, inner])
    }

    /// States at the samples and their transitions from the initial state.
    pub fn run(&mut self, initial: &[f64]) -> Option<Run> {
        self.linearise(initial, None)
    }

    /// The same, and int Psi(t_k, r) B k(z(r)) u dr for the kernel values of all landmarks: N x (s n) rows.
    pub fn run_with_design(&mut self, initial: &[f64]) -> Option<(Run, Vec<f64>)> {
        let features = self.flow.field.features();
        self.nodes.values.resize((2 * self.steps + 1) * features, 0.0);
        let mut design = vec![0.0; self.motion.samples() * self.setting.states() * features];
        let run = self.linearise(initial, Some(&mut design))?;
        Some((run, design))
    }

    fn linearise(&mut self, initial: &[f64], mut design: Option<&mut [f64]>) -> Option<Run> {
        let (count, samples) = (self.setting.states(), self.motion.samples());
        let square = count * count;
        let mut run = Run {
            states: Vec::with_capacity(samples * count),
            transitions: vec![0.0; samples * square],
        };
        run.states.extend_from_slice(initial);
        identity(count, &mut run.transitions[..square]);
        self.z.copy_from_slice(initial);
        self.carried = false;
        for k in 0..self.intervals() {
            if !self.visit(k) {
                return None;
            }
            self.back_to_start(k);
            run.states.extend_from_slice(&self.z);
            let (before, after) = run.transitions.split_at_mut((k + 1) * square);
            let (step, before) = (&self.nodes.to_end[..square], &before[k * square..]);
            multiply(count, step, before, &mut after[..square]);
            if let Some(design) = design.as_deref_mut() {
                self.accumulate(k, design);
            }
        }
        Some(run)
    }

    /// Goes through interval k and fills the nodes' states and matrices; false where the trajectory leaves the data.
    fn visit(&mut self, k: usize) -> bool {
        let (count, h) = (self.setting.states(), self.width(k));
        let square = count * count;
        let last = 2 * self.steps;
        let carried = self.carried;
        if carried {
            self.nodes.matrices.copy_within(last * square.., 0);
        }
        for j in 0..self.steps {
            self.step(k, j);
            self.end_slope(k, j);
            let [start, end, ..] = &self.stages;
            let (z, next) = (&self.z, &self.next);
            let nodes = &mut self.nodes.states[2 * j * count..(2 * j + 3) * count];
            for i in 0..count {
                nodes[i] = z[i];
                // The cubic through both ends with their slopes.
                nodes[count + i] = 0.5 * (z[i] + next[i]) + h / 8.0 * (start[i] - end[i]);
                nodes[2 * count + i] = next[i];
            }
            self.go_on(j);
            if self.setting.is_lost(&self.z) {
                return false;
            }
        }
        for node in usize::from(carried)..=last {
            let u = self.input(k, node);
            let z = &self.nodes.states[node * count..(node + 1) * count];
            let matrix = &mut self.nodes.matrices[node * square..(node + 1) * square];
            self.flow.derivative(z, &self.inputs[u], matrix);
        }
        true
    }

    /// Psi(end of the interval, node) for all nodes (those in the middles of steps for a design alone), backwards, by the Runge-Kutta method on Psi' = dA/dz Psi.
    fn back_to_start(&mut self, k: usize) {
        let (count, h) = (self.setting.states(), self.width(k));
        let square = count * count;
        let of = |node: usize| node * square..(node + 1) * square;
        let Nodes { matrices, to_end, values, room: [between, step], .. } = &mut self.nodes;
        identity(count, &mut to_end[of(2 * self.steps)]);
        for j in (0..self.steps).rev() {
            let [first, middle, last] = [0, 1, 2].map(|node| &matrices[of(2 * j + node)]);
            let (before, after) = to_end.split_at_mut((2 * j + 2) * square);
            let end = &after[..square];
            if !values.is_empty() {
                let means = middle.iter().zip(last).map(|(a, b)| 0.5 * (a + b));
                between.iter_mut().zip(means).for_each(|(to, mean)| *to = mean);
                self.transition.over([middle, between, last], 0.5 * h, step);
                multiply(count, end, step, &mut before[of(2 * j + 1)]);
            }
            self.transition.over([first, middle, last], h, step);
            multiply(count, end, step, &mut before[of(2 * j)]);
        }
    }

    /// Rows of sample k + 1: step times the rows of sample k, plus the integral over the interval.
    fn accumulate(&mut self, k: usize, design: &mut [f64]) {
        let (count, h) = (self.setting.states(), self.width(k));
        let field = self.flow.field;
        let (d, features) = (field.arguments, field.features());
        let rows = count * features;
        for node in 0..2 * self.steps + 1 {
            let x = &self.nodes.states[node * count..node * count + d];
            let values = &mut self.nodes.values[node * features..(node + 1) * features];
            field.kernel_values(x, &mut self.flow.room, values);
            // Simpson's weights; inner ends belong to two steps.
            let inner = node > 0 && node < 2 * self.steps;
            let weight = if node % 2 == 1 { h / 1.5 } else { h / if inner { 3.0 } else { 6.0 } };
            let mut rest = values;
            let u = (k * (2 * self.steps + 1) + node) * self.motion.input_count();
            for term in &field.terms {
                let own;
                (own, rest) = rest.split_at_mut(term.basis.rank());
                let factor = weight * term.input(&self.inputs[u..]);
                own.iter_mut().for_each(|value| *value *= factor);
            }
        }
        let (before, after) = design.split_at_mut((k + 1) * rows);
        Accumulation {
            field,
            nodes: &self.nodes,
            before: &before[k * rows..],
            after: &mut after[..rows],
        }
        .work_out();
    }
}

/// Inputs at the ends and middles of all steps.
fn inputs(motion: &Motion, path: InputPath, steps: usize) -> Vec<f64> {
    let (times, m) = (motion.times(), motion.input_count());
    let count = 2 * steps + 1;
    let mut inputs = vec![0.0; (times.len() - 1) * count * m];
    if m == 0 {
        return inputs;
    }
    for (index, u) in inputs.chunks_exact_mut(m).enumerate() {
        let (k, node) = (index / count, index % count);
        let at_sample = match (node, path) {
            (0, _) => Some(k),
            (_, InputPath::Linear | InputPath::Smooth) if node == 2 * steps => Some(k + 1),
            _ => None,
        };
        if let Some(sample) = at_sample {
            u.copy_from_slice(&motion.inputs()[sample * m..(sample + 1) * m]);
            continue;
        }
        let share = node as f64 / (2 * steps) as f64;
        input_at(motion, path, k, times[k] + share * (times[k + 1] - times[k]), u);
    }
    inputs
}

/// The cubic on \[0, 1\] with these values and slopes at its ends.
fn hermite(values: [f64; 2], slopes: [f64; 2], s: f64) -> f64 {
    let r = 1.0 - s;
    let inner = r * slopes[0] - s * slopes[1] - (r - s) * (values[1] - values[0]);
    r * values[0] + s * values[1] + r * s * inner
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_its_own_interpolation() {
        let (value, slope) = (|s: f64| 2.0 - s + 3.0 * s * s * s, |s: f64| -1.0 + 9.0 * s * s);
        for s in [0.0, 0.2, 0.7, 1.0] {
            let found = hermite([value(0.0), value(1.0)], [slope(0.0), slope(1.0)], s);
            assert!((found - value(s)).abs() < 1e-14, "{s}: {found}");
        }
    }
}
