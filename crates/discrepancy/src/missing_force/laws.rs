//! The laws that the missing forces of all channels obey together.
//!
//! With whitened rows `y = P p + sum_k a_k c_k + e` of all channels, the evidence of a set of laws is that of a
//! linear regression ([`super::regression`]).
//!
//! A machine may lack something on each of its joints. So each round takes the most probable law of every
//! channel, as they hardly rival one another, finds the noise again that they leave, and then gives up what is
//! no longer missed and puts a law in another's place where it is the likelier. A motion is needed for none of
//! this: hundreds of candidates on each of many joints cost seconds.

use super::along::Along;
use super::columns::{Column, Columns, Slopes, rms};
use super::offers::{MOST_TAKEN, Offers};
use super::regression::{Added, Regression};
use super::rows::Rows;
use super::subset::Subset;
use super::{Belief, rows_of};
use crate::candidates::{Candidate, Term};
use crate::colour::{RELIABLE, colour};
use crate::likelihood::Problem;
use crate::probability::log_sum_exp;
use crate::screen::priors;
use lacuna_effects::{CATALOGUE, Law, Variable};
use lacuna_occupation::BandedCholesky;
use rayon::prelude::*;

/// Of a white force beside the laws, in units of the rows' noise: none, then 2^-2 to 2^17.
const WHITE: i32 = 21;
/// Rounds, each of which names at most one law a channel.
const ROUNDS: usize = 12;
/// Rivals that are told of a law.
const MOST_RIVALS: usize = 3;
/// Laws that move the rows of many channels at once, of sensors or structure, that a pursuit may begin with.
const BEGINNINGS: usize = 3;

/// A law with its amplitudes and what it gains beside the others.
#[derive(Clone, Debug)]
pub struct Obeyed {
    /// The effect with its shape.
    pub term: Term,
    /// Its amplitudes.
    pub amplitudes: Vec<f64>,
    /// Nats that are lost without it.
    pub gain: f64,
    /// What could stand in its place.
    pub rivals: Vec<Instead>,
}

/// A law that could stand in the place of another.
#[derive(Clone, Debug)]
pub struct Instead {
    /// The effect with its shape.
    pub term: Term,
    /// Its amplitudes.
    pub amplitudes: Vec<f64>,
    /// Nats by which it lies behind.
    pub behind: f64,
}

/// The laws that the missing forces of a problem's recordings obey, of these candidates.
#[must_use]
pub fn laws(problem: &Problem, belief: &Belief, candidates: &[Candidate], tie: f64) -> Vec<Obeyed> {
    let all: Vec<Along> = (0..problem.smoothed.len())
        .into_par_iter()
        .map(|r| Along::new(problem, belief, r))
        .collect();
    let off = vec![0.0; belief.uncertain.len()];
    let channels = 0..problem.model.channels();
    let rows: Vec<Vec<(usize, Rows)>> =
        channels.into_par_iter().map(|c| rows_of(problem, belief, &all, c, &off)).collect();
    let columns = Columns {
        problem,
        along: &all,
        rows: &rows,
        parameters: &belief.parameters,
        effects: belief.effects,
        slopes: Slopes::new(problem.model.inputs.len()),
    };
    let plain: Vec<Candidate> = candidates.iter().filter(|c| is_plain(c)).copied().collect();
    let offers = Offers::default();
    let Some(empty) = Pursuit::new(&columns, (&offers, candidates), belief) else { return vec![] };
    let candidates = &plain[..];
    let mut best = empty.clone().pursued(candidates, tie).heard(&empty, candidates, tie);
    // What is wrong in a sensor, or with a body, passes for many laws of single channels.
    if best.leaves_more_than_noise() {
        for law in empty.of_many_channels(candidates) {
            let mut begun = Pursuit { taken: vec![law], ..empty.clone() };
            if begun.quiet().is_none() {
                continue;
            }
            let other = begun.clone().pursued(candidates, tie);
            let other = other.heard(&begun, candidates, tie);
            if other.deficit() < best.deficit() {
                best = other;
            }
        }
    }
    best.refine();
    best.obeyed()
}

