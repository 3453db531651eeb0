//! What a pursuit begins with: the likeliest laws of every channel by itself, or one law of many channels.

use super::block::series;
use super::pursuit::{Pursuit, Taken};
use super::subset::Subset;
use crate::candidates::{Candidate, Term};
use crate::colour::{RELIABLE, colour};
use crate::screen::priors;
use lacuna_effects::Law;
use rayon::prelude::*;

/// Laws that move the rows of many channels at once, of sensors or structure, that a pursuit may begin with.
const BEGINNINGS: usize = 3;

impl Pursuit<'_> {
    /// The likeliest laws that move the rows of several channels at once.
    pub(super) fn of_many_channels(&self, candidates: &[Candidate]) -> Vec<Taken> {
        let Some(base) = self.base() else { return vec![] };
        let many = candidates.iter().filter(|c| acts_on_many(c)).collect::<Vec<_>>();
        let mut scored: Vec<(Taken, f64)> =
            many.into_par_iter().filter_map(|c| self.scored(&base, c)).collect();
        scored.retain(|s| s.1 > self.decision.prior_odds);
        scored.sort_by(|a, b| b.1.total_cmp(&a.1));
        scored.into_iter().take(BEGINNINGS).map(|s| s.0).collect()
    }

    /// The likeliest laws of every channel by itself, beside those of many.
    pub(super) fn begin(&mut self, candidates: &[Candidate]) {
        let beside = self.taken.clone();
        if self.begin_beside(&beside, candidates, &[]).is_some() {
            let sharp = self.at_their_edges();
            self.begin_beside(&beside, candidates, &sharp);
        }
    }

    /// The same under the noise that is known so far; what they leave is known then.
    fn begin_beside(
        &mut self,
        beside: &[Taken],
        candidates: &[Candidate],
        sharp: &[Taken],
    ) -> Option<()> {
        self.taken = beside.to_vec();
        let found: Vec<Vec<Taken>> = (0..self.blocks.len())
            .into_par_iter()
            .map(|c| self.of_channel(c, candidates, sharp))
            .collect();
        self.taken.extend(found.into_iter().flatten());
        self.quiet()
    }

    /// The likeliest laws of one channel by itself, of candidates with the shapes on offer and of those that were
    /// made `sharp`.
    fn of_channel(&self, c: usize, candidates: &[Candidate], sharp: &[Taken]) -> Vec<Taken> {
        let Some(block) = &self.blocks[c] else { return vec![] };
        let (problem, rows) = (self.columns.problem, &self.columns.rows[c]);
        let whiten = |entries: &[f64]| {
            let mut entries = entries.to_vec();
            block.whiten(rows, &mut entries);
            entries
        };
        let known = self.known.iter().map(|(column, sd)| (column, *sd));
        let beside = self.taken.iter().flat_map(|t| t.columns.iter().zip(t.sd.iter().copied()));
        let known = known.chain(beside).filter_map(|(column, sd)| {
            let (_, entries) = column.iter().find(|(d, _)| *d == c)?;
            Some((whiten(entries), sd))
        });
        let mut subset = Subset::new(whiten(&self.right[c]), known.collect());
        let mut made: Vec<Taken> = vec![];
        for candidate in candidates.iter().filter(|k| self.acts_alone(k, c)) {
            if self.taken.iter().any(|t| t.term.candidate.excludes(candidate)) {
                continue;
            }
            let offer = self.offers.of(self.columns, candidate);
            let (sd, magnitude) = priors(problem, candidate);
            for (columns, shape) in offer.columns.iter().zip(&offer.shapes) {
                let only = columns.iter().all(|col| col.len() == 1 && col[0].0 == c);
                if !only || columns.is_empty() {
                    continue;
                }
                let own = columns.iter().map(|col| whiten(&col[0].1)).collect();
                subset.offer(*candidate, own, &sd, magnitude);
                let term = Term { candidate: *candidate, shape: shape.clone() };
                made.push(Taken { term, columns: columns.clone(), sd: sd.clone() });
            }
        }
        for law in sharp.iter().filter(|law| self.acts_alone(&law.term.candidate, c)) {
            let (sd, magnitude) = priors(problem, &law.term.candidate);
            let own = law.columns.iter().map(|col| whiten(&col[0].1)).collect();
            subset.offer(law.term.candidate, own, &sd, magnitude);
            made.push(law.clone());
        }
        let series = |left: &[f64]| colour(series(rows, left).into_iter(), RELIABLE);
        let chosen = subset.likeliest(self.decision.prior_odds, series);
        let mut at = 0;
        made.retain(|_| {
            at += 1;
            chosen.contains(&(at - 1))
        });
        made
    }
}

/// Whether a law moves the rows of several channels at once.
fn acts_on_many(c: &Candidate) -> bool {
    matches!(c.effect.law, Law::Sensor(_) | Law::Structure(_))
}
