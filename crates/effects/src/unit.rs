//! Units of effect parameters, derived from the units of the channel they act on.

/// A product of powers: force, coordinate, seconds, input.
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
    pub const INPUT: Self = Self { force: 0, coordinate: 0, seconds: 0, input: 1 };

    /// `force^a coordinate^b s^c`.
    #[must_use]
    pub const fn new(force: i8, coordinate: i8, seconds: i8) -> Self {
        Self { force, coordinate, seconds, input: 0 }
    }

    /// As text, given the units of the channel's force and coordinate, or of the input.
    #[must_use]
    pub fn text(self, force: &str, coordinate: &str, input: &str) -> String {
        let parts = [
            (force, self.force),
            ("s", self.seconds),
            (coordinate, self.coordinate),
            (input, self.input),
        ];
        let mut above = Vec::new();
        let mut below = Vec::new();
        for (unit, power) in parts {
            if power > 0 {
                factor(unit, power, &mut above, &mut below);
            } else if power < 0 {
                factor(unit, -power, &mut below, &mut above);
            }
        }
        let top = if above.is_empty() { "1".to_owned() } else { above.join(" ") };
        match below.len() {
            0 => top,
            1 => format!("{top}/{}", below[0]),
            _ => format!("{top}/({})", below.join(" ")),
        }
    }
}

/// Put `unit^power` above the line; a unit that is itself a quotient (`m/s`) goes to both sides.
fn factor(unit: &str, power: i8, above: &mut Vec<String>, below: &mut Vec<String>) {
    let power_of = |u: &str| {
        if power == 1 { u.to_owned() } else { format!("{u}^{power}") }
    };
    match unit.split_once('/') {
        _ if unit.is_empty() || unit == "1" => {}
        Some((top, bottom)) => {
            if top != "1" {
                above.push(power_of(top.trim()));
            }
            below.push(power_of(bottom.trim()));
        }
        None => above.push(power_of(unit)),
    }
}

#[cfg(test)]
mod tests {
    use super::Dimension;

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
    }
}
