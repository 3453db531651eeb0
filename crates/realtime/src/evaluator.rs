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
        let functions = shape.dimension.saturating_mul(shape.inputs.saturating_add(1));
        check_count("functions", usize::from(u16::MAX), functions)?;
        check_length("lower ends of the box", shape.arguments, lower.len())?;
        check_length("upper ends of the box", shape.arguments, upper.len())?;
        let sides = lower.iter().copied().zip(upper.iter().copied()).enumerate();
        for (argument, (lower, upper)) in sides {
            if !((upper - lower).is_finite() && lower < upper) {
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
mod tests;
