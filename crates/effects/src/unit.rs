//! Units of effect parameters, derived from the units of the channel they act on; what acts on links
//! has units of its own.

use crate::Variable;
use lacuna_units::Product;

/// A product of powers: force, coordinate, seconds, radians, input, the variable of a curve, kilograms,
/// metres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimension {
    /// Power of the channel's generalised force.
    pub force: i8,
    /// Power of the channel's coordinate.
    pub coordinate: i8,
    /// Power of the second.
    pub seconds: i8,
    /// Power of the radian.
    pub angle: i8,
    /// Power of the input's unit.
    pub input: i8,
    /// Power of the variable that a curve is over.
    pub variable: i8,
    /// Power of the kilogram.
    pub mass: i8,
    /// Power of the metre.
    pub length: i8,
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
    pub const RATE: Self = Self { angle: 1, ..Self::new(0, 0, -1) };
    /// The input's unit.
    pub const INPUT: Self = Self { input: 1, ..Self::NUMBER };
    /// The variable that a curve is over.
    pub const VARIABLE: Self = Self { variable: 1, ..Self::NUMBER };
    /// Radians.
    pub const ANGLE: Self = Self { angle: 1, ..Self::NUMBER };
    /// Kilograms, of a link.
    pub const MASS: Self = Self { mass: 1, ..Self::NUMBER };
    /// Metres, of a link.
    pub const LENGTH: Self = Self { length: 1, ..Self::NUMBER };

    /// `force^a coordinate^b s^c`.
    #[must_use]
    pub const fn new(force: i8, coordinate: i8, seconds: i8) -> Self {
        Self { force, coordinate, seconds, angle: 0, input: 0, variable: 0, mass: 0, length: 0 }
    }

    /// The same per unit of the input.
    #[must_use]
    pub const fn per_input(self) -> Self {
        Self { input: self.input - 1, ..self }
    }

    /// The same for a curve over this variable of its channel.
    #[must_use]
    pub const fn over(self, variable: Variable) -> Self {
        let unit = match variable {
            Variable::Coordinate | Variable::OtherCoordinate => Self::COORDINATE,
            Variable::Velocity | Variable::OtherVelocity => Self::VELOCITY,
            Variable::Acceleration => Self::new(0, 1, -2),
            Variable::Time => Self::TIME,
            Variable::Input | Variable::OtherInput => Self::INPUT,
        };
        let power = self.variable;
        Self {
            coordinate: self.coordinate + power * unit.coordinate,
            seconds: self.seconds + power * unit.seconds,
            input: self.input + power * unit.input,
            variable: 0,
            ..self
        }
    }

    /// As text, given the units of the channel's force and coordinate, and of the input. What
    /// [`Dimension::over`] has not settled is taken as a curve over the coordinate. A text that is
    /// no product of symbols is taken as one symbol.
    #[must_use]
    pub fn text(self, force: &str, coordinate: &str, input: &str) -> String {
        let this = self.over(Variable::Coordinate);
        let parts = [
            (force, this.force),
            ("rad", this.angle),
            ("s", this.seconds),
            (coordinate, this.coordinate),
            (input, this.input),
            ("kg", this.mass),
            ("m", this.length),
        ];
        let whole = parts.into_iter().fold(Product::ONE, |whole, (unit, power)| {
            let unit = Product::parse(unit).unwrap_or_else(|_| Product::symbol(unit));
            whole.times(&unit, f64::from(power))
        });
        whole.to_string()
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
        assert_eq!(Dimension::RATE.text("N", "m", ""), "rad/s");
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
        assert_eq!(Dimension::new(1, -1, 0).text("m^2.5/s", "m", ""), "m^1.5/s");
        // However a unit is written, its powers are those of all of it.
        assert_eq!(Dimension::new(2, 0, 1).text("N*m", "rad", ""), "N^2 m^2 s");
        assert_eq!(Dimension::new(1, -1, 0).text("kg mm s^-2", "mm", ""), "kg/s^2");
        // What nobody can read is one symbol.
        assert_eq!(Dimension::new(1, -1, 0).text("N/m s", "m", ""), "N/m s/m");
    }
}
