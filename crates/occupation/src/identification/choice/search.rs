//! The search over the blocks of one coordinate.

use std::cmp::Ordering;

use rayon::prelude::*;

use super::super::IdentificationError;
use super::super::family::{Family, ScaledKernel};
use super::super::optimise::{difference, minimise};
use super::super::weak::WeakRow;
use super::block::{Block, Products};
use super::span::{Span, product};
use super::{Alternative, BlockChoice, RowChoice, Start};
use crate::linear::NonPositivePivot;

/// Prior standard deviation of log widths about twice the spread of the arguments.
const WIDTH_PRIOR: f64 = 1.5;
/// Prior standard deviation of log amplitudes.
const AMPLITUDE_PRIOR: f64 = 4.0;
/// Width, in spreads, of an argument on which a function does not depend.
pub(super) const FLAT: f64 = 1e4;
/// Nats that a feature must bring: families with fewer are preferred where the data cannot tell.
const PRICE: f64 = 0.02;
/// Nats that dependence on another argument must bring ...
const WORTH: f64 = 1.0;
/// ... and for each equation, where the misfit is systematic ...
const SYSTEMATIC: f64 = 0.1;
/// ... which is more than this times the samples' noise,
const CLEARLY: f64 = 2.0;
/// ... and, for any but the first argument, of what the first brought.
const OF_FIRST: f64 = 1.0;
/// Nats that another iteration must gain.
const GAIN: f64 = 0.05;

fn first_kernel(start: &Start<'_>, family: Family) -> ScaledKernel {
    let widths = match start.widths {
        Some(given) => given.to_vec(),
        None => start.spread.iter().map(|spread| 2.0 * spread).collect(),
    };
    ScaledKernel { family, centre: start.centre.to_vec(), widths }
}

/// A block with the noise and evidence that it leads to.
struct Found {
    block: Block,
    noise_sd: f64,
    log_evidence: f64,
}

pub(super) struct Search<'s> {
    pub row: &'s WeakRow<'s>,
    pub start: &'s Start<'s>,
    pub span: Option<Span>,
    pub blocks: Vec<Block>,
    noise_sd: f64,
    log_evidence: f64,
    alternatives: Vec<Alternative>,
    /// What the first argument of each block brought.
    first_gains: Vec<Option<f64>>,
}

impl<'s> Search<'s> {
    /// A drift that depends on everything, and constant effectiveness where widths are not given.
    pub(super) fn new(
        row: &'s WeakRow<'s>,
        start: &'s Start<'s>,
    ) -> Result<Self, IdentificationError> {
        let first = |(b, &amplitude): (usize, &f64)| {
            let mut kernel = first_kernel(start, start.families[0]);
            if b > 0 && start.widths.is_none() {
                kernel.widths = start.spread.iter().map(|spread| FLAT * spread).collect();
            }
            BlockChoice { kernel, amplitude, posterior_sd: amplitude, depends_on: Vec::new() }
        };
        let blocks = start.amplitudes.iter().enumerate().map(first).collect();
        Self::at(row, start, &RowChoice { blocks, noise_sd: start.noise_sd, log_evidence: 0.0 })
    }

    pub(super) fn at(
        row: &'s WeakRow<'s>,
        start: &'s Start<'s>,
        from: &RowChoice,
    ) -> Result<Self, IdentificationError> {
        let mut search = Self {
            row,
            start,
            span: Span::of(row, start.candidates, start.spread.len(), from.blocks.len()),
            blocks: Vec::new(),
            noise_sd: from.noise_sd,
            log_evidence: f64::NEG_INFINITY,
            alternatives: Vec::new(),
            first_gains: vec![None; from.blocks.len()],
        };
        for choice in &from.blocks {
            let block = search.block(choice.clone());
            search.blocks.push(block);
        }
        let first = &search.blocks[0];
        let products = search.products(0, first).map_err(|_| IdentificationError::NoEvidence)?;
        search.log_evidence = search.objective(0, &first.choice, first, &products, search.noise_sd);
        if search.log_evidence.is_finite() {
            Ok(search)
        } else {
            Err(IdentificationError::NoEvidence)
        }
    }

    /// Follows block b uphill as `family`; keeps what is better than before.
    pub(super) fn improve(&mut self, b: usize, family: Family) {
        let same = self.blocks[b].choice.kernel.family == family;
        let from = if same { self.blocks[b].choice.clone() } else { self.other(b, family) };
        let found = self.follow(b, from, self.log_evidence);
        self.keep_better(b, found, 0.0);
    }

