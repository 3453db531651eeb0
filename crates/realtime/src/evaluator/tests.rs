//! Evaluations against their definition.

use super::*;
use crate::lanes::Plain;
use crate::{Eight, Group, Products, Profile};
use std::{vec, vec::Vec};

/// Numbers in (-1, 1) that repeat.
fn numbers(seed: u64, count: usize) -> Vec<f64> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 11) as f64 / 2.0_f64.powi(52) - 1.0
    };
    (0..count).map(|_| next()).collect()
}

const SHAPE: Shape = Shape { arguments: 3, dimension: 2, inputs: 1 };
const LOWER: [f64; 3] = [-1.0, 0.0, -3.0];
const UPPER: [f64; 3] = [2.0, 0.5, 5.0];
/// Highest degrees of the three arguments.
const DEGREES: [u16; 3] = [3, 2, 3];

/// Outer products are those of the first argument, inner ones T_j(z_2) T_k(z_3), at j + 3 k.
fn series(groups: Vec<Group<'static>>) -> Series<'static> {
    let parents = (0..12_u16).map(|p| if p < 3 { 0 } else { p % 3 });
    let factors = (0..12_u16).map(|p| if p < 3 { 2 + p.max(1) } else { 4 + p / 3 });
    let fill = |table: Vec<u16>| Table::Owned([table, vec![0; 4]].concat());
    Series {
        degrees: Table::Borrowed(&DEGREES),
        outer: Products {
            parents: Table::Borrowed(&[0; 4]),
            factors: Table::Borrowed(&[0, 0, 1, 2]),
        },
        inner: Products { parents: fill(parents.collect()), factors: fill(factors.collect()) },
        groups: groups.into(),
    }
}

/// A group of as many functions over all blocks, with coefficients where the table is not filled up.
fn group(entries: Vec<u16>, seed: u64) -> Group<'static> {
    let blocks: Vec<[u16; 2]> = (0..4).flat_map(|i| [[i, 0], [i, 1]]).collect();
    let mut coefficients = numbers(seed, blocks.len() * entries.len() * LANES);
    for (k, c) in coefficients.iter_mut().enumerate() {
        let (block, lane) = (k / (entries.len() * LANES), k % LANES);
        if block % 2 == 1 && lane >= 4 {
            *c = 0.0;
        }
    }
    Group {
        entries: entries.into(),
        blocks: blocks.into(),
        coefficients: Eight::table(&coefficients).into(),
    }
}

fn chebyshev(degree: u16, z: f64) -> f64 {
    (f64::from(degree) * z.acos()).cos()
}

fn scaled(x: &[f64], i: usize) -> f64 {
    (2.0 * x[i] - LOWER[i] - UPPER[i]) / (UPPER[i] - LOWER[i])
}

/// The definition, term by term.
fn add_series(series: &Series<'_>, x: &[f64], sums: &mut [f64]) {
    for group in series.groups.iter() {
        let mut coefficients = group.coefficients.iter().flat_map(|eight| eight.0);
        for &[i, block] in group.blocks.iter() {
            for &entry in group.entries.iter() {
                for lane in 0..8 {
                    let inner = 8 * block + lane;
                    let product = chebyshev(i, scaled(x, 0))
                        * chebyshev(inner % 3, scaled(x, 1))
                        * chebyshev(inner / 3, scaled(x, 2));
                    sums[usize::from(entry)] += coefficients.next().unwrap() * product;
                }
            }
        }
    }
}

fn landmarks(profile: Profile, entries: Vec<u16>, seed: u64) -> LandmarkSum<'static> {
    LandmarkSum {
        profile,
        centre: vec![0.5, 0.2, 1.0].into(),
        factors: vec![1.0, 2.0, 0.25].into(),
        tiles: Eight::table(&numbers(seed, 5 * LANES * (3 + entries.len()))).into(),
        entries: entries.into(),
    }
}

fn add_landmarks(sum: &LandmarkSum<'_>, x: &[f64], sums: &mut [f64]) {
    let y: Vec<f64> = (0..3).map(|i| (x[i] - sum.centre[i]) * sum.factors[i]).collect();
    for tile in sum.tiles.chunks_exact(3 + sum.entries.len()) {
        for lane in 0..LANES {
            let p = |i: usize| tile[i].0[lane];
            let product: f64 = (0..3).map(|i| y[i] * p(i)).sum();
            let r = (0..3).map(|i| (y[i] - p(i)).powi(2)).sum::<f64>().sqrt();
            let value = match sum.profile {
                Profile::Exponential => product.exp(),
                Profile::Power { offset, degree } => (product + offset).powi(degree as i32),
                Profile::Gaussian => (-0.5 * r * r).exp(),
                Profile::MaternHalf => (-r).exp(),
                Profile::MaternThreeHalves => {
                    (1.0 + 3.0_f64.sqrt() * r) * (-3.0_f64.sqrt() * r).exp()
                }
                Profile::MaternFiveHalves => {
                    (1.0 + 5.0_f64.sqrt() * r + 5.0 * r * r / 3.0) * (-5.0_f64.sqrt() * r).exp()
                }
            };
            for (e, &entry) in sum.entries.iter().enumerate() {
                sums[usize::from(entry)] += value * p(3 + e);
            }
        }
    }
}

