//! Where the plane of a diagram is in its drawing.

use super::limits::Limits;
use std::ops::Range;

/// Steps of a drawing's unit in which curves are written: coordinates stay whole numbers, which
/// are short, and a script can read values back to four digits.
pub(super) const FINE: f64 = 10.0;

/// The plane of a diagram: its edges in the drawing, and the ranges that it shows.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) left: i32,
    pub(super) top: i32,
    pub(super) right: i32,
    pub(super) bottom: i32,
    pub(super) xs: Range<f64>,
    pub(super) ys: Range<f64>,
}

impl Frame {
    pub(super) fn new(horizontal: Range<i32>, vertical: Range<i32>, (xs, ys): Limits) -> Self {
        Self {
            left: horizontal.start,
            top: vertical.start,
            right: horizontal.end,
            bottom: vertical.end,
            xs,
            ys,
        }
    }

    /// A point in fine steps from the upper left corner of the plane.
    pub(super) fn place(&self, (x, y): (f64, f64)) -> (i64, i64) {
        let across = |from: i32, to: i32| FINE * f64::from(to - from);
        let share = |v: f64, range: &Range<f64>| (v - range.start) / (range.end - range.start);
        let right = share(x, &self.xs) * across(self.left, self.right);
        let down = (1.0 - share(y, &self.ys)) * across(self.top, self.bottom);
        (right.round() as i64, down.round() as i64)
    }
}
