//! A compiled model as one source file without dependencies.
//!
//! Both languages have the same functions: `inside`, `evaluate` (f and g) and, for mechanisms with as many inputs as
//! coordinates, `mass_and_bias`:
//!
//! ```text
//! M = g_a^-1,   c = -g_a^-1 f_a,   u = M q'' + c
//! ```
//!
//! with the rows f_a and g_a that give accelerations: all of them for order 2, the lower half for order 1 with the
//! states (q, q'). Arguments outside the box are not extrapolated: values are those of the nearest point, and the
//! return value says so.

mod c;
mod header;
mod numbers;
mod rust;

use super::Compiled;

/// The language of a source file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    /// Rust, fit for `no_std`; all in safe code.
    Rust,
    /// C99; of the standard library nothing but `exp` and `sqrt`, and those only where the model needs them.
    C,
}

/// Largest relative difference between the upper rows of a first-order model and q' = q'.
const KINEMATIC: f64 = 0.05;

impl Compiled {
    /// One source file. In C, names begin with `prefix` and an underscore.
    pub fn source(&self, language: Language, prefix: &str) -> String {
        match language {
            Language::Rust => rust::source(self),
            Language::C => c::source(self, prefix),
        }
    }

    /// First of the rows that give accelerations, for a mechanism with as many inputs as coordinates; for others, why
    /// there is no mass matrix.
    ///
    /// # Errors
    /// Says what the model lacks, in words.
    pub fn acceleration_rows(&self) -> Result<usize, String> {
        let shape = self.evaluator.shape();
        let (n, m) = (shape.dimension, shape.inputs);
        let coordinates = match self.order {
            2 => n,
            1 if n % 2 == 0 && shape.arguments == n => n / 2,
            order => {
                return Err(format!(
                    "a model of order {order} with {n} states has no accelerations"
                ));
            }
        };
        if coordinates != m {
            return Err(format!("{coordinates} coordinates and {m} inputs: g has no inverse"));
        }
        if self.order == 2 {
            return Ok(0);
        }
        self.check_kinematics(coordinates)?;
        Ok(coordinates)
    }

    /// Whether the upper rows say q' = q', on the corners of half the box.
    fn check_kinematics(&self, p: usize) -> Result<(), String> {
        let names = self.names();
        if names.is_some_and(|names| names.arguments != names.coordinates) {
            return Err("the arguments are not the states in their order".to_owned());
        }
        let (lower, upper) = (self.evaluator.lower(), self.evaluator.upper());
        let (mut f, mut g) = (vec![0.0; 2 * p], vec![0.0; 2 * p * p]);
        let (mut off, mut largest) = (vec![0.0_f64; p], vec![0.0_f64; p]);
        let (mut effect, mut total) = (0.0_f64, 0.0_f64);
        for corner in 0..1_usize << (2 * p).min(12) {
            let x: Vec<f64> = (0..2 * p)
                .map(|i| {
                    let part = if corner >> i & 1 == 1 { 0.75 } else { 0.25 };
                    lower[i] + part * (upper[i] - lower[i])
                })
                .collect();
            let _inside =
                self.evaluator.evaluate(&x, &mut f, &mut g).map_err(|error| error.to_string())?;
            for i in 0..p {
                off[i] = off[i].max((f[i] - x[p + i]).abs());
                largest[i] = largest[i].max(x[p + i].abs());
            }
            let greatest = |some: &[f64]| some.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            effect = effect.max(greatest(&g[..p * p]));
            total = total.max(greatest(&g[p * p..]));
        }
        let kinematic = off.iter().zip(&largest).all(|(off, largest)| *off <= KINEMATIC * largest);
        if kinematic && effect <= KINEMATIC * total {
            return Ok(());
        }
        Err(format!(
            "the first {p} rows do not say q' = q' (within {} %): the states are not positions and their rates",
            100.0 * KINEMATIC
        ))
    }
}
