//! The evaluator.

use crate::error::{LengthError, TableError, check_count, check_length};
use crate::lanes::{Detected, Dispatch};
use crate::{LANES, LandmarkSum, MOST_ARGUMENTS, Series, Table};

/// d arguments x, n functions f_i, n m functions g_ij.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    /// Number d of arguments, at most [`MOST_ARGUMENTS`].
    pub arguments: usize,
    /// Number n of coordinates.
    pub dimension: usize,
    /// Number m of inputs.
    pub inputs: usize,
}

/// Where the arguments of an evaluation were.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[must_use = "outside the box the values are those of its nearest point"]
pub enum Region {
    /// In the box: the error bound holds.
    Inside,
    /// Outside: f and g are those of the nearest point of the box. Arguments that are no numbers count as outside, and
    /// give no numbers.
    Clamped,
}

/// f and g on a box.
#[derive(Debug, Clone)]
pub struct Evaluator<'a> {
    shape: Shape,
    lower: Table<'a, f64>,
    upper: Table<'a, f64>,
    series: Option<Series<'a>>,
    sums: Table<'a, LandmarkSum<'a>>,
    lanes: Detected,
}

impl PartialEq for Evaluator<'_> {
    fn eq(&self, other: &Self) -> bool {
        let (a, b) = (self, other);
        (a.shape, &a.lower, &a.upper, &a.series, &a.sums)
            == (b.shape, &b.lower, &b.upper, &b.series, &b.sums)
    }
}

impl<'a> Evaluator<'a> {
    /// From tables, borrowed or owned; all indices are checked here, once.
    ///
    /// # Errors
    /// Tables that do not fit together, and a box without inside.
    pub fn new(
        shape: Shape,
        lower: Table<'a, f64>,
        upper: Table<'a, f64>,
        series: Option<Series<'a>>,
        sums: Table<'a, LandmarkSum<'a>>,
    ) -> Result<Self, TableError> {
        check_count("arguments", MOST_ARGUMENTS, shape.arguments)?;
        let functions = shape.dimension.saturating_mul(1 + shape.inputs);
        check_count("functions", usize::from(u16::MAX), functions)?;
        check_length("lower ends of the box", shape.arguments, lower.len())?;
        check_length("upper ends of the box", shape.arguments, upper.len())?;
        let sides = lower.iter().copied().zip(upper.iter().copied()).enumerate();
        for (argument, (lower, upper)) in sides {
            if !(lower.is_finite() && upper.is_finite() && lower < upper) {
                return Err(TableError::Box { argument, lower, upper });
            }
        }
        series.iter().try_for_each(|series| series.check(shape.arguments, functions))?;
        sums.iter().try_for_each(|sum| sum.check(shape.arguments, functions))?;
        Ok(Self { shape, lower, upper, series, sums, lanes: Detected::new() })
    }

    /// Writes f(x) (n) and g(x) (n x m, row-major) at x (d), and says whether x was in the box. Outside it, f and g are
    /// those of the nearest point of the box.
    ///
    /// # Errors
    /// A slice of another length than d, n or n m; then f and g are left as they are.
    pub fn evaluate(&self, x: &[f64], f: &mut [f64], g: &mut [f64]) -> Result<Region, LengthError> {
        self.evaluate_on(self.lanes, x, f, g)
    }

    #[inline(always)]
    fn evaluate_on(
        &self,
        lanes: impl Dispatch,
        x: &[f64],
        f: &mut [f64],
        g: &mut [f64],
    ) -> Result<Region, LengthError> {
        let Shape { arguments, dimension, inputs } = self.shape;
        check_length("x", arguments, x.len())?;
        check_length("f", dimension, f.len())?;
        check_length("g", dimension * inputs, g.len())?;
        f.fill(0.0);
        g.fill(0.0);
        let mut add = |entry: u16, value: f64| {
            let entry = usize::from(entry);
            let sum = match entry.checked_sub(dimension) {
                None => f.get_mut(entry),
                Some(entry) => g.get_mut(entry),
            };
            if let Some(sum) = sum {
                *sum += value;
            }
        };
        if let Some(series) = &self.series {
            let sides = x.iter().zip(self.lower.iter().zip(self.upper.iter()));
            // The nearest point of the box is the nearest of [-1, 1].
            let z = sides.map(|(x, (l, u))| ((2.0 * x - l - u) / (u - l)).clamp(-1.0, 1.0));
            series.add(lanes, z, &mut add);
        }
        for sum in self.sums.iter() {
            let sides = x.iter().zip(self.lower.iter().zip(self.upper.iter()));
            // In a box that was checked; `clamp` would panic in one that was not.
            let nearest = sides.map(|(x, (l, u))| {
                if x < l {
                    *l
                } else if x > u {
                    *u
                } else {
                    *x
                }
            });
            sum.add(lanes, nearest, &mut add);
        }
        Ok(if self.inside(x) { Region::Inside } else { Region::Clamped })
    }

    /// Whether x is in the box, its sides counted. An x of another length is not.
    pub fn inside(&self, x: &[f64]) -> bool {
        let sides = self.lower.iter().zip(self.upper.iter());
        x.len() == self.shape.arguments && x.iter().zip(sides).all(|(x, (l, u))| l <= x && x <= u)
    }

    /// Numbers of arguments, coordinates and inputs.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// Lower ends l of the box.
    pub fn lower(&self) -> &[f64] {
        &self.lower
    }

    /// Upper ends u of the box.
    pub fn upper(&self) -> &[f64] {
        &self.upper
    }

    /// The series, where there is one.
    pub fn series(&self) -> Option<&Series<'a>> {
        self.series.as_ref()
    }

    /// The sums over landmarks.
    pub fn sums(&self) -> &[LandmarkSum<'a>] {
        &self.sums
    }

    /// Numbers that the tables hold: coefficients, and coordinates and weights of landmarks.
    pub fn numbers(&self) -> usize {
        let groups = self.series.iter().flat_map(|series| series.groups.iter());
        let coefficients: usize = groups.map(|group| group.coefficients.len()).sum();
        LANES * (coefficients + self.sums.iter().map(|sum| sum.tiles.len()).sum::<usize>())
    }
}

#[cfg(test)]
mod tests {
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
        let with = |upper: [f64; 3],
                    series: Option<Series<'static>>,
                    sums: Vec<LandmarkSum<'static>>| {
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
}