/// The rows of a channel under the noise that is left.
#[derive(Clone)]
struct Block {
    white: usize,
    /// How many of its rows are worth one.
    temperature: f64,
    /// How many of its rows are correlated.
    colour: f64,
    /// Nats by which it is less likely than if nothing but the noise of the sensors were left, what is correlated
    /// counted once.
    deficit: f64,
    factors: Vec<BandedCholesky>,
}

impl Block {
    fn new(rows: &[(usize, Rows)], white: usize) -> Option<Self> {
        let mut factors = vec![];
        for (_, own) in rows {
            let mut covariance = if white == 0 {
                own.measured.plus(&own.white, 0.0).ok()?
            } else {
                let share = 2f64.powi(white as i32 - 3);
                let size = |m: &lacuna_occupation::SymmetricBanded| {
                    (0..own.right.len()).map(|a| m.get(a, a)).sum::<f64>()
                };
                let ratio = size(&own.measured) / size(&own.white);
                own.measured.plus(&own.white, share * share * ratio).ok()?
            };
            covariance.add_diagonal(1e-12 * covariance.largest_diagonal());
            factors.push(covariance.cholesky().ok()?);
        }
        Some(Self { white, temperature: 1.0, colour: 1.0, deficit: 0.0, factors })
    }

    /// A column of all recordings, whitened.
    fn whiten(&self, rows: &[(usize, Rows)], column: &mut [f64]) {
        let mut first = 0;
        for ((_, own), factor) in rows.iter().zip(&self.factors) {
            let count = own.right.len();
            // Lengths agree.
            let _ = factor.solve_lower_in_place(&mut column[first..first + count]);
            first += count;
        }
    }

    fn half_log_determinant(&self, rows: &[(usize, Rows)]) -> f64 {
        let of = |((_, own), factor): (&(usize, Rows), &BandedCholesky)| {
            (0..own.right.len()).map(|a| factor.get(a, a).ln()).sum::<f64>()
        };
        rows.iter().zip(&self.factors).map(of).sum()
    }
}

/// A law that was taken.
#[derive(Clone)]
pub(super) struct Taken {
    pub term: Term,
    pub columns: Vec<Column>,
    pub sd: Vec<f64>,
}

/// A set of laws under way.
#[derive(Clone)]
pub(super) struct Pursuit<'a> {
    pub columns: &'a Columns<'a>,
    pub offers: &'a Offers,
    /// Every law that may be named, those that come after the plain ones among them.
    pub every: &'a [Candidate],
    /// Columns of the model's own parameters, and their tolerances.
    known: Vec<(Column, f64)>,
    right: Vec<Vec<f64>>,
    blocks: Vec<Option<Block>>,
    /// What does not hang on the laws, as the blocks whiten it.
    quieted: Whitened,
    pub taken: Vec<Taken>,
    /// The inputs that drive each channel alone.
    inputs_of: Vec<Vec<usize>>,
    /// Nats against every single law.
    prior_odds: f64,
}

/// The columns of the model's parameters in units of their tolerances, and the right-hand side of every channel, under
/// the noise that is left.
#[derive(Clone, Default)]
struct Whitened {
    known: Vec<Column>,
    right: Vec<Vec<f64>>,
}

impl<'a> Pursuit<'a> {
    fn new(
        columns: &'a Columns<'a>,
        (offers, every): (&'a Offers, &'a [Candidate]),
        belief: &Belief,
    ) -> Option<Self> {
        let rows = columns.rows;
        let right: Vec<Vec<f64>> = rows
            .iter()
            .map(|r| r.iter().flat_map(|(_, own)| own.right.iter().copied()).collect())
            .collect();
        let p = belief.uncertain.len();
        let known = (0..p)
            .map(|j| {
                let column: Column = rows
                    .iter()
                    .enumerate()
                    .filter(|(_, r)| !r.is_empty())
                    .map(|(c, r)| {
                        let of = |own: &Rows| -> Vec<f64> {
                            own.by_parameter.iter().skip(j).step_by(p).map(|x| -x).collect()
                        };
                        (c, r.iter().flat_map(|(_, own)| of(own)).collect())
                    })
                    .collect();
                (column, columns.problem.model.parameters[belief.uncertain[j]].std())
            })
            .collect();
        let blocks: Vec<Option<Block>> =
            rows.iter().map(|r| if r.is_empty() { None } else { Block::new(r, 0) }).collect();
        blocks.iter().any(Option::is_some).then_some(())?;
        let inputs_of = columns.inputs_that_drive_one();
        let prior_odds = belief.prior_odds;
        let taken = vec![];
        let quieted = Whitened::default();
        let mut this = Self {
            columns,
            offers,
            every,
            known,
            right,
            blocks,
            quieted,
            taken,
            inputs_of,
            prior_odds,
        };
        this.whiten_known();
        this.quiet()?;
        Some(this)
    }

