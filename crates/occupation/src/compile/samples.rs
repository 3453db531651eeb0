//! The model's values at points of the box.

use rayon::prelude::*;

use super::{CompileError, Domain};
use crate::IdentifiedModel;

/// z in \[-1, 1\]^d and the values of all functions there.
#[derive(Debug, Clone, Default)]
pub(crate) struct Samples {
    pub points: Vec<Vec<f64>>,
    /// f_1 ... f_n, g_11 ... g_nm of each point.
    pub values: Vec<Vec<f64>>,
}

impl Samples {
    pub fn of(
        model: &IdentifiedModel,
        domain: &Domain,
        points: Vec<Vec<f64>>,
    ) -> Result<Self, CompileError> {
        let values: Vec<Vec<f64>> = points
            .par_iter()
            .map(|z| {
                let x = domain.point(z);
                let mut values = vec![0.0; model.dimension() * (1 + model.inputs())];
                let (f, g) = values.split_at_mut(model.dimension());
                // Lengths are those of the model.
                let evaluated = model.evaluate(&x, f, g);
                debug_assert!(evaluated.is_ok());
                if values.iter().all(|v| v.is_finite()) {
                    Ok(values)
                } else {
                    Err(CompileError::NotFinite { point: x })
                }
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { points, values })
    }

    /// Greatest magnitude of each function.
    pub fn magnitudes(&self) -> Vec<f64> {
        let mut greatest = vec![0.0_f64; self.values.first().map_or(0, Vec::len)];
        for values in &self.values {
            greatest.iter_mut().zip(values).for_each(|(g, v)| *g = g.max(v.abs()));
        }
        greatest
    }
}