    /// Takes another prior of block b if that is better. A further argument is not looked at again: its worth was
    /// judged beside the first one's.
    pub(super) fn compare(&mut self, b: usize, choice: BlockChoice) {
        let arguments = |choice: &BlockChoice| self.dependences(choice).len();
        let present = arguments(&self.blocks[b].choice);
        let worth = match arguments(&choice).cmp(&present) {
            Ordering::Greater if b > 0 && present > 0 => return,
            Ordering::Greater => self.worth(None),
            Ordering::Equal => 0.0,
            Ordering::Less => -self.worth(None),
        };
        self.keep_better(b, self.as_found(b, choice), worth);
    }

    /// Another prior of block b under the present noise.
    fn as_found(&self, b: usize, choice: BlockChoice) -> Found {
        let block = self.block(choice);
        let log_evidence = self.products(b, &block).map_or(f64::NEG_INFINITY, |products| {
            self.objective(b, &block.choice, &block, &products, self.noise_sd)
        });
        Found { block, noise_sd: self.noise_sd, log_evidence }
    }

    /// The same row with a polynomial for a drift that is none: that of greatest evidence which was tried. None where no tried
    /// one could be more probable with any of its monomials away.
    pub(super) fn with_polynomial_drift(
        mut self,
        alternatives: &[Alternative],
    ) -> Option<RowChoice> {
        if self.family(0).is_polynomial() {
            return None;
        }
        let before = self.log_evidence;
        let polynomial = |a: &&Alternative| a.block == 0 && a.choice.kernel.family.is_polynomial();
        let tried = alternatives.iter().filter(polynomial);
        let found = tried.map(|a| self.as_found(0, a.choice.clone()));
        let best = found.max_by(|x, y| x.log_evidence.total_cmp(&y.log_evidence))?;
        self.accept(0, best);
        let first = &self.blocks[0];
        let products = self.products(0, first).ok()?;
        let posterior = self.posterior(0, &first.choice, first, &products, self.noise_sd).ok()?;
        // Without a monomial that is zero the evidence is greater by its part of the determinant; and along the trajectories of a
        // trial that is no polynomial either, what was chosen is the nearer.
        let more = 0.5 * posterior.factor.log_determinant();
        let nearer = SYSTEMATIC * self.row.equations() as f64;
        (self.log_evidence + more + nearer > before).then(|| self.finish().0)
    }

    fn keep_better(&mut self, b: usize, found: Found, worth: f64) {
        let features = |block: &Block| self.features(b, block) as f64;
        let price = PRICE * (features(&found.block) - features(&self.blocks[b]));
        if found.log_evidence > self.log_evidence + price + worth {
            self.accept(b, found);
        } else {
            self.alternatives.push(Alternative { block: b, choice: found.block.choice });
        }
    }

    fn accept(&mut self, b: usize, found: Found) {
        let before = std::mem::replace(&mut self.blocks[b], found.block);
        self.alternatives.push(Alternative { block: b, choice: before.choice });
        (self.noise_sd, self.log_evidence) = (found.noise_sd, found.log_evidence);
    }

    /// Lets the function of block b depend on more arguments, one at a time, as long as that is worth it.
    pub(super) fn widen(&mut self, b: usize) {
        loop {
            let choice = &self.blocks[b].choice;
            let flat: Vec<usize> =
                (0..self.start.spread.len()).filter(|&i| self.is_flat(choice, i)).collect();
            let tried = flat.into_iter().map(|i| {
                let mut from = choice.clone();
                from.kernel.widths[i] = 2.0 * self.start.spread[i];
                self.follow(b, from, self.log_evidence)
            });
            let best = tried.max_by(|x, y| x.log_evidence.total_cmp(&y.log_evidence));
            let Some(found) = best else { break };
            let gain = found.log_evidence - self.log_evidence;
            if gain <= self.worth(self.first_gains[b]) {
                self.alternatives.push(Alternative { block: b, choice: found.block.choice });
                break;
            }
            self.first_gains[b].get_or_insert(gain);
            self.accept(b, found);
        }
    }

    /// Takes arguments away again that are not worth it beside what the other blocks have become.
    pub(super) fn narrow(&mut self, b: usize) {
        loop {
            let choice = &self.blocks[b].choice;
            let dependences = self.dependences(choice);
            let worth = self.worth(self.first_gains[b].filter(|_| dependences.len() > 1));
            let tried = dependences.into_iter().map(|i| {
                let mut from = choice.clone();
                from.kernel.widths[i] = FLAT * self.start.spread[i];
                self.follow(b, from, self.log_evidence - worth)
            });
            let best = tried.max_by(|x, y| x.log_evidence.total_cmp(&y.log_evidence));
            match best.filter(|found| self.log_evidence - found.log_evidence < worth) {
                Some(found) => self.accept(b, found),
                None => break,
            }
        }
    }

