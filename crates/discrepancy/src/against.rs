//! What speaks against a law before any data.
//!
//! Every law on every channel is as unlikely as any other: `prior_odds` nats. But the joints of a robot are built alike,
//! and what one of them lacks the others lack, too. That a kind of law is missing is what is unlikely, and then that just
//! these k of n joints lack one, where the rate at which they do may be anything:
//!
//! ```text
//! -ln p = prior_odds + ln (n-1 over k-1)
//! ```
//!
//! (the rule of succession: i joints that lack one make the next lack it, too, at odds of i to n - i). And that two joints
//! have to do with each other at all is what is unlikely of a coupling: where one law couples them, a further one is but
//! a draw. Several laws bear this in equal shares: where each is worth its share all of them are worth the whole, and no
//! two doubtful ones make each other likely. None is named on less than a draw.

use crate::Decision;
use crate::candidates::Candidate;
use lacuna_effects::Law;
use lacuna_plants::Model;
use lacuna_plants::model::ModelEffect;

/// Nats against a law beside others, among which it may stand itself.
pub(crate) fn against(
    model: &Model,
    decision: &Decision,
    law: &Candidate,
    beside: impl IntoIterator<Item = Candidate>,
) -> f64 {
    match model.dynamics().tree() {
        Some(_) => of_joints(model.channels(), decision, law, beside),
        None => decision.prior_odds,
    }
}

/// The same of a robot of so many joints.
fn of_joints(
    joints: usize,
    decision: &Decision,
    law: &Candidate,
    beside: impl IntoIterator<Item = Candidate>,
) -> f64 {
    let Decision { prior_odds, tie, .. } = *decision;
    if !matches!(law.effect.law, Law::Force(_)) {
        return prior_odds;
    }
    let beside = beside.into_iter().filter(|c| c != law);
    let (alike, further) = if law.effect.couples() {
        let same = beside.filter(|c| pair(c) == pair(law)).count();
        (same, same as f64 * tie)
    } else {
        let mut with: Vec<usize> = beside.filter(|c| is_kin(law, c)).map(|c| c.channel).collect();
        with.sort_unstable();
        with.dedup();
        (with.len(), log_ways(joints - 1, with.len()))
    };
    ((prior_odds + further) / (alike + 1) as f64).clamp(tie, prior_odds)
}

/// Whether a law is of the kind of another, on another channel.
fn is_kin(law: &Candidate, other: &Candidate) -> bool {
    let (own, effect) = (law.effect, other.effect);
    law.channel != other.channel && (own.class == effect.class || own.is_kin_of(effect))
}

/// The two channels that a law couples.
fn pair(law: &Candidate) -> Option<(usize, usize)> {
    let other = law.other.filter(|_| law.effect.couples())?;
    Some((law.channel.min(other), law.channel.max(other)))
}

/// The logarithm of `n` over `k`.
fn log_ways(n: usize, k: usize) -> f64 {
    (1..=k).map(|i| ((n + 1 - i) as f64 / i as f64).ln()).sum()
}

/// The same for one of some effects.
pub(crate) fn against_one(
    model: &Model,
    decision: &Decision,
    effects: &[ModelEffect],
    k: usize,
) -> f64 {
    against(model, decision, &Candidate::of(&effects[k]), effects.iter().map(Candidate::of))
}

#[cfg(test)]
mod tests {
    use super::of_joints;
    use crate::Decision;
    use crate::candidates::Candidate;
    use lacuna_effects::find;

    fn on(class: &str, channel: usize, other: Option<usize>) -> Candidate {
        Candidate { effect: find(class).expect("in the catalogue"), channel, other }
    }

    fn against(law: Candidate, beside: &[Candidate]) -> f64 {
        of_joints(6, &Decision::default(), &law, beside.iter().copied())
    }

    /// What one joint lacks alone is as unlikely as ever, and so is what acts on inputs and sensors; with each other
    /// joint that lacks it, too, it is less so, down to a draw.
    #[test]
    fn what_other_joints_lack_is_the_likelier() {
        let Decision { prior_odds, tie, .. } = Decision::default();
        let inertia = |channel| on("added_inertia", channel, None);
        let friction = |channel| on("viscous_friction", channel, None);
        assert_eq!(against(inertia(4), &[]), prior_odds);
        assert_eq!(against(inertia(4), &[friction(0), friction(1), inertia(4)]), prior_odds);
        let others: Vec<Candidate> = [0, 1, 2, 3, 5].map(inertia).to_vec();
        // (10 + ln (5 over k)) / (k + 1), k = 1, 2, 3.
        for (k, nats) in [(1, 5.805), (2, 4.101), (3, 3.076)] {
            assert!((against(inertia(4), &others[..k]) - nats).abs() < 1e-3, "{k}");
        }
        assert_eq!(against(inertia(4), &others), tie);
        // Dry friction is dry friction, whichever its law.
        let dry = [on("asymmetric_friction", 1, None), on("coulomb_friction", 1, None)];
        assert_eq!(
            against(on("stribeck_friction", 0, None), &dry),
            against(inertia(4), &others[..1])
        );
        let lag = |channel| on("actuator_lag", channel, None);
        assert_eq!(against(lag(0), &[lag(1), lag(2)]), prior_odds);
    }

    /// All laws of a kind together bear what speaks against that there are any of it.
    #[test]
    fn laws_that_need_each_other_are_not_likely_by_each_other() {
        let stiffness = |channel| on("quadratic_stiffness", channel, None);
        let shares =
            against(stiffness(1), &[stiffness(3)]) + against(stiffness(3), &[stiffness(1)]);
        assert!(shares > Decision::default().prior_odds);
    }

    /// Joints that have to do with each other may have more to do with each other.
    #[test]
    fn what_is_coupled_may_be_so_by_several_laws() {
        let Decision { prior_odds, tie, .. } = Decision::default();
        let damped = |i, j| on("cross_damping", i, Some(j));
        let rubs = on("coupling_friction", 5, Some(4));
        assert_eq!(against(rubs, &[damped(5, 3), damped(0, 1)]), prior_odds);
        assert_eq!(against(rubs, &[damped(4, 5)]), (prior_odds + tie) / 2.0);
        assert_eq!(against(rubs, &[damped(4, 5), damped(5, 4)]), (prior_odds + 2.0 * tie) / 3.0);
    }
}