    /// What one column is, whitened, each channel tempered, in units of its prior.
    fn whitened(&self, column: &Column, sd: f64) -> Column {
        let of = |(c, entries): &(usize, Vec<f64>)| {
            let block = self.blocks[*c].as_ref()?;
            let mut entries = entries.clone();
            block.whiten(&self.columns.rows[*c], &mut entries);
            let factor = sd / block.temperature.sqrt();
            entries.iter_mut().for_each(|e| *e *= factor);
            Some((*c, entries))
        };
        column.iter().filter_map(of).collect()
    }

    /// Whiten what does not hang on the laws.
    fn whiten_known(&mut self) {
        let known = self.known.iter().map(|(column, sd)| self.whitened(column, *sd)).collect();
        let of_channel = |(c, y): (usize, &Vec<f64>)| {
            let whole: Column = vec![(c, y.clone())];
            self.whitened(&whole, 1.0).pop().map(|(_, y)| y).unwrap_or_default()
        };
        let right = self.right.iter().enumerate().map(of_channel).collect();
        self.quieted = Whitened { known, right };
    }

    /// The regression on the model's parameters and some laws.
    pub(super) fn base_of(&self, taken: &[&Taken]) -> Option<Regression> {
        let laws = taken.iter().flat_map(|t| t.columns.iter().zip(&t.sd));
        let laws: Vec<Column> = laws.map(|(column, sd)| self.whitened(column, *sd)).collect();
        let columns: Vec<&Column> = self.quieted.known.iter().chain(&laws).collect();
        Regression::of(&columns, self.quieted.right.clone())
    }

    fn base(&self) -> Option<Regression> {
        self.base_of(&self.taken.iter().collect::<Vec<_>>())
    }

    /// The noise of every channel that makes what is left most likely, and how slowly it varies.
    fn quiet(&mut self) -> Option<()> {
        for _ in 0..2 {
            let base = self.base()?;
            let mean = base.coefficients();
            let plain: Vec<(&Column, f64)> = self
                .known
                .iter()
                .map(|(column, sd)| (column, *sd))
                .chain(self.taken.iter().flat_map(|t| t.columns.iter().zip(t.sd.iter().copied())))
                .collect();
            let mut left = self.right.clone();
            for ((column, sd), z) in plain.iter().zip(mean.iter()) {
                for (c, entries) in column.iter() {
                    left[*c].iter_mut().zip(entries).for_each(|(l, e)| *l -= sd * z * e);
                }
            }
            let blocks = left.par_iter().enumerate().map(|(c, left)| {
                let rows = &self.columns.rows[c];
                let before = self.blocks[c].as_ref()?;
                let quietest = Block::new(rows, 0)?.half_log_determinant(rows);
                let tried = (0..WHITE as usize).filter_map(|white| {
                    let block = Block::new(rows, white)?;
                    let mut left = left.clone();
                    block.whiten(rows, &mut left);
                    let square: f64 = left.iter().map(|x| x * x).sum();
                    let width = block.half_log_determinant(rows);
                    let likelihood = -0.5 * square - width;
                    let own = left.len() as f64;
                    let colour = colour(series(rows, &left).into_iter(), RELIABLE);
                    let temperature = colour * (square / own).max(1.0);
                    let deficit = (0.5 * (square - own).max(0.0) + width - quietest) / colour;
                    Some((Block { temperature, colour, deficit, ..block }, likelihood))
                });
                let best = tried.max_by(|a, b| a.1.total_cmp(&b.1));
                best.map(|b| b.0).or_else(|| Block::new(rows, before.white))
            });
            self.blocks = blocks.collect();
            self.whiten_known();
        }
        Some(())
    }