fn evaluator() -> Evaluator<'static> {
    let power = Profile::Power { offset: 0.5, degree: 5 };
    let sums = vec![
        landmarks(Profile::Exponential, vec![0], 1),
        landmarks(power, vec![1, 2], 2),
        landmarks(Profile::Gaussian, vec![3, 0, 1], 3),
        landmarks(Profile::MaternHalf, vec![2, 3, 0, 1], 4),
        landmarks(Profile::MaternThreeHalves, vec![0, 1, 2, 3, 0], 5),
        landmarks(Profile::MaternFiveHalves, vec![0, 1, 2, 3, 0, 1], 6),
    ];
    let groups = (1..=6_u16).map(|e| group((0..e).map(|k| k % 4).collect(), 10 + u64::from(e)));
    let series = series(groups.collect());
    let (lower, upper) = (Table::Borrowed(&LOWER[..]), Table::Borrowed(&UPPER[..]));
    Evaluator::new(SHAPE, lower, upper, Some(series), sums.into()).unwrap()
}

/// In the box, some outside.
fn points() -> Vec<[f64; 3]> {
    let unit = numbers(99, 300);
    let side = |k: usize, i: usize| {
        0.5 * (LOWER[i] + UPPER[i]) + 0.55 * unit[3 * k + i] * (UPPER[i] - LOWER[i])
    };
    (0..100).map(|k| core::array::from_fn(|i| side(k, i))).collect()
}

#[test]
fn values_are_those_of_the_definition_on_plain_loops_and_on_vectors() {
    let evaluator = evaluator();
    let mut clamped = 0;
    for x in points() {
        let nearest: Vec<f64> = (0..3).map(|i| x[i].clamp(LOWER[i], UPPER[i])).collect();
        let mut exact = [0.0; 4];
        add_series(evaluator.series().unwrap(), &nearest, &mut exact);
        evaluator.sums().iter().for_each(|sum| add_landmarks(sum, &nearest, &mut exact));
        let (mut plain, mut vectors) = ([0.0; 4], [0.0; 4]);
        let (f, g) = plain.split_at_mut(2);
        let region = evaluator.evaluate_on(Plain, &x, f, g).unwrap();
        let (f, g) = vectors.split_at_mut(2);
        assert_eq!(evaluator.evaluate(&x, f, g), Ok(region));
        assert_eq!(region == Region::Inside, nearest == x && evaluator.inside(&x));
        clamped += usize::from(region == Region::Clamped);
        for k in 0..4 {
            assert!((plain[k] - exact[k]).abs() < 2e-12, "{x:?}: {plain:?} {exact:?}");
            assert!((vectors[k] - plain[k]).abs() < 1e-12, "{x:?}: {plain:?} {vectors:?}");
        }
    }
    assert!((10..90).contains(&clamped));
}

#[test]
fn what_is_no_number_is_outside_and_gives_none() {
    let (mut f, mut g) = ([0.0; 2], [0.0; 2]);
    let region = evaluator().evaluate(&[0.0, f64::NAN, 0.0], &mut f, &mut g).unwrap();
    assert_eq!(region, Region::Clamped);
    assert!(f.iter().chain(&g).all(|v| v.is_nan()));
}

#[test]
fn wrong_lengths_are_typed_errors_and_change_nothing() {
    let evaluator = evaluator();
    let (mut f, mut g) = ([7.0; 2], [7.0; 2]);
    let wrong = |what, expected, found| Err(LengthError { what, expected, found });
    assert_eq!(evaluator.evaluate(&[0.0; 2], &mut f, &mut g), wrong("x", 3, 2));
    assert_eq!(evaluator.evaluate(&[0.0; 3], &mut f[..1], &mut g), wrong("f", 2, 1));
    assert_eq!(evaluator.evaluate(&[0.0; 3], &mut f, &mut [0.0; 4]), wrong("g", 2, 4));
    assert_eq!((f, g), ([7.0; 2], [7.0; 2]));
    assert!(!evaluator.inside(&[0.0; 2]));
}

#[test]
fn tables_that_do_not_fit_are_refused() {
    let with =
        |upper: [f64; 3], series: Option<Series<'static>>, sums: Vec<LandmarkSum<'static>>| {
            let lower = Table::Borrowed(&LOWER[..]);
            Evaluator::new(SHAPE, lower, upper.to_vec().into(), series, sums.into()).unwrap_err()
        };
    let error = with([2.0, 0.0, 5.0], None, vec![]);
    assert_eq!(error, TableError::Box { argument: 1, lower: 0.0, upper: 0.0 });
    let mut wrong = group(vec![0, 4], 1);
    assert_eq!(
        with(UPPER, Some(series(vec![wrong.clone()])), vec![]),
        TableError::Index { what: "functions of a group", length: 4, found: 4 }
    );
    wrong.entries = vec![0, 1].into();
    wrong.blocks = vec![[0, 2]; 8].into();
    assert_eq!(
        with(UPPER, Some(series(vec![wrong.clone()])), vec![]),
        TableError::Index { what: "blocks", length: 2, found: 2 }
    );
    wrong.blocks = vec![[0, 1]; 7].into();
    assert!(matches!(
        with(UPPER, Some(series(vec![wrong])), vec![]),
        TableError::Length(LengthError { what: "coefficients", expected: 14, found: 16 })
    ));
    let mut series = series(vec![]);
    series.outer.parents = vec![0, 0, 2, 0].into();
    assert_eq!(
        with(UPPER, Some(series), vec![]),
        TableError::Index { what: "outer products", length: 2, found: 2 }
    );
    let mut sum = landmarks(Profile::Gaussian, vec![0; 34], 1);
    assert!(matches!(
        with(UPPER, None, vec![sum.clone()]),
        TableError::Count { what: "functions of a sum", most: 32, found: 34 }
    ));
    sum.entries = vec![0].into();
    assert!(matches!(with(UPPER, None, vec![sum.clone()]), TableError::Length(_)));
    sum.tiles = vec![Eight([f64::NAN; 8]); 4].into();
    assert_eq!(with(UPPER, None, vec![sum]), TableError::NotFinite { what: "tiles" });
}
