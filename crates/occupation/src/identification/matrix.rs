//! Small square matrices, row-major: Jacobians and transitions of states.

/// Writes the identity.
pub(super) fn identity(size: usize, matrix: &mut [f64]) {
    matrix.fill(0.0);
    matrix.iter_mut().step_by(size + 1).for_each(|entry| *entry = 1.0);
}

/// Writes a b.
#[inline]
pub(super) fn multiply(size: usize, a: &[f64], b: &[f64], product: &mut [f64]) {
    if size == 2 {
        // The compiler keeps these in registers.
        let (a, b) = ([a[0], a[1], a[2], a[3]], [b[0], b[1], b[2], b[3]]);
        product[0] = a[0] * b[0] + a[1] * b[2];
        product[1] = a[0] * b[1] + a[1] * b[3];
        product[2] = a[2] * b[0] + a[3] * b[2];
        product[3] = a[2] * b[1] + a[3] * b[3];
        return;
    }
    product.fill(0.0);
    for (row, product) in a.chunks_exact(size).zip(product.chunks_exact_mut(size)) {
        for (factor, right) in row.iter().zip(b.chunks_exact(size)) {
            product.iter_mut().zip(right).for_each(|(p, r)| *p += factor * r);
        }
    }
}

/// Square root of the sum of squares of the entries.
pub(super) fn norm(matrix: &[f64]) -> f64 {
    matrix.iter().map(|a| a * a).sum::<f64>().sqrt()
}

/// Room for [`Transition::over`].
#[derive(Debug)]
pub(super) struct Transition {
    size: usize,
    slope: Vec<f64>,
    stage: Vec<f64>,
}

impl Transition {
    pub fn new(size: usize) -> Self {
        Self { size, slope: vec![0.0; size * size], stage: vec![0.0; size * size] }
    }

    /// Writes the solution of Psi' = A Psi after h from 1, A given at the start, the middle and the end: the classical
    /// Runge-Kutta method.
    pub fn over(&mut self, [first, middle, last]: [&[f64]; 3], h: f64, result: &mut [f64]) {
        let size = self.size;
        identity(size, result);
        result.iter_mut().zip(first).for_each(|(r, a)| *r += h / 6.0 * a);
        self.slope.copy_from_slice(first);
        for (matrix, ahead, weight) in
            [(middle, 0.5 * h, h / 3.0), (middle, 0.5 * h, h / 3.0), (last, h, h / 6.0)]
        {
            identity(size, &mut self.stage);
            self.stage.iter_mut().zip(&self.slope).for_each(|(s, d)| *s += ahead * d);
            multiply(size, matrix, &self.stage, &mut self.slope);
            result.iter_mut().zip(&self.slope).for_each(|(r, d)| *r += weight * d);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Psi' = \[0 1; -1 0\] Psi is a rotation; sizes 2 and 3 go different ways.
    #[test]
    fn transitions_are_exponentials() {
        for size in [2, 3] {
            let mut a = vec![0.0; size * size];
            (a[1], a[size]) = (1.0, -1.0);
            let mut found = vec![0.0; size * size];
            Transition::new(size).over([&a, &a, &a], 0.1, &mut found);
            let (sine, cosine) = 0.1f64.sin_cos();
            for (at, expected) in [(0, cosine), (1, sine), (size, -sine), (size + 1, cosine)] {
                assert!((found[at] - expected).abs() < 1e-7, "{size} {at}");
            }
        }
    }
}