    /// Nats that another argument must bring: where the misfit is more than the samples' noise, or most of that is taken
    /// for jumps, it is systematic, and any function that is given freedom follows it a little.
    fn worth(&self, first_gain: Option<f64>) -> f64 {
        let noise = (CLEARLY * self.start.noise_sd / self.noise_sd).min(1.0);
        let share = (1.0 - noise * noise).max(self.row.share_of_jumps());
        let systematic = SYSTEMATIC * self.row.equations() as f64;
        WORTH + share * systematic.max(OF_FIRST * first_gain.unwrap_or(0.0))
    }

    /// The family of block b at present.
    pub(super) fn family(&self, b: usize) -> Family {
        self.blocks[b].choice.kernel.family
    }

    pub(super) fn is_constant(&self, b: usize) -> bool {
        self.dependences(&self.blocks[b].choice).is_empty()
    }

    fn dependences(&self, choice: &BlockChoice) -> Vec<usize> {
        if choice.kernel.family == Family::Polynomial(0) {
            return Vec::new();
        }
        (0..self.start.spread.len()).filter(|&i| !self.is_flat(choice, i)).collect()
    }

    fn is_flat(&self, choice: &BlockChoice, i: usize) -> bool {
        choice.kernel.widths[i] >= FLAT * self.start.spread[i]
    }

    /// Follows the evidence uphill in the widths that are not flat, the amplitude and the noise, as long as it may come
    /// above `goal`.
    fn follow(&self, b: usize, from: BlockChoice, goal: f64) -> Found {
        let family = from.kernel.family;
        let flat: Vec<bool> =
            (0..self.start.spread.len()).map(|i| self.is_flat(&from, i)).collect();
        let decode = |theta: &[f64]| self.decode(b, family, &flat, theta);
        let cost = |theta: &[f64]| {
            if theta.iter().any(|t| !t.is_finite() || t.abs() > 60.0) {
                return (f64::INFINITY, None);
            }
            let (choice, noise_sd) = decode(theta);
            let block = self.block(choice);
            let Ok(products) = self.products(b, &block) else { return (f64::INFINITY, None) };
            let found = self.objective(b, &block.choice, &block, &products, noise_sd);
            (-found, Some((block, products)))
        };
        let start = self.parameters(&from, self.noise_sd);
        let widths =
            if self.start.widths.is_some() { 0 } else { flat.iter().filter(|f| !**f).count() };
        let gradient = |theta: &[f64], value: f64, kept: &Option<(Block, Products)>| -> Vec<f64> {
            let slope = |i: usize| match kept {
                // Amplitude and noise leave the kernel as it is.
                Some((block, products)) if i >= widths => difference(theta, i, value, |shifted| {
                    let (choice, noise_sd) = decode(shifted);
                    -self.objective(b, &choice, block, products, noise_sd)
                }),
                _ => difference(theta, i, value, |shifted| cost(shifted).0),
            };
            (0..theta.len()).into_par_iter().map(slope).collect()
        };
        let found = minimise(start, GAIN, self.start.effort.iterations, -goal, cost, gradient);
        let (choice, noise_sd) = decode(&found.at);
        let block = found.kept.map_or_else(|| self.block(choice), |(block, _)| block);
        Found { block, noise_sd, log_evidence: -found.value }
    }

    /// The same prior in another family; a first guess where K depends on something else: widths of the one say nothing
    /// of the other's, nor does an amplitude beside them.
    fn other(&self, b: usize, family: Family) -> BlockChoice {
        let old = &self.blocks[b].choice;
        let mut choice =
            BlockChoice { kernel: ScaledKernel { family, ..old.kernel.clone() }, ..old.clone() };
        if family.is_radial() != old.kernel.family.is_radial() {
            let first = first_kernel(self.start, family);
            for i in (0..first.widths.len()).filter(|&i| !self.is_flat(old, i)) {
                choice.kernel.widths[i] = first.widths[i];
            }
            choice.amplitude = self.start.amplitudes[b];
        }
        choice
    }

    fn parameters(&self, choice: &BlockChoice, noise_sd: f64) -> Vec<f64> {
        let mut theta = Vec::new();
        if self.start.widths.is_none() {
            let free = (0..self.start.spread.len()).filter(|&i| !self.is_flat(choice, i));
            theta.extend(free.map(|i| choice.kernel.widths[i].ln()));
        }
        if self.start.lambda.is_none() {
            theta.push(choice.amplitude.ln());
        }
        theta.push(noise_sd.ln());
        theta
    }

