//! Exponents of the base units.

use std::fmt;

/// Number of exponents: five base units, angle, cycle.
pub(crate) const KINDS: usize = 7;
const ANGLE: usize = 5;
const CYCLE: usize = 6;
/// Symbols of the base units, in the order of the exponents.
const BASE: [&str; KINDS] = ["m", "kg", "s", "A", "K", "rad", "cycle"];
/// Exponents that differ by less are equal (they may be sums of fractions).
pub(crate) const SAME_EXPONENT: f64 = 1e-9;

/// Exponents of m, kg, s, A, K, and of angle (rad) and cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dimension(pub(crate) [f64; KINDS]);

impl Dimension {
    pub(crate) const NONE: Self = Self([0.0; KINDS]);

    pub(crate) fn plus(mut self, other: Self, times: f64) -> Self {
        for (mine, other) in self.0.iter_mut().zip(other.0) {
            *mine += times * other;
        }
        self
    }

    /// Whether values can be converted, and if so, how many cycles become angles.
    pub(crate) fn cycles_to(&self, other: &Self) -> Option<f64> {
        let excess = |kind: usize| self.0[kind] - other.0[kind];
        let same = (0..ANGLE).all(|kind| excess(kind).abs() < SAME_EXPONENT);
        let turned = (excess(CYCLE) + excess(ANGLE)).abs() < SAME_EXPONENT;
        same.then(|| if turned { excess(CYCLE) } else { 0.0 })
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let present = BASE.iter().zip(self.0).filter(|(_, n)| n.abs() >= SAME_EXPONENT);
        let parts: Vec<String> = present
            .map(|(base, exponent)| match exponent {
                1.0 => (*base).to_owned(),
                // Sums of fractions carry rounding errors that nobody wants to read.
                other => format!("{base}^{}", (other * 1e9).round() / 1e9),
            })
            .collect();
        f.write_str(if parts.is_empty() { "dimensionless" } else { "" })?;
        f.write_str(&parts.join(" "))
    }
}
