//! A force rather than a sensor. A servo that droops under a constant load and one whose sensor has an offset are the
//! same recordings: where both say as much, the force is named, and the sensor is its rival.

use super::{Path, Rival, Search, effect_of};
use crate::candidates::Candidate;
use crate::likelihood::{FULL, Fit, QUICK, STILL, What};
use lacuna_effects::Acts;

impl<'p> Search<'p> {
    /// A path in which a constant force stands in the place of what is said of a sensor, wherever it says as much.
    pub(super) fn force_rather(&self, mut path: Path<'p>) -> Path<'p> {
        for k in (0..path.named.len()).rev() {
            let sensor = Candidate::of(&path.fit.hypothesis.supposed()[k]);
            let Some(force) = self.constant_on(&sensor) else { continue };
            if path.fit.hypothesis.supposed().iter().any(|e| Candidate::of(e) == force) {
                continue;
            }
            let Some(fit) = self.taken_over(&path.fit, k, &force) else { continue };
            // Equals are told apart by no prior's width.
            let likelihood = |fit: &Fit| -0.5 * (fit.chi2 + fit.width());
            let lead = (likelihood(&fit) - likelihood(&path.fit)) / path.fit.temperature();
            let words = sensor.effect.words;
            self.watch.tell(&format!("a constant force leads {words} by {lead:.1} nats"));
            if lead < -self.decision.tie {
                continue;
            }
            let before = std::mem::replace(&mut path.fit, fit).hypothesis;
            let mut named = path.named.remove(k);
            named.rivals.retain(|r| r.candidate != force);
            named.rivals.push(Rival {
                candidate: sensor,
                behind: lead.max(0.0),
                hypothesis: before,
            });
            path.named.push(named);
        }
        path
    }

    /// A fit in which a force takes over what a sensor's effect `k` says, little by little: from none of it there may be
    /// no way to all of it.
    fn taken_over(&self, fit: &Fit<'p>, k: usize, force: &Candidate) -> Option<Fit<'p>> {
        let e = fit.hypothesis.own + k;
        let whole = fit.hypothesis.effects[e].parameters.clone();
        let ideal = fit.hypothesis.effects[e].effect.nature.ideal;
        let both = self.with(&fit.hypothesis, effect_of(force, &[0.0], &[]));
        let mut fit = fit.refit(both, STILL).ok()?;
        for share in [0.75, 0.5, 0.25, 0.0] {
            let mut h = fit.hypothesis.clone();
            let parameters = h.effects[e].parameters.iter_mut().zip(&whole).zip(ideal);
            parameters.for_each(|((now, whole), ideal)| *now = ideal + share * (whole - ideal));
            h.free.retain(|f| !matches!(f.what, What::Effect(effect, _) if effect == e));
            fit = fit.refit(h, QUICK).ok()?;
        }
        fit.without(k, FULL).ok()
    }

    /// The constant force on what a sensor measures, if it may be named.
    fn constant_on(&self, sensor: &Candidate) -> Option<Candidate> {
        if sensor.effect.acts != Acts::Sensors {
            return None;
        }
        let state = |c: &Candidate| self.problem.model.coordinate_index(c.channel);
        let mut all = self.candidates.iter();
        all.find(|c| c.is_constant() && state(c) == sensor.channel).copied()
    }
}
