//! Products of symbols, whether or not these are known units.

use crate::UnitError;
use crate::dimension::SAME_EXPONENT;
use crate::parse::Parser;
use std::fmt;

/// A product of powers of symbols, in the order in which they were written: `kg mm/s^2`.
///
/// Its symbols need not be units that this crate knows (`count/s`): they multiply and cancel all
/// the same. Two products are equal where they hold the same powers, in any order.
#[derive(Clone, Debug)]
pub struct Product(Vec<(String, f64)>);

impl Product {
    /// A pure number, `1`.
    pub const ONE: Self = Self(vec![]);

    /// Reads a product; an empty text is 1.
    ///
    /// # Errors
    /// [`UnitError`]: wrong or ambiguous grammar.
    pub fn parse(text: &str) -> Result<Self, UnitError> {
        let text = text.trim();
        if text.is_empty() { Ok(Self::ONE) } else { Parser::read(text) }
    }

    /// One symbol, taken as it stands.
    #[must_use]
    pub fn symbol(symbol: &str) -> Self {
        Self(vec![(symbol.to_owned(), 1.0)])
    }

    /// `self * other^power`; what stands above and below the line cancels.
    #[must_use]
    pub fn times(mut self, other: &Self, power: f64) -> Self {
        for (symbol, exponent) in &other.0 {
            match self.0.iter_mut().find(|(known, _)| known == symbol) {
                Some((_, total)) => *total += exponent * power,
                None => self.0.push((symbol.clone(), exponent * power)),
            }
        }
        self.0.retain(|(_, power)| power.is_nan() || power.abs() >= SAME_EXPONENT);
        self
    }

    /// Its symbols with their powers.
    pub fn powers(&self) -> impl Iterator<Item = (&str, f64)> {
        self.0.iter().map(|(symbol, power)| (symbol.as_str(), *power))
    }
}

impl PartialEq for Product {
    fn eq(&self, other: &Self) -> bool {
        self.clone().times(other, -1.0).0.is_empty()
    }
}

impl fmt::Display for Product {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let side = |sign: f64| -> Vec<String> {
            let here = self.powers().filter(|(_, power)| power * sign > 0.0);
            here.map(|(symbol, power)| match (power.abs() * 1e9).round() / 1e9 {
                1.0 => symbol.to_owned(),
                power => format!("{symbol}^{power}"),
            })
            .collect()
        };
        let (above, below) = (side(1.0), side(-1.0));
        let top = if above.is_empty() { "1".to_owned() } else { above.join(" ") };
        match below.as_slice() {
            [] => f.write_str(&top),
            [one] => write!(f, "{top}/{one}"),
            several => write!(f, "{top}/({})", several.join(" ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Product;
    use crate::Unit;

    fn product(text: &str) -> Product {
        Product::parse(text).unwrap()
    }

    #[test]
    fn products_read_as_an_engineer_writes_them() {
        for (text, expected) in [
            ("N*m*s", "N m s"),
            ("kg m^2 s^-2", "kg m^2/s^2"),
            ("s^-1", "1/s"),
            ("m/s/s", "m/s^2"),
            ("1", "1"),
            ("", "1"),
            ("(count/s)^2", "count^2/s^2"),
            ("10 mV/(s K)", "10 mV/(s K)"),
            ("V^0.5/s", "V^0.5/s"),
        ] {
            assert_eq!(product(text).to_string(), expected, "{text}");
            assert_eq!(product(expected), product(text), "{text}");
        }
    }

    #[test]
    fn what_is_above_and_below_the_line_cancels() {
        let damping = product("N*m").times(&product("rad/s"), -1.0);
        assert_eq!(damping.to_string(), "N m s/rad");
        assert_eq!(damping.times(&product("rad/s"), 1.0), product("m N"));
        assert_eq!(product("kg mm/s^2").times(&product("mm"), -1.0).to_string(), "kg/s^2");
    }

    #[test]
    fn a_product_of_known_units_is_a_unit() {
        let text = product("N*m").times(&product("deg/s"), -1.0).to_string();
        assert!(Unit::parse(&text).is_ok(), "{text}");
    }
}
