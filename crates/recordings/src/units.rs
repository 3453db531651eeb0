//! Units read at run time: `N m s/rad`, `kg m^2`, `mm/s`, `degC`.
//!
//! A unit is a vector of exponents of the base units and a factor (for a temperature
//! scale also an offset):
//!
//! ```text
//! value in base units = factor * value + offset
//! ```
//!
//! | on paper | in code |
//! | --- | --- |
//! | exponents of m, kg, s, A, K | [`Dimension`], also of angle and cycle |
//! | factor, offset | in [`Unit`], 0.001 for mm; 273.15 for degC |
//!
//! **Angles.** rad is 1: `N m/rad` fits `N m`, and `rad/s` fits `1/s`. deg, rev and rpm are
//! multiples of rad. The exponent of the angle is remembered all the same, for one purpose:
//! Hz counts cycles, so Hz turns into rad/s (or rpm, deg/s) with 2 pi, but into 1/s with 1.
//!
//! **Grammar.** Factors are joined by a space, `*` or a middle dot, `/` divides by the next
//! factor only, `^` raises to a power that may be negative or a fraction (`m^2.5/s`),
//! parentheses group: `m^3/(s V)`. `s2` and `s²` mean `s^2`. A space after a division
//! (`N/m s`) is refused, as half of its readers would read it the other way.

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use crate::error::{did_you_mean, nearest};

/// Number of exponents: five base units, angle, cycle.
const KINDS: usize = 7;
const ANGLE: usize = 5;
const CYCLE: usize = 6;
/// Symbols of the base units, in the order of the exponents.
const BASE: [&str; KINDS] = ["m", "kg", "s", "A", "K", "rad", "cycle"];
/// Exponents that differ by less are equal (they may be sums of fractions).
const SAME_EXPONENT: f64 = 1e-9;
/// Parentheses may be nested this deep.
const DEEPEST: usize = 16;

/// Exponents of m, kg, s, A, K, and of angle (rad) and cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dimension([f64; KINDS]);

/// A unit of measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    text: String,
    dimension: Dimension,
    factor: f64,
    offset: f64,
}

/// A text that is no unit, or two units that do not fit.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum UnitError {
    /// Nothing is written.
    #[error("expected a unit, found an empty text; a plain number has the unit '1'")]
    Empty,
    /// A name that is not in the table, with or without a prefix.
    #[error("unit '{text}': '{name}' is not a known unit{}", did_you_mean(suggestion))]
    Unknown {
        /// The whole text.
        text: String,
        /// The name.
        name: String,
        /// The nearest known one, where one is near.
        suggestion: Option<String>,
    },
    /// Something else than the grammar allows.
    #[error("unit '{text}', character {position}: expected {expected}, found {found}")]
    Syntax {
        /// The whole text.
        text: String,
        /// Place in the text, in characters from 1.
        position: usize,
        /// What may stand there.
        expected: &'static str,
        /// What stands there.
        found: String,
    },
    /// A product by a space after a division.
    #[error(
        "unit '{text}' can be read in two ways; write a/(b c) or a c/b with parentheses where \
         several units divide"
    )]
    Ambiguous {
        /// The whole text.
        text: String,
    },
    /// The two units measure different things.
    #[error("cannot convert '{from}' ({from_dimension}) to '{to}' ({to_dimension})")]
    Incompatible {
        /// Unit of the values.
        from: String,
        /// Its dimension.
        from_dimension: Box<Dimension>,
        /// Unit wanted.
        to: String,
        /// Its dimension.
        to_dimension: Box<Dimension>,
    },
    /// A factor alone cannot convert between temperature scales with different zeros.
    #[error("'{from}' and '{to}' have different zeros: no factor alone converts them")]
    Offset {
        /// Unit of the values.
        from: String,
        /// Unit wanted.
        to: String,
    },
}

