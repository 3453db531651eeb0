//! Which monomials there are, by evidence.
//!
//! The prior of all coefficients c ~ N(0, D^2), on the subspace where all monomials but those of a set S are zero, is the
//! prior of what is left. With D^-1 c = T b, y = Phi c + e and B = I + D Phi^T Phi D as in [`super::evidence`]
//!
//! ```text
//! log p(y | S) = ln det(T_S^T T_S) / 2 - ln det(T_S^T B T_S) / 2 + r_S^T (T_S^T B T_S)^-1 r_S / 2 + what all S share
//! r = T^T D Phi^T y,   p(S) = 1 / ((M + 1) binom(M, |S|))
//! ```
//!
//! the latter for any number of the M monomials being as likely as another. From all of them, that one is taken away or put
//! back which gains the most, until none gains. What each would gain stands in the pivots of the sweep operator
//! (J. Goodnight, The American Statistician 33:149-158, 1979), so that an exchange costs M^2.
//!
//! With a gain of Delta_k < 0 nats it is with w_k = 1 / (1 + exp(-Delta_k)) the other way, and then the coefficients are
//! elsewhere by v_k delta_k, with another variance along v_k. The standard deviations hold both, about what was chosen:
//!
//! ```text
//! cov = cov_S + sum_k w_k (+- s_k^-1 + delta_k^2) v_k v_k^T
//! ```
//!
//! and w_k = 1 where the data would hardly tell of the monomial if it were there.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

use super::evidence::{Normal, Posterior};
use super::report::UNKNOWN;
use crate::linear::{Factor, NonPositivePivot};

/// Nats that an exchange must gain: above what rounding makes of none.
const GAIN: f64 = 1e-6;

/// A subspace of the coefficients over the prior's standard deviations.
#[derive(Debug, Clone)]
pub(super) struct Subspace {
    /// Orthonormal columns, each of coefficients of one term.
    columns: Mat<f64>,
    /// Which of the monomials there are.
    pub present: Vec<bool>,
    /// ln p(S) less that of all monomials.
    pub log_odds: f64,
}

impl Subspace {
    /// Number of its dimensions.
    pub fn dimension(&self) -> usize {
        self.columns.ncols()
    }

    /// The posterior of the coefficients on the subspace, and their covariance over the prior's standard deviations.
    ///
    /// # Errors
    /// As of [`Normal::posterior`].
    pub fn posterior(
        &self,
        normal: &Normal,
        prior: &[f64],
    ) -> Result<(Posterior, Mat<f64>), NonPositivePivot> {
        let (size, count) = (prior.len(), self.columns.ncols());
        let wide = Mat::from_fn(size, count, |i, k| prior[i] * self.columns[(i, k)]);
        let within = Normal {
            gram: product(
                wide.transpose(),
                product(whole(normal).as_ref(), wide.as_ref()).as_ref(),
            ),
            moment: transposed_times(&wide, &normal.moment),
            square: normal.square,
            equations: normal.equations,
        };
        let mut found = within.posterior(&vec![1.0; count], 1.0)?;
        let coefficient =
            |i: usize| found.coefficients.iter().enumerate().map(|(k, c)| wide[(i, k)] * c).sum();
        found.coefficients = (0..size).map(coefficient).collect();
        let inverse = found.factor.inverse();
        let covariance = product(
            product(self.columns.as_ref(), inverse.as_ref()).as_ref(),
            self.columns.transpose(),
        );
        Ok((found, covariance))
    }
}

/// What a term's coefficients are chosen from.
pub(super) struct Choices {
    /// Number of coefficients.
    pub size: usize,
    /// T; none where all of them stay.
    pub monomials: Option<Mat<f64>>,
}

/// The choice of monomials as it stands, by matrices that are swept on those that are present.
pub(super) struct Selection {
    /// Unit columns of the coefficients that stay, then T; by term orthogonal.
    spread: Mat<f64>,
    /// Number of the former.
    stay: usize,
    /// How all coefficients move with each monomial's, those that stay following as the equations have them.
    moves: Mat<f64>,
    /// T^T B T | r, of what those that stay leave.
    after: Mat<f64>,
    /// T^T T.
    before: Mat<f64>,
    present: Vec<bool>,
}

