//! Small square matrices: Jacobians and transitions of states.

/// A small square matrix.
#[derive(Debug, Clone)]
pub(crate) struct Matrix {
    size: usize,
    /// Row-major.
    pub entries: Vec<f64>,
}

impl Matrix {
    pub fn zeros(size: usize) -> Self {
        Self { size, entries: vec![0.0; size * size] }
    }

    pub fn identity(size: usize) -> Self {
        let mut matrix = Self::zeros(size);
        (0..size).for_each(|i| matrix.set(i, i, 1.0));
        matrix
    }

    pub fn get(&self, i: usize, j: usize) -> f64 {
        self.entries[i * self.size + j]
    }

    pub fn set(&mut self, i: usize, j: usize, value: f64) {
        self.entries[i * self.size + j] = value;
    }

    pub fn times(&self, other: &Self) -> Self {
        let mut product = Self::zeros(self.size);
        for i in 0..self.size {
            for k in 0..self.size {
                let factor = self.get(i, k);
                let (row, right) = (i * self.size, k * self.size);
                for j in 0..self.size {
                    product.entries[row + j] += factor * other.entries[right + j];
                }
            }
        }
        product
    }

    pub fn plus(&self, other: &Self, factor: f64) -> Self {
        let entries = self.entries.iter().zip(&other.entries);
        Self { size: self.size, entries: entries.map(|(a, b)| a + factor * b).collect() }
    }

    pub fn scaled(&self, factor: f64) -> Self {
        Self { size: self.size, entries: self.entries.iter().map(|a| factor * a).collect() }
    }

    pub fn norm(&self) -> f64 {
        self.entries.iter().map(|a| a * a).sum::<f64>().sqrt()
    }
}

/// Solution of Psi' = A Psi after h from 1, A given at the start, the middle and the end: the classical Runge-Kutta method.
pub(super) fn transition(first: &Matrix, middle: &Matrix, last: &Matrix, h: f64) -> Matrix {
    let one = Matrix::identity(first.size);
    let a = first.clone();
    let b = middle.times(&one.plus(&a, 0.5 * h));
    let c = middle.times(&one.plus(&b, 0.5 * h));
    let d = last.times(&one.plus(&c, h));
    one.plus(&a, h / 6.0).plus(&b, h / 3.0).plus(&c, h / 3.0).plus(&d, h / 6.0)
}
