//! Laws of the catalogue that the difference of a drift is: weighted least squares over the common states.

use super::functions::Entry;
use super::place::weights;
use crate::effects::{
    Acts, AnyForceLaw, At, CATALOGUE, Channel, Effect, Law as Kind, Scales, Variable,
};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Functions of a motion are smooth: so many states at most speak for themselves.
const INDEPENDENT: f64 = 60.0;
/// Most laws on a channel.
const MOST: usize = 3;
/// Difference of the Bayesian information criterion that a law must make.
const WORTH: f64 = 6.0;
/// Share of the whole difference that a law must tell.
const TELLS: f64 = 0.05;
/// Share that all laws of a channel must tell to be named.
const NAMED: f64 = 0.5;
/// Rivals below this probability are not told.
const RIVAL: f64 = 0.02;

/// A law that tells a difference.
#[derive(Clone, Debug, Serialize)]
pub struct Law {
    /// Its class.
    pub class: String,
    /// Where it acts.
    pub channel: String,
    /// Its parameters: value and standard deviation, where it has one. In the units of the inputs and the channel, or of
    /// accelerations.
    pub parameters: BTreeMap<String, (f64, Option<f64>)>,
    /// Whether the simulator has too much of it, and the machine less.
    pub in_the_simulator: bool,
    /// Share of the difference that is told when it is added.
    pub tells: f64,
    /// Probability beside its rivals.
    pub probability: f64,
    /// Other classes that could stand in its place.
    pub alternatives: Vec<Rival>,
    /// What it says.
    #[serde(skip)]
    pub words: &'static str,
    /// The force of all laws of the channel, state by state.
    #[serde(skip)]
    pub force: Vec<f64>,
}

/// Another class.
#[derive(Clone, Debug, Serialize)]
pub struct Rival {
    /// Its class.
    pub class: String,
    /// Its probability.
    pub probability: f64,
}

/// The channel whose drift differs.
pub struct Differing<'a> {
    pub entry: &'a Entry,
    pub name: &'a str,
    /// Its place among the channels, and how many there are.
    pub place: (usize, usize),
    pub order: usize,
    pub states: &'a [Vec<f64>],
}

/// By what a shape is multiplied and divided, one after the other.
const FACTORS: [f64; 6] = [1.4, 1.4, 1.2, 1.2, 1.1, 1.05];

/// Laws by weighted least squares.
struct Fit {
    /// Bayesian information criterion.
    score: f64,
    /// Weighted sum of squares left.
    left: f64,
    amplitudes: Vec<f64>,
    std: Vec<f64>,
    force: Vec<f64>,
}

/// A law with its shape, and the force of each amplitude.
#[derive(Clone)]
struct Candidate {
    effect: &'static Effect,
    law: &'static dyn AnyForceLaw,
    shape: Vec<f64>,
    basis: Vec<Vec<f64>>,
}