    /// Whether a law acts on this channel and by itself, without a reaction elsewhere.
    fn acts_alone(&self, candidate: &Candidate, c: usize) -> bool {
        match candidate.effect.law {
            Law::Force(law) => {
                candidate.channel == c && !(law.reacts() && candidate.other.is_some())
            }
            Law::Input(_) => self.inputs_of[c].contains(&candidate.channel),
            Law::Sensor(_) | Law::Structure(_) => false,
        }
    }

    /// Whether two laws act on the same channel, each on no other.
    pub(super) fn shares(&self, a: &Candidate, b: &Candidate) -> bool {
        (0..self.blocks.len()).any(|c| self.acts_alone(a, c) && self.acts_alone(b, c))
            || (matches!((a.effect.law, b.effect.law), (Law::Force(_), Law::Force(_)))
                && a.channel == b.channel)
    }

    /// The best shape of a candidate beside what is taken, and nats that it gains, all shapes counted.
    pub(super) fn scored(&self, base: &Regression, candidate: &Candidate) -> Option<(Taken, f64)> {
        let problem = self.columns.problem;
        let offer = self.offers.of(self.columns, candidate);
        let (sd, magnitude) = priors(problem, candidate);
        let gains = self.gains(base, &offer.columns, &sd, magnitude).into_iter().enumerate();
        let mut tried: Vec<(usize, f64)> = vec![];
        for (number, gain) in gains {
            // Twice a law takes four times the power.
            let leaves_input = |by: &f64| by * by * offer.shares[number] < MOST_TAKEN;
            let may_be = |g: &(f64, Vec<f64>)| g.0.is_finite() && g.1.iter().all(leaves_input);
            tried.extend(gain.filter(may_be).map(|g| (number, g.0)));
        }
        let gain = log_sum_exp(tried.iter().map(|t| t.1)) - (offer.shapes.len() as f64).ln();
        let (best, _) = tried.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let columns = offer.columns[best].clone();
        let term = Term { candidate: *candidate, shape: offer.shapes[best].clone() };
        Some((Taken { term, columns, sd }, gain))
    }

    /// Nats that the columns of each of several shapes gain beside what is taken, and their amplitudes; none for a
    /// magnitude that would be negative.
    fn gains(
        &self,
        base: &Regression,
        shapes: &[Vec<Column>],
        sd: &[f64],
        magnitude: bool,
    ) -> Vec<Option<(f64, Vec<f64>)>> {
        let whiten = |columns: &Vec<Column>| -> Vec<Column> {
            columns.iter().zip(sd).map(|(c, sd)| self.whitened(c, *sd)).collect()
        };
        let own: Vec<Vec<Column>> = shapes.iter().map(whiten).collect();
        let added = base.adding(&own).into_iter().zip(&own).map(|(added, own)| {
            let Added { gain, coefficients } = added?;
            let acts = own.iter().any(|column| !column.is_empty());
            let wrong = magnitude && coefficients.iter().any(|z| *z < 0.0);
            let sides = if magnitude { own.len() as f64 } else { 0.0 };
            let amplitudes = coefficients.iter().zip(sd).map(|(z, sd)| sd * z).collect();
            (acts && !wrong).then_some((gain + sides * std::f64::consts::LN_2, amplitudes))
        });
        added.collect()
    }

    /// The same of one shape.
    pub(super) fn gain(
        &self,
        base: &Regression,
        t: &Taken,
        magnitude: bool,
    ) -> Option<(f64, Vec<f64>)> {
        self.gains(base, std::slice::from_ref(&t.columns), &t.sd, magnitude).pop()?
    }

    /// The laws that are found beside those that were taken.
    fn pursued(mut self, candidates: &[Candidate], tie: f64) -> Self {
        self.begin(candidates);
        self.run(candidates, tie);
        self
    }

