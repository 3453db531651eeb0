//! What is missing to rows of nothing but the sensors' noise, and what laws of inputs silence.

use super::super::columns::rms;
use super::block::Block;
use super::pursuit::Pursuit;
use crate::candidates::{Candidate, Term};
use lacuna_effects::Law;

impl Pursuit<'_> {
    /// These laws, or, on channels where others are likelier once the inputs must be explained too, what is found
    /// without laws of their inputs. Of a joint that its model needs hardly a torque for, a law that silences the
    /// actuator leaves as little as friction does; but of what it silences it says nothing ([`Self::silenced`]).
    pub(super) fn heard(self, empty: &Self, candidates: &[Candidate]) -> Self {
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
            empty.clone().pursued(&left)
        };
        let other = without(&on);
        let colour = |p: &Self, c: usize| p.blocks[c].as_ref().map_or(1.0, |b| b.colour);
        let worse = |c: &usize| {
            let colour = f64::max(colour(&self, *c), colour(&other, *c));
            let [own, other] = [&self, &other].map(|p| p.deficit_of(*c, colour));
            other + self.decision.tie < own
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
        let laws = self.taken.iter().zip(self.against_each());
        let laws = laws.filter(|(t, _)| self.acts_alone(&t.term.candidate, c));
        let cost: f64 = laws.map(|(_, against)| against).sum();
        let all = block.deficit * block.colour + self.silenced(c, block);
        all / colour + cost
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
        let amplitudes = self.base().map_or(vec![], |base| self.amplitudes(&base));
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
    pub(super) fn deficit(&self) -> f64 {
        let left: f64 = self.blocks.iter().flatten().map(|b| b.deficit).sum();
        left + self.against_each().sum::<f64>()
    }

    /// Whether some channel is left with more than the noise of its sensors.
    pub(super) fn leaves_more_than_noise(&self) -> bool {
        self.blocks.iter().flatten().any(|b| b.white > 0)
    }
}
