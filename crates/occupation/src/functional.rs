//! Linear functionals of a sampled signal.

/// A linear functional y -> sum_k weights\[k\] y(t_(first + k)) of a sampled signal.
#[derive(Debug, Clone, PartialEq)]
pub struct Functional {
    /// Index of the first sample it looks at.
    pub first: usize,
    /// Weights of that sample and those that follow.
    pub weights: Vec<f64>,
}

impl Functional {
    /// One past the last sample it looks at.
    pub fn end(&self) -> usize {
        self.first + self.weights.len()
    }

    /// Its value on the samples `signal` of one channel.
    ///
    /// # Panics
    /// Where `signal` is shorter than [`Functional::end`].
    pub fn apply(&self, signal: &[f64]) -> f64 {
        self.apply_column(signal, 1, 0)
    }

    /// Its value on one column of samples stored row after row (samples x `columns`).
    ///
    /// # Panics
    /// Where there are fewer than [`Functional::end`] rows.
    pub fn apply_column(&self, rows: &[f64], columns: usize, column: usize) -> f64 {
        let samples = rows[self.first * columns..self.end() * columns].chunks_exact(columns);
        self.weights.iter().zip(samples).map(|(weight, row)| weight * row[column]).sum()
    }

    /// sum_k a(k) b(k) over the samples that both look at: the covariance of the two functionals of white
    /// noise of unit variance.
    pub fn overlap(&self, other: &Self) -> f64 {
        let (start, end) = (self.first.max(other.first), self.end().min(other.end()));
        if start >= end {
            return 0.0;
        }
        let own = &self.weights[start - self.first..end - self.first];
        let others = &other.weights[start - other.first..end - other.first];
        own.iter().zip(others).map(|(a, b)| a * b).sum()
    }

    /// The same functional of a longer signal in which the samples come `samples` later.
    pub(crate) fn shifted(mut self, samples: usize) -> Self {
        self.first += samples;
        self
    }
}