    /// These laws, or, on channels where others are likelier once the inputs must be explained too, what is found
    /// without laws of their inputs. Of a joint that its model needs hardly a torque for, a law that silences the
    /// actuator leaves as little as friction does; but of what it silences it says nothing ([`Self::silenced`]).
    fn heard(self, empty: &Self, candidates: &[Candidate], tie: f64) -> Self {
        let on: Vec<usize> =
            (0..self.blocks.len()).filter(|&c| self.laws_of_inputs(c).next().is_some()).collect();
        if on.is_empty() {
            return self;
        }
        let drives =
            |on: &[usize], k: &Candidate| on.iter().any(|c| self.input_of(k, *c).is_some());
        let without = |channels: &[usize]| {
            let left: Vec<Candidate> =
                candidates.iter().filter(|k| !drives(channels, k)).copied().collect();
            empty.clone().pursued(&left, tie)
        };
        let other = without(&on);
        let colour = |p: &Self, c: usize| p.blocks[c].as_ref().map_or(1.0, |b| b.colour);
        let worse = |c: &usize| {
            let colour = f64::max(colour(&self, *c), colour(&other, *c));
            let [own, other] = [&self, &other].map(|p| p.deficit_of(*c, colour));
            other + tie < own
        };
        let silent: Vec<usize> = on.iter().copied().filter(worse).collect();
        match silent.len() {
            0 => self,
            n if n == on.len() => other,
            _ => without(&silent),
        }
    }

    /// The input that drives a channel alone and on which a law acts, or of which its force on the channel depends.
    fn input_of(&self, candidate: &Candidate, c: usize) -> Option<usize> {
        let input = match candidate.effect.law {
            Law::Input(_) => Some(candidate.channel),
            Law::Force(_) if candidate.channel == c && candidate.effect.names_input() => {
                candidate.other
            }
            Law::Force(_) | Law::Sensor(_) | Law::Structure(_) => None,
        };
        input.filter(|j| self.inputs_of[c].contains(j))
    }

    /// The laws of inputs that drive a channel alone: their places among those that were taken, and which input.
    fn laws_of_inputs(&self, c: usize) -> impl Iterator<Item = (usize, usize)> {
        let all = self.taken.iter().enumerate();
        all.filter_map(move |(k, t)| Some((k, self.input_of(&t.term.candidate, c)?)))
    }

    /// Nats that are missing to rows of a channel of nothing but the sensors' noise, what its own laws silence, and
    /// what they cost; of so many rows that are correlated one is counted.
    fn deficit_of(&self, c: usize, colour: f64) -> f64 {
        let Some(block) = &self.blocks[c] else { return 0.0 };
        let laws = self.taken.iter().filter(|t| self.acts_alone(&t.term.candidate, c)).count();
        let all = block.deficit * block.colour + self.silenced(c, block);
        all / colour + self.prior_odds * laws as f64
    }

    /// Nats by which laws of a channel's inputs make the motion more likely only in that less of the input
    /// reaches the machine. What is known is the recorded input no less than the motion, and where u' is made of u,
    /// `log p(u | motion) = log p(motion | u) + sum_k log |du'/du|`: of an input that makes no difference, no value is
    /// likelier than another. No slope is smaller than the noise is beside the input. Where nothing but the sensors'
    /// noise is left, the input is what the machine got, and needs no explanation.
    fn silenced(&self, c: usize, block: &Block) -> f64 {
        if block.white == 0 || self.laws_of_inputs(c).next().is_none() {
            return 0.0;
        }
        let amplitudes = self.base().map_or(vec![], |base| amplitudes(&self.taken, &base));
        let rows: usize = self.columns.rows[c].iter().map(|(_, own)| own.right.len()).sum();
        let of = |j: usize| {
            let laws: Vec<(&Term, &[f64])> = self
                .laws_of_inputs(c)
                .filter(|(_, of)| *of == j)
                .filter_map(|(k, _)| Some((&self.taken[k].term, amplitudes.get(k)?.as_slice())))
                .collect();
            if laws.is_empty() {
                return 0.0;
            }
            let own = self.columns.of_input(j).into_iter().find(|(d, _)| *d == c);
            let mut entries = own.map_or(vec![], |(_, entries)| entries);
            block.whiten(&self.columns.rows[c], &mut entries);
            -self.columns.log_slope((j, c), &laws, 1.0 / rms(&entries).max(1.0))
        };
        let all: f64 = self.inputs_of[c].iter().map(|j| of(*j)).sum();
        all * rows as f64
    }

