//! The search begun afresh. Parameters take the place of what is missing as far as they can, and a constant force
//! that is missing too puts every path off by more than any law changes: what is then found, or not, may hang on
//! where the search began. Where it leaves much, it is begun again: beside a constant force, which need not be
//! missed itself, with forces along the measured motion and not along that of a model far from it, and with fits that
//! begin in several places; and without what was found first there, which may say the most by itself and leave nothing that
//! another could be told beside.

use super::forward::settles;
use super::{First, MOST_EFFECTS, Named, Once, Path, Search, Searched, effect_of, untried};
use crate::candidates::Candidate;
use crate::likelihood::{FULL, Fit, QUICK};
use lacuna_effects::Acts;

/// Searches without what those before them found first: each takes as long as the one begun, and what hides others is
/// seldom more than a law and what comes next to it.
const WITHOUT: usize = 3;

impl<'p> Search<'p> {
    /// A search by free runs, or one begun afresh, where the first leaves more than noise, no small share of the
    /// mismatch, and the other takes most of it away.
    pub(super) fn begun_afresh(
        &self,
        calibrated: &Fit<'p>,
        mut free: Searched<'p>,
        driven: &Once<'p>,
    ) -> Searched<'p> {
        // Of a robot the measured motion has been asked already (`together`); and where noise that drives the machine
        // says all that was not named, nothing hides.
        let nothing = free.path.named.is_empty() && self.is_driven(calibrated, driven);
        if nothing || self.problem.is_robot() || self.says_it(calibrated, &free.path) {
            return free;
        }
        let mut search = Self { afresh: true, ..self.clone() };
        let constants = self.candidates.iter().filter(|c| c.is_constant()).map(Some);
        for constant in constants.chain([None; 1 + WITHOUT]) {
            if self.watch.skips(untried::AFRESH) {
                break;
            }
            let found = search.begun_with(constant, calibrated, driven);
            if constant.is_none() {
                // What finds nothing would find nothing again.
                let Some(found) = &found else { break };
                search = search.without_first_of(found);
            }
            let Some(found) = found else { continue };
            if !self.leads(&found, &free.path) {
                continue;
            }
            let path = self.selected(calibrated, found);
            if self.leads(&path, &free.path) {
                free.path = path;
                if self.says_it(calibrated, &free.path) {
                    break;
                }
            }
        }
        free
    }

    /// The same search without what a path found first.
    fn without_first_of(mut self, path: &Path) -> Self {
        if let Some(first) = path.fit.hypothesis.supposed().first().map(Candidate::of) {
            self.candidates.retain(|c| !first.excludes(c));
        }
        self
    }

    /// Whether a path says all of the mismatch but a small share of it. A constant force, and an offset of a sensor that
    /// passes for one, may say most of it, and hide all else.
    fn says_it(&self, calibrated: &Fit<'p>, path: &Path<'p>) -> bool {
        if path.fit.reduced() < self.decision.explained {
            return true;
        }
        let hides = |c: Candidate| c.effect.acts == Acts::Sensors || c.is_constant();
        if path.fit.hypothesis.supposed().iter().map(Candidate::of).all(hides) {
            return false;
        }
        let without = calibrated.at_level(path.fit.windowed.level, QUICK);
        without.is_ok_and(|fit| path.fit.excess() < self.decision.share * fit.excess())
    }

    /// What is found beside a constant force, or beside nothing.
    fn begun_with(
        &self,
        constant: Option<&Candidate>,
        calibrated: &Fit<'p>,
        driven: &Once<'p>,
    ) -> Option<Path<'p>> {
        let begun = match constant {
            Some(constant) => {
                let h = self.with(&calibrated.hypothesis, effect_of(constant, &[0.0], &[]));
                let fit = calibrated.refit(h, FULL).ok()?;
                let named = vec![Named { gain: fit.gain_over(calibrated), rivals: vec![] }];
                Path { fit, named }
            }
            None => Path { fit: calibrated.clone(), named: vec![] },
        };
        self.tell("begun afresh", &begun.fit);
        let (least, look) = (begun.named.len() + 1, self.look(&begun.fit));
        let First { path, .. } = self.first(begun, look, driven);
        (path.named.len() >= least).then(|| self.forward(path, None, MOST_EFFECTS))
    }

    /// Whether a path takes away most of what another leaves, in the longer windows of the two, and is worth what it
    /// has more.
    fn leads(&self, found: &Path<'p>, path: &Path<'p>) -> bool {
        let level = found.fit.windowed.level.min(path.fit.windowed.level);
        let (Ok(with), Ok(without)) =
            (found.fit.at_level(level, QUICK), path.fit.at_level(level, QUICK))
        else {
            return false;
        };
        let more = found.named.len().saturating_sub(path.named.len()) as f64;
        let least = (more * self.decision.prior_odds).max(self.decision.tie);
        settles(&self.decision, (&without, &with), self.decision.further_share, 0.0)
            && with.gain_over(&without) > least
    }
}
