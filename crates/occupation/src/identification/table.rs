//! A function of one argument as a table.
//!
//! Trajectories ask for f, g and their slopes hundreds of thousands of times, each a sum over all landmarks. A cubic
//! between the points of a table, with exact values and slopes there, is a few operations; it is made where its error is
//! far below what samples tell, and checked between the points.

/// Intervals of the first table that is tried, and of the last.
const INTERVALS: usize = 512;
const MOST_INTERVALS: usize = 2048;
/// Largest error, relative to the largest value.
const ERROR: f64 = 1e-9;
/// Every so many intervals are checked.
const CHECKED: usize = 5;

/// Values and slopes of a function on even points.
#[derive(Debug, Clone)]
pub(super) struct Table {
    low: f64,
    /// Points a unit.
    density: f64,
    /// Value, and slope times the step.
    points: Vec<[f64; 2]>,
}

impl Table {
    /// A table of a function and its slope on \[low, high\]; none where the function is too wild for it.
    pub fn of([low, high]: [f64; 2], function: impl Fn(f64) -> [f64; 2]) -> Option<Self> {
        let mut intervals = INTERVALS;
        while intervals <= MOST_INTERVALS {
            let step = (high - low) / intervals as f64;
            let point = |k: usize| {
                let [value, slope] = function(low + step * k as f64);
                [value, step * slope]
            };
            let points: Vec<[f64; 2]> = (0..=intervals).map(point).collect();
            let table = Self { low, density: 1.0 / step, points };
            let largest = table.points.iter().fold(0.0f64, |m, [value, _]| m.max(value.abs()));
            let off = |k: usize| {
                let x = low + step * (k as f64 + 0.5);
                table.at(x).map_or(f64::INFINITY, |[value, _]| (value - function(x)[0]).abs())
            };
            if (0..intervals).step_by(CHECKED).all(|k| off(k) <= ERROR * largest) {
                return Some(table);
            }
            intervals *= 2;
        }
        None
    }

    /// Value and slope at x; none beyond the ends.
    #[inline(always)]
    pub fn at(&self, x: f64) -> Option<[f64; 2]> {
        let place = (x - self.low) * self.density;
        // Also false for what is not a number.
        if !(place >= 0.0 && place < (self.points.len() - 1) as f64) {
            return None;
        }
        let k = place as usize;
        let s = place - k as f64;
        let [[a, p], [b, q]] = [self.points[k], self.points[k + 1]];
        let rise = b - a;
        let (left, right) = (p - rise, rise - q);
        // a + s rise + s (1 - s) ((1 - s) left + s right)
        let r = 1.0 - s;
        let inner = r * left + s * right;
        let value = a + s * (rise + r * inner);
        let slope = rise + (r - s) * inner + s * r * (right - left);
        Some([value, slope * self.density])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_the_function_and_knows_its_ends() {
        let table = Table::of([-3.0, 2.0], |x| [(2.0 * x).sin(), 2.0 * (2.0 * x).cos()]).unwrap();
        for k in 0..100 {
            let x = -2.999 + 0.049 * f64::from(k);
            let [value, slope] = table.at(x).unwrap();
            assert!((value - (2.0 * x).sin()).abs() < 2e-9, "{x}");
            assert!((slope - 2.0 * (2.0 * x).cos()).abs() < 1e-5, "{x}");
        }
        assert!(table.at(-3.001).is_none() && table.at(2.1).is_none());
        assert!(table.at(f64::NAN).is_none());
    }

    #[test]
    fn there_is_no_table_of_what_is_too_wild() {
        assert!(Table::of([0.0, 1.0], |x| [(5e3 * x).sin(), 5e3 * (5e3 * x).cos()]).is_none());
    }
}
