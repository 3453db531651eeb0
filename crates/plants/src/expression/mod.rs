//! Expressions of model files: text, to a shared graph, to a register program.
//!
//! `parse` reads `p1 + 2*p3*cos(q2)` into a [`Graph`] in which equal sub-expressions are
//! one node; [`Program`] evaluates any set of nodes at a cost of about a nanosecond an operation, computing what depends on
//! parameters alone only once.

mod graph;
mod parse;
mod program;
mod token;

pub use graph::{Binary, Graph, Node, NodeId, Unary};
pub(crate) use parse::hint;
pub use parse::{ExpressionError, Problem, nearest, parse};
pub(crate) use parse::{FORCE_ON, is_function, names_in};
pub use program::{Bound, Program};
