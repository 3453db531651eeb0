//! The laws that the missing forces of all channels obey together.
//!
//! With whitened rows `y = P p + sum_k a_k c_k + e` of all channels, the evidence of a set of laws is that of a
//! linear regression ([`regression`]).
//!
//! A machine may lack something on each of its joints. So each round takes the most probable law of every
//! channel, as they hardly rival one another, finds the noise again that they leave, and then gives up what is
//! no longer missed and puts a law in another's place where it is the likelier. A motion is needed for none of
//! this: hundreds of candidates on each of many joints cost seconds.

mod beginnings;
mod block;
mod deficit;
mod edges;
mod offers;
mod pursuit;
mod regression;
mod rounds;
mod subset;
mod told;

use super::along::Along;
use super::columns::{Columns, Slopes};
use super::rows::Rows;
use super::{Belief, rows_of};
use crate::Decision;
use crate::candidates::{Candidate, Term};
use crate::likelihood::Problem;
use lacuna_effects::{CATALOGUE, Law, Variable};
use offers::Offers;
use pursuit::Pursuit;
use rayon::prelude::*;

/// A law with its amplitudes and what it gains beside the others.
#[derive(Clone, Debug)]
pub struct Obeyed {
    /// The effect with its shape.
    pub term: Term,
    /// Its amplitudes.
    pub amplitudes: Vec<f64>,
    /// Nats that are lost without it.
    pub gain: f64,
    /// What could stand in its place.
    pub rivals: Vec<Instead>,
}

/// A law that could stand in the place of another.
#[derive(Clone, Debug)]
pub struct Instead {
    /// The effect with its shape.
    pub term: Term,
    /// Its amplitudes.
    pub amplitudes: Vec<f64>,
    /// Nats by which it lies behind.
    pub behind: f64,
}

/// The laws that the missing forces of a problem's recordings obey, of these candidates.
#[must_use]
pub fn laws(
    problem: &Problem,
    belief: &Belief,
    candidates: &[Candidate],
    decision: &Decision,
) -> Vec<Obeyed> {
    let all: Vec<Along> = (0..problem.smoothed.len())
        .into_par_iter()
        .map(|r| Along::new(problem, belief, r))
        .collect();
    let off = vec![0.0; belief.uncertain.len()];
    let channels = 0..problem.model.channels();
    let rows: Vec<Vec<(usize, Rows)>> =
        channels.into_par_iter().map(|c| rows_of(problem, belief, &all, c, &off)).collect();
    let columns = Columns {
        problem,
        along: &all,
        rows: &rows,
        parameters: &belief.parameters,
        effects: belief.effects,
        slopes: Slopes::new(problem.model.inputs.len()),
    };
    let plain: Vec<Candidate> = candidates.iter().filter(|c| is_plain(c)).copied().collect();
    let offers = Offers::default();
    let Some(empty) = Pursuit::new(&columns, (&offers, candidates), belief, decision) else {
        return vec![];
    };
    let candidates = &plain[..];
    let mut best = empty.clone().pursued(candidates).heard(&empty, candidates);
    // What is wrong in a sensor, or with a body, passes for many laws of single channels.
    if best.leaves_more_than_noise() {
        for law in empty.of_many_channels(candidates) {
            let mut begun = empty.clone();
            begun.taken.push(law);
            if begun.quiet().is_none() {
                continue;
            }
            let other = begun.clone().pursued(candidates);
            let other = other.heard(&begun, candidates);
            if other.deficit() < best.deficit() {
                best = other;
            }
        }
    }
    best.refine();
    best.obeyed()
}

/// Whether a law is a plain one. What has a memory or a time of its own follows much that it is not, and the
/// variants of a law come after it.
fn is_plain(c: &Candidate) -> bool {
    let effect = c.effect;
    let variant = effect.nature.variation_of.is_some()
        || CATALOGUE
            .iter()
            .any(|e| effect.is_kin_of(e) && e.parameters.len() < effect.parameters.len());
    match effect.law {
        Law::Force(law) => {
            !variant && law.memory() == 0 && !effect.depends_on.contains(&Variable::Time)
        }
        Law::Structure(_) | Law::Input(_) | Law::Sensor(_) => !variant,
    }
}
