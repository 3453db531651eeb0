//! A set of laws under way: the noise that it leaves on every channel, and what one more law gains.

use super::super::Belief;
use super::super::columns::{Column, Columns};
use super::super::rows::Rows;
use super::block::{Block, WHITE, series};
use super::offers::{MOST_TAKEN, Offers};
use super::regression::{Added, Regression};
use crate::Decision;
use crate::against::against;
use crate::candidates::{Candidate, Term};
use crate::colour::{RELIABLE, colour};
use crate::probability::log_sum_exp;
use crate::screen::priors;
use lacuna_effects::Law;
use rayon::prelude::*;

/// A law that was taken.
#[derive(Clone)]
pub(super) struct Taken {
    pub(super) term: Term,
    pub(super) columns: Vec<Column>,
    pub(super) sd: Vec<f64>,
}

/// A set of laws under way.
#[derive(Clone)]
pub(super) struct Pursuit<'a> {
    pub(super) columns: &'a Columns<'a>,
    pub(super) offers: &'a Offers,
    /// Every law that may be named, those that come after the plain ones among them.
    pub(super) every: &'a [Candidate],
    /// Columns of the model's own parameters, and their tolerances.
    pub(super) known: Vec<(Column, f64)>,
    pub(super) right: Vec<Vec<f64>>,
    pub(super) blocks: Vec<Option<Block>>,
    /// What does not hang on the laws, as the blocks whiten it.
    quieted: Whitened,
    pub(super) taken: Vec<Taken>,
    /// The inputs that drive each channel alone.
    pub(super) inputs_of: Vec<Vec<usize>>,
    pub(super) decision: &'a Decision,
}

/// The columns of the model's parameters in units of their tolerances, and the right-hand side of every channel, under
/// the noise that is left.
#[derive(Clone, Default)]
struct Whitened {
    known: Vec<Column>,
    right: Vec<Vec<f64>>,
}

impl<'a> Pursuit<'a> {
    pub(super) fn new(
        columns: &'a Columns<'a>,
        (offers, every): (&'a Offers, &'a [Candidate]),
        belief: &Belief,
        decision: &'a Decision,
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
            decision,
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

    /// Nats against a law beside these.
    pub(super) fn against<'t>(
        &self,
        law: &Candidate,
        beside: impl IntoIterator<Item = &'t Taken>,
    ) -> f64 {
        let beside = beside.into_iter().map(|t| t.term.candidate);
        against(self.columns.problem.model, self.decision, law, beside)
    }

    /// Nats against each law that was taken, beside the others.
    pub(super) fn against_each(&self) -> impl Iterator<Item = f64> {
        self.taken.iter().map(|t| self.against(&t.term.candidate, &self.taken))
    }

    /// Every law that was taken but one.
    pub(super) fn others(&self, k: usize) -> Vec<&Taken> {
        self.taken.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, t)| t).collect()
    }

    /// The amplitudes of the laws that were taken, which stand last in the regression on all of them.
    pub(super) fn amplitudes(&self, base: &Regression) -> Vec<Vec<f64>> {
        let mean = base.coefficients();
        let mut at = mean.len() - self.taken.iter().map(|t| t.sd.len()).sum::<usize>();
        let of = |t: &Taken| {
            let first = at;
            at += t.sd.len();
            t.sd.iter().enumerate().map(|(i, sd)| sd * mean[first + i]).collect()
        };
        self.taken.iter().map(of).collect()
    }

    pub(super) fn base(&self) -> Option<Regression> {
        self.base_of(&self.taken.iter().collect::<Vec<_>>())
    }

    /// The noise of every channel that makes what is left most likely, and how slowly it varies.
    pub(super) fn quiet(&mut self) -> Option<()> {
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
    pub(super) fn acts_alone(&self, candidate: &Candidate, c: usize) -> bool {
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
}
