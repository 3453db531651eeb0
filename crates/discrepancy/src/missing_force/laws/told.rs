//! What is told of the laws in the end: amplitudes, gains and rivals.

use super::pursuit::{Pursuit, Taken};
use super::regression::Regression;
use super::{Instead, Obeyed, is_plain};
use crate::candidates::Candidate;
use crate::screen::priors;
use rayon::prelude::*;

/// Rivals that are told of a law.
const MOST_RIVALS: usize = 3;

impl Pursuit<'_> {
    /// What could stand in the place of a law beside the others, the best first.
    fn rivals(&self, without: &Regression, t: &Taken) -> Vec<Instead> {
        let own = t.term.candidate;
        let (_, magnitude) = priors(self.columns.problem, &own);
        let Some((here, _)) = self.gain(without, t, magnitude) else {
            return vec![];
        };
        let kin = |c: &&Candidate| {
            **c != own
                && (is_plain(c) || c.effect.is_kin_of(own.effect))
                && (own.excludes(c) || self.shares(&own, c))
        };
        let rivals: Vec<&Candidate> = self.every.iter().filter(kin).collect();
        let mut all: Vec<Instead> = rivals
            .par_iter()
            .filter_map(|c| {
                let (taken, gain) = self.scored(without, c)?;
                let (_, magnitude) = priors(self.columns.problem, c);
                let (_, amplitudes) = self.gain(without, &taken, magnitude)?;
                Some(Instead { term: taken.term, amplitudes, behind: here - gain })
            })
            .filter(|r| r.behind.is_finite())
            .collect();
        all.sort_by(|a, b| a.behind.total_cmp(&b.behind));
        all.truncate(MOST_RIVALS);
        all
    }

    pub(super) fn obeyed(&self) -> Vec<Obeyed> {
        let Some(base) = self.base() else { return vec![] };
        let mut all = vec![];
        for (k, (t, amplitudes)) in self.taken.iter().zip(self.amplitudes(&base)).enumerate() {
            let Some(without) = self.base_of(&self.others(k)) else { continue };
            let rivals = self.rivals(&without, t);
            let gain = base.evidence - without.evidence;
            all.push(Obeyed { term: t.term.clone(), amplitudes, gain, rivals });
        }
        all
    }
}
