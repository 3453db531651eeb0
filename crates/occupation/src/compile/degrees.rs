//! How high the degree in each argument must be, from lines through the box.

use std::f64::consts::PI;

use super::domain::Purpose;
use super::samples::Samples;
use super::{CompileError, Domain};
use crate::IdentifiedModel;

/// Highest degree in one argument.
pub(crate) const MOST_DEGREE: usize = 64;
/// Lines parallel to each axis.
const LINES: usize = 8;

/// Degrees of each function in each argument: beyond them, the coefficients of its Chebyshev series along the lines sum
/// to less than `tolerance` of its magnitude. An argument on which it does not depend has degree 0.
pub(crate) fn degrees(
    model: &IdentifiedModel,
    domain: &Domain,
    magnitudes: &[f64],
    tolerance: f64,
) -> Result<Vec<Vec<usize>>, CompileError> {
    let nodes = MOST_DEGREE + 1;
    let node = |k: usize| (PI * (k as f64 + 0.5) / nodes as f64).cos();
    let mut degrees = vec![vec![0; domain.arguments()]; magnitudes.len()];
    let bases = domain.interior(Purpose::Lines, LINES);
    for argument in 0..domain.arguments() {
        for base in &bases {
            let on_line = |k: usize| {
                let mut z = base.clone();
                z[argument] = node(k);
                z
            };
            let line = Samples::of(model, domain, (0..nodes).map(on_line).collect())?;
            for (function, magnitude) in magnitudes.iter().enumerate() {
                let values: Vec<f64> = line.values.iter().map(|v| v[function]).collect();
                let degree = degree(&coefficients(&values), tolerance * magnitude);
                degrees[function][argument] = degrees[function][argument].max(degree);
            }
        }
    }
    Ok(degrees)
}

/// c_j of the interpolating series on the zeros of the next polynomial.
fn coefficients(values: &[f64]) -> Vec<f64> {
    let n = values.len() as f64;
    let one = |j: usize| {
        let cosine = |k: usize| (PI * j as f64 * (k as f64 + 0.5) / n).cos();
        let sum: f64 = values.iter().enumerate().map(|(k, v)| v * cosine(k)).sum();
        if j == 0 { sum / n } else { 2.0 * sum / n }
    };
    (0..values.len()).map(one).collect()
}

/// The least degree beyond which the coefficients sum to less than `enough`.
fn degree(coefficients: &[f64], enough: f64) -> usize {
    let mut beyond = 0.0;
    for (j, c) in coefficients.iter().enumerate().skip(1).rev() {
        beyond += c.abs();
        if beyond > enough {
            return j;
        }
    }
    0
}
