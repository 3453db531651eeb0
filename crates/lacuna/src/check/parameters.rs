//! Whether the recordings can move the model's parameters.
//!
//! About the nominal parameters, in the longest windows that the model follows, the likelihood is
//! a linear regression on what each parameter changes ([`crate::discrepancy::likelihood`]). With
//! the tolerances as prior, its posterior covariance is what the recordings could tell at best:
//! with the measurement noise as the only error, and nothing missing from the model.

use crate::discrepancy::Dataset;
use crate::discrepancy::likelihood::{Problem, What};
use crate::discrepancy::search::about_nominal;
use crate::plants::Model;
use crate::table::{Table, number};
use serde::Serialize;
use std::error::Error;

/// A parameter whose standard deviation stays above this share of its tolerance is not excited.
const NOT_EXCITED: f64 = 0.7;
/// Parameters correlated above this cannot be told apart.
const CONFOUNDED: f64 = 0.98;

/// What the recordings could tell of one parameter.
#[derive(Serialize)]
pub struct Parameter {
    pub name: String,
    pub value: f64,
    pub unit: String,
    /// Standard deviation that the model's tolerance states.
    pub std_before: f64,
    /// Standard deviation that the recordings could leave, at best.
    pub std_after: f64,
    pub excited: bool,
}

/// Two parameters of which only a combination shows.
#[derive(Serialize)]
pub struct Confounded {
    pub parameters: [String; 2],
    pub correlation: f64,
}

/// All parameters with a tolerance.
#[derive(Serialize)]
pub struct Parameters {
    pub list: Vec<Parameter>,
    pub confounded: Vec<Confounded>,
    /// Why nothing can be said of them, where that is so.
    pub not_assessed: Option<String>,
}

impl Parameters {
    /// Assess the parameters of a model on recordings.
    pub fn of(model: &Model, data: &Dataset) -> Self {
        let nothing = |reason| Self { list: vec![], confounded: vec![], not_assessed: reason };
        if model.parameters.iter().all(|p| p.std() == 0.0) {
            return nothing(None);
        }
        match Self::assess(model, data) {
            Ok(parameters) => parameters,
            Err(error) => nothing(Some(error.to_string())),
        }
    }

    fn assess(model: &Model, data: &Dataset) -> Result<Self, Box<dyn Error>> {
        let problem = Problem::new(model, data)?;
        let fit = about_nominal(&problem)?;
        let free: Vec<usize> = fit
            .hypothesis
            .free
            .iter()
            .filter_map(|f| if let What::Parameter(k) = f.what { Some(k) } else { None })
            .collect();
        let covariance = fit.covariance(1.0).ok_or("the recordings' precision is not finite")?;
        let std = |i: usize| covariance[(i, i)].max(0.0).sqrt();
        let list = free.iter().enumerate().map(|(i, &k)| {
            let p = &model.parameters[k];
            let std_after = std(i);
            Parameter {
                name: p.name.clone(),
                value: p.value,
                unit: p.unit.clone(),
                std_before: p.std(),
                std_after,
                excited: std_after <= NOT_EXCITED * p.std(),
            }
        });
        let pairs = (0..free.len()).flat_map(|i| (0..i).map(move |j| (j, i)));
        let confounded = pairs.filter_map(|(j, i)| {
            let correlation = covariance[(i, j)] / (std(i) * std(j));
            let name = |k: usize| model.parameters[free[k]].name.clone();
            (correlation.abs() > CONFOUNDED)
                .then(|| Confounded { parameters: [name(j), name(i)], correlation })
        });
        let (list, confounded) = (list.collect(), confounded.collect());
        Ok(Self { list, confounded, not_assessed: None })
    }

    /// The table.
    pub fn text(&self) -> String {
        if self.list.is_empty() {
            return String::new();
        }
        let mut table =
            Table::new(&["parameter", "value", "unit", "sd before", "sd after", "excited"]);
        for p in &self.list {
            table.row(vec![
                p.name.clone(),
                number(p.value),
                p.unit.clone(),
                number(p.std_before),
                number(p.std_after),
                if p.excited { "yes" } else { "no" }.to_owned(),
            ]);
        }
        table.text()
            + "  Sd before: the model's tolerance. Sd after: what the recordings can tell at best, \
               the noise being\n  the only error.\n\n"
    }
}
