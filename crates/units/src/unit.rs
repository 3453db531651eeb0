//! Units of measurement and their conversion.

use crate::dimension::Dimension;
use crate::table::{KELVIN, ONE, RADIAN, SCALES, Scaled, look_up, unknown};
use crate::{Product, UnitError};
use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

/// A unit of measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    text: String,
    dimension: Dimension,
    factor: f64,
    offset: f64,
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
        let product = Product::parse(text)?;
        let mut whole = ONE;
        for (symbol, power) in product.powers() {
            let factor = look_up(symbol).ok_or_else(|| unknown(text, symbol))?;
            whole = whole.times(factor, power);
        }
        let Scaled { dimension, factor } = whole;
        if !(factor.is_normal() && dimension.0.iter().all(|exponent| exponent.is_finite())) {
            return Err(UnitError::Range { text: text.into() });
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
        for text in ["/s", "m^", "m^x", "(m", "m)", "m//s", "0 m", "-m", "m^1e999"] {
            assert!(matches!(Unit::parse(text), Err(UnitError::Syntax { .. })), "{text}");
        }
        assert!(matches!(Unit::parse("1e300^2"), Err(UnitError::Range { .. })));
        let deep = format!("{}m{}", "(".repeat(100), ")".repeat(100));
        assert!(matches!(Unit::parse(&deep), Err(UnitError::Syntax { .. })));
    }
}
