//! Dynamics as expressions of a model file, compiled to register programs, and what servos add to their forces.

use super::servo::BoundServo;
use super::{Bound, BoundDynamics, Dynamics, Point, Room, SERVO, Servo, Sizes};
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
#[derive(Clone, Debug)]
pub(crate) struct Equations {
    rates: Program,
    outputs: Program,
    /// Parameters that expressions may name.
    named: usize,
    servos: Vec<Servo>,
    sizes: Sizes,
}

impl Equations {
    /// Compile the expressions of a model of these sizes.
    pub fn compile(nodes: &Nodes, sizes: Sizes) -> Self {
        let rates: Vec<_> = nodes.mass.iter().chain(&nodes.force).copied().collect();
        let program = |of: &[NodeId]| Program::compile(&nodes.graph, sizes.parameters, of);
        let (rates, outputs) = (program(&rates), program(&nodes.outputs));
        Self { rates, outputs, named: sizes.parameters, servos: vec![], sizes }
    }

    /// The same with servos, whose forces add to those of the expressions.
    pub fn with_servos(mut self, servos: Vec<Servo>) -> Self {
        self.sizes.parameters += servos.iter().map(|s| s.parameters()).sum::<usize>();
        Self { servos, ..self }
    }

    fn bound<T: Number>(&self, parameters: &[T]) -> Bound<T> {
        let (own, left_out) = parameters.split_at(self.sizes.parameters);
        let (named, of_servos) = own.split_at(self.named);
        // What is left out of servos is the last.
        let left_out = &left_out[left_out.len().saturating_sub(SERVO * self.servos.len())..];
        Arc::new(BoundEquations {
            rates: (self.rates.clone(), self.rates.bind(named)),
            outputs: (self.outputs.clone(), self.outputs.bind(named)),
            servos: Servo::bound(&self.servos, of_servos, left_out),
            sizes: self.sizes,
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

    fn servos(&self) -> &[Servo] {
        &self.servos
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
    servos: Vec<BoundServo<T>>,
    sizes: Sizes,
}

impl<T: Number> BoundEquations<T> {
    /// Add the forces of the servos.
    #[inline(always)]
    fn drive(&self, variables: &[T], rates: &mut [T]) {
        if self.servos.is_empty() {
            return;
        }
        let at = Point::new(self.sizes, &[], variables);
        let force = &mut rates[self.sizes.coordinates * self.sizes.coordinates..];
        for servo in &self.servos {
            force[servo.coordinate] = force[servo.coordinate] + servo.force(&at);
        }
    }
}

impl<T: Number> BoundDynamics<T> for BoundEquations<T> {
    fn room(&self) -> Room<T> {
        Room::new(self.rates.0.registers(&self.rates.1), vec![])
    }

    #[inline(always)]
    fn evaluate(&self, room: &mut Room<T>, variables: &[T], rates: &mut [T]) {
        self.rates.0.evaluate_in(&mut room.numbers, variables, rates);
        self.drive(variables, rates);
    }

    fn evaluate_once(&self, variables: &[T], rates: &mut [T]) {
        self.rates.0.evaluate(&self.rates.1, variables, rates);
        self.drive(variables, rates);
    }

    fn observe(&self, variables: &[T], outputs: &mut [T]) {
        self.outputs.0.evaluate(&self.outputs.1, variables, outputs);
    }
}
