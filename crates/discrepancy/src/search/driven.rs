//! Machines that are driven by more than what was recorded: noise on the recorded inputs, random
//! forces.
//!
//! Where the search leaves more than the outputs' noise, either physics is missing that it did not
//! name, or something else drives the machine. Then it is repeated with filters in the place of
//! free runs: the intensities of what drives are fitted with the model's parameters and again with
//! every effect, and what an effect gains is what it spares them.

use super::forward::{Tried, rank};
use super::{Path, Search, Searched};
use crate::likelihood::{FULL, Fit, FitError, QUICK, intensity};
use std::sync::Arc;

/// Rounds in which intensities and parameters are fitted in turn.
const ROUNDS: usize = 3;

impl<'p> Search<'p> {
    /// What was found, or, where it leaves more than noise, what is found beside noise that drives
    /// the machine.
    pub(super) fn search_driven(&self, exact: Searched<'p>) -> Searched<'p> {
        if exact.path.fit.reduced() < self.decision.noise {
            return exact;
        }
        self.watch.tell("looking for what drives the machine beside its inputs");
        let Ok(Some(calibrated)) = self.calibrated_driven(&exact.calibrated) else { return exact };
        let driven = self.search_from(calibrated, exact.floor);
        let Ok(noise) = self.requieted(&driven.path.fit).map(|fit| fit.and_then(|f| f.noise)) else {
            return exact;
        };
        // What was found without noise may be right nevertheless.
        let level = driven.path.fit.windowed.level.max(exact.path.fit.windowed.level);
        let under = |fit: &Fit<'p>| {
            fit.at_level(level, QUICK).and_then(|f| f.driven_by(noise.clone(), FULL))
        };
        let (Ok(fit), found) = (under(&driven.path.fit), under(&exact.path.fit)) else {
            return exact;
        };
        match found {
            Ok(found) if found.gain_over(&fit) > self.decision.tie => {
                let path = Path { fit: found, named: exact.path.named };
                Searched { path: self.select(&driven.calibrated, self.prune(path)), ..driven }
            }
            _ => Searched { path: Path { fit, named: driven.path.named }, ..driven },
        }
    }

    /// The model's parameters, with the noise that drives it; none where no noise does. What drives
    /// a machine shows in windows that are long enough for it to add up.
    fn calibrated_driven(&self, exact: &Fit<'p>) -> Result<Option<Fit<'p>>, FitError> {
        let mut begun = exact.clone();
        let fit = loop {
            if let Some(fit) = self.requieted(&begun)? {
                break fit;
            }
            if begun.windowed.level == 0 {
                return Ok(None);
            }
            begun = begun.at_level(begun.windowed.level - 1, QUICK)?;
        };
        let fit = super::chain::polish(self.lengthen(fit));
        let fit = self.requieted(&fit)?;
        if let Some(fit) = &fit {
            self.tell("calibrated", fit);
        }
        Ok(fit)
    }

    /// A fit with the intensities that are most likely along it; none where no noise drives the
    /// machine.
    fn requieted<'f>(&self, fit: &Fit<'f>) -> Result<Option<Fit<'f>>, FitError> {
        let mut fit = fit.clone();
        for _ in 0..ROUNDS {
            let (noise, gained) = intensity::most_likely(&fit, self.decision.tie)?;
            if noise.is_none() || gained < self.decision.prior_odds {
                return Ok(None);
            }
            self.watch.tell(&format!(
                "noise on inputs {:.3?}, on forces {:.3?}: {gained:.0} nats",
                noise.inputs, noise.forces
            ));
            let settled = fit.noise.as_deref().is_some_and(|old| old.is_near(&noise));
            fit = fit.driven_by(Some(Arc::new(noise)), QUICK)?;
            if settled {
                break;
            }
        }
        Ok(Some(fit))
    }

    /// A fit and those that were tried on top of it, the best first, with the intensities that
    /// the best of them leaves.
    pub(super) fn quieter(
        &self,
        base: &Fit<'p>,
        mut tried: Vec<Tried<'p>>,
    ) -> Option<(Fit<'p>, Vec<Tried<'p>>)> {
        if base.noise.is_none() {
            return Some((base.clone(), tried));
        }
        // Where the best leaves nothing to noise, all are judged without.
        let noise = match self.requieted(&tried.first()?.fit) {
            Ok(fit) => fit.and_then(|f| f.noise),
            Err(_) => base.noise.clone(),
        };
        let base = base.driven_by(noise.clone(), QUICK).ok()?;
        tried.truncate(self.decision.shortlist);
        let again = tried.into_iter().filter_map(|t| {
            let fit = t.fit.driven_by(noise.clone(), QUICK).ok()?;
            Some(Tried { fit, ..t })
        });
        let mut tried: Vec<Tried> = again.collect();
        rank(&mut tried);
        Some((base, tried))
    }
}
