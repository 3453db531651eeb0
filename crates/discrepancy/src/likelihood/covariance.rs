//! The covariance P of what a filter does not know of the state, in units of the outputs' noise.
//!
//! ```text
//! measured:  s = c P c^T + r,  g = P c^T / sqrt(s),  P <- P - g g^T
//! a step:    P <- A P A^T + sum_j q_j b_j b_j^T
//! ```
//!
//! Outputs of one sample are taken one after the other, so that nothing is inverted.

/// A covariance under way.
#[derive(Clone, Debug)]
pub(super) struct Covariance {
    width: usize,
    /// Row-major, symmetric.
    p: Vec<f64>,
    room: Vec<f64>,
}

impl Covariance {
    /// Of a state that is known.
    pub(super) fn known(width: usize) -> Self {
        Self { width, p: vec![0.0; width * width], room: vec![0.0; width * width] }
    }

    /// Of a state whose entries have these variances, and nothing in common.
    pub(super) fn of(variances: &[f64]) -> Self {
        let mut this = Self::known(variances.len());
        for (i, v) in variances.iter().enumerate() {
            this.p[i * this.width + i] = *v;
        }
        this
    }

    /// Variances of the state's entries.
    pub(super) fn variances(&self) -> Vec<f64> {
        self.p.iter().step_by(self.width + 1).copied().collect()
    }

    /// `c P c^T`, with `P c^T` in `projected`.
    pub(super) fn seen_by(&self, c: &[f64], projected: &mut [f64]) -> f64 {
        for (row, p) in self.p.chunks_exact(self.width).zip(projected.iter_mut()) {
            *p = row.iter().zip(c).map(|(a, b)| a * b).sum();
        }
        projected.iter().zip(c).map(|(a, b)| a * b).sum()
    }

    /// Take up what an output says whose row is `c` and whose noise has variance `r`: the variance s
    /// of its innovation, and the gain g by which one standard deviation of it moves the state.
    pub(super) fn measure(&mut self, c: &[f64], r: f64, gain: &mut [f64]) -> f64 {
        let s = self.seen_by(c, gain) + r;
        let scale = s.sqrt().recip();
        gain.iter_mut().for_each(|g| *g *= scale);
        for (row, a) in self.p.chunks_exact_mut(self.width).zip(&*gain) {
            row.iter_mut().zip(&*gain).for_each(|(p, b)| *p -= a * b);
        }
        s
    }

    /// What a gain that was made for another covariance leaves: `M P M^T + r g g^T / s` with
    /// `M = 1 - g c / sqrt(s)`.
    pub(super) fn corrected(&mut self, c: &[f64], r: f64, gain: &[f64], s: f64) {
        let n = self.width;
        let scale = s.sqrt().recip();
        let mut projected = vec![0.0; n];
        let seen = self.seen_by(c, &mut projected);
        for i in 0..n {
            for j in 0..n {
                let (a, b) = (gain[i] * scale, gain[j] * scale);
                self.p[i * n + j] += a * b * (seen + r) - a * projected[j] - b * projected[i];
            }
        }
    }

    /// A step of the map whose rows, of `stride` entries, begin with those of A; what drives it
    /// stands in the columns `driven` of the map, each with its variance.
    pub(super) fn step(&mut self, map: &[f64], stride: usize, driven: &[(usize, f64)]) {
        let n = self.width;
        for i in 0..n {
            let row = &map[i * stride..i * stride + n];
            for j in 0..n {
                self.room[i * n + j] = (0..n).map(|l| row[l] * self.p[l * n + j]).sum();
            }
        }
        for i in 0..n {
            for j in 0..=i {
                let row = &map[j * stride..j * stride + n];
                let own: f64 = (0..n).map(|l| self.room[i * n + l] * row[l]).sum();
                let noise =
                    driven.iter().map(|(at, q)| q * map[i * stride + at] * map[j * stride + at]);
                let sum = own + noise.sum::<f64>();
                self.p[i * n + j] = sum;
                self.p[j * n + i] = sum;
            }
        }
    }
}
