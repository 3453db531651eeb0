//! The numbers that decide: all that is not mathematics, in one place, each with its reason.
//!
//! What the search finds must not hang on any of them. They are fields and no constants, so that a
//! study can move them ([`crate::diagnose::Options`]).

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
    /// twentieth of the noise, squared, to which the integration of the search is exact.
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