impl Differing<'_> {
    /// The laws that tell the difference, in the order in which they do; none where they do not.
    pub fn named(&self) -> Vec<Law> {
        let candidates = self.candidates();
        let whole = self.fit(&[]);
        let (mut chosen, mut laws) = (Vec::<Candidate>::new(), Vec::<Law>::new());
        let mut best = whole.left;
        let mut score = whole.score;
        while chosen.len() < MOST {
            let mut tried: Vec<(Candidate, Fit)> = candidates
                .iter()
                .filter(|c| chosen.iter().all(|o| !is_kin(o.effect, c.effect)))
                .map(|c| (c.clone(), self.with(&chosen, c)))
                .filter(|(c, fit)| c.sign(fit).is_some())
                .collect();
            tried.sort_by(|a, b| a.1.score.total_cmp(&b.1.score));
            let mut classes = BTreeSet::new();
            for (candidate, fit) in &mut tried {
                // The first of a class is its best.
                if classes.insert(candidate.effect.class) {
                    self.refine(&chosen, candidate, fit);
                }
            }
            tried.sort_by(|a, b| a.1.score.total_cmp(&b.1.score));
            let Some((candidate, fit)) = tried.first() else { break };
            let tells = (best - fit.left) / whole.left;
            if score - fit.score < WORTH || tells < TELLS {
                break;
            }
            laws.push(candidate.told(fit, self.name, tells, &tried));
            (best, score) = (fit.left, fit.score);
            chosen.push(candidate.clone());
        }
        match best < (1.0 - NAMED) * whole.left {
            true => laws,
            false => vec![],
        }
    }

    /// All laws of this channel's own motion, at all their shapes.
    fn candidates(&self) -> Vec<Candidate> {
        let scales = self.scales(self.channel());
        let fits = |effect: &Effect| {
            let acts = match effect.acts {
                Acts::Coordinates => self.order == 2,
                Acts::States => self.order == 1,
                Acts::CoordinatesAndStates | Acts::CoordinatesAndSpeeds => true,
                _ => false,
            };
            let own = [Variable::Coordinate, Variable::Velocity];
            acts && effect.nature.onset.is_none()
                && effect.depends_on.iter().all(|v| own.contains(v))
        };
        let mut all = vec![];
        for effect in CATALOGUE.iter().copied().filter(|e| fits(e)) {
            let Kind::Force(law) = effect.law else { continue };
            if law.memory() > 0 {
                continue;
            }
            for shape in (effect.shapes)(&scales) {
                all.push(self.candidate(effect, law, shape));
            }
        }
        all
    }

    fn channel(&self) -> Channel {
        let (i, n) = self.place;
        Channel { q: i, v: if self.order == 1 { i } else { n + i }, si: 1.0 }
    }

    fn candidate(
        &self,
        effect: &'static Effect,
        law: &'static dyn AnyForceLaw,
        shape: Vec<f64>,
    ) -> Candidate {
        let channels = [self.channel()];
        let mut basis = vec![Vec::with_capacity(self.states.len()); law.amplitudes()];
        let mut at_one = vec![0.0; law.amplitudes()];
        for x in self.states {
            law.plain().along(&shape, &At::new(0.0, x, &channels), &mut at_one);
            basis.iter_mut().zip(&at_one).for_each(|(series, b)| series.push(*b));
        }
        Candidate { effect, law, shape, basis }
    }

    /// Move a law's shape to where it tells most.
    fn refine(&self, chosen: &[Candidate], candidate: &mut Candidate, fit: &mut Fit) {
        for factor in FACTORS {
            for k in 0..candidate.shape.len() {
                for factor in [factor, 1.0 / factor] {
                    let mut shape = candidate.shape.clone();
                    shape[k] *= factor;
                    let moved = self.candidate(candidate.effect, candidate.law, shape);
                    let better = self.with(chosen, &moved);
                    if better.left < fit.left && moved.sign(&better).is_some() {
                        (*candidate, *fit) = (moved, better);
                    }
                }
            }
        }
    }

    /// The fit of some laws and one more.
    fn with(&self, chosen: &[Candidate], one: &Candidate) -> Fit {
        self.fit(&[chosen, std::slice::from_ref(one)].concat())
    }

    fn scales(&self, channel: Channel) -> Scales {
        let series = |k: usize| self.states.iter().map(move |x| x[k]);
        let range = series(channel.q)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), q| (a.min(q), b.max(q)));
        let speed = super::functions::rms(&series(channel.v).collect::<Vec<_>>());
        Scales {
            q: range,
            stroke: 0.5 * (range.1 - range.0),
            v: speed,
            acceleration: self.entry.scale,
            force: self.entry.scale,
            time: (0.0, 1.0),
            step: 1.0,
            ..Scales::default()
        }
    }

    fn fit(&self, laws: &[Candidate]) -> Fit {
        let difference = self.entry.difference();
        let weights = weights(self.entry);
        let series: Vec<&Vec<f64>> = laws.iter().flat_map(|c| &c.basis).collect();
        let (rows, columns) = (difference.len(), series.len());
        let y = DVector::from_fn(rows, |k, _| difference[k] * weights[k].sqrt());
        let b = DMatrix::from_fn(rows, columns, |k, j| series[j][k] * weights[k].sqrt());
        let normal = b.transpose() * &b;
        // A law that is 0 everywhere, or the same as another, is no law here.
        let inverse = normal.try_inverse().filter(|i| i.iter().all(|v| v.is_finite()));
        let Some(inverse) = inverse.or_else(|| (columns == 0).then(|| DMatrix::zeros(0, 0))) else {
            return Fit {
                score: f64::INFINITY,
                left: f64::INFINITY,
                amplitudes: vec![],
                std: vec![],
                force: vec![],
            };
        };
        let amplitudes = &inverse * b.transpose() * &y;
        let left = (&y - &b * &amplitudes).norm_squared();
        let each = left / rows as f64;
        let free = columns + laws.iter().map(|c| c.shape.len()).sum::<usize>();
        // What is left below the noise says nothing.
        let independent = INDEPENDENT.min(rows as f64);
        let score = independent * each.max(1.0).ln() + free as f64 * independent.ln();
        let inflation = each.max(1.0) * rows as f64 / independent;
        let std = (0..columns).map(|j| (inflation * inverse[(j, j)]).sqrt()).collect();
        let at = |k: usize| series.iter().zip(amplitudes.iter()).map(|(s, a)| s[k] * a).sum();
        let force = (0..rows).map(at).collect();
        Fit { score, left, amplitudes: amplitudes.iter().copied().collect(), std, force }
    }
}