impl Selection {
    /// All monomials, in equations with errors of variance 1 and with prior standard deviations D.
    ///
    /// # Errors
    /// Equations whose numbers are not finite.
    pub fn of(normal: &Normal, prior: &[f64], terms: &[Choices]) -> Result<Self, NonPositivePivot> {
        let (spread, stay) = spread(terms);
        let (size, count) = (prior.len(), spread.ncols() - stay);
        let wide = Mat::from_fn(size, spread.ncols(), |i, k| prior[i] * spread[(i, k)]);
        let before = product(spread.transpose(), spread.as_ref());
        let gram =
            product(wide.transpose(), product(whole(normal).as_ref(), wide.as_ref()).as_ref());
        let precision = |i: usize, j: usize| before[(i, j)] + gram[(i, j)];
        let right = transposed_times(&wide, &normal.moment);
        let with_right =
            |i: usize, j: usize| if j == count { right[i] } else { precision(i, stay + j) };
        let mut beside = Mat::from_fn(stay, count + 1, with_right);
        let factor = Factor::of(Mat::from_fn(stay, stay, precision))?;
        factor.solve_lower(&mut beside);
        let explained = product(beside.transpose(), beside.as_ref());
        let after =
            Mat::from_fn(count, count + 1, |i, j| with_right(stay + i, j) - explained[(i, j)]);
        factor.solve_lower_transposed(&mut beside);
        let followed = product(spread.subcols(0, stay), beside.subcols(0, count));
        let mut found = Self {
            moves: spread.subcols(stay, count) - followed,
            before: before.submatrix(stay, stay, count, count).to_owned(),
            after,
            spread,
            stay,
            present: vec![false; count],
        };
        (0..count).for_each(|k| found.exchange(k));
        Ok(found)
    }

    /// The same with those monomials alone.
    pub fn with(mut self, present: &[bool]) -> Self {
        let other = (0..present.len()).filter(|&k| self.present[k] != present[k]);
        other.collect::<Vec<_>>().into_iter().for_each(|k| self.exchange(k));
        self
    }

    /// Takes away and puts back what gains the most, until nothing gains.
    pub fn improve(&mut self) {
        let all = self.present.len();
        for _ in 0..4 * all {
            let gains = (0..all).map(|k| (k, self.gain(k))).filter(|(_, gain)| gain.is_finite());
            match gains.max_by(|a, b| a.1.total_cmp(&b.1)) {
                Some((k, gain)) if gain > GAIN => self.exchange(k),
                _ => break,
            }
        }
    }

    /// Where the coefficients are then.
    ///
    /// # Errors
    /// Monomials that are not told apart.
    pub fn subspace(&self) -> Result<Subspace, NonPositivePivot> {
        let all = self.present.len();
        let kept: Vec<usize> = (0..self.stay)
            .chain((0..all).filter(|&k| self.present[k]).map(|k| self.stay + k))
            .collect();
        let size = self.spread.nrows();
        let mut rows = Mat::from_fn(kept.len(), size, |k, i| self.spread[(i, kept[k])]);
        Factor::of(product(rows.as_ref(), rows.transpose()))?.solve_lower(&mut rows);
        Ok(Subspace {
            columns: rows.transpose().to_owned(),
            present: self.present.clone(),
            log_odds: log_prior(all, self.count()) - log_prior(all, all),
        })
    }

    /// What the covariance of all coefficients, over the prior's standard deviations, has more than that on the subspace, as
    /// each monomial may be there after all, or not.
    pub fn doubt(&self) -> Mat<f64> {
        let (size, all) = (self.moves.nrows(), self.present.len());
        let moves = self.moves.transpose().to_owned();
        let mut doubt = Mat::zeros(size, size);
        for k in (0..all).filter(|&k| self.gain(k).is_finite()) {
            let weight = if self.is_told(k) { 1.0 / (1.0 + (-self.gain(k)).exp()) } else { 1.0 };
            let (pivot, right) = (self.after[(k, k)], self.after[(k, all)]);
            let along = |i: usize| match (i == k, self.present[k], self.present[i]) {
                (true, false, _) => 1.0,
                (false, false, true) | (_, true, true) => -self.after[(i, k)],
                _ => 0.0,
            };
            let along: Vec<f64> = (0..all).map(along).collect();
            let along = transposed_times(&moves, &along);
            let factor = weight * (1.0 / pivot + (right / pivot).powi(2));
            for j in 0..size {
                for i in 0..size {
                    doubt[(i, j)] += factor * along[i] * along[j];
                }
            }
        }
        doubt
    }

    /// Whether there is a monomial, or whether the data would leave less than its share of the prior's standard deviation to one
    /// that is away: where they do not, the number of monomials alone speaks against it, and it is as unknown as before.
    fn is_told(&self, k: usize) -> bool {
        self.present[k] || self.before[(k, k)] / self.after[(k, k)] < UNKNOWN * UNKNOWN
    }