    /// Nats that are missing to rows of nothing but the sensors' noise, and what the laws cost.
    fn deficit(&self) -> f64 {
        let left: f64 = self.blocks.iter().flatten().map(|b| b.deficit).sum();
        left + self.prior_odds * self.taken.len() as f64
    }

    /// Whether some channel is left with more than the noise of its sensors.
    fn leaves_more_than_noise(&self) -> bool {
        self.blocks.iter().flatten().any(|b| b.white > 0)
    }

    /// The likeliest laws that move the rows of several channels at once.
    fn of_many_channels(&self, candidates: &[Candidate]) -> Vec<Taken> {
        let Some(base) = self.base() else { return vec![] };
        let many = candidates.iter().filter(|c| acts_on_many(c)).collect::<Vec<_>>();
        let mut scored: Vec<(Taken, f64)> =
            many.into_par_iter().filter_map(|c| self.scored(&base, c)).collect();
        scored.retain(|s| s.1 > self.prior_odds);
        scored.sort_by(|a, b| b.1.total_cmp(&a.1));
        scored.into_iter().take(BEGINNINGS).map(|s| s.0).collect()
    }

    /// The likeliest laws of every channel by itself, beside those of many.
    fn begin(&mut self, candidates: &[Candidate]) {
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
        let chosen = subset.likeliest(self.prior_odds, series);
        let mut at = 0;
        made.retain(|_| {
            at += 1;
            chosen.contains(&(at - 1))
        });
        made
    }

    fn run(&mut self, candidates: &[Candidate], tie: f64) {
        for _ in 0..ROUNDS {
            let Some(base) = self.base() else { return };
            let have: Vec<Candidate> = self.taken.iter().map(|t| t.term.candidate).collect();
            let left: Vec<&Candidate> =
                candidates.iter().filter(|c| !have.iter().any(|h| h.excludes(c))).collect();
            let mut scored: Vec<(Taken, f64)> =
                left.par_iter().filter_map(|c| self.scored(&base, c)).collect();
            scored.retain(|s| s.1 > self.prior_odds);
            scored.sort_by(|a, b| b.1.total_cmp(&a.1));
            let mut busy = vec![false; self.blocks.len()];
            let mut news = 0;
            for (taken, _) in scored {
                let on: Vec<usize> = taken.columns.iter().flatten().map(|(c, _)| *c).collect();
                if on.iter().any(|c| busy[*c]) {
                    on.iter().for_each(|c| busy[*c] = true);
                    continue;
                }
                on.iter().for_each(|c| busy[*c] = true);
                self.taken.push(taken);
                news += 1;
            }
            if self.quiet().is_none() {
                return;
            }
            self.revise(candidates, tie);
            if news == 0 {
                return;
            }
        }
    }

