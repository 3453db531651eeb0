//! Equations and their errors.

use super::super::super::family::{Family, ScaledKernel};
use super::super::super::motion::{InputPath, Motion};
use super::*;
use crate::Functional;
use crate::whitening::BandedCholesky;

fn window(order: usize) -> WeakWindow {
    // Uneven times.
    let times: Vec<f64> = (0..24).map(|k| 0.05 * f64::from(k) + 0.01 * f64::from(k % 3)).collect();
    let y: Vec<f64> = times.iter().map(|t| (2.0 * t).sin() + t * t).collect();
    let u: Vec<f64> = times.iter().map(|t| (3.0 * t).cos()).collect();
    let motion = Motion::new(times, y.clone(), u).unwrap();
    let zeros = vec![0.0; 24];
    WeakWindow::sampled(motion.into(), y, order, InputPath::Smooth, [&zeros, &zeros], &[0.0])
}

fn integrate(
    window: &WeakWindow,
    values: &[f64],
    block: usize,
    levels: usize,
    integrated: &mut Vec<f64>,
) {
    integrated.resize(levels * window.motion.samples(), 0.0);
    Integral { window, block, levels, columns: 1, values, integrated }.work_out();
}

/// int int cos(3 t) from known derivatives.
#[test]
fn integrals_are_those_of_the_integrand() {
    let w = window(2);
    let mut found = Vec::new();
    integrate(&w, &[1.0; 24], 1, 2, &mut found);
    for (k, t) in w.motion.times().iter().enumerate() {
        let expected = [(1.0 - (3.0 * t).cos()) / 9.0, (3.0 * t).sin() / 3.0];
        for (p, e) in expected.iter().enumerate() {
            assert!((found[p * 24 + k] - e).abs() < 2e-5, "{p} {k}");
        }
    }
}

/// int int sin(2 t) from values at the nodes within the intervals.
#[test]
fn integrals_along_a_path_are_those_of_the_integrand() {
    let motion = window(2).motion;
    let times = motion.times().to_vec();
    let shares = crate::identification::weak::shares_within(2);
    let between = |t: &[f64]| {
        let (start, step) = (t[0], t[1] - t[0]);
        shares.iter().map(move |share| (2.0 * (start + share * step)).sin())
    };
    let values: Vec<f64> = times.windows(2).flat_map(between).collect();
    let none = vec![0.0; 23];
    let w = WeakWindow::along(motion, values.clone(), 2, InputPath::Smooth, 2, none);
    let mut found = Vec::new();
    integrate(&w, &values, 0, 2, &mut found);
    for (k, t) in times.iter().enumerate() {
        let expected = [0.5 * t - 0.25 * (2.0 * t).sin(), 0.5 - 0.5 * (2.0 * t).cos()];
        for (p, e) in expected.iter().enumerate() {
            assert!((found[p * 24 + k] - e).abs() < 1e-12, "{p} {k}");
        }
    }
}

/// What landmarks leave is what dense kernels have and features have not.
#[test]
fn remainders_make_few_landmarks_as_good_as_all() {
    let w = [window(2)];
    let row = WeakRow::new(&w, 0, 1.0, None);
    let kernel = ScaledKernel { family: Family::Matern, centre: vec![0.5], widths: vec![0.4] };
    let covariance = |most: usize| {
        let basis = Basis::choose(kernel.clone(), &w[0].arguments, 1e-12, most);
        let design = row.design(&basis, 0);
        let mut whole = &design * design.transpose();
        if let Some(left) = row.remainders(&basis, 0).0.first() {
            whole += left;
        }
        whole
    };
    let (all, few) = (covariance(24), covariance(3));
    for i in 0..all.nrows() {
        for j in 0..=i {
            let scale = (all[(i, i)] * all[(j, j)]).sqrt();
            assert!((all[(i, j)] - few[(i, j)]).abs() < 1e-8 * scale, "{i} {j}");
        }
    }
}

/// y'' = 2 - 4 sin 2t is explained to the quadrature's accuracy.
#[test]
fn the_true_integrand_explains_the_samples() {
    let w = window(2);
    let truth = w.motion.times().iter().map(|t| 2.0 - 4.0 * (2.0 * t).sin());
    let truth: Vec<f64> = truth.collect();
    let mut explained = Vec::new();
    integrate(&w, &truth, 0, 1, &mut explained);
    let row = RowWindow::new(&w, 0, 1.0, None);
    row.reduction.reflect(&mut explained);
    for (a, b) in explained[row.reduction.lost()..].iter().zip(&row.right) {
        assert!((a - b).abs() < 3e-6, "{a} {b}");
    }
}

#[test]
fn reduction_is_whitening_of_divided_differences() {
    let w = window(2);
    let times = w.motion.times();
    let difference = |k: usize| {
        let t = &times[k..k + 3];
        let weight =
            |l: usize| (0..3).filter(|&j| j != l).map(|j| 1.0 / (t[l] - t[j])).product::<f64>();
        Functional { first: k, weights: (0..3).map(weight).collect() }
    };
    let functionals: Vec<Functional> = (0..22).map(difference).collect();
    let whitener = BandedCholesky::of_functionals(&functionals).unwrap();
    let integrated = [1.0, 2.0].map(|rate| {
        let feature: Vec<f64> = times.iter().map(|t| (t * rate).cos()).collect();
        let mut integrated = Vec::new();
        integrate(&w, &feature, 1, 1, &mut integrated);
        integrated
    });
    let row = RowWindow::new(&w, 0, 1.0, None);
    let whitened = |values: &[f64]| {
        let mut out: Vec<f64> = functionals.iter().map(|f| f.apply_column(values, 1, 0)).collect();
        whitener.solve_lower_in_place(&mut out).unwrap();
        out
    };
    let reduced = |values: &[f64]| {
        let mut out = values.to_vec();
        row.reduction.reflect(&mut out);
        out.split_off(row.reduction.lost())
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let (y, a, b) = (w.motion.coordinates(), integrated[0].as_slice(), integrated[1].as_slice());
    for (p, q) in [(y, y), (y, a), (a, b), (b, b)] {
        let (left, right) = (dot(&whitened(p), &whitened(q)), dot(&reduced(p), &reduced(q)));
        let size = (dot(p, p) * dot(q, q)).sqrt();
        assert!((left - right).abs() < 1e-9 * size, "{left} {right}");
    }
}
