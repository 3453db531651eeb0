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
use nalgebra::{DMatrix, DVector};

/// Sets that are kept while they grow.
const BEAM: usize = 8;
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
        let design = Mat::from_fn(n, k, |i, j| self.columns[j][i] * self.sd[j]);
        let mut gram = Mat::zeros(k, k);
        matmul(&mut gram, Accum::Replace, design.transpose(), &design, 1.0, Par::Seq);
        let moment: Vec<f64> = (0..k)
            .map(|j| design.col_as_slice(j).iter().zip(&self.right).map(|(a, b)| a * b).sum())
            .collect();
        let square: f64 = self.right.iter().map(|y| y * y).sum();
        let products = Products { gram, moment, square };
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
            left = (products.left(&at, &z.0) / n).max(f64::MIN_POSITIVE);
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
    gram: Mat<f64>,
    moment: Vec<f64>,
    square: f64,
}

impl Products {
    /// Coefficients in units of their priors under noise of this variance, `share` of the rows counted; and
    /// half the log determinant.
    fn solved(&self, at: &[usize], variance: f64, share: f64) -> Option<(DVector<f64>, f64)> {
        let weight = share / variance;
        let unit = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        let h = DMatrix::from_fn(at.len(), at.len(), |i, j| {
            unit(i, j) + weight * self.gram[(at[i], at[j])]
        });
        let g = DVector::from_fn(at.len(), |i, _| weight * self.moment[at[i]]);
        let factor = h.cholesky()?;
        let log: f64 = factor.l_dirty().diagonal().map(f64::ln).sum();
        Some((factor.solve(&g), log))
    }

    /// Sum of squares that coefficients leave.
    fn left(&self, at: &[usize], z: &DVector<f64>) -> f64 {
        let mut sum = self.square;
        for (i, a) in at.iter().enumerate() {
            sum -= 2.0 * z[i] * self.moment[*a];
            for (j, b) in at.iter().enumerate() {
                sum += z[i] * z[j] * self.gram[(*a, *b)];
            }
        }
        sum
    }
}
