//! The box on which a model is compiled, and points of it.

use std::f64::consts::PI;

use super::CompileError;
use crate::IdentifiedModel;

/// A box of arguments, l_i <= x_i <= u_i.
#[derive(Debug, Clone, PartialEq)]
pub struct Domain {
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
}

/// Which points of the Halton sequence serve for what: no two overlap.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Purpose {
    /// Lines along which degrees are told.
    Lines,
    /// Least squares.
    Fit,
    /// Choice of the terms.
    Choice,
    /// The error that is reported.
    Proof,
}

impl Purpose {
    fn first(self) -> usize {
        match self {
            Self::Lines => 1,
            Self::Fit => 101,
            Self::Choice => 1_000_003,
            Self::Proof => 2_000_003,
        }
    }
}

/// Bases of the Halton sequence.
const PRIMES: [u8; 54] = [
    2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71, 73, 79, 83, 89, 97,
    101, 103, 107, 109, 113, 127, 131, 137, 139, 149, 151, 157, 163, 167, 173, 179, 181, 191, 193,
    197, 199, 211, 223, 227, 229, 233, 239, 241, 251,
];

impl Domain {
    /// The box between `lower` and `upper`.
    ///
    /// # Errors
    /// Another number of sides on both ends, and a side without inside.
    pub fn new(lower: Vec<f64>, upper: Vec<f64>) -> Result<Self, CompileError> {
        if lower.len() != upper.len() {
            let (expected, found) = (lower.len(), upper.len());
            return Err(CompileError::Sides { expected, found });
        }
        for (argument, (&lower, &upper)) in lower.iter().zip(&upper).enumerate() {
            if !((upper - lower).is_finite() && lower < upper) {
                return Err(CompileError::Empty { argument, lower, upper });
            }
        }
        Ok(Self { lower, upper })
    }

    /// Lower and upper ends of the model's points, samples or landmarks, in each argument: the range of the data, as far
    /// as the model keeps them.
    pub fn range_of_points(model: &IdentifiedModel) -> [Vec<f64>; 2] {
        let d = model.arguments();
        let (mut lower, mut upper) = (vec![f64::INFINITY; d], vec![f64::NEG_INFINITY; d]);
        for saved in model.expansions().iter().map(|e| &e.saved) {
            for point in saved.points.chunks_exact(d) {
                for (i, p) in point.iter().enumerate() {
                    let scaled = saved.widths.get(i).zip(saved.centre.get(i));
                    let x = scaled.map_or(*p, |(width, centre)| centre + width * p);
                    lower[i] = lower[i].min(x);
                    upper[i] = upper[i].max(x);
                }
            }
        }
        [lower, upper]
    }

    /// Lower ends l.
    pub fn lower(&self) -> &[f64] {
        &self.lower
    }

    /// Upper ends u.
    pub fn upper(&self) -> &[f64] {
        &self.upper
    }

    /// Number d of arguments.
    pub(crate) fn arguments(&self) -> usize {
        self.lower.len()
    }

    /// From z in \[-1, 1\]^d.
    pub(crate) fn point(&self, z: &[f64]) -> Vec<f64> {
        let sides = self.lower.iter().zip(&self.upper).zip(z);
        // The nearest to the ends in rounding must not fall outside.
        sides.map(|((l, u), z)| (l + 0.5 * (1.0 + z) * (u - l)).clamp(*l, *u)).collect()
    }

    /// Points z of \[-1, 1\]^d: spread evenly.
    pub(crate) fn interior(&self, purpose: Purpose, count: usize) -> Vec<Vec<f64>> {
        (0..count).map(|k| self.halton(purpose, k).map(|u| 2.0 * u - 1.0).collect()).collect()
    }

    /// Points z of \[-1, 1\]^d that are dense near its sides, as the zeros of Chebyshev polynomials are: in their measure
    /// the polynomials are orthogonal.
    pub(crate) fn arcsine(&self, count: usize) -> Vec<Vec<f64>> {
        let points = (0..count).map(|k| self.halton(Purpose::Fit, k));
        points.map(|point| point.map(|u| (PI * u).cos()).collect()).collect()
    }

    /// Points z of the boundary of \[-1, 1\]^d: corners, edges and faces in turn.
    pub(crate) fn boundary(&self, purpose: Purpose, most: usize) -> Vec<Vec<f64>> {
        let d = self.arguments();
        let patterns = 3_usize.checked_pow(d as u32).unwrap_or(usize::MAX);
        // A stride without a common factor, so that all patterns have their turn and neighbours differ.
        let pattern = |k: usize| k.wrapping_mul(2_654_435_761) % patterns;
        (0..most.min(patterns.saturating_mul(32)))
            .map(|k| {
                let mut digits = pattern(k);
                let halton = self.halton(purpose, k + most);
                halton
                    .map(|u| {
                        let digit = digits % 3;
                        digits /= 3;
                        [-1.0, 1.0, 2.0 * u - 1.0][digit]
                    })
                    .collect()
            })
            .collect()
    }

    fn halton(&self, purpose: Purpose, k: usize) -> impl Iterator<Item = f64> {
        let bases = PRIMES.iter().copied().cycle().enumerate().take(self.arguments());
        // Beyond the table bases come again, far from where they were.
        bases.map(move |(i, base)| {
            halton::number(base, purpose.first() + k + 10_000_019 * (i / PRIMES.len()))
        })
    }
}
