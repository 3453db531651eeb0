//! Where the edge of a law stands, and how the law goes on beyond it.
//!
//! What is nothing on one side of an edge hangs on where that is as on nothing else: of a stiff stop a place that is
//! off by the spacing of the shapes on offer leaves most of the force, and other laws of the channel would be taken
//! for what it leaves. So where such a law was taken, its shape is found between those on offer, beside the laws of
//! other channels alone, and so are those of its variations, which begin from it.

use super::super::columns::Columns;
use super::pursuit::{Pursuit, Taken};
use super::regression::Regression;
use crate::candidates::{Candidate, Term};
use crate::screen::priors;
use lacuna_effects::Prior;
use rayon::prelude::*;

/// Halvings of the spacing of the shapes on offer: to about a hundredth of it.
const HALVINGS: usize = 7;

impl Pursuit<'_> {
    /// The laws with an edge among those that were taken, and their variations, each with its likeliest shape beside
    /// the laws of other channels.
    pub(super) fn at_their_edges(&self) -> Vec<Taken> {
        let has_edge = |t: &&Taken| t.term.candidate.effect.nature.edge;
        let laws: Vec<&Taken> = self.taken.iter().filter(has_edge).collect();
        let of = |law: &&Taken| {
            let own = law.term.candidate;
            let elsewhere = |t: &&Taken| !self.shares(&t.term.candidate, &own);
            let others: Vec<&Taken> = self.taken.iter().filter(elsewhere).collect();
            let base = self.base_of(&others)?;
            let kin: Vec<Candidate> = std::iter::once(own).chain(self.variations(&own)).collect();
            let sharpened = kin.into_par_iter().filter_map(|candidate| {
                let (begun, _) = self.scored(&base, &candidate)?;
                Some(self.sharpened(&base, begun))
            });
            Some(sharpened.collect::<Vec<Taken>>())
        };
        laws.par_iter().filter_map(of).collect::<Vec<_>>().into_iter().flatten().collect()
    }

    /// The laws that are variations of one, in its place.
    fn variations(&self, own: &Candidate) -> impl Iterator<Item = Candidate> {
        let own = *own;
        let varies = move |c: &Candidate| {
            let of = c.effect.nature.variation_of;
            (c.channel, c.other) == (own.channel, own.other)
                && of.is_some_and(|of| of.class == own.effect.class)
        };
        self.every.iter().copied().filter(varies)
    }

    /// A law with its shape moved to where it gains most.
    fn sharpened(&self, base: &Regression, mut law: Taken) -> Taken {
        let candidate = law.term.candidate;
        let (_, magnitude) = priors(self.columns.problem, &candidate);
        let gain = |law: &Taken| self.gain(base, law, magnitude).map_or(f64::MIN, |g| g.0);
        let mut best = gain(&law);
        let mut moves =
            moves(self.columns, &law.term, &self.offers.of(self.columns, &candidate).shapes);
        for _ in 0..HALVINGS {
            for Move { number, step, logarithmic } in &mut moves {
                *step *= 0.5;
                for by in [*step, -*step] {
                    let mut shape = law.term.shape.clone();
                    shape[*number] =
                        if *logarithmic { shape[*number] * by.exp() } else { shape[*number] + by };
                    let Some(columns) =
                        self.columns.of(&candidate, std::slice::from_ref(&shape)).pop()
                    else {
                        continue;
                    };
                    let moved =
                        Taken { term: Term { candidate, shape }, columns, sd: law.sd.clone() };
                    let gained = gain(&moved);
                    if gained > best {
                        (best, law) = (gained, moved);
                        break;
                    }
                }
            }
        }
        law
    }
}

/// A number of a shape that may be moved.
struct Move {
    number: usize,
    /// How far, or by which logarithm.
    step: f64,
    logarithmic: bool,
}

/// The numbers of a shape that may be moved, as far as the next shape on offer.
fn moves(columns: &Columns, term: &Term, offered: &[Vec<f64>]) -> Vec<Move> {
    let Candidate { effect, channel, other } = term.candidate;
    let scales = columns.problem.scales(effect, channel, other);
    let priors = (effect.priors)(&scales).split_off(term.candidate.amplitudes());
    let of = |(number, prior): (usize, Prior)| {
        let logarithmic = match prior {
            Prior::Fixed => return None,
            Prior::LogNormal { .. } => true,
            Prior::Normal { .. } => false,
        };
        let place = |shape: &[f64]| if logarithmic { shape[number].ln() } else { shape[number] };
        let own = place(&term.shape);
        let away = offered.iter().map(|shape| (place(shape) - own).abs()).filter(|d| *d > 0.0);
        let step = away.min_by(f64::total_cmp)?;
        Some(Move { number, step, logarithmic })
    };
    priors.into_iter().enumerate().filter_map(of).collect()
}
