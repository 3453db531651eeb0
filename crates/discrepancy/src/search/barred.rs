//! What a name bars. A law that says most of what two others do bars its kin from standing beside it, and so may bar
//! one of the two: a spring that slips is nearly a loop and dry friction, and the friction is its kin.

use super::{MOST_EFFECTS, Named, Path, Rival, Search, chain};
use crate::candidates::Candidate;
use crate::likelihood::QUICK;

impl<'p> Search<'p> {
    /// A path to which nothing further could be added, or one that begins with a rival of its last effect: where the
    /// path leaves more than noise, the rival bars less, and with what it does not bar it does better.
    pub(super) fn unbarred(&self, path: Path<'p>) -> Path<'p> {
        let Some((last, before)) = path.named.split_last() else { return path };
        if path.fit.reduced() < self.decision.explained || self.watch.is_late() {
            return path;
        }
        let named = path.fit.hypothesis.supposed();
        let Some(own) = named.last().map(Candidate::of) else { return path };
        for rival in last.rivals.iter().filter(|r| self.bars_less(&own, &r.candidate)) {
            let Ok(fit) = path.fit.refit(rival.hypothesis.clone(), QUICK) else { continue };
            self.tell("begun anew", &fit);
            let behind = path.fit.gain_over(&fit);
            let given_up =
                Rival { candidate: own, behind, hypothesis: path.fit.hypothesis.clone() };
            let begun = Named { gain: last.gain - behind, rivals: vec![given_up] };
            let named = before.iter().cloned().chain([begun]).collect();
            let found = self.forward(Path { fit: chain::polish(fit), named }, None, MOST_EFFECTS);
            if found.named.len() <= path.named.len() {
                continue;
            }
            let more = (found.named.len() - path.named.len()) as f64;
            // In windows as long as those that the path follows.
            let Ok(alike) = found.fit.at_level(path.fit.windowed.level, QUICK) else { continue };
            if alike.gain_over(&path.fit) > more * self.decision.prior_odds {
                return found;
            }
        }
        path
    }

    /// Whether some candidate is barred beside one and not beside its rival.
    fn bars_less(&self, own: &Candidate, rival: &Candidate) -> bool {
        let barred = |c: &Candidate| own.excludes(c) && c != own && !rival.excludes(c);
        self.candidates.iter().any(barred)
    }
}
