//! The learned force as curves.

use super::evidence::{Evidence, FEATURES, Supposed};
use super::knots::{KNOTS, Knots};
use super::{Channel, Study};
use crate::screen::Over;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use rayon::prelude::*;

/// Points of a curve.
const POINTS: usize = 96;
/// Hyper-parameters of less weight than this, beside the best, are left out.
const LEAST: f64 = 1e-3;

/// A force learned without a formula.
#[derive(Clone, Debug)]
pub struct Learned {
    /// What it is over.
    pub over: Over,
    /// Values of the variable that the recordings visited.
    pub at: Vec<f64>,
    /// The force there.
    pub force: Vec<f64>,
    /// Its standard deviation.
    pub std: Vec<f64>,
    /// Nats that it gains.
    pub gain: f64,
}

/// Values of every part at its knots.
pub(super) fn parts<'s>(study: &'s Study) -> Option<Vec<(&'s Knots, Vec<f64>)>> {
    let Study { evidence, chosen } = study;
    let (posterior, _) = evidence.posterior(&chosen.supposed)?;
    let p = evidence.tolerances.len();
    let part = |i: usize| {
        let l = evidence.features(&chosen.supposed, i)?;
        let own = &posterior.coefficients[p + i * FEATURES..p + (i + 1) * FEATURES];
        let value = |k: usize| (0..FEATURES).map(|j| l[(k, j)] * own[j]).sum();
        let knots = &evidence.variables[chosen.supposed.parts[i].variable];
        Some((knots, (0..KNOTS).map(value).collect()))
    };
    (0..chosen.supposed.parts.len()).map(part).collect()
}

/// Values of one part at points, and their variance.
struct Shown {
    force: Vec<f64>,
    variance: Vec<f64>,
}

pub(super) fn channel(study: &Study) -> Option<Channel> {
    let Study { evidence, chosen } = study;
    let mixture = mixture(study)?;
    let curve = |i: usize| {
        let knots = &evidence.variables[chosen.supposed.parts[i].variable];
        let spacing = (knots.to - knots.from) / (POINTS - 1) as f64;
        let at = |k: &usize| knots.from + spacing * *k as f64;
        let visited = knots.visited(POINTS);
        Learned {
            over: knots.over,
            at: visited.iter().map(at).collect(),
            force: visited.iter().map(|&k| mixture[i].force[k]).collect(),
            std: visited.iter().map(|&k| mixture[i].variance[k].max(0.0).sqrt()).collect(),
            gain: chosen.gains[i],
        }
    };
    let curves = (0..chosen.supposed.parts.len()).map(curve).collect();
    let significance = chosen.gains[0].max(0.0);
    Some(Channel { significance, rms: rms(&parts(study)?), curves })
}

/// Root mean square of the force along the recordings.
fn rms(parts: &[(&Knots, Vec<f64>)]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    let recordings = parts.first().map_or(0, |p| p.0.series.len());
    for r in 0..recordings {
        for k in 0..parts[0].0.series[r].len() {
            let each = parts.iter().map(|(knots, values)| knots.at(values, knots.series[r][k]));
            sum += each.sum::<f64>().powi(2);
            count += 1.0;
        }
    }
    (sum / f64::max(count, 1.0)).sqrt()
}

/// Every part on its even grid, averaged over the hyper-parameters about the chosen ones by
/// their evidence: what they leave open is part of the variance.
fn mixture(study: &Study) -> Option<Vec<Shown>> {
    let Study { evidence, chosen } = study;
    let top = evidence.posterior(&chosen.supposed)?.1;
    let mut total = 0.0;
    let parts = chosen.supposed.parts.len();
    let nothing = || Shown { force: vec![0.0; POINTS], variance: vec![0.0; POINTS] };
    let mut sum: Vec<Shown> = (0..parts).map(|_| nothing()).collect();
    let of = |supposed: &Supposed| {
        let Some((posterior, found)) = evidence.posterior(supposed) else { return Some(None) };
        let weight = (found - top).exp();
        if weight.is_nan() || weight < LEAST {
            return Some(None);
        }
        let inverse = posterior.factor.inverse();
        let part = |i| shown(evidence, supposed, i, &posterior.coefficients, &inverse);
        let all: Option<Vec<Shown>> = (0..parts).map(part).collect();
        Some(Some((weight, all?)))
    };
    let about = chosen.supposed.about();
    let weighed: Option<Vec<_>> = about.par_iter().map(of).collect();
    for (weight, all) in weighed?.into_iter().flatten() {
        total += weight;
        for (sum, shown) in sum.iter_mut().zip(all) {
            for k in 0..POINTS {
                let force = shown.force[k];
                sum.force[k] += weight * force;
                sum.variance[k] += weight * (shown.variance[k] + force * force);
            }
        }
    }
    for sum in &mut sum {
        for (force, variance) in sum.force.iter_mut().zip(&mut sum.variance) {
            *force /= total;
            *variance = *variance / total - *force * *force;
        }
    }
    Some(sum)
}

/// One part on its even grid, for given hyper-parameters.
fn shown(
    evidence: &Evidence,
    supposed: &Supposed,
    i: usize,
    coefficients: &[f64],
    inverse: &Mat<f64>,
) -> Option<Shown> {
    let knots = &evidence.variables[supposed.parts[i].variable];
    let first = evidence.tolerances.len() + i * FEATURES;
    let (features, sizes) = (evidence.features(supposed, i)?, evidence.sizes(supposed, i));
    let spacing = (knots.to - knots.from) / (POINTS - 1) as f64;
    let rows = Mat::from_fn(POINTS, FEATURES, |k, j| {
        let (knot, share) = knots.place(knots.from + spacing * k as f64);
        (1.0 - share) * features[(knot, j)] + share * features[(knot + 1, j)]
    });
    let sized = Mat::from_fn(POINTS, FEATURES, |k, j| rows[(k, j)] * sizes[j]);
    let mut half = Mat::zeros(POINTS, FEATURES);
    let own = inverse.submatrix(first, first, FEATURES, FEATURES);
    matmul(&mut half, Accum::Replace, &sized, own, 1.0, Par::Seq);
    let force = |k| (0..FEATURES).map(|j| rows[(k, j)] * coefficients[first + j]).sum();
    let variance = |k| (0..FEATURES).map(|j| half[(k, j)] * sized[(k, j)]).sum();
    Some(Shown {
        force: (0..POINTS).map(force).collect(),
        variance: (0..POINTS).map(variance).collect(),
    })
}
