//! An FMU as a simulator: its states in the order of a model's.

use super::{Mass, Point, Simulator, Sizes};
use lacuna_fmu::{Fmu, Question, Wanted};
use std::sync::Arc;

/// Where an FMU's states stand in a model: coordinates and velocities, then first-order states.
#[derive(Debug)]
pub(crate) struct Unit {
    pub fmu: Arc<Fmu>,
    /// The FMU's state that each entry of the machine's state is.
    pub order: Vec<usize>,
}

impl Unit {
    /// Rows of parameters and variables in the FMU's order.
    fn points(&self, sizes: Sizes, points: &[f64]) -> Vec<f64> {
        let mut own = points.to_vec();
        let width = sizes.parameters + sizes.variables();
        for (own, row) in own.chunks_exact_mut(width).zip(points.chunks_exact(width)) {
            let (own, states) = (&mut own[sizes.parameters..], &row[sizes.parameters..]);
            for (&to, from) in self.order.iter().zip(states) {
                own[to] = *from;
            }
        }
        own
    }

    /// Rates of the FMU's states as those of a model: what each force channel has is the derivative of its
    /// velocity, or of its first-order state.
    fn pick(&self, sizes: Sizes, derivatives: &[f64], force: &mut [f64]) {
        for (to, &state) in force.iter_mut().zip(&self.order[sizes.coordinates..]) {
            *to = derivatives[state];
        }
    }

    /// Entry of a point as the FMU numbers states and inputs.
    fn own_entry(&self, sizes: Sizes, entry: usize) -> usize {
        let variable = entry - sizes.parameters;
        self.order.get(variable).copied().unwrap_or(variable)
    }
}

impl Simulator for Unit {
    fn mass(&self) -> Mass {
        Mass::Unit
    }

    fn evaluate(&self, at: &Point<'_>, _mass: &mut [f64], force: &mut [f64]) {
        let sizes = Sizes {
            parameters: at.parameters.len(),
            coordinates: at.coordinates.len(),
            states: at.states.len(),
            inputs: at.inputs.len(),
        };
        let parts =
            [at.parameters, at.coordinates, at.velocities, at.states, at.inputs, &[at.time]];
        let mut rates = vec![0.0; sizes.rates()];
        self.evaluate_all(sizes, &parts.concat(), &mut rates);
        force.copy_from_slice(&rates[sizes.coordinates * sizes.coordinates..]);
    }

    fn evaluate_all(&self, sizes: Sizes, points: &[f64], rates: &mut [f64]) {
        self.evaluate_along(sizes, points, rates, (&[], &mut []));
    }

    fn has_derivative(&self, sizes: Sizes, entry: usize) -> bool {
        let variables = sizes.parameters..sizes.parameters + sizes.variables() - 1;
        self.fmu.description().has_derivatives && variables.contains(&entry)
    }

    fn evaluate_along(
        &self,
        sizes: Sizes,
        points: &[f64],
        rates: &mut [f64],
        (entries, slopes): (&[usize], &mut [f64]),
    ) {
        let (width, states) = (sizes.rates(), self.order.len());
        let along: Vec<usize> = entries.iter().map(|&e| self.own_entry(sizes, e)).collect();
        let mut values = vec![0.0; rates.len() / width * states];
        let mut along_values = vec![0.0; along.len() * states];
        let points = &self.points(sizes, points);
        let question = Question { wanted: Wanted::Rates, points, along: &along };
        self.fmu.evaluate(&question, &mut values, &mut along_values);
        let n = sizes.coordinates;
        for (rates, own) in rates.chunks_exact_mut(width).zip(values.chunks_exact(states)) {
            let (_, force) = super::mass_and_force(sizes, rates);
            self.pick(sizes, own, force);
        }
        for (slopes, own) in slopes.chunks_exact_mut(width).zip(along_values.chunks_exact(states)) {
            slopes[..n * n].fill(0.0);
            self.pick(sizes, own, &mut slopes[n * n..]);
        }
    }

    fn outputs(&self) -> usize {
        self.fmu.description().outputs.len()
    }

    fn observe_all(&self, sizes: Sizes, points: &[f64], outputs: &mut [f64]) {
        let points = &self.points(sizes, points);
        let question = Question { wanted: Wanted::Outputs, points, along: &[] };
        self.fmu.evaluate(&question, outputs, &mut []);
    }

    fn trouble(&self) -> Option<String> {
        self.fmu.trouble()
    }
}
