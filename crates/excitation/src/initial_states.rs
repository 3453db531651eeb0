//! Initial states that cover a region of the state space.

use thiserror::Error;

/// Bases of the Halton sequence: one prime a dimension.
const PRIMES: [u8; 20] =
    [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71];

/// Why no initial states could be laid out.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum InitialStateError {
    /// The Halton sequence covers high dimensions badly, so they are refused.
    #[error("Halton points have at most {most} dimensions, {found} were asked for")]
    TooManyDimensions {
        /// Greatest number of dimensions.
        most: usize,
        /// The number asked for.
        found: usize,
    },
    /// A region has a size that is negative or not finite.
    #[error("a region from {from} to {to} is not a finite, increasing interval")]
    BadRegion {
        /// Lower end.
        from: f64,
        /// Upper end.
        to: f64,
    },
}

/// The first `count` points of the Halton sequence on the cube of side `side` centred at
/// `centre`: `x_i = c_i - side/2 + side * h_i`, one row a point.
///
/// The sequence is unscrambled and begins with its point 0, the corner
/// `c - side/2`; the next one is `(1/2, 1/3, 1/5, ...)` of the side. Source: Halton (1960);
/// the beginning at 0 is that of the paper's data.
///
/// # Errors
/// [`InitialStateError`] for more than 20 dimensions or a cube that is not finite.
pub fn halton_cube(
    count: usize,
    side: f64,
    centre: &[f64],
) -> Result<Vec<Vec<f64>>, InitialStateError> {
    if centre.len() > PRIMES.len() {
        return Err(InitialStateError::TooManyDimensions {
            most: PRIMES.len(),
            found: centre.len(),
        });
    }
    for c in centre {
        check(c - 0.5 * side, c + 0.5 * side)?;
    }
    let entry = |k, (c, &base): (&f64, &u8)| c + side * (halton::number(base, k) - 0.5);
    let point = |k| centre.iter().zip(&PRIMES).map(|pair| entry(k, pair)).collect();
    Ok((0..count).map(point).collect())
}

/// Equally spaced values on `[from, to]`, both ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// First value.
    pub from: f64,
    /// Last value.
    pub to: f64,
    /// Number of values; a single one is `from`.
    pub count: usize,
}

impl Axis {
    /// The values of the axis.
    pub fn values(&self) -> Vec<f64> {
        let step = (self.to - self.from) / self.count.saturating_sub(1).max(1) as f64;
        (0..self.count).map(|k| self.from + step * k as f64).collect()
    }
}

/// All combinations of the axes' values, the last axis varying fastest, one row a point.
///
/// # Errors
/// [`InitialStateError::BadRegion`] when an axis is reversed or not finite.
pub fn grid(axes: &[Axis]) -> Result<Vec<Vec<f64>>, InitialStateError> {
    let mut points = vec![Vec::with_capacity(axes.len())];
    for axis in axes {
        check(axis.from, axis.to)?;
        let values = axis.values();
        points = points
            .iter()
            .flat_map(|point| values.iter().map(|v| [point.as_slice(), &[*v]].concat()))
            .collect();
    }
    Ok(points)
}

fn check(from: f64, to: f64) -> Result<(), InitialStateError> {
    match from <= to && (to - from).is_finite() {
        true => Ok(()),
        false => Err(InitialStateError::BadRegion { from, to }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first points of the paper's manipulator data, from their bases 2, 3, 5, 7.
    #[test]
    fn halton_begins_at_the_corner() {
        let points = halton_cube(4, 6.0, &[0.0; 4]).unwrap();
        let expected = [
            [-3.0, -3.0, -3.0, -3.0],
            [0.0, -1.0, -1.8, -3.0 + 6.0 / 7.0],
            [-1.5, 1.0, -0.6, -3.0 + 12.0 / 7.0],
            [1.5, -3.0 + 6.0 / 9.0, 0.6, -3.0 + 18.0 / 7.0],
        ];
        for (point, row) in points.iter().zip(expected) {
            for (a, b) in point.iter().zip(row) {
                assert!((a - b).abs() < 1e-12, "{points:?}");
            }
        }
    }

    #[test]
    fn halton_points_are_spread_evenly() {
        let points = halton_cube(1024, 2.0, &[1.0, -1.0]).unwrap();
        // A quarter of the cube holds a quarter of the points, to within the discrepancy.
        let inside = points.iter().filter(|p| p[0] < 1.0 && p[1] < -1.0).count();
        assert!(inside.abs_diff(256) <= 4, "{inside}");
        assert!(points.iter().all(|p| (0.0..=2.0).contains(&p[0]) && (-2.0..=0.0).contains(&p[1])));
    }

    #[test]
    fn a_grid_holds_every_combination() {
        let axis = |count| Axis { from: -3.0, to: 3.0, count };
        let points = grid(&[axis(3), axis(2)]).unwrap();
        let expected: [[f64; 2]; 6] =
            [[-3.0, -3.0], [-3.0, 3.0], [0.0, -3.0], [0.0, 3.0], [3.0, -3.0], [3.0, 3.0]];
        assert_eq!(points, expected.map(|p| p.to_vec()));
        assert_eq!(grid(&[axis(13), axis(13)]).unwrap().len(), 169);
        assert_eq!(axis(1).values(), [-3.0]);
    }

    #[test]
    fn impossible_regions_are_errors() {
        assert!(matches!(
            halton_cube(1, 1.0, &[0.0; 21]),
            Err(InitialStateError::TooManyDimensions { most: 20, found: 21 })
        ));
        assert!(halton_cube(1, -1.0, &[0.0]).is_err());
        assert_eq!(
            grid(&[Axis { from: 1.0, to: 0.0, count: 2 }]),
            Err(InitialStateError::BadRegion { from: 1.0, to: 0.0 })
        );
    }
}
