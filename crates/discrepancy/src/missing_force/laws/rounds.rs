//! Rounds, each of which takes laws, gives up what is no longer missed and puts likelier laws in the places of others.

use super::pursuit::{Pursuit, Taken};
use super::regression::Regression;
use crate::candidates::Candidate;
use crate::screen::priors;
use rayon::prelude::*;

/// Rounds, each of which names at most one law a channel.
const ROUNDS: usize = 12;

impl Pursuit<'_> {
    /// The laws that are found beside those that were taken.
    pub(super) fn pursued(mut self, candidates: &[Candidate]) -> Self {
        self.begin(candidates);
        self.run(candidates);
        self
    }

    fn run(&mut self, candidates: &[Candidate]) {
        for _ in 0..ROUNDS {
            let Some(base) = self.base() else { return };
            let have: Vec<Candidate> = self.taken.iter().map(|t| t.term.candidate).collect();
            let left: Vec<&Candidate> =
                candidates.iter().filter(|c| !have.iter().any(|h| h.excludes(c))).collect();
            let mut scored: Vec<(Taken, f64)> =
                left.par_iter().filter_map(|c| self.scored(&base, c)).collect();
            for (law, gain) in &mut scored {
                *gain -= self.against(&law.term.candidate, &self.taken);
            }
            scored.retain(|s| s.1 > 0.0);
            scored.sort_by(|a, b| b.1.total_cmp(&a.1));
            let mut busy = vec![false; self.blocks.len()];
            let mut news = 0;
            for (taken, _) in scored {
                let on: Vec<usize> = taken.columns.iter().flatten().map(|(c, _)| *c).collect();
                if on.iter().any(|c| busy[*c]) {
                    on.iter().for_each(|c| busy[*c] = true);
                    continue;
                }
                on.iter().for_each(|c| busy[*c] = true);
                self.taken.push(taken);
                news += 1;
            }
            if self.quiet().is_none() {
                return;
            }
            self.revise(candidates);
            if news == 0 {
                return;
            }
        }
    }

    /// Give up what is no longer missed, and put a law in another's place where it is the likelier.
    fn revise(&mut self, candidates: &[Candidate]) {
        let mut k = 0;
        while k < self.taken.len() {
            let others = self.others(k);
            let Some(base) = self.base_of(&others) else { return };
            let own = self.taken[k].term.candidate;
            let rivals: Vec<&Candidate> = candidates
                .iter()
                .filter(|c| **c == own || (own.excludes(c) || self.shares(&own, c)))
                .filter(|c| **c == own || !others.iter().any(|o| o.term.candidate.excludes(c)))
                .collect();
            let scored: Vec<(Taken, f64)> =
                rivals.par_iter().filter_map(|c| self.scored(&base, c)).collect();
            let against = |law: &Candidate| self.against(law, others.iter().copied());
            let here = self.gain_here(&base, &self.taken[k], &scored) - against(&own);
            let worth = |(taken, gain): (Taken, f64)| {
                let against = against(&taken.term.candidate);
                (taken, gain - against)
            };
            let best = scored.into_iter().map(worth).max_by(|a, b| a.1.total_cmp(&b.1));
            let better = best.filter(|(taken, worth)| {
                let least =
                    if taken.term.candidate == own { here } else { here + self.decision.tie };
                *worth > 0.0 && *worth >= least
            });
            match better {
                Some((taken, _)) => self.taken[k] = taken,
                None if here > 0.0 => {}
                None => {
                    self.taken.remove(k);
                    continue;
                }
            }
            k += 1;
        }
    }

    /// Nats that a law gains beside others: as it was scored with them, or with the shape that it has, one of as many
    /// as are on offer, where that gains more.
    fn gain_here(&self, base: &Regression, law: &Taken, scored: &[(Taken, f64)]) -> f64 {
        let own = law.term.candidate;
        let (_, magnitude) = priors(self.columns.problem, &own);
        let shapes = self.offers.of(self.columns, &own).shapes.len();
        let standing = self.gain(base, law, magnitude).map(|g| g.0 - (shapes as f64).ln());
        let here = scored.iter().find(|s| s.0.term.candidate == own).map(|s| s.1);
        here.into_iter().chain(standing).fold(f64::MIN, f64::max)
    }

    /// Put richer laws of its kind in the place of one where they are worth as much as a law of their own.
    pub(super) fn refine(&mut self) {
        for k in 0..self.taken.len() {
            let own = self.taken[k].term.candidate;
            let kin: Vec<&Candidate> = self
                .every
                .iter()
                .filter(|c| c.channel == own.channel && c.effect.is_kin_of(own.effect))
                .filter(|c| c.effect.nature.variation_of.is_none())
                .collect();
            let base = self.base_of(&self.others(k));
            let Some(base) = base.filter(|_| kin.len() > 1) else { continue };
            let scored: Vec<(Taken, f64)> =
                kin.par_iter().filter_map(|c| self.scored(&base, c)).collect();
            let here = self.gain_here(&base, &self.taken[k], &scored);
            let best = scored.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((taken, _)) = best.filter(|b| b.1 > here + self.decision.prior_odds) {
                self.taken[k] = taken;
            }
        }
    }
}
