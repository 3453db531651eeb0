//! The likeliest laws of one channel by itself.
//!
//! The inner products of the whitened columns of all laws with all their shapes are found once; every set of
//! laws is then judged without the data. The size of the noise is not known before the laws are, so each set is
//! judged by the noise that it leaves:
//!
//! ```text
//! log Z = - n ln(s^2) / 2 - log det L - |z|^2 / 2,   s^2 = |y - C S z|^2 / n,   L L^T = I + S C^T C S / s^2
//! ```
//!
//! with n rows of which c say the same counted as n / c. A few of the best sets are kept while they grow.

use crate::candidates::Candidate;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Sets that are kept while they grow.
const BEAM: usize = 8;
/// Rotations of a matrix before its eigenvalues are given up, over its size: a few do.
const MOST_SWEEPS: usize = 100;
/// Most laws of a set.
const MOST: usize = 8;

/// A law with one shape.
struct Offer {
    candidate: Candidate,
    /// Its first column and their number.
    first: usize,
    count: usize,
    magnitude: bool,
}

/// The whitened columns of all laws on offer.
pub(super) struct Subset {
    right: Vec<f64>,
    columns: Vec<Vec<f64>>,
    sd: Vec<f64>,
    known: usize,
    offers: Vec<Offer>,
}

/// A set of laws as good as it gets.
#[derive(Clone)]
struct Set {
    offers: Vec<usize>,
    evidence: f64,
    /// Mean square that is left.
    left: f64,
}

impl Subset {
    pub(super) fn new(right: Vec<f64>, known: Vec<(Vec<f64>, f64)>) -> Self {
        let count = known.len();
        let (columns, sd) = known.into_iter().unzip();
        Self { right, columns, sd, known: count, offers: vec![] }
    }

    /// A law with one shape.
    pub(super) fn offer(
        &mut self,
        candidate: Candidate,
        columns: Vec<Vec<f64>>,
        sd: &[f64],
        magnitude: bool,
    ) {
        let (first, count) = (self.columns.len(), columns.len());
        self.columns.extend(columns);
        self.sd.extend(sd);
        self.offers.push(Offer { candidate, first, count, magnitude });
    }

    /// The offers of the likeliest set, where each must be worth its prior odds; `colour` tells how slowly a
    /// residual varies.
    pub(super) fn likeliest(self, prior_odds: f64, colour: impl Fn(&[f64]) -> f64) -> Vec<usize> {
        let (n, k) = (self.right.len(), self.columns.len());
        let Some(design) = self.design() else { return vec![] };
        let mut gram = Mat::zeros(k, k);
        matmul(&mut gram, Accum::Replace, design.transpose(), &design, 1.0, Par::Seq);
        let moment: Vec<f64> = (0..k)
            .map(|j| design.col_as_slice(j).iter().zip(&self.right).map(|(a, b)| a * b).sum())
            .collect();
        let square: f64 = self.right.iter().map(|y| y * y).sum();
        let products = Products { known: self.known, gram, moment, square };
        let mut counted = n as f64;
        let mut best = vec![];
        for _ in 0..2 {
            let sets = self.grown(&products, counted);
            let Some(deepest) = sets.last() else { return best };
            let left = self.left(&design, &products, deepest, counted);
            counted = n as f64 / colour(&left);
            let worth = |s: &Set| s.evidence - prior_odds * s.offers.len() as f64;
            let top = sets.into_iter().max_by(|a, b| worth(a).total_cmp(&worth(b)));
            best = top.map(|s| s.offers).unwrap_or_default();
        }
        best
    }

    /// The columns in units of their priors. The known ones, whose priors are then all one, are turned so that they
    /// have nothing to do with each other: whatever the noise, they are eliminated one by one. None where they are
    /// not finite.
    fn design(&self) -> Option<Mat<f64>> {
        let (n, k, p) = (self.right.len(), self.columns.len(), self.known);
        let mut design = Mat::from_fn(n, k, |i, j| self.columns[j][i] * self.sd[j]);
        if p == 0 {
            return Some(design);
        }
        let known = design.as_ref().subcols(0, p).to_owned();
        let mut gram = Mat::zeros(p, p);
        matmul(&mut gram, Accum::Replace, known.transpose(), &known, 1.0, Par::Seq);
        let gram = DMatrix::from_fn(p, p, |i, j| gram[(i, j)]);
        let eigen = SymmetricEigen::try_new(gram, f64::EPSILON, MOST_SWEEPS * p)?;
        let turn = Mat::from_fn(p, p, |i, j| eigen.eigenvectors[(i, j)]);
        matmul(design.as_mut().subcols_mut(0, p), Accum::Replace, &known, &turn, 1.0, Par::Seq);
        Some(design)
    }

    /// The best set of each size, none first.
    fn grown(&self, products: &Products, counted: f64) -> Vec<Set> {
        let start = (products.square / self.right.len() as f64).max(f64::MIN_POSITIVE);
        let Some(none) = self.judged(products, vec![], start, counted) else { return vec![] };
        let mut beam = vec![none.clone()];
        let mut best = vec![none];
        for _ in 0..MOST {
            let mut next: Vec<Set> = vec![];
            for set in &beam {
                for (number, offer) in self.offers.iter().enumerate() {
                    let excluded = |o: &usize| self.offers[*o].candidate.excludes(&offer.candidate);
                    if set.offers.iter().any(excluded) {
                        continue;
                    }
                    let offers = set.offers.iter().copied().chain([number]).collect();
                    let judged = self.judged(products, offers, set.left, counted);
                    let Some(judged) = judged else { continue };
                    let same = next.iter_mut().find(|s| self.same_laws(s, &judged));
                    match same {
                        Some(s) if s.evidence < judged.evidence => *s = judged,
                        Some(_) => {}
                        None => next.push(judged),
                    }
                }
            }
            next.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
            next.truncate(BEAM);
            let Some(top) = next.first() else { break };
            let gained = top.evidence - best[best.len() - 1].evidence;
            best.push(top.clone());
            beam = next;
            if gained <= 0.0 {
                break;
            }
        }
        best
    }

