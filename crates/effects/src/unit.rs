//! Units of effect parameters, derived from the units of the channel they act on.

use crate::Variable;

/// A product of powers: force, coordinate, seconds, input, the variable of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimension {
    /// Power of the channel's generalised force.
    pub force: i8,
    /// Power of the channel's coordinate.
    pub coordinate: i8,
    /// Power of the second.
    pub seconds: i8,
    /// Power of the input's unit.
    pub input: i8,
    /// Power of the variable that a curve is over.
    pub variable: i8,
}

impl Dimension {
    /// A pure number.
    pub const NUMBER: Self = Self::new(0, 0, 0);
    /// The channel's generalised force.
    pub const FORCE: Self = Self::new(1, 0, 0);
    /// The channel's coordinate.
    pub const COORDINATE: Self = Self::new(0, 1, 0);
    /// The channel's velocity.
    pub const VELOCITY: Self = Self::new(0, 1, -1);
    /// Seconds.
    pub const TIME: Self = Self::new(0, 0, 1);
    /// Radians per second.
    pub const RATE: Self = Self::new(0, 0, -1);
    /// The input's unit.
    pub const INPUT: Self = Self { input: 1, ..Self::NUMBER };
    /// The variable that a curve is over.
    pub const VARIABLE: Self = Self { variable: 1, ..Self::NUMBER };

    /// `force^a coordinate^b s^c`.
    #[must_use]
    pub const fn new(force: i8, coordinate: i8, seconds: i8) -> Self {
        Self { force, coordinate, seconds, input: 0, variable: 0 }
    }

    /// The same for a curve over this variable of its channel.
    #[must_use]
    pub const fn over(self, variable: Variable) -> Self {
        let unit = match variable {
            Variable::Coordinate | Variable::OtherCoordinate => Self::COORDINATE,
            Variable::Velocity | Variable::OtherVelocity => Self::VELOCITY,
            Variable::Acceleration => Self::new(0, 1, -2),
            Variable::Time => Self::TIME,
            Variable::Input => Self::INPUT,
        };
        let power = self.variable;
        Self {
            force: self.force,
            coordinate: self.coordinate + power * unit.coordinate,
            seconds: self.seconds + power * unit.seconds,
            input: self.input + power * unit.input,
            variable: 0,
        }
    }

    /// As text, given the units of the channel's force and coordinate, or of the input. What
    /// [`Dimension::over`] has not settled is taken as a curve over the coordinate.
    #[must_use]
    pub fn text(self, force: &str, coordinate: &str, input: &str) -> String {
        let this = self.over(Variable::Coordinate);
        let parts = [
            (force, this.force),
            ("s", this.seconds),
            (coordinate, this.coordinate),
            (input, this.input),
        ];
        let mut factors = Vec::new();
        for (unit, power) in parts {
            multiply(&mut factors, unit, i32::from(power));
        }
        let side = |sign: i32| -> Vec<String> {
            let here = factors.iter().filter(|(_, power)| power * sign > 0);
            here.map(|(symbol, power)| match power.abs() {
                1 => (*symbol).to_owned(),
                p => format!("{symbol}^{p}"),
            })
            .collect()
        };
        let (above, below) = (side(1), side(-1));
        let top = if above.is_empty() { "1".to_owned() } else { above.join(" ") };
        match below.len() {
            0 => top,
            1 => format!("{top}/{}", below[0]),
            _ => format!("{top}/({})", below.join(" ")),
        }
    }
}

/// Multiply a product of symbols by `unit^power`: `m/s` to the power of -1 is `s` times `m^-1`,
/// and what stands above and below the line cancels.
fn multiply<'u>(factors: &mut Vec<(&'u str, i32)>, unit: &'u str, power: i32) {
    let (top, bottom) = unit.split_once('/').unwrap_or((unit, ""));
    for (side, sign) in [(top, 1), (bottom, -1)] {
        let symbols = side.split([' ', '(', ')']).filter(|s| !s.is_empty() && *s != "1");
        for written in symbols {
            let (symbol, exponent) = match written.split_once('^') {
                Some((symbol, e)) => e.parse().map_or((written, 1), |e: i32| (symbol, e)),
                None => (written, 1),
            };
            let more = sign * exponent * power;
            match factors.iter_mut().find(|(s, _)| *s == symbol) {
                Some((_, total)) => *total += more,
                None => factors.push((symbol, more)),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Dimension;
    use crate::Variable;

    #[test]
    fn units_read_as_an_engineer_writes_them() {
        assert_eq!(Dimension::new(1, -1, 1).text("N", "m", ""), "N s/m");
        assert_eq!(Dimension::new(1, -3, 0).text("N m", "rad", ""), "N m/rad^3");
        assert_eq!(Dimension::VELOCITY.text("N", "m", ""), "m/s");
        assert_eq!(Dimension::RATE.text("N", "m", ""), "1/s");
        assert_eq!(Dimension::NUMBER.text("N", "m", "V"), "1");
        assert_eq!(Dimension::INPUT.text("", "", "A"), "A");
        // A first-order state in metres: its "force" is a rate, m/s.
        assert_eq!(Dimension::FORCE.text("m/s", "m", ""), "m/s");
        // What is above and below the line cancels.
        assert_eq!(Dimension::new(1, -1, 0).text("degC/s", "degC", ""), "1/s");
        assert_eq!(Dimension::new(1, -1, 0).text("kg/(m s)", "m^2", ""), "kg/(m^3 s)");
        let over = |v| Dimension::VARIABLE.over(v).text("N m", "rad", "");
        assert_eq!([Variable::Velocity, Variable::Time].map(over), ["rad/s", "s"]);
        assert_eq!(Dimension::VARIABLE.text("N m", "rad", ""), "rad");
        // A power that is no whole number is part of the symbol.
        assert_eq!(Dimension::FORCE.text("m^2.5/s", "m", ""), "m^2.5/s");
    }
}
