//! Coefficients of all functions from the weak form on some windows.

use rayon::prelude::*;

use super::IdentificationError;
use super::choice::{RowChoice, side_by_side};
use super::data::Data;
use super::evidence::Normal;
use super::field::{Field, Term};
use super::weak::WeakWindow;
use crate::linear::NonPositivePivot;

/// Fewest windows of a group that one thread works on; inner products are summed in the groups' order.
const GROUP: usize = 8;
/// Least noise, as a share of what the samples' own scatter says.
const LEAST_NOISE: f64 = 1e-3;
/// Most groups.
const GROUPS: usize = 32;

/// The field with its most probable coefficients for the kernels that were chosen, coordinate by coordinate.
pub(super) fn fit(
    data: &Data,
    windows: &[WeakWindow],
    rows: &[RowChoice],
    mut field: Field,
) -> Result<Field, IdentificationError> {
    for (i, row) in rows.iter().enumerate() {
        fit_row(data, windows, i, row, &mut field)?;
    }
    Ok(field)
}

fn fit_row(
    data: &Data,
    windows: &[WeakWindow],
    i: usize,
    choice: &RowChoice,
    field: &mut Field,
) -> Result<(), IdentificationError> {
    let terms: Vec<&Term> = field.terms.iter().filter(|t| t.row == i).collect();
    let size: usize = terms.iter().map(|t| t.basis.rank()).sum();
    // Kernels that follow the samples to rounding leave no noise to weigh by.
    let noise_sd = choice.noise_sd.max(LEAST_NOISE * data.channels[i].noise_sd);
    let group = |windows: &[WeakWindow]| {
        let row = data.row(windows, i);
        let parts: Vec<_> = terms.iter().map(|t| row.design(&t.basis, t.block)).collect();
        let remainders: Vec<_> = terms.iter().map(|t| row.remainders(&t.basis, t.block)).collect();
        let remainders: Vec<_> = terms.iter().map(|t| t.amplitude).zip(&remainders).collect();
        let design = side_by_side(&parts.iter().collect::<Vec<_>>());
        Ok(row.normal(design, &remainders, noise_sd)?.0)
    };
    let size_of_group = GROUP.max(windows.len() / GROUPS);
    let groups: Result<Vec<Normal>, NonPositivePivot> =
        windows.par_chunks(size_of_group).map(group).collect();
    let mut normal = Normal::new(size);
    let no_evidence = |_| IdentificationError::NoEvidence;
    groups.map_err(no_evidence)?.iter().for_each(|g| normal.merge(g));
    let prior = Term::priors(terms.iter().copied());
    let posterior = normal.posterior(&prior, 1.0).map_err(no_evidence)?;
    let mut first = 0;
    for term in field.terms.iter_mut().filter(|t| t.row == i) {
        let rank = term.basis.rank();
        term.set(&posterior.coefficients[first..first + rank]);
        first += rank;
    }
    Ok(())
}
