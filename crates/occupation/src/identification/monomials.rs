//! Polynomials by their monomials, about the zero of the arguments.
//!
//! ```text
//! f(x) = phi(x) . c = sum_alpha b_alpha prod_i (x_i / s_i)^alpha_i,   c / a = T b,   T = L^-1 V,   V_j,alpha = prod_i (z_ji / s_i)^alpha_i
//! ```
//!
//! with the landmarks z and the factor L of [`super::basis`], s_i the largest |z_ji|, and the columns of T scaled to norm 1:
//! a term of norm 1 is one that the prior N(0, a^2 I) of c holds for likely.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};

use super::choice::BlockChoice;
use super::family::Family;
use super::field::Term;
use crate::linear::Factor;

/// Least share of a monomial's square that the others may leave of it: below, far from the zero of the arguments, rounding
/// tells it no longer from them.
const TOLD_APART: f64 = 1e-10;

/// The monomials that a polynomial may have.
#[derive(Debug)]
pub(super) struct Monomials {
    /// T.
    pub columns: Mat<f64>,
    /// Sum of each one's powers.
    pub degrees: Vec<u32>,
}

/// Those of a term; none where it is no polynomial, or its monomials are not told apart.
pub(super) fn of(term: &Term, choice: &BlockChoice) -> Option<Monomials> {
    let exponents = exponents(degree(term, choice)?, &choice.depends_on);
    let (rank, d) = (term.basis.rank(), term.basis.kernel.widths.len());
    if exponents.len() > rank {
        return None;
    }
    let landmarks: Vec<&[f64]> = term.basis.landmarks.chunks_exact(d).collect();
    let size = |&i: &usize| landmarks.iter().fold(f64::MIN_POSITIVE, |m, z| m.max(z[i].abs()));
    let sizes: Vec<f64> = choice.depends_on.iter().map(size).collect();
    let value = |j: usize, k: usize| -> f64 {
        let factors = choice.depends_on.iter().zip(&sizes).zip(&exponents[k]);
        factors.map(|((&i, size), &power)| (landmarks[j][i] / size).powi(power)).product()
    };
    let values = Mat::from_fn(rank, exponents.len(), value);
    let mut found: Mat<f64> = Mat::zeros(rank, exponents.len());
    matmul(&mut found, Accum::Replace, term.basis.inverse.transpose(), &values, 1.0, Par::Seq);
    for k in 0..found.ncols() {
        let norm = found.col(k).norm_l2();
        found.col_as_slice_mut(k).iter_mut().for_each(|entry| *entry /= norm);
    }
    let told_apart =
        |factor: Factor| (0..found.ncols()).all(|k| factor.entry(k, k).powi(2) > TOLD_APART);
    let degrees = exponents.iter().map(|powers| powers.iter().sum::<i32>() as u32).collect();
    let told_apart = Factor::of(found.transpose() * &found).is_ok_and(told_apart);
    told_apart.then_some(Monomials { columns: found, degrees })
}

/// Degree of a polynomial; a function of no argument is one of degree 0.
fn degree(term: &Term, choice: &BlockChoice) -> Option<u32> {
    match choice.kernel.family {
        Family::Polynomial(degree) => Some(degree),
        _ if term.block > 0 && choice.depends_on.is_empty() => Some(0),
        _ => None,
    }
}

/// Powers of each of the arguments, of all monomials up to a degree.
fn exponents(degree: u32, arguments: &[usize]) -> Vec<Vec<i32>> {
    let mut all = vec![Vec::new()];
    for _ in arguments {
        let longer = |powers: &Vec<i32>| {
            let left = degree as i32 - powers.iter().sum::<i32>();
            let powers = powers.clone();
            (0..=left).map(move |power| powers.iter().copied().chain([power]).collect())
        };
        all = all.iter().flat_map(longer).collect();
    }
    all
}
