//! A weighted sum of occupation kernels.

use serde::{Deserialize, Serialize};

use super::Expansion;
use crate::functional::Functional;
use crate::kernel::{Kernel, KernelSpec};
use crate::occupation_kernels::OccupationKernels;
use crate::simd::{LANES, MOST_ARGUMENTS, MOST_ENTRIES, MOST_ROWS, OccupationSums};

/// \[f g\](x) = sum_a W_a Gamma_a(x)^T as the file holds it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct SavedOccupation {
    pub kernel: KernelSpec,
    /// Number of samples of each functional; they stand one after the other.
    pub lengths: Vec<usize>,
    /// c_a(k) of each sample.
    pub functionals: Vec<f64>,
    /// x_k, samples x d.
    pub points: Vec<f64>,
    /// u_k, samples x m.
    pub inputs: Vec<f64>,
    /// W, functionals x n.
    pub weights: Vec<f64>,
}

/// The same, laid out for vectorised sums.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OccupationExpansion {
    pub saved: SavedOccupation,
    sums: OccupationSums,
    /// W of eight functionals after eight, coordinate by coordinate.
    weights: Vec<[f64; LANES]>,
}

impl OccupationExpansion {
    /// Of d arguments, m inputs and n coordinates; none for a kernel without vectorised sums or too many entries.
    pub fn new(saved: SavedOccupation, [d, m, n]: [usize; 3]) -> Option<Self> {
        let small = n.saturating_mul(m.saturating_add(1)) <= MOST_ENTRIES
            && n <= MOST_ROWS
            && d <= MOST_ARGUMENTS;
        let form = saved.kernel.form(d).filter(|_| small)?;
        let mut occupation = OccupationKernels::new(d, m);
        let mut first = 0;
        for &length in &saved.lengths {
            let range = first..first + length;
            let weights = saved.functionals.get(range.clone())?.to_vec();
            let arguments = saved.points.get(range.start * d..range.end * d)?;
            let inputs = saved.inputs.get(range.start * m..range.end * m)?;
            occupation.append(arguments, inputs, vec![Functional { first: 0, weights }]);
            first = range.end;
        }
        let sums = occupation.sums(form);
        let mut weights = vec![[0.0; LANES]; sums.blocks() * n];
        for (a, own) in saved.weights.chunks_exact(n).enumerate() {
            let entries = weights.get_mut(a / LANES * n..)?.iter_mut().zip(own);
            entries.for_each(|(lanes, weight)| lanes[a % LANES] = *weight);
        }
        Some(Self { saved, sums, weights })
    }

    /// Number of samples.
    pub fn points(&self) -> usize {
        self.saved.functionals.len()
    }

    /// The same as a sum over samples, for n coordinates.
    pub fn folded(&self, n: usize) -> Expansion {
        let saved = &self.saved;
        let shape = [n, self.sums.columns() - 1, saved.points.len() / self.points().max(1)];
        let of_functional = |(w, length): (&[f64], &usize)| w.repeat(*length);
        let beta = saved.weights.chunks_exact(n).zip(&saved.lengths).flat_map(of_functional);
        let weights = saved.functionals.iter().flat_map(|c| std::iter::repeat_n(c, n));
        let beta: Vec<f64> = beta.zip(weights).map(|(w, c)| w * c).collect();
        Expansion::of_samples(saved.kernel.clone(), shape, [&saved.points, &saved.inputs], &beta)
    }

    /// Adds the sums at x to f (n) and g (n x m).
    pub fn add(&self, x: &[f64], f: &mut [f64], g: &mut [f64]) {
        let (n, columns) = (f.len(), self.sums.columns());
        let mut entries = [0.0; MOST_ENTRIES];
        let entries = &mut entries[..n * columns];
        self.sums.contract(x, &self.weights, entries);
        for (i, row) in entries.chunks_exact(columns).enumerate() {
            f[i] += row[0];
            let own = &mut g[i * (columns - 1)..(i + 1) * (columns - 1)];
            own.iter_mut().zip(&row[1..]).for_each(|(sum, entry)| *sum += entry);
        }
    }
}