    fn count(&self) -> usize {
        self.present.iter().filter(|present| **present).count()
    }

    /// ln p(S | y) after an exchange of monomial k less that before: of one that is present the ratio of posterior and prior
    /// density of b_k = 0 (J. Dickey, 1971), and the odds.
    fn gain(&self, k: usize) -> f64 {
        let (all, count) = (self.present.len() as f64, self.count() as f64);
        let odds = match self.present[k] {
            true => (all - count + 1.0) / count,
            false => (count + 1.0) / (all - count),
        };
        let (after, before) = (self.after[(k, k)], self.before[(k, k)]);
        // Of those present the pivots are minus their variances, of others what is left of their precisions.
        let right = self.after[(k, self.present.len())];
        0.5 * ((before / after).ln() + right * right / after) + odds.ln()
    }

    fn exchange(&mut self, k: usize) {
        sweep(&mut self.after, k, self.present[k]);
        sweep(&mut self.before, k, self.present[k]);
        self.present[k] = !self.present[k];
    }
}

/// Unit columns of the coefficients of terms of which all stay, their number, and T.
fn spread(terms: &[Choices]) -> (Mat<f64>, usize) {
    let size: usize = terms.iter().map(|term| term.size).sum();
    let stay = terms.iter().filter(|t| t.monomials.is_none()).map(|t| t.size).sum();
    let count = |t: &Choices| t.monomials.as_ref().map_or(0, Mat::ncols);
    let mut spread = Mat::zeros(size, stay + terms.iter().map(count).sum::<usize>());
    let (mut row, mut unit, mut column) = (0, 0, stay);
    for term in terms {
        match &term.monomials {
            None => {
                (0..term.size).for_each(|i| spread[(row + i, unit + i)] = 1.0);
                unit += term.size;
            }
            Some(own) => {
                spread.submatrix_mut(row, column, term.size, own.ncols()).copy_from(own);
                column += own.ncols();
            }
        }
        row += term.size;
    }
    (spread, stay)
}

/// ln p(S) of so many of all monomials.
fn log_prior(all: usize, count: usize) -> f64 {
    let ways: f64 = (0..count).map(|k| ((all - k) as f64 / (k + 1) as f64).ln()).sum();
    -ways - (all as f64 + 1.0).ln()
}

/// Sweeps a matrix on pivot k, or back.
fn sweep(matrix: &mut Mat<f64>, k: usize, back: bool) {
    let pivot = matrix[(k, k)];
    let row: Vec<f64> = (0..matrix.ncols()).map(|j| matrix[(k, j)]).collect();
    let sign = if back { -1.0 } else { 1.0 };
    for j in 0..matrix.ncols() {
        if j == k {
            continue;
        }
        let factor = row[j] / pivot;
        for i in 0..matrix.nrows() {
            if i != k {
                matrix[(i, j)] -= row[i] * factor;
            }
        }
        matrix[(k, j)] = sign * factor;
        if j < matrix.nrows() {
            matrix[(j, k)] = sign * factor;
        }
    }
    matrix[(k, k)] = -1.0 / pivot;
}

fn product(left: MatRef<'_, f64>, right: MatRef<'_, f64>) -> Mat<f64> {
    let mut found = Mat::zeros(left.nrows(), right.ncols());
    matmul(&mut found, Accum::Replace, left, right, 1.0, Par::Seq);
    found
}

fn transposed_times(matrix: &Mat<f64>, vector: &[f64]) -> Vec<f64> {
    let column = MatRef::from_column_major_slice(vector, vector.len(), 1);
    product(matrix.transpose(), column).col_as_slice(0).to_vec()
}

