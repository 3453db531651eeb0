//! A weighted sum of kernel values.

use serde::{Deserialize, Serialize};

use crate::identification::ScaledKernel;
use crate::kernel::{Kernel, KernelSpec};
use crate::simd::{coordinate_by_coordinate, dot};

/// Points in a tile: their kernel values stand on the stack.
const TILE: usize = 128;
/// Most arguments of a scaled kernel: scaled arguments stand on the stack.
pub(super) const MOST_ARGUMENTS: usize = 64;

/// sum_k w_ek K((x - c) / w, p_k) for several entries e of \[f g\].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct SavedExpansion {
    pub kernel: KernelSpec,
    /// Centre and widths of the arguments; empty where the kernel takes them as they are.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub centre: Vec<f64>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub widths: Vec<f64>,
    /// p_k, scaled, points x d.
    pub points: Vec<f64>,
    /// Row i and block of each entry: 0 for f_i, j for g_ij.
    pub entries: Vec<(usize, usize)>,
    /// w_ek, entries x points.
    pub weights: Vec<f64>,
}

/// The same, laid out for vectorised sums.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Expansion {
    pub saved: SavedExpansion,
    tiles: Vec<Tile>,
}

#[derive(Debug, Clone, PartialEq)]
struct Tile {
    points: usize,
    /// p_k, coordinate by coordinate.
    coordinates: Vec<f64>,
    /// w_ek, entry by entry.
    weights: Vec<f64>,
}

impl Expansion {
    pub fn new(saved: SavedExpansion, arguments: usize) -> Self {
        let points = saved.points.len() / arguments;
        let tile = |first: usize| {
            let last = points.min(first + TILE);
            let mut coordinates = Vec::new();
            let rows = &saved.points[first * arguments..last * arguments];
            coordinate_by_coordinate(rows, arguments, &mut coordinates);
            let of_entry = |e: usize| &saved.weights[e * points + first..e * points + last];
            let weights = (0..saved.entries.len()).flat_map(of_entry).copied().collect();
            Tile { points: last - first, coordinates, weights }
        };
        let tiles = (0..points).step_by(TILE).map(tile).collect();
        Self { saved, tiles }
    }

    /// f = sum_k beta_k K(x, x_k), g = sum_k beta_k K(x, x_k) u_k^T over samples x_k (rows of d) and u_k (rows of m) with
    /// beta_k (rows of n); samples without weight are left out.
    pub fn of_samples(
        kernel: KernelSpec,
        [n, m, d]: [usize; 3],
        [arguments, inputs]: [&[f64]; 2],
        beta: &[f64],
    ) -> Self {
        let used: Vec<usize> = (0..beta.len() / n)
            .filter(|k| beta[k * n..(k + 1) * n].iter().any(|&entry| entry != 0.0))
            .collect();
        let points = used.iter().flat_map(|&k| &arguments[k * d..(k + 1) * d]).copied().collect();
        let entries: Vec<(usize, usize)> =
            (0..n).flat_map(|i| (0..=m).map(move |block| (i, block))).collect();
        let weight = |(i, block): (usize, usize), k: usize| match block {
            0 => beta[k * n + i],
            j => beta[k * n + i] * inputs[k * m + j - 1],
        };
        let weights =
            entries.iter().flat_map(|&e| used.iter().map(move |&k| weight(e, k))).collect();
        let (centre, widths) = (Vec::new(), Vec::new());
        Self::new(SavedExpansion { kernel, centre, widths, points, entries, weights }, d)
    }

    /// One function over the landmarks of a scaled kernel.
    pub fn of_landmarks(
        kernel: &ScaledKernel,
        landmarks: &[f64],
        weights: Vec<f64>,
        entry: (usize, usize),
    ) -> Self {
        let d = kernel.widths.len();
        let mut points = vec![0.0; landmarks.len()];
        for (x, scaled) in landmarks.chunks_exact(d).zip(points.chunks_exact_mut(d)) {
            kernel.scale(x, scaled);
        }
        let saved = SavedExpansion {
            kernel: kernel.family.kernel(),
            centre: kernel.centre.clone(),
            widths: kernel.widths.clone(),
            points,
            entries: vec![entry],
            weights,
        };
        Self::new(saved, d)
    }

    /// Number of points p.
    pub fn points(&self) -> usize {
        self.tiles.iter().map(|tile| tile.points).sum()
    }

    /// Adds the sums at x to f (n) and g (n x m).
    pub fn add(&self, x: &[f64], f: &mut [f64], g: &mut [f64]) {
        let mut room = [0.0; MOST_ARGUMENTS];
        let x = self.scaled(x, &mut room);
        let inputs = g.len() / f.len();
        let mut values = [0.0; TILE];
        for tile in &self.tiles {
            let values = &mut values[..tile.points];
            self.saved.kernel.evaluate_row(x, &tile.coordinates, values);
            let weights = tile.weights.chunks_exact(tile.points);
            for (&(row, block), weights) in self.saved.entries.iter().zip(weights) {
                let sum = match block {
                    0 => &mut f[row],
                    j => &mut g[row * inputs + j - 1],
                };
                *sum += dot(values, weights);
            }
        }
    }

    fn scaled<'x>(&self, x: &'x [f64], room: &'x mut [f64; MOST_ARGUMENTS]) -> &'x [f64] {
        if self.saved.widths.is_empty() {
            return x;
        }
        let room = &mut room[..x.len()];
        let entries = x.iter().zip(&self.saved.centre).zip(&self.saved.widths).zip(room.iter_mut());
        entries.for_each(|(((x, c), w), scaled)| *scaled = (x - c) / w);
        room
    }
}
