//! Expressions as one graph in which equal sub-expressions are shared.

use lacuna_numbers::Number;
use std::collections::HashMap;

/// Index of a node in its [`Graph`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(u32);

impl NodeId {
    pub(super) fn index(self) -> usize {
        self.0 as usize
    }
}

/// Operations on one value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum Unary {
    Negate,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Exp,
    Log,
    Sqrt,
    Abs,
    Sign,
    Square,
    Cube,
}

/// Operations on two values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Atan2,
    Min,
    Max,
}

impl Unary {
    pub(super) fn of_name(name: &str) -> Option<Self> {
        Some(match name {
            "sin" => Self::Sin,
            "cos" => Self::Cos,
            "tan" => Self::Tan,
            "asin" => Self::Asin,
            "acos" => Self::Acos,
            "atan" => Self::Atan,
            "sinh" => Self::Sinh,
            "cosh" => Self::Cosh,
            "tanh" => Self::Tanh,
            "exp" => Self::Exp,
            "log" => Self::Log,
            "sqrt" => Self::Sqrt,
            "abs" => Self::Abs,
            "sign" => Self::Sign,
            _ => return None,
        })
    }

    /// The value of the operation.
    #[inline(always)]
    #[must_use]
    pub fn apply<T: Number>(self, a: T) -> T {
        match self {
            Self::Negate => -a,
            Self::Sin => a.sin(),
            Self::Cos => a.cos(),
            Self::Tan => a.tan(),
            Self::Asin => a.asin(),
            Self::Acos => a.acos(),
            Self::Atan => a.atan(),
            Self::Sinh => a.sinh(),
            Self::Cosh => a.cosh(),
            Self::Tanh => a.tanh(),
            Self::Exp => a.exp(),
            Self::Log => a.ln(),
            Self::Sqrt => a.sqrt(),
            Self::Abs => a.abs(),
            Self::Sign => a.sign(),
            Self::Square => a.powi(2),
            Self::Cube => a.powi(3),
        }
    }
}

impl Binary {
    pub(super) fn of_name(name: &str) -> Option<Self> {
        Some(match name {
            "atan2" => Self::Atan2,
            "min" => Self::Min,
            "max" => Self::Max,
            _ => return None,
        })
    }

    /// The value of the operation.
    #[inline(always)]
    #[must_use]
    pub fn apply<T: Number>(self, a: T, b: T) -> T {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::Power => a.powf(b),
            Self::Atan2 => a.atan2(b),
            Self::Min => a.min(b),
            Self::Max => a.max(b),
        }
    }
}

/// A node: a constant (by its bits), a variable (by its slot), or an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Node {
    /// A constant, as the bits of its value so that nodes can be compared.
    Constant(u64),
    /// A variable: an index into the caller's list of values.
    Variable(u32),
    /// An operation on one node.
    Unary(Unary, NodeId),
    /// An operation on two nodes.
    Binary(Binary, NodeId, NodeId),
}

/// Nodes, each after its operands, no two equal.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    nodes: Vec<Node>,
    index: HashMap<Node, NodeId>,
}

impl Graph {
    /// The node behind an id.
    #[must_use]
    pub fn node(&self, id: NodeId) -> Node {
        self.nodes[id.index()]
    }

    pub(super) fn len(&self) -> usize {
        self.nodes.len()
    }

    pub(crate) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    fn intern(&mut self, node: Node) -> NodeId {
        if let Some(&id) = self.index.get(&node) {
            return id;
        }
        let id =
            NodeId(u32::try_from(self.nodes.len()).expect("a model has fewer than 2^32 nodes"));
        self.nodes.push(node);
        self.index.insert(node, id);
        id
    }

    /// A constant.
    pub fn constant(&mut self, value: f64) -> NodeId {
        // +0 and -0 are one number here.
        self.intern(Node::Constant((value + 0.0).to_bits()))
    }

    /// A variable by its slot.
    pub fn variable(&mut self, slot: usize) -> NodeId {
        self.intern(Node::Variable(u32::try_from(slot).expect("a model has fewer than 2^32 names")))
    }

    /// The value of a node that is a constant.
    #[must_use]
    pub fn constant_value(&self, id: NodeId) -> Option<f64> {
        match self.node(id) {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// `op(a)`, simplified.
    pub fn unary(&mut self, op: Unary, a: NodeId) -> NodeId {
        if let Some(value) = self.constant_value(a) {
            return self.constant(op.apply(value));
        }
        match (op, self.node(a)) {
            (Unary::Negate, Node::Unary(Unary::Negate, inner)) => inner,
            _ => self.intern(Node::Unary(op, a)),
        }
    }

    /// `op(a, b)`, simplified.
    pub fn binary(&mut self, op: Binary, a: NodeId, b: NodeId) -> NodeId {
        let (x, y) = (self.constant_value(a), self.constant_value(b));
        if let (Some(x), Some(y)) = (x, y) {
            return self.constant(op.apply(x, y));
        }
        match op {
            Binary::Add if x == Some(0.0) => return b,
            Binary::Add | Binary::Subtract if y == Some(0.0) => return a,
            Binary::Subtract if x == Some(0.0) => return self.unary(Unary::Negate, b),
            Binary::Subtract if a == b => return self.constant(0.0),
            Binary::Multiply if x == Some(0.0) || y == Some(0.0) => return self.constant(0.0),
            Binary::Multiply if x == Some(1.0) => return b,
            Binary::Multiply | Binary::Divide | Binary::Power if y == Some(1.0) => return a,
            Binary::Multiply if x == Some(-1.0) => return self.unary(Unary::Negate, b),
            Binary::Multiply if y == Some(-1.0) => return self.unary(Unary::Negate, a),
            Binary::Multiply if a == b => return self.unary(Unary::Square, a),
            Binary::Divide if x == Some(0.0) => return self.constant(0.0),
            Binary::Power if y == Some(0.0) => return self.constant(1.0),
            Binary::Power if y == Some(2.0) => return self.unary(Unary::Square, a),
            Binary::Power if y == Some(3.0) => return self.unary(Unary::Cube, a),
            Binary::Power if y == Some(0.5) => return self.unary(Unary::Sqrt, a),
            Binary::Power if y == Some(-1.0) => {
                let one = self.constant(1.0);
                return self.intern(Node::Binary(Binary::Divide, one, a));
            }
            _ => {}
        }
        // Sums and products are stored in one order, so that a*b and b*a are one node.
        let (a, b) = match op {
            Binary::Add | Binary::Multiply if b < a => (b, a),
            _ => (a, b),
        };
        self.intern(Node::Binary(op, a, b))
    }
}
