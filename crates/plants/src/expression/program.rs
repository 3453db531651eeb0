//! Register programs: what a graph becomes to be evaluated ten million times.
//!
//! Registers hold, in this order, the *frozen* values (constants and everything that
//! depends on parameters alone, computed once by [`Program::bind`]), the variables of the
//! call, and temporaries that are used again as soon as they are free.

use super::graph::{Binary, Graph, Node, NodeId, Unary};
use lacuna_numbers::Number;
use std::sync::Arc;

/// One operation on registers. The two kinds of operations are one flat code, so that the
/// interpreter jumps once an instruction; a unary one ignores `b`.
#[derive(Clone, Copy, Debug)]
struct Instruction {
    op: Code,
    a: u16,
    b: u16,
    to: u16,
}

macro_rules! codes {
    ($($unary:ident)*; $($binary:ident)*) => {
        /// Operations of both kinds.
        #[derive(Clone, Copy, Debug)]
        enum Code { $($unary,)* $($binary,)* }

        impl From<Unary> for Code {
            fn from(op: Unary) -> Self {
                match op { $(Unary::$unary => Self::$unary,)* }
            }
        }

        impl From<Binary> for Code {
            fn from(op: Binary) -> Self {
                match op { $(Binary::$binary => Self::$binary,)* }
            }
        }

        impl Code {
            #[inline(always)]
            fn apply<T: Number>(self, a: T, b: T) -> T {
                match self {
                    $(Self::$unary => Unary::$unary.apply(a),)*
                    $(Self::$binary => Binary::$binary.apply(a, b),)*
                }
            }
        }
    };
}

codes! {
    Negate Sin Cos Tan Asin Acos Atan Sinh Cosh Tanh Exp Log Sqrt Abs Sign Square Cube;
    Add Subtract Multiply Divide Power Atan2 Min Max
}

/// A compiled set of expressions. Variables with a slot below `parameters` are frozen by
/// [`Program::bind`], the rest are given with each evaluation. Clones share the code.
#[derive(Clone, Debug)]
pub struct Program {
    parameters: usize,
    frozen: Arc<[Frozen]>,
    variables: Arc<[u32]>,
    body: Arc<[Instruction]>,
    outputs: Arc<[u32]>,
    registers: usize,
}

/// How a frozen register gets its value.
#[derive(Clone, Copy, Debug)]
enum Frozen {
    Constant(f64),
    Parameter(u32),
    Unary(Unary, u32),
    Binary(Binary, u32, u32),
}

/// A program with its parameters set.
#[derive(Clone, Debug)]
pub struct Bound<T = f64> {
    frozen: Vec<T>,
}

impl Program {
    /// Compile `outputs`. Variable slots below `parameters` are parameters.
    #[must_use]
    pub fn compile(graph: &Graph, parameters: usize, outputs: &[NodeId]) -> Self {
        Compiler::new(graph, parameters, outputs).run()
    }

    /// Number of outputs.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.outputs.len()
    }

    /// Compute everything that depends on the parameters alone.
    #[must_use]
    pub fn bind<T: Number>(&self, parameters: &[T]) -> Bound<T> {
        debug_assert_eq!(parameters.len(), self.parameters);
        let mut frozen: Vec<T> = Vec::with_capacity(self.frozen.len());
        for &f in &*self.frozen {
            frozen.push(match f {
                Frozen::Constant(v) => T::constant(v),
                Frozen::Parameter(p) => parameters[p as usize],
                Frozen::Unary(op, a) => op.apply(frozen[a as usize]),
                Frozen::Binary(op, a, b) => op.apply(frozen[a as usize], frozen[b as usize]),
            });
        }
        Bound { frozen }
    }

    /// Evaluate the outputs. `variables[k]` is the variable in slot `parameters + k`.
    #[inline(always)]
    pub fn evaluate<T: Number>(&self, bound: &Bound<T>, variables: &[T], outputs: &mut [T]) {
        // The registers live on the stack; small programs need not clear a large one.
        match self.registers {
            0..=32 => self.run::<32, T>(bound, variables, outputs),
            33..=64 => self.run::<64, T>(bound, variables, outputs),
            65..=256 => self.run::<256, T>(bound, variables, outputs),
            257..=2048 => self.run::<2048, T>(bound, variables, outputs),
            n => self.run_in(&mut vec![T::constant(0.0); n], bound, variables, outputs),
        }
    }

    #[inline(always)]
    fn run<const N: usize, T: Number>(&self, bound: &Bound<T>, variables: &[T], outputs: &mut [T]) {
        self.run_in(&mut [T::constant(0.0); N], bound, variables, outputs);
    }

    #[inline(always)]
    fn run_in<T: Number>(&self, r: &mut [T], bound: &Bound<T>, variables: &[T], outputs: &mut [T]) {
        r[..bound.frozen.len()].copy_from_slice(&bound.frozen);
        self.evaluate_in(r, variables, outputs);
    }

    /// Registers to evaluate in again and again ([`Program::evaluate_in`]), parameters set.
    #[must_use]
    pub fn registers<T: Number>(&self, bound: &Bound<T>) -> Vec<T> {
        let mut registers = bound.frozen.clone();
        registers.resize(self.registers, T::constant(0.0));
        registers
    }

    /// Evaluate the outputs in registers that have their parameters already.
    #[inline(always)]
    pub fn evaluate_in<T: Number>(&self, r: &mut [T], variables: &[T], outputs: &mut [T]) {
        let frozen = self.frozen.len();
        for (register, &slot) in r[frozen..].iter_mut().zip(&*self.variables) {
            *register = variables[slot as usize].same();
        }
        for &Instruction { op, a, b, to } in &*self.body {
            r[to as usize] = op.apply(r[a as usize], r[b as usize]);
        }
        for (output, &register) in outputs.iter_mut().zip(&*self.outputs) {
            *output = r[register as usize].same();
        }
    }
}

