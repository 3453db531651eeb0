//! Initial values reflected out of the measurements.

/// Orthogonal reflections after which the first entries hold all that initial values do.
#[derive(Debug, Clone)]
pub(crate) struct Reduction {
    /// Unit vectors v of H = I - 2 v v^T; the j-th begins at entry j.
    reflections: Vec<Vec<f64>>,
}

impl Reduction {
    /// Reflections for columns that initial values span; columns that add nothing are left out.
    pub fn of(columns: impl Iterator<Item = Vec<f64>>) -> Self {
        let mut reduction = Self { reflections: Vec::new() };
        for mut column in columns {
            let before = norm(&column);
            reduction.reflect(&mut column);
            let first = reduction.reflections.len();
            let mut v = column.split_off(first.min(column.len()));
            let length = norm(&v);
            if length <= 1e-10 * before || length == 0.0 {
                continue;
            }
            v[0] += length.copysign(v[0]);
            let size = norm(&v);
            v.iter_mut().for_each(|entry| *entry /= size);
            reduction.reflections.push(v);
        }
        reduction
    }

    /// Unit vectors v of H = I - 2 v v^T, the j-th for entries j and on.
    pub fn vectors(&self) -> impl Iterator<Item = &[f64]> {
        self.reflections.iter().map(Vec::as_slice)
    }

    /// Number of equations that are lost.
    pub fn lost(&self) -> usize {
        self.reflections.len()
    }

    /// What is left of measurements without initial values: all entries but the first `lost()`, afterwards.
    pub fn reflect(&self, values: &mut [f64]) {
        for (first, v) in self.reflections.iter().enumerate() {
            let values = &mut values[first..];
            let share: f64 = v.iter().zip(values.iter()).map(|(v, x)| v * x).sum();
            values.iter_mut().zip(v).for_each(|(x, v)| *x -= 2.0 * share * v);
        }
    }
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_initial_values_do_is_lost_and_lengths_stay() {
        let line: Vec<f64> = (0..7).map(f64::from).collect();
        let columns = [vec![1.0; 7], line.clone(), line.iter().map(|t| 3.0 - t).collect()];
        let reduction = Reduction::of(columns.iter().cloned());
        assert_eq!(reduction.lost(), 2, "the third is a sum of the others");
        for mut column in columns {
            reduction.reflect(&mut column);
            assert!(column[2..].iter().all(|v| v.abs() < 1e-12), "{column:?}");
        }
        let mut curved: Vec<f64> = line.iter().map(|t| t * t).collect();
        let before = norm(&curved);
        reduction.reflect(&mut curved);
        assert!((norm(&curved) - before).abs() < 1e-12 * before);
        assert!(norm(&curved[2..]) > 0.1 * before);
    }
}