/// Phi^T Phi, both triangles.
fn whole(normal: &Normal) -> Mat<f64> {
    let size = normal.moment.len();
    Mat::from_fn(size, size, |i, j| normal.gram[(i.max(j), i.min(j))])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 40 equations in six coefficients: the first two stay, the others are those of four monomials, of which the first acts, no two of
    /// them orthogonal.
    fn equations() -> (Normal, Vec<f64>, Vec<Choices>) {
        let design = Mat::from_fn(40, 6, |i, j| 10.0 * ((i * (j + 2)) as f64 * 0.37).sin());
        let noise = |i: usize| ((i * i) as f64 * 1.7).sin();
        let truth = [0.5, 0.0, 0.8, -0.6, 0.0, 0.0];
        let right: Vec<f64> = (0..40)
            .map(|i| (0..6).map(|j| design[(i, j)] * truth[j]).sum::<f64>() + noise(i))
            .collect();
        let mut normal = Normal::new(6);
        normal.add(design.as_ref(), &right);
        let monomials = Mat::from_fn(4, 4, |i, j| match (i, j) {
            (i, j) if i == j => 0.8,
            (i, j) if i == (j + 1) % 4 => -0.6,
            _ => 0.0,
        });
        let stay = Choices { size: 2, monomials: None };
        (normal, vec![2.0; 6], vec![stay, Choices { size: 4, monomials: Some(monomials) }])
    }

    fn log_posterior(subspace: &Subspace, normal: &Normal, prior: &[f64]) -> f64 {
        subspace.posterior(normal, prior).unwrap().0.log_evidence + subspace.log_odds
    }

    #[test]
    fn gains_are_differences_of_the_evidence() {
        let (normal, prior, terms) = equations();
        let mut present = vec![true, false, true, true];
        let at = |p: &[bool]| Selection::of(&normal, &prior, &terms).unwrap().with(p);
        let log_posterior = |p: &[bool]| log_posterior(&at(p).subspace().unwrap(), &normal, &prior);
        let (selection, before) = (at(&present), log_posterior(&present));
        for k in 0..4 {
            present[k] = !present[k];
            let gain = log_posterior(&present) - before;
            assert!((selection.gain(k) - gain).abs() < 1e-9 * gain.abs().max(1.0), "{k}");
            present[k] = !present[k];
        }
    }

    #[test]
    fn what_is_chosen_is_more_probable_than_any_other_set() {
        let (normal, prior, terms) = equations();
        let mut selection = Selection::of(&normal, &prior, &terms).unwrap();
        selection.improve();
        let chosen = selection.subspace().unwrap();
        assert_eq!(chosen.present, [true, false, false, false]);
        let best = log_posterior(&chosen, &normal, &prior);
        for set in 0..16u32 {
            let present: Vec<bool> = (0..4).map(|k| set >> k & 1 == 1).collect();
            let other = Selection::of(&normal, &prior, &terms).unwrap().with(&present);
            let other = log_posterior(&other.subspace().unwrap(), &normal, &prior);
            assert!(other <= best + 1e-9, "{present:?} {other} {best}");
        }
    }

    /// Of the last monomial the equations say nothing: where it is away, it is as unknown as before.
    #[test]
    fn what_the_data_do_not_tell_stays_unknown() {
        let design = Mat::from_fn(40, 3, |i, j| match j {
            2 => 0.0,
            j => 10.0 * ((i * (j + 2)) as f64 * 0.37).sin(),
        });
        let right: Vec<f64> =
            (0..40).map(|i| 0.5 * design[(i, 0)] + (1.7 * i as f64).sin()).collect();
        let mut normal = Normal::new(3);
        normal.add(design.as_ref(), &right);
        let terms = [Choices { size: 3, monomials: Some(Mat::identity(3, 3)) }];
        let selection = Selection::of(&normal, &[2.0; 3], &terms).unwrap();
        let selection = selection.with(&[true, false, false]);
        let subspace = selection.subspace().unwrap();
        let covariance = subspace.posterior(&normal, &[2.0; 3]).unwrap().1 + selection.doubt();
        assert!((covariance[(2, 2)] - 1.0).abs() < 1e-9, "{covariance:?}");
        assert!(covariance[(0, 0)] < 1e-2 && covariance[(1, 1)] < 1e-2, "{covariance:?}");
    }

    #[test]
    fn doubt_is_where_the_coefficients_are_with_one_monomial_more_or_less() {
        let (normal, prior, terms) = equations();
        let present = [true, false, false, true];
        let at = |p: &[bool]| Selection::of(&normal, &prior, &terms).unwrap().with(p);
        let known = |p: &[bool]| at(p).subspace().unwrap().posterior(&normal, &prior).unwrap();
        let (chosen, covariance) = known(&present);
        let mut expected: Mat<f64> = Mat::zeros(6, 6);
        for k in 0..4 {
            let mut other = present;
            other[k] = !other[k];
            let weight = 1.0 / (1.0 + (-at(&present).gain(k)).exp());
            let (found, own) = known(&other);
            let off = |i: usize| (found.coefficients[i] - chosen.coefficients[i]) / prior[i];
            for j in 0..6 {
                for i in 0..6 {
                    let more = own[(i, j)] - covariance[(i, j)] + off(i) * off(j);
                    expected[(i, j)] += weight * more;
                }
            }
        }
        let doubt = at(&present).doubt();
        let size = expected.norm_max();
        assert!((doubt - expected).norm_max() < 1e-9 * size);
    }
}
