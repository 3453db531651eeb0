//! Dynamics as expressions of a model file, compiled to register programs.

use super::{Bound, BoundDynamics, Dynamics, Room, Sizes};
use crate::expression::{self, Graph, NodeId, Program};
use lacuna_numbers::{Dual, Number};
use std::sync::Arc;

/// The expressions of a model file as nodes of one graph, in which a parameter's slot is its
/// number and the slots of the variables follow.
#[derive(Default)]
pub(crate) struct Nodes {
    pub graph: Graph,
    /// Mass matrix, row-major.
    pub mass: Vec<NodeId>,
    /// Generalised forces of the coordinates, then rates of the first-order states.
    pub force: Vec<NodeId>,
    /// Measured expressions.
    pub outputs: Vec<NodeId>,
}

/// Compiled expressions, parameters free.
#[derive(Debug)]
pub(crate) struct Equations {
    rates: Program,
    outputs: Program,
    sizes: Sizes,
}

impl Equations {
    /// Compile the expressions of a model of these sizes.
    pub fn compile(nodes: &Nodes, sizes: Sizes) -> Self {
        let rates: Vec<_> = nodes.mass.iter().chain(&nodes.force).copied().collect();
        let program = |of: &[NodeId]| Program::compile(&nodes.graph, sizes.parameters, of);
        Self { rates: program(&rates), outputs: program(&nodes.outputs), sizes }
    }

    fn bound<T: Number>(&self, parameters: &[T]) -> Bound<T> {
        Arc::new(BoundEquations {
            rates: (self.rates.clone(), self.rates.bind(parameters)),
            outputs: (self.outputs.clone(), self.outputs.bind(parameters)),
        })
    }
}

impl Dynamics for Equations {
    fn sizes(&self) -> Sizes {
        self.sizes
    }

    fn outputs(&self) -> usize {
        self.outputs.outputs()
    }

    fn bind(&self, parameters: &[f64]) -> Bound {
        self.bound(parameters)
    }

    fn bind_dual(&self, parameters: &[Dual]) -> Bound<Dual> {
        self.bound(parameters)
    }
}

/// Each program with what it computes from the parameters alone.
#[derive(Debug)]
struct BoundEquations<T> {
    rates: (Program, expression::Bound<T>),
    outputs: (Program, expression::Bound<T>),
}

impl<T: Number> BoundDynamics<T> for BoundEquations<T> {
    fn room(&self) -> Room<T> {
        Room::new(self.rates.0.registers(&self.rates.1), vec![])
    }

    #[inline(always)]
    fn evaluate(&self, room: &mut Room<T>, variables: &[T], rates: &mut [T]) {
        self.rates.0.evaluate_in(&mut room.numbers, variables, rates);
    }

    fn evaluate_once(&self, variables: &[T], rates: &mut [T]) {
        self.rates.0.evaluate(&self.rates.1, variables, rates);
    }

    fn observe(&self, variables: &[T], outputs: &mut [T]) {
        self.outputs.0.evaluate(&self.outputs.1, variables, outputs);
    }
}
