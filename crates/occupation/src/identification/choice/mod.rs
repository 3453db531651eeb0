//! Kernel family and widths, prior amplitude and noise of one coordinate, by marginal likelihood.
//!
//! ```text
//! f_i ~ GP(0, a_0^2 K_0),   g_ij ~ GP(0, a_j^2 K_j),   lambda_j = sigma^2 / a_j^2
//! ```
//!
//! The weak form is linear in f and g, so log p(y | kernels, a, sigma) is in closed form (module `evidence`). One
//! block after the other is followed uphill with the others held, first in the first family, then in every other; the
//! family of greatest evidence stays. Log-normal priors, wide on purpose, keep widths of dimensions that do not matter
//! from running away. Which arguments an effectiveness depends on is found by forward selection, and backward again
//! where other blocks have made one needless.
//!
//! The search sees few equations; `reconsider` compares where it ended with the other priors that it came across on
//! many more, at the cost of one evaluation each.

mod block;
mod search;
mod span;

use faer::Mat;
use serde::{Deserialize, Serialize};

use super::IdentificationError;
use super::family::{Family, ScaledKernel};
use super::weak::WeakRow;
use search::Search;

/// The prior of one function f_i or g_ij.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BlockChoice {
    /// Kernel with its widths.
    pub kernel: ScaledKernel,
    /// Prior standard deviation a, in units of f_i or g_ij over those of the kernel.
    pub amplitude: f64,
    /// Root mean square of the posterior standard deviation on the data that were used for choosing.
    pub posterior_sd: f64,
    /// Arguments on which the function depends; in the others it was chosen flat.
    pub depends_on: Vec<usize>,
}

impl BlockChoice {
    /// Whether the function depends on something and is no polynomial.
    pub(crate) fn is_general(&self) -> bool {
        !self.depends_on.is_empty() && !self.kernel.family.is_polynomial()
    }

    /// The same for a function that depends on nothing.
    pub(crate) fn constant(mut self, spread: &[f64]) -> Self {
        let flat = spread.iter().map(|spread| search::FLAT * spread);
        self.kernel.widths = flat.collect();
        self.depends_on.clear();
        self
    }
}

/// What was chosen for one coordinate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RowChoice {
    /// f_i, g_i1, ..., g_im.
    pub blocks: Vec<BlockChoice>,
    /// Standard deviation sigma of the samples' errors.
    pub noise_sd: f64,
    /// log p(y) of the windows that were used for choosing, in nats.
    pub log_evidence: f64,
}

/// What the search starts from.
pub(crate) struct Start<'s> {
    /// Mean and spread of each argument.
    pub centre: &'s [f64],
    pub spread: &'s [f64],
    /// Arguments from which landmarks are taken, rows of d.
    pub candidates: &'s [f64],
    /// First guesses of the amplitudes of f_i, g_i1, ... and of the noise.
    pub amplitudes: Vec<f64>,
    pub noise_sd: f64,
    /// Families that may be chosen for f and for g.
    pub families: &'s [Family],
    /// Widths that are given, one per argument.
    pub widths: Option<&'s [f64]>,
    /// lambda = sigma^2 / a^2 that is given.
    pub lambda: Option<f64>,
    /// How thoroughly to search.
    pub effort: Effort,
}

/// How thoroughly to search.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    /// Most families that are tried.
    families: usize,
    /// Rounds over the blocks.
    rounds: usize,
    /// Most iterations on one block.
    iterations: usize,
    /// Most landmarks of a block.
    landmarks: usize,
}

impl Effort {
    /// Enough for a trial model.
    pub const QUICK: Self = Self { families: 1, rounds: 1, iterations: 6, landmarks: 80 };
    /// Until nothing is gained.
    pub const THOROUGH: Self =
        Self { families: usize::MAX, rounds: 2, iterations: 12, landmarks: 160 };
}

/// Chooses the priors of one coordinate, and tells which others were tried.
pub(crate) fn choose(
    row: &WeakRow<'_>,
    start: &Start<'_>,
) -> Result<(RowChoice, Vec<Alternative>), IdentificationError> {
    let mut search = Search::new(row, start)?;
    let blocks = start.amplitudes.len();
    for b in 0..blocks {
        search.improve(b, search.family(b));
    }
    for b in 1..blocks {
        search.widen(b);
    }
    for b in 0..blocks {
        if search.is_constant(b) {
            continue;
        }
        for &family in start.families.iter().take(start.effort.families) {
            if family != search.family(b) {
                search.improve(b, family);
            }
        }
    }
    for _ in 1..start.effort.rounds {
        for b in 0..blocks {
            search.improve(b, search.family(b));
        }
        if start.widths.is_none() {
            (1..blocks).for_each(|b| search.narrow(b));
        }
    }
    Ok(search.finish())
}

/// A prior of block `block` that few equations did not prefer.
#[derive(Debug, Clone)]
pub(crate) struct Alternative {
    block: usize,
    choice: BlockChoice,
}

/// What more equations make of a choice and its alternatives: families with few features are preferred by few equations,
/// and their standard deviations know nothing of what they cannot follow. Beside it the same row with a polynomial for
/// its drift, where few of its monomials may turn out to be more probable.
pub(crate) fn reconsider(
    row: &WeakRow<'_>,
    start: &Start<'_>,
    (chosen, alternatives): (RowChoice, Vec<Alternative>),
) -> Result<(RowChoice, Option<RowChoice>), IdentificationError> {
    let mut search = Search::at(row, start, &chosen)?;
    for Alternative { block, choice } in &alternatives {
        search.compare(*block, choice.clone());
    }
    let (chosen, _) = search.finish();
    let polynomial = Search::at(row, start, &chosen)?.with_polynomial_drift(&alternatives);
    Ok((chosen, polynomial))
}

/// Matrices of equal height, one beside the other.
pub(crate) fn side_by_side(parts: &[&Mat<f64>]) -> Mat<f64> {
    let rows = parts.first().map_or(0, |part| part.nrows());
    let columns = parts.iter().map(|part| part.ncols()).sum();
    let mut whole = Mat::zeros(rows, columns);
    let mut first = 0;
    for part in parts {
        whole.as_mut().subcols_mut(first, part.ncols()).copy_from(part);
        first += part.ncols();
    }
    whole
}