    fn decode(&self, b: usize, family: Family, flat: &[bool], theta: &[f64]) -> (BlockChoice, f64) {
        let mut kernel = first_kernel(self.start, family);
        let noise_sd = theta[theta.len() - 1].exp();
        if self.start.widths.is_none() {
            let mut free = theta.iter();
            for (i, width) in kernel.widths.iter_mut().enumerate() {
                *width = if flat[i] {
                    FLAT * self.start.spread[i]
                } else {
                    free.next().map_or(*width, |t| t.exp())
                };
            }
        }
        let amplitude = match self.start.lambda {
            Some(lambda) => noise_sd / lambda.sqrt(),
            None => theta[theta.len() - 2].exp(),
        };
        kernel.centre.clone_from(&self.blocks[b].choice.kernel.centre);
        (
            BlockChoice { kernel, amplitude, posterior_sd: amplitude, depends_on: Vec::new() },
            noise_sd,
        )
    }

    /// Log evidence and log priors with another block b of this choice (and of another amplitude perhaps).
    fn objective(
        &self,
        b: usize,
        choice: &BlockChoice,
        block: &Block,
        products: &Products,
        noise_sd: f64,
    ) -> f64 {
        let of = |k: usize| if k == b { choice } else { &self.blocks[k].choice };
        let log_priors: f64 = (0..self.blocks.len()).map(|k| self.log_prior(k, of(k))).sum();
        match self.posterior(b, choice, block, products, noise_sd) {
            Ok(posterior) => posterior.log_evidence + log_priors,
            Err(NonPositivePivot { .. }) => f64::NEG_INFINITY,
        }
    }

    /// a of a block: that of the given lambda for this noise, where lambda is given.
    pub(super) fn amplitude(&self, choice: &BlockChoice, noise_sd: f64) -> f64 {
        self.start.lambda.map_or(choice.amplitude, |lambda| noise_sd / lambda.sqrt())
    }

    fn log_prior(&self, b: usize, choice: &BlockChoice) -> f64 {
        let widths = choice.kernel.widths.iter().zip(self.start.spread);
        let widths: f64 = widths
            .filter(|(w, spread)| **w < FLAT * **spread)
            .map(|(w, spread)| ((w / (2.0 * spread)).ln() / WIDTH_PRIOR).powi(2))
            .sum();
        let amplitude = match self.start.lambda {
            Some(_) => 0.0,
            None => (choice.amplitude / self.start.amplitudes[b]).ln() / AMPLITUDE_PRIOR,
        };
        -0.5 * (widths + amplitude * amplitude)
    }

    /// Root mean square of the standard deviation sqrt(phi^T C phi) at the candidates.
    fn posterior_sd(&self, b: usize) -> Option<f64> {
        let block = &self.blocks[b];
        let products = self.products(b, block).ok()?;
        let posterior = self.posterior(b, &block.choice, block, &products, self.noise_sd).ok()?;
        let inverse = posterior.factor.inverse();
        let features = match (&self.span, &block.spanned) {
            (Some(span), Some(spanned)) => product(span.at_candidates.as_ref(), spanned.as_ref()),
            _ => self.basis(&block.choice).features(self.start.candidates),
        };
        let rank = features.ncols();
        let variance = |k: usize| -> f64 {
            let pairs = (0..rank).flat_map(|i| (0..rank).map(move |j| (i, j)));
            pairs.map(|(i, j)| features[(k, i)] * inverse[(i, j)] * features[(k, j)]).sum()
        };
        let mean = (0..features.nrows()).map(variance).sum::<f64>() / features.nrows() as f64;
        Some(block.choice.amplitude * mean.sqrt())
    }

    pub(super) fn finish(mut self) -> (RowChoice, Vec<Alternative>) {
        for b in 0..self.blocks.len() {
            self.blocks[b].choice.amplitude = self.amplitude(&self.blocks[b].choice, self.noise_sd);
            self.blocks[b].choice.depends_on = self.dependences(&self.blocks[b].choice);
            if let Some(sd) = self.posterior_sd(b) {
                self.blocks[b].choice.posterior_sd = sd;
            }
        }
        let row = RowChoice {
            blocks: self.blocks.into_iter().map(|block| block.choice).collect(),
            noise_sd: self.noise_sd,
            log_evidence: self.log_evidence,
        };
        (row, self.alternatives)
    }
}
