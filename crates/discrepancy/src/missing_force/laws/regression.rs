//! A linear regression of whitened rows, and what further columns would add to it.
//!
//! With columns C in units of their priors and the right-hand side y, all channels below each other,
//!
//! ```text
//! log Z = |z|^2 / 2 - log det L,   L L^T = I + C^T C,   z = L^-1 C^T y
//! ```
//!
//! and further columns D add, without another factorisation of what is there,
//!
//! ```text
//! log Z' - log Z = r^T S^-1 r / 2 - log det S / 2
//! X = L^-1 C^T D,   S = I + D^T D - X^T X,   r = D^T y - X^T z
//! ```

use super::super::columns::Column;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// The regression on some columns.
pub(super) struct Regression {
    /// Of each channel its rows (none where nothing tells it), one column each.
    design: Vec<Mat<f64>>,
    /// y, channel by channel.
    right: Vec<Vec<f64>>,
    factor: Cholesky<f64, Dyn>,
    /// z.
    whitened: DVector<f64>,
    /// log Z.
    pub evidence: f64,
}

/// What further columns add.
pub(super) struct Added {
    /// Nats.
    pub gain: f64,
    /// Their coefficients in units of their priors.
    pub coefficients: DVector<f64>,
}

impl Regression {
    /// On these columns, with the right-hand side of every channel; none where a number is not finite.
    pub fn of(columns: &[&Column], right: Vec<Vec<f64>>) -> Option<Self> {
        let count = columns.len();
        let design: Vec<Mat<f64>> = right
            .iter()
            .enumerate()
            .map(|(c, right)| {
                let own: Vec<Option<&[f64]>> = columns.iter().map(|col| on(col, c)).collect();
                side_by_side(right.len(), &own)
            })
            .collect();
        let mut normal = Mat::zeros(count, count);
        for design in &design {
            matmul(&mut normal, Accum::Add, design.transpose(), design, 1.0, Par::Seq);
        }
        let unit = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        let normal = DMatrix::from_fn(count, count, |i, j| normal[(i, j)] + unit(i, j));
        let factor = normal.cholesky()?;
        let moment = DVector::from_fn(count, |j, _| with_right(columns[j], &right));
        let mut whitened = moment;
        factor.l_dirty().solve_lower_triangular_mut(&mut whitened).then_some(())?;
        let evidence = 0.5 * whitened.norm_squared() - log_determinant(&factor);
        Some(Self { design, right, factor, whitened, evidence })
    }

    /// The coefficients, in units of the columns' priors.
    pub fn coefficients(&self) -> DVector<f64> {
        let mut mean = self.whitened.clone();
        // Of a factor without a zero on its diagonal.
        let _ = self.factor.l_dirty().tr_solve_lower_triangular_mut(&mut mean);
        mean
    }

    /// What each of several sets of columns adds; none where they are singular.
    pub fn adding(&self, sets: &[Vec<Column>]) -> Vec<Option<Added>> {
        let all: Vec<&Column> = sets.iter().flatten().collect();
        let along = self.along(&all);
        let mut first = 0;
        let added = sets.iter().map(|set| {
            let along = along.columns(first, set.len());
            first += set.len();
            let schur = DMatrix::from_fn(set.len(), set.len(), |i, j| {
                let unit = if i == j { 1.0 } else { 0.0 };
                unit + product(&set[i], &set[j]) - along.column(i).dot(&along.column(j))
            });
            let left = DVector::from_fn(set.len(), |i, _| {
                with_right(&set[i], &self.right) - along.column(i).dot(&self.whitened)
            });
            let factor = schur.cholesky()?;
            let coefficients = factor.solve(&left);
            let gain = 0.5 * coefficients.dot(&left) - log_determinant(&factor);
            Some(Added { gain, coefficients })
        });
        added.collect()
    }

    /// X of some columns.
    fn along(&self, columns: &[&Column]) -> DMatrix<f64> {
        let mut cross = DMatrix::zeros(self.whitened.len(), columns.len());
        for (c, design) in self.design.iter().enumerate() {
            let here = columns.iter().enumerate().filter_map(|(k, col)| Some((k, on(col, c)?)));
            let (numbers, own): (Vec<usize>, Vec<_>) = here.map(|(k, e)| (k, Some(e))).unzip();
            if numbers.is_empty() {
                continue;
            }
            let own = side_by_side(design.nrows(), &own);
            let mut products = Mat::zeros(design.ncols(), numbers.len());
            matmul(&mut products, Accum::Replace, design.transpose(), &own, 1.0, Par::Seq);
            for (at, k) in numbers.into_iter().enumerate() {
                for (sum, x) in cross.column_mut(k).iter_mut().zip(products.col_as_slice(at)) {
                    *sum += x;
                }
            }
        }
        // As above.
        let _ = self.factor.l_dirty().solve_lower_triangular_mut(&mut cross);
        cross
    }
}