impl Unit {
    /// Reads a unit.
    ///
    /// An offset (degC, degF) counts only where the unit stands alone: `W/degC` is `W/K`.
    ///
    /// # Errors
    /// [`UnitError`]: empty text, unknown name, wrong or ambiguous grammar.
    pub fn parse(text: &str) -> Result<Self, UnitError> {
        let text = text.trim();
        if text.is_empty() {
            return Err(UnitError::Empty);
        }
        if let Some(scale) = SCALES.iter().find(|scale| scale.0.contains(&text)) {
            let dimension = Dimension(KELVIN);
            return Ok(Self { text: text.into(), dimension, factor: scale.1, offset: scale.2 });
        }
        let mut parser = Parser { text, rest: text, depth: 0 };
        let Scaled { dimension, factor } = parser.product()?;
        if !parser.rest.is_empty() {
            return Err(parser.syntax("a unit, '*', '/' or '^'"));
        }
        if !(factor.is_normal() && dimension.0.iter().all(|exponent| exponent.is_finite())) {
            return Err(parser.syntax("a unit within the range of numbers"));
        }
        Ok(Self { text: text.into(), dimension, factor, offset: 0.0 })
    }

    /// Its exponents.
    pub fn dimension(&self) -> Dimension {
        self.dimension
    }

    /// The size of a full turn in this unit, where it is one of angles: 2 pi for rad, 360 for deg.
    pub fn turn(&self) -> Option<f64> {
        (self.dimension == Dimension(RADIAN)).then(|| 2.0 * PI / self.factor)
    }

    /// Factor and offset that turn values of `self` into values of `other`.
    fn affine_to(&self, other: &Unit) -> Result<(f64, f64), UnitError> {
        let turns =
            self.dimension.cycles_to(&other.dimension).ok_or_else(|| UnitError::Incompatible {
                from: self.text.clone(),
                from_dimension: Box::new(self.dimension),
                to: other.text.clone(),
                to_dimension: Box::new(other.dimension),
            })?;
        let factor = self.factor / other.factor * (2.0 * PI).powf(turns);
        Ok((factor, (self.offset - other.offset) / other.factor))
    }
}

impl FromStr for Unit {
    type Err = UnitError;