struct Compiler<'a> {
    graph: &'a Graph,
    parameters: usize,
    outputs: &'a [NodeId],
    needed: Vec<bool>,
    is_frozen: Vec<bool>,
}

impl<'a> Compiler<'a> {
    fn new(graph: &'a Graph, parameters: usize, outputs: &'a [NodeId]) -> Self {
        let mut needed = vec![false; graph.len()];
        for &o in outputs {
            needed[o.index()] = true;
        }
        // Operands stand before their operations: one backward pass marks all.
        for k in (0..graph.len()).rev() {
            if needed[k] {
                for a in operands(graph, k) {
                    needed[a] = true;
                }
            }
        }
        let mut is_frozen = vec![false; graph.len()];
        for k in 0..graph.len() {
            is_frozen[k] = match node(graph, k) {
                Node::Constant(_) => true,
                Node::Variable(v) => (v as usize) < parameters,
                _ => operands(graph, k).iter().all(|&a| is_frozen[a]),
            };
        }
        Self { graph, parameters, outputs, needed, is_frozen }
    }

    fn run(self) -> Program {
        let n = self.graph.len();
        let mut register = vec![u32::MAX; n];
        let (frozen, fixed) = self.freeze(&mut register);
        let mut variables = Vec::new();
        for (k, register) in register.iter_mut().enumerate() {
            if let (true, false, Node::Variable(v)) =
                (self.needed[k], self.is_frozen[k], node(self.graph, k))
            {
                *register = (fixed + variables.len()) as u32;
                variables.push(v - self.parameters as u32);
            }
        }
        let first = fixed + variables.len();
        let last_use = self.last_uses();
        let mut body = Vec::new();
        let mut free: Vec<u32> = Vec::new();
        let mut next = first as u32;
        for k in 0..n {
            let operation = matches!(node(self.graph, k), Node::Unary(..) | Node::Binary(..));
            if !self.needed[k] || self.is_frozen[k] || !operation {
                continue;
            }
            let mut used = operands(self.graph, k);
            used.dedup();
            let sources: Vec<u32> = operands(self.graph, k).iter().map(|&a| register[a]).collect();
            // An operand that dies here leaves its register to the result.
            free.extend(
                used.iter()
                    .filter(|&&a| last_use[a] == k && register[a] >= first as u32)
                    .map(|&a| register[a]),
            );
            let to = free.pop().unwrap_or_else(|| {
                next += 1;
                next - 1
            });
            register[k] = to;
            let op = match node(self.graph, k) {
                Node::Unary(op, _) => op.into(),
                Node::Binary(op, ..) => op.into(),
                Node::Constant(_) | Node::Variable(_) => unreachable!("only operations get here"),
            };
            let (a, b) = (small(sources[0]), small(sources[sources.len() - 1]));
            body.push(Instruction { op, a, b, to: small(to) });
        }
        let outputs = self.outputs.iter().map(|o| register[o.index()]).collect();
        Program {
            parameters: self.parameters,
            frozen: frozen.into(),
            variables: variables.into(),
            body: body.into(),
            outputs,
            registers: next as usize,
        }
    }

    /// The frozen part, all of it in registers of its own.
    fn freeze(&self, register: &mut [u32]) -> (Vec<Frozen>, usize) {
        let mut frozen = Vec::new();
        for k in 0..self.graph.len() {
            if !self.needed[k] || !self.is_frozen[k] {
                continue;
            }
            let at = |id: NodeId| register[id.index()];
            frozen.push(match node(self.graph, k) {
                Node::Constant(bits) => Frozen::Constant(f64::from_bits(bits)),
                Node::Variable(v) => Frozen::Parameter(v),
                Node::Unary(op, a) => Frozen::Unary(op, at(a)),
                Node::Binary(op, a, b) => Frozen::Binary(op, at(a), at(b)),
            });
            register[k] = (frozen.len() - 1) as u32;
        }
        let count = frozen.len();
        (frozen, count)
    }

    /// For each node the last operation that reads it; outputs are read at the very end.
    fn last_uses(&self) -> Vec<usize> {
        let n = self.graph.len();
        let mut last = vec![0; n];
        for k in (0..n).filter(|&k| self.needed[k]) {
            for a in operands(self.graph, k) {
                last[a] = k;
            }
        }
        for o in self.outputs {
            last[o.index()] = usize::MAX;
        }
        last
    }
}

/// Registers are numbered with 16 bits: the reader refuses models that need more.
fn small(register: u32) -> u16 {
    u16::try_from(register).expect("a model needs fewer than 65536 registers")
}

fn node(graph: &Graph, k: usize) -> Node {
    graph.nodes()[k]
}

fn operands(graph: &Graph, k: usize) -> Vec<usize> {
    match node(graph, k) {
        Node::Constant(_) | Node::Variable(_) => vec![],
        Node::Unary(_, a) => vec![a.index()],
        Node::Binary(_, a, b) => vec![a.index(), b.index()],
    }
}
