//! What is fitted: parameters of the model and of effects, with their priors.

use lacuna_effects::{Prior, Scales};
use lacuna_plants::Model;
use lacuna_plants::model::{Direction, ModelEffect};

/// Parameters stay within this many tolerances.
const MOST_TOLERANCES: f64 = 4.0;

/// One entry of theta.
#[derive(Clone, Copy, Debug)]
pub struct Free {
    /// What it is.
    pub what: What,
    /// Whether its logarithm is fitted.
    pub logarithmic: bool,
    /// Prior mean of the fitted value.
    pub mean: f64,
    /// Prior standard deviation of the fitted value.
    pub sd: f64,
    /// Bounds of the fitted value.
    pub bounds: (f64, f64),
}

/// A parameter that is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// A parameter of the model.
    Parameter(usize),
    /// An internal parameter of an effect: effect, parameter.
    Effect(usize, usize),
}

impl Free {
    fn of(what: What, prior: Prior) -> Option<Self> {
        let (logarithmic, mean, sd, low, high) = match prior {
            Prior::Fixed => return None,
            Prior::Normal { mean, sd, low, high } => (false, mean, sd, low, high),
            Prior::LogNormal { median, factor, low, high } => {
                (true, median.ln(), factor.ln(), low.ln(), high.ln())
            }
        };
        Some(Self { what, logarithmic, mean, sd, bounds: (low, high) })
    }

    /// The fitted value of a plain one, within bounds.
    #[must_use]
    pub fn fitted(&self, plain: f64) -> f64 {
        let value = if self.logarithmic { plain.max(f64::MIN_POSITIVE).ln() } else { plain };
        value.clamp(self.bounds.0, self.bounds.1)
    }

    /// Whether a fitted value lies on one of the bounds: the data would have it beyond.
    #[must_use]
    pub fn is_at_bound(&self, fitted: f64) -> bool {
        // Values are cut off at the bounds; what they are computed from is rounded.
        let near = f64::EPSILON.sqrt() * self.sd;
        fitted - self.bounds.0 <= near || self.bounds.1 - fitted <= near
    }

    /// The plain value of a fitted one.
    #[must_use]
    pub fn plain(&self, fitted: f64) -> f64 {
        if self.logarithmic { fitted.exp() } else { fitted }
    }

    /// Derivative of the plain value by the fitted one.
    #[must_use]
    pub fn slope(&self, fitted: f64) -> f64 {
        if self.logarithmic { fitted.exp() } else { 1.0 }
    }
}

/// A model with parameters and effects: the machine's own effects, then those supposed.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// Parameters of the model.
    pub parameters: Vec<f64>,
    /// All effects.
    pub effects: Vec<ModelEffect>,
    /// What is fitted.
    pub free: Vec<Free>,
    /// Effects that the model has itself; they are not fitted.
    pub own: usize,
}

impl Hypothesis {
    /// The model as it is, its uncertain parameters free.
    #[must_use]
    pub fn of(model: &Model) -> Self {
        let uncertain = model.parameters.iter().enumerate().filter(|(_, p)| p.std() > 0.0);
        let free = uncertain
            .map(|(k, p)| {
                let room = MOST_TOLERANCES * p.std();
                let bounds = (p.value - room, p.value + room);
                let what = What::Parameter(k);
                Free { what, logarithmic: false, mean: p.value, sd: p.std(), bounds }
            })
            .collect();
        let effects = model.effects.clone();
        Self { parameters: model.values(), own: effects.len(), effects, free }
    }

    /// The same with nothing free but the states.
    #[must_use]
    pub fn held(mut self) -> Self {
        self.free.clear();
        self
    }

    /// The same for data that say less: priors weigh as much more as if the variance of the noise
    /// were `doubt` times as large.
    #[must_use]
    pub fn doubting(&self, doubt: f64) -> Self {
        let mut h = self.clone();
        for f in &mut h.free {
            f.sd /= doubt.sqrt();
        }
        h
    }

    /// The same with one more effect, whose channel has these magnitudes.
    #[must_use]
    pub fn with(mut self, effect: ModelEffect, scales: &Scales) -> Self {
        let index = self.effects.len();
        let entries = (effect.effect.priors)(scales).into_iter().enumerate();
        self.free.extend(entries.filter_map(|(j, p)| Free::of(What::Effect(index, j), p)));
        self.effects.push(effect);
        self.set(&self.theta());
        self
    }

    /// The same without several of the effects supposed, in their order.
    #[must_use]
    pub fn without_all(self, which: impl DoubleEndedIterator<Item = usize>) -> Self {
        which.rev().fold(self, Self::without)
    }

    /// The same without the effect that stands `k`-th among those supposed.
    #[must_use]
    pub fn without(mut self, k: usize) -> Self {
        let gone = self.own + k;
        self.effects.remove(gone);
        self.free.retain(|f| !matches!(f.what, What::Effect(e, _) if e == gone));
        for f in &mut self.free {
            if let What::Effect(e, _) = &mut f.what
                && *e > gone
            {
                *e -= 1;
            }
        }
        self
    }

    /// The supposed effects.
    #[must_use]
    pub fn supposed(&self) -> &[ModelEffect] {
        &self.effects[self.own..]
    }

    /// The fitted values.
    #[must_use]
    pub fn theta(&self) -> Vec<f64> {
        let internal: Vec<Vec<f64>> = self.effects.iter().map(ModelEffect::internal).collect();
        let value = |f: &Free| match f.what {
            What::Parameter(k) => f.fitted(self.parameters[k]),
            What::Effect(e, j) => f.fitted(internal[e][j]),
        };
        self.free.iter().map(value).collect()
    }

    /// Set the fitted values.
    pub fn set(&mut self, theta: &[f64]) {
        let mut internal: Vec<Vec<f64>> = self.effects.iter().map(ModelEffect::internal).collect();
        for (f, &value) in self.free.iter().zip(theta) {
            match f.what {
                What::Parameter(k) => self.parameters[k] = f.plain(value),
                What::Effect(e, j) => internal[e][j] = f.plain(value),
            }
        }
        for (effect, internal) in self.effects.iter_mut().zip(&internal).skip(self.own) {
            effect.set_internal(internal);
        }
    }

    /// The direction that an entry of theta is.
    #[must_use]
    pub fn direction(&self, entry: usize) -> Direction {
        match self.free[entry].what {
            What::Parameter(k) => Direction::Parameter(k),
            What::Effect(e, j) => Direction::Effect(e, j),
        }
    }

    /// The penalty `|(theta - theta_0)/S|^2`.
    #[must_use]
    pub fn penalty(&self, theta: &[f64]) -> f64 {
        self.free.iter().zip(theta).map(|(f, t)| ((t - f.mean) / f.sd).powi(2)).sum()
    }

    /// Logarithm of the mass that the normal priors of all entries have within their bounds.
    #[must_use]
    pub fn log_prior_mass(&self) -> f64 {
        let below = |x: f64| 0.5 * libm::erfc(-x * std::f64::consts::FRAC_1_SQRT_2);
        let within = |f: &Free| {
            let at = |bound: f64| below((bound - f.mean) / f.sd);
            (at(f.bounds.1) - at(f.bounds.0)).max(f64::MIN_POSITIVE).ln()
        };
        self.free.iter().map(within).sum()
    }
}
