//! What is believed of a parameter before any data.

/// The prior of one internal parameter (an amplitude or a shape), in its own unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Prior {
    /// Never fitted: a side, a choice.
    Fixed,
    /// Normal, cut off at bounds.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation.
        sd: f64,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
    },
    /// The logarithm is normal, cut off at bounds: for what is positive and known by its order
    /// of magnitude.
    LogNormal {
        /// Median.
        median: f64,
        /// One standard deviation, as a factor.
        factor: f64,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
    },
}

impl Prior {
    /// An amplitude of this size, of either sign.
    #[must_use]
    pub fn amplitude(sd: f64) -> Self {
        Self::Normal { mean: 0.0, sd, low: f64::NEG_INFINITY, high: f64::INFINITY }
    }

    /// An amplitude of this size that cannot be negative: a friction that drives is no friction.
    #[must_use]
    pub fn magnitude(sd: f64) -> Self {
        Self::Normal { mean: 0.0, sd, low: 0.0, high: f64::INFINITY }
    }

    /// A value near `mean`, within bounds.
    #[must_use]
    pub fn near(mean: f64, sd: f64, (low, high): (f64, f64)) -> Self {
        Self::Normal { mean, sd, low, high }
    }

    /// A positive value of this order of magnitude, within bounds.
    #[must_use]
    pub fn order(median: f64, factor: f64, (low, high): (f64, f64)) -> Self {
        Self::LogNormal { median, factor, low, high }
    }
}
