//! The ladder: how much of the mismatch is parameters, each named effect, still unknown.
//!
//! Let E(p, e) be the mean square misfit above the noise with the model's parameters as they were
//! or as they are now (p) and without or with the effects (e). Parameters alone can take up much
//! of what an effect does, and an effect what wrong parameters do, so neither may stand first:
//! each gets the mean of what it takes away before and after the other (Shapley's value),
//!
//! ```text
//! share of p = (E(0,0) - E(1,0) + E(0,1) - E(1,1)) / 2 E(0,0)
//! ```

use super::outcome::Ladder;
use crate::diagnosis::Rung;
use crate::likelihood::{FULL, Fit, Hypothesis};

impl Ladder<'_> {
    /// Shares of the misfit that parameters and effects take away, and what remains.
    pub(super) fn rungs(&self) -> Vec<Rung> {
        let found = &self.found;
        let total = (found.nominal.reduced() - 1.0).max(1e-12);
        let share = |f: &Fit| ((f.reduced() - 1.0) / total).max(0.0);
        let unexplained = share(&found.chosen).min(1.0);
        let named: f64 = self.share_of_effects(&share).clamp(0.0, 1.0 - unexplained);
        let rung = |what: String, share: f64| Rung { what, share };
        let mut rungs = vec![rung("calibration".to_owned(), 1.0 - unexplained - named)];
        let gains: f64 = found.named.iter().map(|n| n.gain.max(0.0)).sum();
        for (e, n) in self.effects.iter().zip(&found.named) {
            let part = if gains > 0.0 { n.gain.max(0.0) / gains } else { 1.0 };
            let on = self.problem.model.effect_channel_name(e.effect, e.channel);
            let what = format!("{} {}", e.effect.words, e.effect.acts.at(on));
            rungs.push(rung(what, part * named));
        }
        rungs.push(rung("unexplained".to_owned(), unexplained));
        rungs
    }

    fn share_of_effects(&self, share: &(dyn Fn(&Fit) -> f64 + Sync)) -> f64 {
        let chosen = &self.found.chosen;
        if chosen.hypothesis.supposed().is_empty() {
            return 0.0;
        }
        let states = |h: Hypothesis| chosen.refit(h.held(), FULL).ok();
        let nominal = &self.found.nominal.hypothesis;
        let (mut moved, mut added) = (nominal.clone(), chosen.hypothesis.clone());
        moved.parameters.clone_from(&chosen.hypothesis.parameters);
        added.parameters.clone_from(&nominal.parameters);
        // What diverges explains nothing of the misfit.
        let of = |h: Hypothesis| states(h).as_ref().map_or(1.0, share).min(1.0);
        let (added, moved) = rayon::join(|| of(added), || of(moved));
        0.5 * (1.0 - added + moved - share(chosen).min(1.0))
    }
}
