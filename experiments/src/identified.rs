//! What every recipe makes: a drift and a control effectiveness that can be evaluated.

use lacuna_occupation::compile::Compiled;
use lacuna_occupation::{EvaluationError, IdentifiedModel, StandardDeviations};
use lacuna_realtime::Region;

/// An identified model `x^(s) = f(x) + g(x) u`, whichever recipe made it.
pub trait Evaluate: Send + Sync {
    /// Write the drift `f(x)` (length n) and the control effectiveness `g(x)` (row-major n x m)
    /// at `x`.
    ///
    /// # Errors
    /// A slice whose length is not that of the model's.
    fn evaluate(&self, x: &[f64], f: &mut [f64], g: &mut [f64]) -> Result<(), EvaluationError>;

    /// Standard deviations of `f(x)` and `g(x)`; none for a recipe that has none.
    ///
    /// # Errors
    /// An `x` whose length is not that of the model's.
    fn standard_deviations(
        &self,
        _x: &[f64],
    ) -> Result<Option<StandardDeviations>, EvaluationError> {
        Ok(None)
    }
}

impl Evaluate for IdentifiedModel {
    fn evaluate(&self, x: &[f64], f: &mut [f64], g: &mut [f64]) -> Result<(), EvaluationError> {
        Self::evaluate(self, x, f, g)
    }

    fn standard_deviations(
        &self,
        x: &[f64],
    ) -> Result<Option<StandardDeviations>, EvaluationError> {
        Self::standard_deviations(self, x)
    }
}

/// A compiled model; outside its box there is no value, so that a loop that leaves it ends.
impl Evaluate for Compiled {
    fn evaluate(&self, x: &[f64], f: &mut [f64], g: &mut [f64]) -> Result<(), EvaluationError> {
        let region = self.evaluator().evaluate(x, f, g).map_err(|e| EvaluationError {
            what: e.what,
            expected: e.expected,
            found: e.found,
        })?;
        if region == Region::Clamped {
            f.fill(f64::NAN);
        }
        Ok(())
    }
}
