//! Kernel families with one width per dimension.

use serde::{Deserialize, Serialize};

use crate::kernel::{
    ExponentialDotProduct, Gaussian, KernelSpec, Matern, Polynomial, Profile, Smoothness,
};
use crate::pivoted::{Pivoted, Stop};
use crate::simd::slope_row;

/// A kernel of scaled arguments xi_i = (x_i - c_i) / w_i; the widths w are what is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// exp(-|xi - eta|^2 / 2): smooth functions.
    Gaussian,
    /// Matern 5/2 of |xi - eta|: functions with two derivatives.
    Matern,
    /// exp(xi . eta): power series, which grow with distance from the centre.
    Exponential,
    /// (1 + xi . eta)^degree: polynomials.
    Polynomial(u32),
}

impl Family {
    /// What the tool chooses from where nothing is given, simplest last.
    pub const ALL: [Self; 6] = [
        Self::Gaussian,
        Self::Matern,
        Self::Polynomial(3),
        Self::Polynomial(2),
        Self::Polynomial(1),
        Self::Polynomial(0),
    ];
    /// What users may ask for by name, and the families to choose from then; of polynomials the data choose the degree.
    pub const NAMED: [(&'static str, &'static [Self]); 4] = [
        ("gaussian", &[Self::Gaussian]),
        ("exponential", &[Self::Exponential]),
        ("matern", &[Self::Matern]),
        (
            "polynomial",
            &[Self::Polynomial(3), Self::Polynomial(2), Self::Polynomial(1), Self::Polynomial(0)],
        ),
    ];

    /// The families of a name; none where there is no such name.
    pub fn named(name: &str) -> Option<Vec<Self>> {
        let found = Self::NAMED.into_iter().find(|(known, _)| *known == name);
        found.map(|(_, families)| families.to_vec())
    }

    /// The kernel of scaled arguments.
    pub fn kernel(self) -> KernelSpec {
        match self {
            Self::Gaussian => Gaussian { widths: vec![1.0] }.into(),
            Self::Matern => Matern { smoothness: Smoothness::FiveHalves, widths: vec![1.0] }.into(),
            Self::Exponential => ExponentialDotProduct { mu: 1.0 }.into(),
            Self::Polynomial(degree) => Polynomial { degree, offset: 1.0, scale: 1.0 }.into(),
        }
    }

    /// Whether the functions are polynomials.
    pub(crate) fn is_polynomial(self) -> bool {
        self.degree().is_some()
    }

    /// Degree of the polynomials; none where the functions are no polynomials.
    pub(crate) fn degree(self) -> Option<u32> {
        match self {
            Self::Polynomial(degree) => Some(degree),
            _ => None,
        }
    }

    /// Whether K depends on xi - eta (else on xi . eta).
    pub(crate) fn is_radial(self) -> bool {
        matches!(self, Self::Gaussian | Self::Matern)
    }

    /// Slopes h with dK/dxi = h (xi - eta) for radial kernels and h eta for the others; points stored coordinate by
    /// coordinate as for [`crate::Kernel::evaluate_row`].
    pub(crate) fn slope_row(self, x: &[f64], points: &[f64], slopes: &mut [f64]) {
        let profile = match self {
            Self::Gaussian => Profile::Gaussian,
            Self::Matern => Profile::MaternFiveHalves,
            Self::Exponential => Profile::Exponential,
            Self::Polynomial(degree) => Profile::Power { degree, offset: 1.0 },
        };
        slope_row(profile, x, points, slopes);
    }
}

impl std::fmt::Display for Family {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Gaussian => write!(formatter, "Gaussian"),
            Self::Matern => write!(formatter, "Matern 5/2"),
            Self::Exponential => write!(formatter, "exponential dot product"),
            Self::Polynomial(degree) => write!(formatter, "polynomial of degree {degree}"),
        }
    }
}

/// A family with its centre c and widths w, in units of the arguments.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ScaledKernel {
    /// Which kernel of the scaled arguments.
    pub family: Family,
    /// c, one per dimension.
    pub centre: Vec<f64>,
    /// w > 0, one per dimension.
    pub widths: Vec<f64>,
}

impl ScaledKernel {
    /// xi = (x - c) / w.
    pub(crate) fn scale(&self, x: &[f64], scaled: &mut [f64]) {
        let entries = x.iter().zip(&self.centre).zip(&self.widths).zip(scaled);
        entries.for_each(|(((x, c), w), scaled)| *scaled = (x - c) / w);
    }

    /// Candidates (rows of d) in the order in which they represent the kernel: at most `most`, until the largest variance
    /// left is below `enough`, or lost in rounding.
    pub(crate) fn pivoted(&self, candidates: &[f64], enough: f64, most: usize) -> Pivoted {
        /// Variance that rounding leaves, relative to the largest.
        const ROUNDING: f64 = 1e-12;
        let stop = Stop { most, absolute: enough, relative: ROUNDING };
        let columns = self.scaled_columns(candidates);
        Pivoted::of(&self.family.kernel(), &columns, self.widths.len(), stop)
    }

    /// Scaled rows of points x (rows x d), coordinate by coordinate.
    pub(crate) fn scaled_columns(&self, rows: &[f64]) -> Vec<f64> {
        let d = self.widths.len();
        let of = |i: usize| {
            rows.iter().skip(i).step_by(d).map(move |x| (x - self.centre[i]) / self.widths[i])
        };
        (0..d).flat_map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::Kernel;

    #[test]
    fn slopes_are_the_derivatives_of_the_kernels() {
        let (x, p) = ([0.4, -0.7], [1.1, 0.2]);
        for family in Family::ALL {
            let kernel = family.kernel();
            let mut slope = [0.0];
            family.slope_row(&x, &p, &mut slope);
            for i in 0..2 {
                let direction = if family.is_radial() { x[i] - p[i] } else { p[i] };
                let shifted = |h: f64| {
                    let mut y = x;
                    y[i] += h;
                    kernel.evaluate(&y, &p)
                };
                let expected = (shifted(1e-5) - shifted(-1e-5)) / 2e-5;
                assert!((slope[0] * direction - expected).abs() < 1e-8, "{family}");
            }
        }
    }
}
