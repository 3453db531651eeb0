//! The units that are known.

use crate::UnitError;
use crate::dimension::{Dimension, KINDS};
use crate::names::nearest;
use std::f64::consts::PI;

/// A factor and a dimension.
#[derive(Clone, Copy)]
pub(crate) struct Scaled {
    pub dimension: Dimension,
    pub factor: f64,
}

impl Scaled {
    pub fn times(self, other: Self, power: f64) -> Self {
        Self {
            dimension: self.dimension.plus(other.dimension, power),
            factor: self.factor * other.factor.powf(power),
        }
    }
}

pub(crate) const ONE: Scaled = Scaled { dimension: Dimension::NONE, factor: 1.0 };

const METRE: [f64; KINDS] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
const VOLUME: [f64; KINDS] = [3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
const KILOGRAM: [f64; KINDS] = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
const SECOND: [f64; KINDS] = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
const AMPERE: [f64; KINDS] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
pub(crate) const KELVIN: [f64; KINDS] = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
const PURE: [f64; KINDS] = [0.0; KINDS];
pub(crate) const RADIAN: [f64; KINDS] = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
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
pub(crate) const SCALES: &[(&[&str], f64, f64)] =
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

/// A number, a name as it stands in the table, or an SI prefix and a name that takes one.
pub(crate) fn look_up(name: &str) -> Option<Scaled> {
    if name.starts_with(|c: char| c.is_ascii_digit()) {
        return name.parse().ok().map(|factor| Scaled { dimension: Dimension::NONE, factor });
    }
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

/// That a name of a text is none of a unit, and which one may be meant.
pub(crate) fn unknown(text: &str, name: &str) -> UnitError {
    let common = ["mm", "cm", "um", "kg", "ms", "mV", "mA", "kN", "mNm", "kPa", "kHz"];
    let names = UNITS.iter().map(|unit| unit.0).chain(common);
    let suggestion = nearest(name, names).map(Into::into);
    UnitError::Unknown { text: text.into(), name: name.into(), suggestion }
}
