//! What an axis measures, and how values are placed along it.

/// How values are placed along an axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal steps.
    Linear,
    /// Equal factors: `log10 v`. Values that are not positive are gaps.
    Log,
    /// Names at 0, 1, 2, ...
    Names(Vec<String>),
}

impl Scale {
    /// Where a value is along the axis.
    pub(crate) fn place(&self, value: f64) -> f64 {
        match self {
            Self::Log if value > 0.0 => value.log10(),
            Self::Log => f64::NAN,
            Self::Linear | Self::Names(_) => value,
        }
    }
}

/// An axis: a quantity, its unit and its scale.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// What it shows.
    pub name: String,
    /// Unit, shown in parentheses; none where it is empty or `1`, the unit of pure numbers.
    pub unit: String,
    /// Scale.
    pub scale: Scale,
}

impl Axis {
    /// A linear axis.
    #[must_use]
    pub fn linear(name: &str, unit: &str) -> Self {
        Self { name: name.to_owned(), unit: unit.to_owned(), scale: Scale::Linear }
    }

    /// A logarithmic axis.
    #[must_use]
    pub fn log(name: &str, unit: &str) -> Self {
        Self { scale: Scale::Log, ..Self::linear(name, unit) }
    }

    /// An axis of names.
    #[must_use]
    pub fn names(names: &[&str]) -> Self {
        let names = names.iter().map(|n| (*n).to_owned()).collect();
        Self { scale: Scale::Names(names), ..Self::linear("", "") }
    }

    /// Whether it measures time, so that a part of it may be worth a closer look.
    #[must_use]
    pub fn is_time(&self) -> bool {
        self.unit == "s"
    }

    /// Name and unit.
    pub(crate) fn label(&self) -> String {
        match self.unit.as_str() {
            "" | "1" => self.name.clone(),
            unit => format!("{} ({unit})", self.name),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_have_units_where_there_are_any() {
        assert_eq!(Axis::linear("lag", "s").label(), "lag (s)");
        assert_eq!(Axis::log("error", "1").label(), "error");
        assert_eq!(Axis::linear("gain", "").label(), "gain");
        assert!(Axis::linear("t", "s").is_time() && !Axis::linear("velocity", "m/s").is_time());
    }

    #[test]
    fn logarithms_have_gaps_where_there_are_none() {
        assert_eq!(Scale::Log.place(1e-3), -3.0);
        assert!(Scale::Log.place(0.0).is_nan() && Scale::Log.place(-1.0).is_nan());
        assert_eq!(Scale::Linear.place(-1.0), -1.0);
    }
}
