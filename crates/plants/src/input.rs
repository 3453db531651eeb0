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

    /// Index of the last sample at or before `t` (0 before the first one).
    fn index(&self, t: f64) -> usize {
        // Times computed as k * dt may fall short of a sample by rounding.
        let slack = 1e-9 * (1.0 + t.abs());
        self.times.partition_point(|&s| s <= t + slack).saturating_sub(1)
    }
}

impl Input for SampledInput<'_> {
    fn value(&self, start: f64, t: f64, u: &mut [f64]) {
        let m = self.channels();
        let k = self.index(start);
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
