//! How much of an effect there is, as one number that can be compared between machines.

use crate::{Effect, Kind};

impl Effect {
    /// How much of it there is with these parameters and their standard deviations, in the order of
    /// [`Effect::values`], as of independent ones: its stated quantity, or the first parameter, less the value
    /// with which it does nothing (of a limit, its reciprocal). 0 where the effect is absent; the same quantity
    /// for all of a family. None of a curve, which no number says.
    #[must_use]
    pub fn size(&self, parameters: &[(f64, f64)]) -> Option<(f64, f64)> {
        let first = self.parameters.first().filter(|p| p.kind == Kind::Number)?;
        let (value, std) = match &self.nature.stated {
            Some(stated) => stated.of(parameters.iter().copied()),
            None => *parameters.first()?,
        };
        debug_assert!(first.physical, "{}: the first parameter says how much", self.class);
        Some(match self.nature.absent {
            absent if absent.is_finite() => (value - absent, std),
            _ => (value.recip(), std / value.powi(2)),
        })
    }

    /// What it is a variant of, or itself, in words: what its size is compared with.
    #[must_use]
    pub fn kind_words(&self) -> &'static str {
        self.nature.kin.map_or(self.words, |kin| kin.family.words)
    }
}

#[cfg(test)]
mod tests {
    use crate::find;

    #[test]
    fn sizes_are_zero_of_what_is_absent_and_compare_within_a_family() {
        let size =
            |class: &str, parameters: &[(f64, f64)]| find(class).unwrap().size(parameters).unwrap();
        assert_eq!(size("gain_error", &[(1.2, 0.1)]).1, 0.1);
        assert!((size("gain_error", &[(1.2, 0.1)]).0 - 0.2).abs() < 1e-12);
        assert_eq!(size("saturation", &[(2.0, 0.4)]), (0.5, 0.1));
        assert_eq!(size("coulomb_friction", &[(3.0, 0.1), (0.1, 1.0)]), (3.0, 0.1));
        let (value, std) = size("asymmetric_friction", &[(2.0, 0.3), (4.0, 0.4), (0.1, 1.0)]);
        assert!((value - 3.0).abs() < 1e-12 && (std - 0.25).abs() < 1e-12);
        assert_eq!(find("unknown_function").and_then(|e| e.size(&[(1.0, 0.0)])), None);
        let kinds =
            ["stribeck_friction", "coulomb_friction"].map(|c| find(c).unwrap().kind_words());
        assert_eq!(kinds, ["dry friction"; 2]);
    }
}
