//! What a case is about, and in which order topics come.

use lacuna_effects::Effect;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::beyond::Kind;
use super::places::{classes, robots_classes};
use super::sealed::Group;
use super::several::several;

/// What is unusual about the noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noise {
    /// Nothing: white.
    White,
    /// Correlated from sample to sample.
    Coloured,
    /// White, and the clock of the time stamps jitters.
    Jitter,
}

/// What a real machine, or its logger, does beside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hardship {
    /// The recorded inputs are noisy; the machine gets them exactly.
    NoisyInputs,
    /// A random force acts on a channel.
    RandomForce,
    /// Nobody measures one of the coordinates.
    HiddenCoordinate,
    /// Some samples are glitches.
    Glitches,
    /// The log holds one sample in two or four.
    SlowLog,
}

/// What a case conceals.
#[derive(Clone, Copy, Debug)]
pub enum Topic {
    /// An effect of the catalogue.
    Effect(&'static Effect),
    /// Two effects of the catalogue.
    Pair,
    /// A law beyond the catalogue.
    Beyond(Kind),
    /// An effect of the catalogue, whichever, under noise that is not white.
    Under(Noise),
    /// Nothing.
    Nothing(Noise),
    /// Wrong parameters.
    Parameter,
    /// A force of the catalogue, whichever, amid what real machines do.
    Amid(Hardship),
    /// Nothing but that.
    Only(Hardship),
    /// Three effects of the catalogue.
    Three,
    /// Dry and viscous friction on every joint.
    Friction,
}

impl Topic {
    /// The topic in a word or two.
    pub fn words(self) -> String {
        let noise = |n: Noise| match n {
            Noise::White => "white noise",
            Noise::Coloured => "coloured noise",
            Noise::Jitter => "clock jitter",
        };
        match self {
            Self::Effect(effect) => effect.class.to_owned(),
            Self::Pair => "two effects".to_owned(),
            Self::Beyond(kind) => format!("{kind:?}"),
            Self::Under(n) => format!("an effect under {}", noise(n)),
            Self::Nothing(n) => format!("nothing, {}", noise(n)),
            Self::Parameter => "parameters".to_owned(),
            Self::Amid(hardship) => format!("an effect amid {hardship:?}"),
            Self::Only(hardship) => format!("nothing but {hardship:?}"),
            Self::Three => "three effects".to_owned(),
            Self::Friction => "friction of all joints".to_owned(),
        }
    }

    /// What the machine or its logger does beside.
    pub fn hardship(self) -> Option<Hardship> {
        match self {
            Self::Amid(hardship) | Self::Only(hardship) => Some(hardship),
            _ => None,
        }
    }

    /// The noise of the recordings.
    pub fn noise(self) -> Noise {
        match self {
            Self::Under(noise) | Self::Nothing(noise) => noise,
            _ => Noise::White,
        }
    }
}

/// Pairs among the effects of the catalogue, as a number of classes.
const PAIRS: usize = 4;

/// All topics of a group.
fn topics(group: Group) -> Vec<Topic> {
    let effect = |name: &str| classes().filter(|e| e.class == name).map(Topic::Effect).next();
    match group {
        Group::Catalogue => classes().map(Topic::Effect).chain([Topic::Pair; PAIRS]).collect(),
        Group::OffFormula => {
            let twice = [Kind::LuGre, Kind::Dahl, Kind::SofteningSpring];
            let once = [Kind::LoadFriction, Kind::DampedStop, Kind::HertzianStop, Kind::PowerDrag];
            let laws = twice.iter().chain(&twice).chain(&once).map(|k| Topic::Beyond(*k));
            laws.chain([Topic::Under(Noise::Coloured), Topic::Under(Noise::Jitter)]).collect()
        }
        Group::Local => {
            let beyond = [Kind::Bump, Kind::Overflow].map(Topic::Beyond);
            ["end_stop", "step_change"].into_iter().filter_map(effect).chain(beyond).collect()
        }
        Group::Null => vec![
            Topic::Nothing(Noise::White),
            Topic::Nothing(Noise::White),
            Topic::Parameter,
            Topic::Parameter,
            Topic::Nothing(Noise::Coloured),
            Topic::Nothing(Noise::Jitter),
        ],
        Group::Machines => {
            use Hardship::{Glitches, HiddenCoordinate, NoisyInputs, RandomForce, SlowLog};
            let amid = [NoisyInputs, RandomForce, HiddenCoordinate, Glitches, SlowLog];
            let only = [NoisyInputs, RandomForce, NoisyInputs, RandomForce, Glitches];
            let twice = amid.iter().chain(&amid).map(|h| Topic::Amid(*h));
            let several = several().map(Topic::Effect).chain([Topic::Three; 2]);
            twice.chain(only.map(Topic::Only)).chain(several).collect()
        }
        Group::Robots => {
            let nothing = [Topic::Nothing(Noise::White), Topic::Parameter];
            let many = [Topic::Pair, Topic::Pair, Topic::Three, Topic::Friction];
            robots_classes().map(Topic::Effect).chain(many).chain(nothing).chain(nothing).collect()
        }
    }
}

/// The topics of the first `count` cases of a group: all of them once in random order, then again.
pub fn sequence(group: Group, count: usize, rng: &mut ChaCha8Rng) -> Vec<Topic> {
    let mut sequence = Vec::new();
    while sequence.len() < count {
        let mut round = topics(group);
        shuffle(&mut round, rng);
        sequence.extend(round);
    }
    sequence.truncate(count);
    sequence
}

/// A random order (Fisher and Yates).
pub fn shuffle<T>(items: &mut [T], rng: &mut ChaCha8Rng) {
    for k in (1..items.len()).rev() {
        items.swap(k, rng.random_range(0..k + 1));
    }
}

/// How many of `count` cases each group gets when all are asked for; what real machines do is asked
/// for by name.
pub fn shares(count: usize) -> [(Group, usize); 4] {
    let share = |percent: usize| count * percent / 100;
    let (beyond, local, null) = (share(25), share(15), share(20));
    [
        (Group::Catalogue, count - beyond - local - null),
        (Group::OffFormula, beyond),
        (Group::Local, local),
        (Group::Null, null),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use lacuna_excitation::rng;
    use std::collections::BTreeSet;

    #[test]
    fn every_topic_comes_before_any_comes_again() {
        for group in Group::ALL {
            let count = topics(group).len();
            let all = sequence(group, count, &mut rng(1, 0));
            let words = |t: &[Topic]| t.iter().map(|t| t.words()).collect::<BTreeSet<_>>();
            assert_eq!(words(&all), words(&topics(group)), "{group:?}");
        }
        assert_eq!(shares(101).iter().map(|s| s.1).sum::<usize>(), 101);
    }
}