    fn same_laws(&self, a: &Set, b: &Set) -> bool {
        let of = |s: &Set, o: usize| self.offers[s.offers[o]].candidate;
        a.offers.len() == b.offers.len()
            && (0..a.offers.len()).all(|i| (0..b.offers.len()).any(|j| of(a, i) == of(b, j)))
    }

    fn columns_of(&self, offers: &[usize]) -> Vec<usize> {
        let own = |o: &usize| self.offers[*o].first..self.offers[*o].first + self.offers[*o].count;
        (0..self.known).chain(offers.iter().flat_map(own)).collect()
    }

    /// What a set leaves, begun at a guess of it; none where a magnitude would be negative.
    fn judged(
        &self,
        products: &Products,
        offers: Vec<usize>,
        left: f64,
        counted: f64,
    ) -> Option<Set> {
        let at = self.columns_of(&offers);
        let n = self.right.len() as f64;
        let (mut left, mut solved) = (left, None);
        for _ in 0..3 {
            let z = products.solved(&at, left, counted / n)?;
            left = (products.left(&at, &z.0, left * n / counted) / n).max(f64::MIN_POSITIVE);
            solved = Some(z);
        }
        let (z, log) = solved?;
        let mut begin = self.known;
        for o in &offers {
            let offer = &self.offers[*o];
            if offer.magnitude && (begin..begin + offer.count).any(|i| z[i] < 0.0) {
                return None;
            }
            begin += offer.count;
        }
        let sides: usize = offers
            .iter()
            .map(|o| if self.offers[*o].magnitude { self.offers[*o].count } else { 0 })
            .sum();
        let evidence = -0.5 * counted * left.ln() - log - 0.5 * z.norm_squared()
            + sides as f64 * std::f64::consts::LN_2;
        Some(Set { offers, evidence, left })
    }

    /// The residual of a set.
    fn left(&self, design: &Mat<f64>, products: &Products, set: &Set, counted: f64) -> Vec<f64> {
        let at = self.columns_of(&set.offers);
        let mut left = self.right.clone();
        let share = counted / self.right.len() as f64;
        if let Some((z, _)) = products.solved(&at, set.left, share) {
            for (j, z) in at.iter().zip(z.iter()) {
                left.iter_mut().zip(design.col_as_slice(*j)).for_each(|(l, c)| *l -= z * c);
            }
        }
        left
    }
}

/// Inner products of the columns in units of their priors, and of the right-hand side.
struct Products {
    /// The first so many columns have nothing to do with each other.
    known: usize,
    gram: Mat<f64>,
    moment: Vec<f64>,
    square: f64,
}

impl Products {
    /// Coefficients in units of their priors under noise of this variance, `share` of the rows counted; and
    /// half the log determinant. The known columns are eliminated first.
    fn solved(&self, at: &[usize], variance: f64, share: f64) -> Option<(DVector<f64>, f64)> {
        let (weight, p) = (share / variance, self.known);
        let (own, count) = (&at[p..], at.len() - p);
        let known: Vec<f64> = (0..p).map(|i| 1.0 + weight * self.gram[(i, i)]).collect();
        let cross = DMatrix::from_fn(p, count, |i, j| weight * self.gram[(i, own[j])]);
        let mut slope = cross.clone();
        for mut column in slope.column_iter_mut() {
            column.iter_mut().zip(&known).for_each(|(x, d)| *x /= d);
        }
        let moment = DVector::from_fn(p, |i, _| weight * self.moment[i]);
        let mut schur = DMatrix::from_fn(count, count, |i, j| {
            let unit = if i == j { 1.0 } else { 0.0 };
            unit + weight * self.gram[(own[i], own[j])]
        });
        schur.gemm_tr(-1.0, &slope, &cross, 1.0);
        let mut left = DVector::from_fn(count, |i, _| weight * self.moment[own[i]]);
        left.gemv_tr(-1.0, &slope, &moment, 1.0);
        let factor = schur.cholesky()?;
        let of_own = factor.solve(&left);
        let mut z =
            DVector::from_fn(at.len(), |i, _| if i < p { moment[i] / known[i] } else { 0.0 });
        z.rows_mut(0, p).gemv(-1.0, &slope, &of_own, 1.0);
        z.rows_mut(p, count).copy_from(&of_own);
        let log: f64 = factor.l_dirty().diagonal().map(f64::ln).sum();
        Some((z, log + 0.5 * known.iter().map(|d| d.ln()).sum::<f64>()))
    }

    /// Sum of squares that coefficients leave which were found under noise of this variance a row that is counted:
    /// `|y - C z|^2 = y y - z C^T y - variance |z|^2`, as they solve `(I + C^T C / variance) z = C^T y / variance`.
    fn left(&self, at: &[usize], z: &DVector<f64>, variance: f64) -> f64 {
        let explained: f64 = at.iter().zip(z.iter()).map(|(a, z)| z * self.moment[*a]).sum();
        self.square - explained - variance * z.norm_squared()
    }
}