/// Whether two laws are of one family, of which a channel has one, or the same.
fn is_kin(a: &Effect, b: &Effect) -> bool {
    let family = |e: &Effect| e.nature.kin.map(|kin| std::ptr::from_ref(kin.family));
    a.class == b.class || (family(a).is_some() && family(a) == family(b))
}

impl Candidate {
    /// Its own amplitudes, which stand last.
    fn own<'f>(&self, values: &'f [f64]) -> &'f [f64] {
        &values[values.len() - self.basis.len()..]
    }

    fn physical(&self, amplitudes: impl Iterator<Item = f64>) -> Vec<f64> {
        self.law.physical(&amplitudes.chain(self.shape.iter().copied()).collect::<Vec<_>>())
    }

    /// 1 where the machine has it, -1 where the simulator has too much of it; none where it makes no sense either way.
    fn sign(&self, fit: &Fit) -> Option<f64> {
        if !fit.score.is_finite() {
            return None;
        }
        let makes_sense = |sign: f64| {
            let physical = self.physical(self.own(&fit.amplitudes).iter().map(|a| sign * a));
            self.effect.values().zip(physical).all(|(p, v)| p.range.contains(v))
        };
        [1.0, -1.0].into_iter().find(|sign| makes_sense(*sign))
    }

    fn told(&self, fit: &Fit, channel: &str, tells: f64, tried: &[(Self, Fit)]) -> Law {
        let sign = self.sign(fit).unwrap_or(1.0);
        let own: Vec<f64> = self.own(&fit.amplitudes).iter().map(|a| sign * a).collect();
        let physical = self.physical(own.iter().copied());
        let mut variance = vec![0.0; physical.len()];
        for (k, std) in self.own(&fit.std).iter().enumerate() {
            let moved = self
                .physical(own.iter().enumerate().map(|(j, a)| a + if j == k { *std } else { 0.0 }));
            variance
                .iter_mut()
                .zip(moved.iter().zip(&physical))
                .for_each(|(v, (a, b))| *v += (a - b).powi(2));
        }
        let values =
            physical.into_iter().zip(variance.into_iter().map(|v| (v > 0.0).then(|| v.sqrt())));
        let parameters = self.effect.values().map(|p| p.name.to_owned()).zip(values).collect();
        let rivals = probabilities(tried);
        let class = self.effect.named_class();
        Law {
            class: class.to_owned(),
            channel: channel.to_owned(),
            parameters,
            in_the_simulator: sign < 0.0,
            tells,
            probability: rivals.get(class).copied().unwrap_or_default(),
            alternatives: alternatives(rivals, class),
            words: self.effect.words,
            force: fit.force.clone(),
        }
    }
}

/// Probabilities of the classes, each by its best shape.
fn probabilities(tried: &[(Candidate, Fit)]) -> BTreeMap<&'static str, f64> {
    let best = tried.first().map_or(0.0, |t| t.1.score);
    let mut likely = BTreeMap::new();
    for (candidate, fit) in tried {
        let likelihood = (0.5 * (best - fit.score)).exp();
        let of = likely.entry(candidate.effect.named_class()).or_insert(0.0f64);
        *of = of.max(likelihood);
    }
    let sum: f64 = likely.values().sum();
    likely.into_iter().map(|(class, p)| (class, p / sum)).collect()
}

fn alternatives(probabilities: BTreeMap<&'static str, f64>, class: &str) -> Vec<Rival> {
    let mut rivals: Vec<Rival> = probabilities
        .into_iter()
        .filter(|(other, p)| *other != class && *p >= RIVAL)
        .map(|(class, probability)| Rival { class: class.to_owned(), probability })
        .collect();
    rivals.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    rivals
}
