//! An identified model as an evaluator for control loops, on a box, to a tolerance.
//!
//! A model is a sum over samples or landmarks, and costs as much as there are. On a box its functions h (the f_i and
//! g_ij) are compiled to whichever is cheapest, counted in operations:
//!
//! ```text
//! h(x) ~ sum_(k in K) c_k T_k1(z_1) ... T_kd(z_d),   z_i = (2 x_i - l_i - u_i) / (u_i - l_i)
//! ```
//!
//! a Chebyshev series, or the model's own sum without the landmarks that do not count. The set of terms is
//! K = {k : sum_i k_i / D_i <= theta}; the D_i are told by Chebyshev coefficients along lines through the box (0 for
//! an argument on which h does not depend), and theta is raised until the error is met. Coefficients are those of least
//! squares on Halton points in the measure in which the polynomials are orthogonal, prod_i dz_i / sqrt(1 - z_i^2);
//! blocks of eight that the error does not need are left out. Where no series within reach meets the tolerance (a kernel
//! that is not smooth, many arguments), the sum remains, and [`Function::representation`] says so.
//!
//! **The error** is measured, on points that served for nothing else: [`PROOF_POINTS`] Halton points of the box and up
//! to [`BOUNDARY_POINTS`] of its corners, edges and faces in turn. For each function
//!
//! ```text
//! absolute = max_x |compiled h(x) - h(x)|,   relative = absolute / max_x |h(x)|
//! ```
//!
//! and the tolerance is on the relative one. Beside it stands an estimate from the coefficients alone
//! ([`Function::estimate`]).
//!
//! | on paper | in code |
//! | --- | --- |
//! | box l, u | [`Domain`] |
//! | compiled f and g | [`Compiled::evaluator`] |
//! | errors | [`Function`] |

mod build;
mod cost;
mod degrees;
mod domain;
mod error;
mod file;
mod fit;
mod groups;
mod layout;
mod prune;
mod samples;
mod search;
pub mod source;
mod sums;
#[cfg(test)]
mod tests;

use lacuna_realtime::Evaluator;
use serde::{Deserialize, Serialize};

use crate::{IdentifiedModel, Names};
pub use build::compile;
pub use domain::Domain;
pub use error::CompileError;

/// Interior points on which errors are measured.
pub const PROOF_POINTS: usize = 20_000;
/// Most points of corners, edges and faces on which errors are measured.
pub const BOUNDARY_POINTS: usize = 8192;
/// Least and greatest tolerance.
pub const TOLERANCES: [f64; 2] = [1e-10, 0.1];

/// A model on a box, for an evaluator.
#[derive(Debug, Clone, PartialEq)]
pub struct Compiled {
    order: usize,
    names: Option<Names>,
    tolerance: f64,
    functions: Vec<Function>,
    evaluator: Evaluator<'static>,
}

/// How a function is represented.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Representation {
    /// Zero on the whole box.
    Zero,
    /// A Chebyshev series.
    Series,
    /// The model's own sum: no series that was tried meets the tolerance at less cost.
    Landmarks,
}

/// What is known of one compiled function, f_i or g_ij.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Function {
    /// i, from 0.
    pub row: usize,
    /// Of g_ij its j, from 0; none for f_i.
    pub input: Option<usize>,
    /// What stands for it.
    pub representation: Representation,
    /// Coefficients that are not zero, or landmarks.
    pub coefficients: usize,
    /// Largest absolute value of the model's function on the points of the proof.
    pub magnitude: f64,
    /// Largest absolute error there.
    pub absolute: f64,
    /// The same over the magnitude.
    pub relative: f64,
    /// Before any measurement: absolute values of the coefficients that were left out, and of the outermost ones that
    /// were found, which tell how large those beyond them are; for a sum, the most that its missing landmarks can
    /// contribute.
    pub estimate: f64,
}

impl Compiled {
    /// f and g on the box.
    pub fn evaluator(&self) -> &Evaluator<'static> {
        &self.evaluator
    }

    /// f_1 ... f_n, g_11 ... g_nm.
    pub fn functions(&self) -> &[Function] {
        &self.functions
    }

    /// The tolerance asked for.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Order s of the dynamics.
    pub fn order(&self) -> usize {
        self.order
    }

    /// Names of what the model was identified from, where given.
    pub fn names(&self) -> Option<&Names> {
        self.names.as_ref()
    }

    /// Largest relative error of any function.
    pub fn relative_error(&self) -> f64 {
        self.functions.iter().map(|f| f.relative).fold(0.0, f64::max)
    }

    /// Operations on vectors of eight that an evaluation takes.
    pub fn operations(&self) -> usize {
        cost::evaluator(&self.evaluator)
    }
}

/// Names for the reports: f_i or g_ij of a model.
impl Function {
    /// `f_q1`, `g_q1_tau1`: by the names of coordinate and input, or their numbers from 1.
    pub fn name(&self, names: Option<&Names>) -> String {
        let row = names.map_or((self.row + 1).to_string(), |n| n.coordinates[self.row].clone());
        match self.input {
            None => format!("f_{row}"),
            Some(j) => {
                let input = names.map_or((j + 1).to_string(), |n| n.inputs[j].clone());
                format!("g_{row}_{input}")
            }
        }
    }
}

fn function_of(model: &IdentifiedModel, index: usize) -> (usize, Option<usize>) {
    let (n, m) = (model.dimension(), model.inputs());
    match index.checked_sub(n) {
        None => (index, None),
        Some(k) => (k / m, Some(k % m)),
    }
}