    fn from_str(text: &str) -> Result<Self, UnitError> {
        Self::parse(text)
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// The number of `to` in one `from`.
///
/// # Errors
/// [`UnitError::Incompatible`] names both units and dimensions; [`UnitError::Offset`] where
/// the zeros differ.
pub fn convert_factor(from: &Unit, to: &Unit) -> Result<f64, UnitError> {
    let (factor, offset) = from.affine_to(to)?;
    if offset != 0.0 {
        return Err(UnitError::Offset { from: from.text.clone(), to: to.text.clone() });
    }
    Ok(factor)
}

/// `values` in `from`, in `to`: affine where temperature scales need it; NaN stays NaN.
///
/// # Errors
/// [`UnitError::Incompatible`] names both units and dimensions.
pub fn convert(values: &[f64], from: &Unit, to: &Unit) -> Result<Vec<f64>, UnitError> {
    let (factor, offset) = from.affine_to(to)?;
    Ok(values.iter().map(|value| factor * value + offset).collect())
}

impl Dimension {
    const NONE: Self = Self([0.0; KINDS]);

    fn plus(mut self, other: Self, times: f64) -> Self {
        for (mine, other) in self.0.iter_mut().zip(other.0) {
            *mine += times * other;
        }
        self
    }

    /// Whether values can be converted, and if so, how many cycles become angles.
    fn cycles_to(&self, other: &Self) -> Option<f64> {
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

/// A factor and a dimension while a text is read.
#[derive(Clone, Copy)]
struct Scaled {
    dimension: Dimension,
    factor: f64,
}

impl Scaled {
    fn times(self, other: Self, power: f64) -> Self {
        Self {
            dimension: self.dimension.plus(other.dimension, power),
            factor: self.factor * other.factor.powf(power),
        }
    }
}

const ONE: Scaled = Scaled { dimension: Dimension::NONE, factor: 1.0 };
const METRE: [f64; KINDS] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
const VOLUME: [f64; KINDS] = [3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
const KILOGRAM: [f64; KINDS] = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
const SECOND: [f64; KINDS] = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
const AMPERE: [f64; KINDS] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
const KELVIN: [f64; KINDS] = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
const PURE: [f64; KINDS] = [0.0; KINDS];
const RADIAN: [f64; KINDS] = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
const SPEED: [f64; KINDS] = [0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0];
const HERTZ: [f64; KINDS] = [0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0];
const NEWTON: [f64; KINDS] = [1.0, 1.0, -2.0, 0.0, 0.0, 0.0, 0.0];
const TORQUE: [f64; KINDS] = [2.0, 1.0, -2.0, 0.0, 0.0, 0.0, 0.0];
const PASCAL: [f64; KINDS] = [-1.0, 1.0, -2.0, 0.0, 0.0, 0.0, 0.0];
const WATT: [f64; KINDS] = [2.0, 1.0, -3.0, 0.0, 0.0, 0.0, 0.0];
const COULOMB: [f64; KINDS] = [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0];
const VOLT: [f64; KINDS] = [2.0, 1.0, -3.0, -1.0, 0.0, 0.0, 0.0];
const OHM: [f64; KINDS] = [2.0, 1.0, -3.0, -2.0, 0.0, 0.0, 0.0];
const HENRY: [f64; KINDS] = [2.0, 1.0, -2.0, -2.0, 0.0, 0.0, 0.0];
const FARAD: [f64; KINDS] = [-2.0, -1.0, 4.0, 2.0, 0.0, 0.0, 0.0];
const WEBER: [f64; KINDS] = [2.0, 1.0, -2.0, -1.0, 0.0, 0.0, 0.0];
const TESLA: [f64; KINDS] = [0.0, 1.0, -2.0, -1.0, 0.0, 0.0, 0.0];

/// Known units: name, exponents, factor, whether SI prefixes apply.
const UNITS: &[(&str, [f64; KINDS], f64, bool)] = &[
    ("m", METRE, 1.0, true),
    ("in", METRE, 0.0254, false),
    ("ft", METRE, 0.3048, false),
    ("l", VOLUME, 1e-3, true),
    ("L", VOLUME, 1e-3, true),
    ("g", KILOGRAM, 1e-3, true),
    ("lb", KILOGRAM, 0.453_592_37, false),
    ("s", SECOND, 1.0, true),
    ("min", SECOND, 60.0, false),
    ("h", SECOND, 3600.0, false),
    ("A", AMPERE, 1.0, true),
    ("K", KELVIN, 1.0, true),
    ("degC", KELVIN, 1.0, false),
    ("\u{b0}C", KELVIN, 1.0, false),
    ("degF", KELVIN, 5.0 / 9.0, false),
    ("%", PURE, 0.01, false),
    ("rad", RADIAN, 1.0, true),
    ("deg", RADIAN, PI / 180.0, true),
    ("\u{b0}", RADIAN, PI / 180.0, false),
    ("rev", RADIAN, 2.0 * PI, false),
    ("turn", RADIAN, 2.0 * PI, false),
    ("rpm", SPEED, 2.0 * PI / 60.0, true),
    ("Hz", HERTZ, 1.0, true),
    ("N", NEWTON, 1.0, true),
    ("lbf", NEWTON, 4.448_221_615_260_5, false),
    ("Nm", TORQUE, 1.0, true),
    ("Pa", PASCAL, 1.0, true),
    ("bar", PASCAL, 1e5, true),
    ("psi", PASCAL, 6_894.757_293_168, false),
    ("J", TORQUE, 1.0, true),
    ("W", WATT, 1.0, true),
    ("C", COULOMB, 1.0, true),
    ("V", VOLT, 1.0, true),
    ("ohm", OHM, 1.0, true),
    ("Ohm", OHM, 1.0, true),
    ("\u{3a9}", OHM, 1.0, true),
    ("\u{2126}", OHM, 1.0, true),
    ("H", HENRY, 1.0, true),
    ("F", FARAD, 1.0, true),
    ("Wb", WEBER, 1.0, true),
    ("T", TESLA, 1.0, true),
];

/// Temperature scales with a zero of their own: names, factor, offset.
const SCALES: &[(&[&str], f64, f64)] =
    &[(&["degC", "\u{b0}C"], 1.0, 273.15), (&["degF"], 5.0 / 9.0, 273.15 - 32.0 * 5.0 / 9.0)];

/// SI prefixes.
const PREFIXES: &[(char, f64)] = &[
    ('p', 1e-12),
    ('n', 1e-9),
    ('u', 1e-6),
    ('\u{b5}', 1e-6),
    ('\u{3bc}', 1e-6),
    ('m', 1e-3),
    ('c', 1e-2),
    ('d', 1e-1),
    ('k', 1e3),
    ('M', 1e6),
    ('G', 1e9),
    ('T', 1e12),
];

/// A name as it stands in the table, or an SI prefix and a name that takes one.
fn look_up(name: &str) -> Option<Scaled> {
    let known = |name: &str| UNITS.iter().find(|unit| unit.0 == name);
    if let Some(&(_, dimension, factor, _)) = known(name) {
        return Some(Scaled { dimension: Dimension(dimension), factor });
    }
    let mut letters = name.chars();
    let prefix = letters.next()?;
    let &(_, dimension, factor, _) = known(letters.as_str()).filter(|unit| unit.3)?;
    let &(_, scale) = PREFIXES.iter().find(|known| known.0 == prefix)?;
    Some(Scaled { dimension: Dimension(dimension), factor: scale * factor })
}

/// Reads a text from left to right.
struct Parser<'a> {
    text: &'a str,
    rest: &'a str,
    depth: usize,
}

impl<'a> Parser<'a> {
    /// Powers joined by a space, `*`, a middle dot or `/`, up to the end or a `)`.
    fn product(&mut self) -> Result<Scaled, UnitError> {
        let mut product = self.power()?;
        let mut divided = false;
        loop {
            let spaced = self.skip_spaces();
            let dotted = self.take_one_of("*\u{b7}\u{22c5}.");
            let divides = !dotted && self.take_one_of("/");
            if !dotted && !divides {
                if self.rest.is_empty() || self.rest.starts_with(')') {
                    return Ok(product);
                }
                if divided {
                    return Err(UnitError::Ambiguous { text: self.text.into() });
                }
                if !spaced {
                    return Err(self.syntax("a space, '*', '/' or '^'"));
                }
            }
            divided |= divides;
            self.skip_spaces();
            product = product.times(self.power()?, if divides { -1.0 } else { 1.0 });
        }
    }

    /// A factor with an exponent.
    fn power(&mut self) -> Result<Scaled, UnitError> {
        let (factor, is_number) = self.factor()?;
        let exponent = if self.take_one_of("^") {
            self.skip_spaces();
            self.exponent()?
        } else if self.take_one_of("\u{b2}") {
            2.0
        } else if self.take_one_of("\u{b3}") {
            3.0
        } else if !is_number && self.rest.starts_with(|c: char| c.is_ascii_digit() || c == '-') {
            // s2, s-1
            self.exponent()?
        } else {
            1.0
        };
        Ok(ONE.times(factor, exponent))
    }

    /// A name, a number or a product in parentheses; and whether it is a number.
    fn factor(&mut self) -> Result<(Scaled, bool), UnitError> {
        if self.rest.starts_with('(') {
            return Ok((self.group()?, false));
        }
        if self.rest.starts_with(|c: char| c.is_ascii_digit()) {
            let before = self.rest;
            let factor = self.number()?;
            if factor == 0.0 {
                self.rest = before;
                return Err(self.syntax("a positive number"));
            }
            return Ok((Scaled { dimension: Dimension::NONE, factor }, true));
        }
        let is_letter = |c: char| c.is_alphabetic() || "%\u{b0}".contains(c);
        let end = self.rest.find(|c| !is_letter(c)).unwrap_or(self.rest.len());
        let name = &self.rest[..end];
        if name.is_empty() {
            return Err(self.syntax("a unit"));
        }
        let found = look_up(name).ok_or_else(|| self.unknown(name))?;
        self.rest = &self.rest[end..];
        Ok((found, false))
    }

    fn group(&mut self) -> Result<Scaled, UnitError> {
        if self.depth == DEEPEST {
            return Err(self.syntax("fewer nested parentheses"));
        }
        self.depth += 1;
        self.rest = &self.rest[1..];
        self.skip_spaces();
        let inside = self.product()?;
        self.depth -= 1;
        if self.take_one_of(")") { Ok(inside) } else { Err(self.syntax("')'")) }
    }

    /// A number without a sign; an `e` belongs to it only if digits follow.
    fn number(&mut self) -> Result<f64, UnitError> {
        let digits = |text: &str| text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
        let mut end = digits(self.rest);
        if self.rest[end..].starts_with('.') {
            end += 1 + digits(&self.rest[end + 1..]);
        }
        if let Some(after) = self.rest[end..].strip_prefix(['e', 'E']) {
            let sign = usize::from(after.starts_with(['+', '-']));
            let power = digits(&after[sign..]);
            if power > 0 {
                end += 1 + sign + power;
            }
        }
        match self.rest[..end].parse::<f64>() {
            Ok(number) if number.is_finite() => {
                self.rest = &self.rest[end..];
                Ok(number)
            }
            _ => Err(self.syntax("a number")),
        }
    }

    /// An exponent: 2, -1, 2.5, (1/2).
    fn exponent(&mut self) -> Result<f64, UnitError> {
        if self.take_one_of("(") {
            let above = self.signed()?;
            let below = if self.take_one_of("/") { self.number()? } else { 1.0 };
            return if self.take_one_of(")") { Ok(above / below) } else { Err(self.syntax("')'")) };
        }
        self.signed()
    }

    fn signed(&mut self) -> Result<f64, UnitError> {
        let sign = if self.take_one_of("-") { -1.0 } else { 1.0 };
        Ok(sign * self.number()?)
    }

    /// Whether there were any.
    fn skip_spaces(&mut self) -> bool {
        let before = self.rest.len();
        self.rest = self.rest.trim_start();
        self.rest.len() < before
    }

    fn take_one_of(&mut self, characters: &str) -> bool {
        match self.rest.chars().next().filter(|&c| characters.contains(c)) {
            Some(c) => {
                self.rest = &self.rest[c.len_utf8()..];
                true
            }
            None => false,
        }
    }

    fn syntax(&self, expected: &'static str) -> UnitError {
        let found = match self.rest.chars().next() {
            Some(c) => format!("'{c}'"),
            None => "the end".into(),
        };
        let read = &self.text[..self.text.len() - self.rest.len()];
        let position = read.chars().count() + 1;
        UnitError::Syntax { text: self.text.into(), position, expected, found }
    }

    fn unknown(&self, name: &str) -> UnitError {
        let common = ["mm", "cm", "um", "kg", "ms", "mV", "mA", "kN", "mNm", "kPa", "kHz"];
        let names = UNITS.iter().map(|unit| unit.0).chain(common);
        let suggestion = nearest(name, names).map(Into::into);
        UnitError::Unknown { text: self.text.into(), name: name.into(), suggestion }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(text: &str) -> Unit {
        Unit::parse(text).unwrap()
    }

    fn factor(from: &str, to: &str) -> f64 {
        convert_factor(&unit(from), &unit(to)).unwrap()
    }

    #[test]
    fn factors_between_units_of_one_kind() {
        let same_kind = [
            ("deg", "rad", PI / 180.0),
            ("rpm", "rad/s", 2.0 * PI / 60.0),
            ("rev/s", "deg/s", 360.0),
            ("mm", "m", 1e-3),
            ("um", "mm", 1e-3),
            ("\u{b5}m", "m", 1e-6),
            ("in", "cm", 2.54),
            ("ms", "s", 1e-3),
            ("kN", "N", 1e3),
            ("N mm", "N m", 1e-3),
            ("mNm", "Nm", 1e-3),
            ("Nm", "kg m^2/s^2", 1.0),
            ("g", "kg", 1e-3),
            ("bar", "Pa", 1e5),
            ("%", "1", 0.01),
            ("W", "V A", 1.0),
            ("Ohm", "V/A", 1.0),
            ("H", "V s/A", 1.0),
            ("N s/m", "kg/s", 1.0),
            ("N m s/rad", "N m s", 1.0),
            ("N/m^3", "kg/(m^2 s^2)", 1.0),
            ("rad/s^2", "1/s^2", 1.0),
            ("km/h", "m/s", 1.0 / 3.6),
            ("m^2.5/s", "cm^2.5/s", 1e5),
            ("m^3/(s V)", "L/(s V)", 1e3),
            ("m/s\u{b2}", "mm/s2", 1e3),
            ("kg\u{b7}m\u{b2}", "g*cm^2", 1e7),
            ("s^-1", "1/s", 1.0),
            ("m s-1", "mm/s", 1e3),
            ("m^(1/2)", "cm^0.5", 10.0),
            ("10 mV", "V", 0.01),
            ("W/degC", "W/K", 1.0),
            ("A s", "C", 1.0),
            ("F V", "C", 1.0),
            ("T m^2", "Wb", 1.0),
            ("Wb/s", "V", 1.0),
            ("psi", "lbf/in^2", 1.0),
            ("J/s", "W", 1.0),
        ];
        for (from, to, expected) in same_kind {
            let found = factor(from, to);
            assert!((found / expected - 1.0).abs() < 1e-12, "{from} {to}: {found}");
        }
    }

    #[test]
    fn hertz_counts_cycles() {
        assert!((factor("Hz", "rad/s") - 2.0 * PI).abs() < 1e-12);
        assert!((factor("rpm", "Hz") - 1.0 / 60.0).abs() < 1e-15);
        assert!((factor("kHz", "1/s") - 1e3).abs() < 1e-9);
        assert!((factor("N s/(m Hz)", "N s^2/(m rad)") - 0.5 / PI).abs() < 1e-12);
    }

    #[test]
    fn temperatures_have_offsets() {
        let celsius = convert(&[0.0, 26.85, f64::NAN], &unit("degC"), &unit("K")).unwrap();
        assert!((celsius[0] - 273.15).abs() < 1e-12 && (celsius[1] - 300.0).abs() < 1e-12);
        assert!(celsius[2].is_nan());
        let back = convert(&[212.0], &unit("degF"), &unit("degC")).unwrap();
        assert!((back[0] - 100.0).abs() < 1e-10);
        let refused = convert_factor(&unit("degC"), &unit("K"));
        assert!(matches!(refused, Err(UnitError::Offset { .. })));
    }

    #[test]
    fn units_that_do_not_fit_are_named_with_their_dimensions() {
        let said = convert_factor(&unit("N m"), &unit("N")).unwrap_err().to_string();
        assert_eq!(said, "cannot convert 'N m' (m^2 kg s^-2) to 'N' (m kg s^-2)");
        let said = convert(&[1.0], &unit("rad"), &unit("m")).unwrap_err().to_string();
        assert_eq!(said, "cannot convert 'rad' (rad) to 'm' (m)");
        assert_eq!(unit("%").dimension().to_string(), "dimensionless");
    }

    #[test]
    fn wrong_texts_are_answered() {
        let said = |text: &str| Unit::parse(text).unwrap_err().to_string();
        assert_eq!(
            said("degs/s"),
            "unit 'degs/s': 'degs' is not a known unit (did you mean 'deg'?)"
        );
        assert_eq!(Unit::parse(" "), Err(UnitError::Empty));
        assert!(matches!(Unit::parse("N/m s"), Err(UnitError::Ambiguous { .. })));
        assert!(matches!(Unit::parse("kkg"), Err(UnitError::Unknown { .. })));
        assert_eq!(said("N *"), "unit 'N *', character 4: expected a unit, found the end");
        for text in ["/s", "m^", "m^x", "(m", "m)", "m//s", "0 m", "-m", "m^1e999", "1e300^2"] {
            assert!(matches!(Unit::parse(text), Err(UnitError::Syntax { .. })), "{text}");
        }
        let deep = format!("{}m{}", "(".repeat(100), ")".repeat(100));
        assert!(matches!(Unit::parse(&deep), Err(UnitError::Syntax { .. })));
    }
}
