//! Inputs as functions of time, and how sampled ones are held between samples.

/// How a sampled input behaves between its samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Hold {
    /// The last sample is kept until the next one.
    #[default]
    ZeroOrder,
    /// Straight lines between samples.
    Linear,
}

impl Hold {
    /// The sample whose input is there at the end of the step from sample `k` to the next.
    #[must_use]
    pub fn end_of_step(self, k: usize) -> usize {
        match self {
            Self::ZeroOrder => k,
            Self::Linear => k + 1,
        }
    }
}

/// An input signal `u(t)`.
pub trait Input: Sync {
    /// Value at time `t` within the integration step that began at `start <= t`, into `u`.
    ///
    /// A held input jumps at its samples; a step that ends on a sample must still see
    /// the value from before the jump, which is why the step's beginning is given.
    fn value(&self, start: f64, t: f64, u: &mut [f64]);

    /// Times at which the signal may jump, in increasing order. Integration steps do not
    /// reach across them.
    fn breakpoints(&self) -> &[f64] {
        &[]
    }
}

/// A smooth input given as a function of time.
pub struct InputFn<F: Fn(f64, &mut [f64]) + Sync>(pub F);

impl<F: Fn(f64, &mut [f64]) + Sync> Input for InputFn<F> {
    fn value(&self, _start: f64, t: f64, u: &mut [f64]) {
        (self.0)(t, u);
    }
}

/// A sampled input: `values[k * m + j]` is channel `j` at `times[k]`.
#[derive(Clone, Debug)]
pub struct SampledInput<'a> {
    /// Sample times, strictly increasing.
    pub times: &'a [f64],
    /// Samples, row-major `times.len() x m`.
    pub values: &'a [f64],
    /// What happens between the samples.
    pub hold: Hold,
}

impl SampledInput<'_> {
    fn channels(&self) -> usize {
        self.values.len() / self.times.len().max(1)
    }
}

/// Index of the last sample at or before `t` (0 before the first one).
fn last_sample(times: &[f64], t: f64) -> usize {
    // Times computed as k * dt may fall short of a sample by rounding.
    let slack = 1e-9 * (1.0 + t.abs());
    times.partition_point(|&s| s <= t + slack).saturating_sub(1)
}

impl Input for SampledInput<'_> {
    fn value(&self, start: f64, t: f64, u: &mut [f64]) {
        let m = self.channels();
        let k = last_sample(self.times, start);
        let here = &self.values[k * m..(k + 1) * m];
        if self.hold == Hold::ZeroOrder || k + 1 == self.times.len() {
            u.copy_from_slice(here);
            return;
        }
        let next = &self.values[(k + 1) * m..(k + 2) * m];
        let share = (t - self.times[k]) / (self.times[k + 1] - self.times[k]);
        for ((u, a), b) in u.iter_mut().zip(here).zip(next) {
            *u = a + share * (b - a);
        }
    }

    fn breakpoints(&self) -> &[f64] {
        self.times
    }
}

/// Samples of a smooth input, joined by cubics through four neighbouring samples (a polynomial
/// through all where there are fewer): `values[k * m + j]` is channel `j` at `times[k]`.
#[derive(Clone, Debug)]
pub struct SmoothInput<'a> {
    /// Sample times, strictly increasing.
    pub times: &'a [f64],
    /// Samples, row-major `times.len() x m`.
    pub values: &'a [f64],
}

impl Input for SmoothInput<'_> {
    fn value(&self, start: f64, t: f64, u: &mut [f64]) {
        let (samples, m) = (self.times.len(), u.len());
        let count = samples.min(4);
        let first = last_sample(self.times, start).saturating_sub(1).min(samples - count);
        let near = &self.times[first..first + count];
        u.fill(0.0);
        for (l, here) in near.iter().enumerate() {
            let others = near.iter().enumerate().filter(|(k, _)| *k != l);
            let weight: f64 = others.map(|(_, other)| (t - other) / (here - other)).product();
            let row = &self.values[(first + l) * m..(first + l + 1) * m];
            u.iter_mut().zip(row).for_each(|(u, value)| *u += weight * value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Input, SmoothInput};

    #[test]
    fn a_smooth_input_runs_along_cubics() {
        let times = [0.0, 0.4, 1.0, 1.5, 2.0, 2.6];
        let cubic = |t: f64| [t * t * t - t, 2.0 - t * t];
        let values: Vec<f64> = times.iter().flat_map(|&t| cubic(t)).collect();
        let at = |samples: usize, start: f64, t: f64| {
            let input = SmoothInput { times: &times[..samples], values: &values[..2 * samples] };
            let mut u = [f64::NAN; 2];
            input.value(start, t, &mut u);
            u
        };
        for (start, t) in [(0.0, 0.1), (0.4, 0.9), (1.0, 1.5), (2.0, 2.5), (2.6, 2.6)] {
            for (found, expected) in at(6, start, t).into_iter().zip(cubic(t)) {
                assert!((found - expected).abs() < 1e-12, "{t}: {found} {expected}");
            }
        }
        // Two samples: a line.
        assert!((at(2, 0.0, 0.2)[1] - 1.92).abs() < 1e-12);
    }
}
