//! The numbers that decide: all that is not mathematics, in one place, each with its reason.
//!
//! What the search finds must not hang on any of them. They are fields and no constants, so that a
//! study can move them ([`crate::diagnose::Options`], [`FIELDS`]): `experiments -- ablation` halves
//! and doubles each.

/// The numbers that decide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Prior log odds (nats) against every single effect, and against a parameter that is not what
    /// the model says. With some hundred candidates, one in e^10 = 22 000 each leaves the belief
    /// that nothing at all is missing a hundred to one ahead before any data.
    pub prior_odds: f64,
    /// Nats by which one of two names must lead to be preferred to the other: odds of seven to
    /// one. Less is a draw, and the simpler or earlier one stays.
    pub tie: f64,
    /// Mean square, in units of the noise, by which predictions must change to be worth a word: a
    /// twentieth of the noise, squared, to which the integration of the search is exact. And the
    /// least share of a mismatch that an effect beside others must say: no formula is better.
    pub relevant: f64,
    /// Mean square residual, in units of the noise, up to which what is left is noise: its standard
    /// deviation is known to a few hundredths.
    pub noise: f64,
    /// Mean square residual, relative to what the shortest windows leave, up to which a model
    /// explains its data but for the shape of a formula.
    pub explained: f64,
    /// Least share of a mismatch that an effect must take away to be its name, of what it changes
    /// that must come true on recordings left out, and of a mismatch that is told from its rest.
    pub share: f64,
    /// The same for each further effect: what a formula that is not quite reality's leaves can be
    /// nibbled at by many; another physics takes away most of it.
    pub further_share: f64,
    /// Candidates that are fitted with the differential equation after each screening: a budget.
    /// The right one is nearly always among the first three.
    pub shortlist: usize,
    /// Relative error of what the screening promises: it is linear, and effects are not small.
    pub screening_error: f64,
    /// Share of half a channel's range up to which a misfit above the noise still leaves windows
    /// linear in their states; beyond it longer windows weigh little but what adds up in them.
    pub window_misfit: f64,
}

impl Default for Decision {
    fn default() -> Self {
        Self {
            prior_odds: 10.0,
            tie: 2.0,
            relevant: 0.0025,
            noise: 1.05,
            explained: 1.5,
            share: 0.2,
            further_share: 0.5,
            shortlist: 7,
            screening_error: 0.6,
            window_misfit: 0.02,
        }
    }
}

impl Decision {
    /// Nats by which an effect is missed that is beyond doubt: what formulas that are not quite reality's leave is
    /// worth less.
    #[must_use]
    pub fn beyond_doubt(&self) -> f64 {
        20.0 * self.prior_odds
    }
}

/// A field that is a real number.
macro_rules! real {
    ($name:ident) => {
        Field { name: stringify!($name), get: |d| d.$name, set: |d, value| d.$name = value }
    };
}

/// A number that decides, by its name.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Its name, as a field of [`Decision`].
    pub name: &'static str,
    get: fn(&Decision) -> f64,
    set: fn(&mut Decision, f64),
}

/// Every field of [`Decision`].
pub const FIELDS: [Field; 10] = [
    real!(prior_odds),
    real!(tie),
    real!(relevant),
    real!(noise),
    real!(explained),
    real!(share),
    real!(further_share),
    Field {
        name: "shortlist",
        get: |d| d.shortlist as f64,
        // A search with nothing to fit is none.
        set: |d, value| d.shortlist = (value.round() as usize).max(1),
    },
    real!(screening_error),
    real!(window_misfit),
];

impl Field {
    /// Its value; a count as a real number.
    #[must_use]
    pub fn of(&self, decision: &Decision) -> f64 {
        (self.get)(decision)
    }

    /// The decision with another value of it; a count is rounded, and at least 1.
    #[must_use]
    pub fn set(&self, decision: Decision, value: f64) -> Decision {
        let mut decision = decision;
        (self.set)(&mut decision, value);
        decision
    }
}

#[cfg(test)]
mod tests {
    use super::{Decision, FIELDS};

    /// A new field of the struct that is not in the list is found by its name.
    #[test]
    fn every_field_is_in_the_list() {
        let debug = format!("{:?}", Decision::default());
        let inside = debug.trim_start_matches("Decision { ").trim_end_matches(" }");
        let names: Vec<&str> =
            inside.split(", ").filter_map(|pair| pair.split(": ").next()).collect();
        assert_eq!(names, FIELDS.map(|f| f.name));
    }

    #[test]
    fn each_field_is_read_and_set_alone() {
        let plain = Decision::default();
        for field in &FIELDS {
            let doubled = field.set(plain, 2.0 * field.of(&plain));
            for other in &FIELDS {
                let factor = if other.name == field.name { 2.0 } else { 1.0 };
                assert_eq!(other.of(&doubled), factor * other.of(&plain), "{}", other.name);
            }
        }
        let few = FIELDS.iter().find(|f| f.name == "shortlist").unwrap();
        assert_eq!(few.set(plain, 3.5).shortlist, 4);
        assert_eq!(few.set(plain, 0.0).shortlist, 1);
    }
}