/// The entries of a column on a channel, if it acts there.
fn on(column: &Column, c: usize) -> Option<&[f64]> {
    column.iter().find(|(d, _)| *d == c).map(|(_, entries)| &entries[..])
}

/// Columns of so many entries; those that are none are zero.
fn side_by_side(rows: usize, columns: &[Option<&[f64]>]) -> Mat<f64> {
    let mut all = Mat::zeros(rows, columns.len());
    for (j, column) in columns.iter().enumerate() {
        if let Some(column) = column {
            all.col_as_slice_mut(j).copy_from_slice(column);
        }
    }
    all
}

fn product(a: &Column, b: &Column) -> f64 {
    a.iter().filter_map(|(c, x)| Some(dot(x, on(b, *c)?))).sum()
}

fn with_right(a: &Column, right: &[Vec<f64>]) -> f64 {
    a.iter().map(|(c, x)| dot(x, &right[*c])).sum()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    use nalgebra::DVectorView;
    DVectorView::from_slice(a, a.len()).dot(&DVectorView::from_slice(b, b.len()))
}

/// log det L.
fn log_determinant(factor: &Cholesky<f64, Dyn>) -> f64 {
    factor.l_dirty().diagonal().map(f64::ln).sum()
}

#[cfg(test)]
mod tests {
    use super::{Column, Regression};
    use lacuna_excitation::rng;
    use rand::RngExt;

    /// Of two channels of 30 and 20 rows.
    fn drawn(seed: u64, channels: &[usize]) -> Column {
        let mut rng = rng(seed, 0);
        let rows = |c: usize| [30, 20][c];
        let of = |&c: &usize| (c, (0..rows(c)).map(|_| rng.random_range(-1.0..1.0)).collect());
        channels.iter().map(of).collect()
    }

    /// Columns that are added gain what the regression on all of them has more evidence by, and have the coefficients
    /// that they have there.
    #[test]
    fn what_columns_add_is_what_they_are_worth_among_all() {
        let known = [drawn(1, &[0, 1]), drawn(2, &[1]), drawn(3, &[0])];
        let right: Vec<Vec<f64>> = drawn(4, &[0, 1]).into_iter().map(|(_, y)| y).collect();
        let base: Vec<&Column> = known.iter().collect();
        let regression = Regression::of(&base, right.clone()).expect("regular");
        let sets = [vec![drawn(5, &[0])], vec![drawn(6, &[1]), drawn(7, &[0, 1])], vec![]];
        let added = regression.adding(&sets);
        for (set, added) in sets.iter().zip(added) {
            let added = added.expect("regular");
            let all: Vec<&Column> = known.iter().chain(set).collect();
            let whole = Regression::of(&all, right.clone()).expect("regular");
            assert!((added.gain - (whole.evidence - regression.evidence)).abs() < 1e-10);
            let coefficients = whole.coefficients();
            let own = coefficients.rows(known.len(), set.len());
            assert!((added.coefficients - own).amax() < 1e-10);
        }
    }

    /// The coefficients solve the normal equations, written out.
    #[test]
    fn coefficients_solve_the_normal_equations() {
        let columns = [drawn(1, &[0, 1]), drawn(2, &[1])];
        let right: Vec<Vec<f64>> = drawn(3, &[0, 1]).into_iter().map(|(_, y)| y).collect();
        let all: Vec<&Column> = columns.iter().collect();
        let z = Regression::of(&all, right.clone()).expect("regular").coefficients();
        for own in &columns {
            let mut left = 0.0;
            for (c, x) in own {
                for (k, x) in x.iter().enumerate() {
                    let of = |(column, z): (&Column, &f64)| {
                        let here = column.iter().find(|(d, _)| d == c);
                        here.map_or(0.0, |(_, entries)| z * entries[k])
                    };
                    let fitted: f64 = columns.iter().zip(z.iter()).map(of).sum();
                    left += x * (right[*c][k] - fitted);
                }
            }
            let at = columns.iter().position(|c| c == own).expect("one of them");
            assert!((left - z[at]).abs() < 1e-10, "{left} {z}");
        }
    }
}