    /// Give up what is no longer missed, and put a law in another's place where it is the likelier.
    fn revise(&mut self, candidates: &[Candidate], tie: f64) {
        let mut k = 0;
        while k < self.taken.len() {
            let others: Vec<&Taken> =
                self.taken.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, t)| t).collect();
            let Some(base) = self.base_of(&others) else { return };
            let own = self.taken[k].term.candidate;
            let rivals: Vec<&Candidate> = candidates
                .iter()
                .filter(|c| **c == own || (own.excludes(c) || self.shares(&own, c)))
                .filter(|c| **c == own || !others.iter().any(|o| o.term.candidate.excludes(c)))
                .collect();
            let scored: Vec<(Taken, f64)> =
                rivals.par_iter().filter_map(|c| self.scored(&base, c)).collect();
            let here = self.gain_here(&base, &self.taken[k], &scored);
            let best = scored.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
            let better = best.filter(|(taken, gain)| {
                let least = if taken.term.candidate == own { here } else { here + tie };
                *gain > self.prior_odds && *gain >= least
            });
            match better {
                Some((taken, _)) => self.taken[k] = taken,
                None if here > self.prior_odds => {}
                None => {
                    self.taken.remove(k);
                    continue;
                }
            }
            k += 1;
        }
    }

    /// Nats that a law gains beside others: as it was scored with them, or with the shape that it has, one of as many
    /// as are on offer, where that gains more.
    fn gain_here(&self, base: &Regression, law: &Taken, scored: &[(Taken, f64)]) -> f64 {
        let own = law.term.candidate;
        let (_, magnitude) = priors(self.columns.problem, &own);
        let shapes = self.offers.of(self.columns, &own).shapes.len();
        let standing = self.gain(base, law, magnitude).map(|g| g.0 - (shapes as f64).ln());
        let here = scored.iter().find(|s| s.0.term.candidate == own).map(|s| s.1);
        here.into_iter().chain(standing).fold(f64::MIN, f64::max)
    }

    /// Put richer laws of its kind in the place of one where they are worth as much as a law of their own.
    fn refine(&mut self) {
        for k in 0..self.taken.len() {
            let own = self.taken[k].term.candidate;
            let kin: Vec<&Candidate> = self
                .every
                .iter()
                .filter(|c| c.channel == own.channel && c.effect.is_kin_of(own.effect))
                .filter(|c| c.effect.nature.variation_of.is_none())
                .collect();
            let others: Vec<&Taken> =
                self.taken.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, t)| t).collect();
            let Some(base) = self.base_of(&others).filter(|_| kin.len() > 1) else { continue };
            let scored: Vec<(Taken, f64)> =
                kin.par_iter().filter_map(|c| self.scored(&base, c)).collect();
            let here = self.gain_here(&base, &self.taken[k], &scored);
            let best = scored.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((taken, _)) = best.filter(|b| b.1 > here + self.prior_odds) {
                self.taken[k] = taken;
            }
        }
    }

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

    fn obeyed(&self) -> Vec<Obeyed> {
        let Some(base) = self.base() else { return vec![] };
        let mut all = vec![];
        for (k, (t, amplitudes)) in
            self.taken.iter().zip(amplitudes(&self.taken, &base)).enumerate()
        {
            let others: Vec<&Taken> =
                self.taken.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, t)| t).collect();
            let Some(without) = self.base_of(&others) else { continue };
            let rivals = self.rivals(&without, t);
            let gain = base.evidence - without.evidence;
            all.push(Obeyed { term: t.term.clone(), amplitudes, gain, rivals });
        }
        all
    }
}

/// The amplitudes of laws that stand last in a regression.
fn amplitudes(taken: &[Taken], base: &Regression) -> Vec<Vec<f64>> {
    let mean = base.coefficients();
    let mut at = mean.len() - taken.iter().map(|t| t.sd.len()).sum::<usize>();
    let of = |t: &Taken| {
        let first = at;
        at += t.sd.len();
        t.sd.iter().enumerate().map(|(i, sd)| sd * mean[first + i]).collect()
    };
    taken.iter().map(of).collect()
}

/// Whether a law is a plain one. What has a memory or a time of its own follows much that it is not, and the
/// variants of a law come after it.
fn is_plain(c: &Candidate) -> bool {
    let effect = c.effect;
    let variant = effect.nature.variation_of.is_some()
        || CATALOGUE
            .iter()
            .any(|e| effect.is_kin_of(e) && e.parameters.len() < effect.parameters.len());
    match effect.law {
        Law::Force(law) => {
            !variant && law.memory() == 0 && !effect.depends_on.contains(&Variable::Time)
        }
        Law::Structure(_) | Law::Input(_) | Law::Sensor(_) => !variant,
    }
}

/// Whether a law moves the rows of several channels at once.
fn acts_on_many(c: &Candidate) -> bool {
    matches!(c.effect.law, Law::Sensor(_) | Law::Structure(_))
}

/// A column of all recordings, recording by recording.
fn series<'s>(rows: &[(usize, Rows)], column: &'s [f64]) -> Vec<&'s [f64]> {
    let mut first = 0;
    rows.iter()
        .map(|(_, own)| {
            let part = &column[first..first + own.right.len()];
            first += own.right.len();
            part
        })
        .collect()
}
