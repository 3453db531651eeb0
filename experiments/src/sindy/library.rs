//! The library of candidate functions.

use lacuna_occupation::TrajectoryData;
use nalgebra::DMatrix;

/// A candidate function of the state.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Term {
    /// The product of the listed coordinates; none for the constant 1.
    Monomial(Vec<usize>),
    /// The sine of a coordinate.
    Sine(usize),
    /// The cosine of a coordinate.
    Cosine(usize),
}

impl Term {
    fn value(&self, x: &[f64]) -> f64 {
        match self {
            Self::Monomial(factors) => factors.iter().map(|&i| x[i]).product(),
            Self::Sine(i) => x[*i].sin(),
            Self::Cosine(i) => x[*i].cos(),
        }
    }
}

/// Theta(x): all monomials of the coordinates up to a degree, then the sine and the cosine of each
/// coordinate, all on their natural scale.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Library {
    arguments: usize,
    terms: Vec<Term>,
}

impl Library {
    /// The library of `arguments` coordinates with monomials up to `degree`.
    pub fn new(arguments: usize, degree: usize) -> Self {
        let mut monomials = vec![Vec::new()];
        let mut highest = monomials.clone();
        for _ in 0..degree {
            highest = highest.iter().flat_map(|m| longer(m, arguments)).collect();
            monomials.extend_from_slice(&highest);
        }
        let monomials = monomials.into_iter().map(Term::Monomial);
        let trigonometric = (0..arguments).flat_map(|i| [Term::Sine(i), Term::Cosine(i)]);
        Self { arguments, terms: monomials.chain(trigonometric).collect() }
    }

    /// Number d of coordinates.
    pub fn arguments(&self) -> usize {
        self.arguments
    }

    /// Number of functions.
    pub fn size(&self) -> usize {
        self.terms.len()
    }

    /// The values of all functions at `x`.
    pub fn values(&self, x: &[f64]) -> impl Iterator<Item = f64> {
        self.terms.iter().map(|term| term.value(x))
    }

    /// A row of the control-affine regression: Theta(x), then Theta(x) u_j for each input.
    pub fn row(&self, x: &[f64], u: &[f64]) -> impl Iterator<Item = f64> {
        let factors = std::iter::once(1.0).chain(u.iter().copied());
        factors.flat_map(|factor| self.values(x).map(move |value| value * factor))
    }

    /// The rows of all samples of a recording.
    pub fn regressors(&self, recording: &TrajectoryData) -> DMatrix<f64> {
        let (d, m) = (recording.argument_count(), recording.input_count());
        let sample = |k: usize| {
            let x = &recording.arguments()[k * d..(k + 1) * d];
            self.row(x, &recording.inputs()[k * m..(k + 1) * m])
        };
        let rows = (0..recording.samples()).flat_map(sample);
        DMatrix::from_row_iterator(recording.samples(), self.size() * (1 + m), rows)
    }
}

/// The monomials of one degree more, with factors in increasing order so that none comes twice.
fn longer(monomial: &[usize], arguments: usize) -> impl Iterator<Item = Vec<usize>> {
    let last = monomial.last().copied().unwrap_or(0);
    (last..arguments).map(move |next| [monomial, &[next]].concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_coordinate_has_powers_and_trigonometric_functions() {
        let values: Vec<f64> = Library::new(1, 3).values(&[2.0]).collect();
        assert_eq!(values, [1.0, 2.0, 4.0, 8.0, 2.0_f64.sin(), 2.0_f64.cos()]);
    }

    /// (4 + 3 choose 3) monomials of four coordinates, each once.
    #[test]
    fn monomials_of_four_coordinates_are_complete() {
        let library = Library::new(4, 3);
        assert_eq!(library.size(), 35 + 8);
        // At primes, equal values would be equal monomials.
        let mut values: Vec<f64> = library.values(&[2.0, 3.0, 5.0, 7.0]).take(35).collect();
        values.sort_by(f64::total_cmp);
        assert!(values.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!(values[34], 343.0);
    }

    #[test]
    fn a_row_repeats_the_library_for_each_input() {
        let row: Vec<f64> = Library::new(1, 1).row(&[0.0], &[2.0, -1.0]).collect();
        assert_eq!(row, [1.0, 0.0, 0.0, 1.0, 2.0, 0.0, 0.0, 2.0, -1.0, -0.0, -0.0, -1.0]);
    }
}
