//! What each candidate offers to a regression: its shapes with their columns, which do not depend on what stands
//! beside it.

use super::super::columns::{Column, Columns};
use crate::candidates::Candidate;
use lacuna_effects::Law;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Share of the power of an input that a law may take: of a machine that hardly anything drives its friction is
/// told by nothing.
pub(super) const MOST_TAKEN: f64 = 0.5;
/// Most numbers that are kept (128 MiB).
const MOST: usize = 1 << 24;

/// A candidate with the shapes that may be.
pub(super) struct Offer {
    /// Shapes, none of which takes away most of an input.
    pub shapes: Vec<Vec<f64>>,
    /// The share of the input's power that each takes.
    pub shares: Vec<f64>,
    /// The columns of each.
    pub columns: Vec<Vec<Column>>,
}

/// Those of all candidates that were asked for.
#[derive(Default)]
pub(super) struct Offers {
    kept: Mutex<Kept>,
}

/// Class, channel and other channel of a candidate.
type Key = (&'static str, usize, Option<usize>);

#[derive(Default)]
struct Kept {
    offers: HashMap<Key, Arc<Offer>>,
    numbers: usize,
}

impl Offers {
    /// That of a candidate, made where it is not known.
    pub(super) fn of(&self, columns: &Columns, candidate: &Candidate) -> Arc<Offer> {
        let key = (candidate.effect.class, candidate.channel, candidate.other);
        let kept = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let known = kept().offers.get(&key).cloned();
        if let Some(known) = known {
            return known;
        }
        let offer = Arc::new(Offer::of(columns, candidate));
        let numbers = offer.numbers();
        let mut kept = kept();
        if kept.numbers + numbers <= MOST && kept.offers.insert(key, offer.clone()).is_none() {
            kept.numbers += numbers;
        }
        offer
    }
}

impl Offer {
    fn of(columns: &Columns, candidate: &Candidate) -> Self {
        let scales = columns.problem.scales(candidate.effect, candidate.channel, candidate.other);
        let taken = |shape: &[f64]| match candidate.effect.law {
            Law::Input(law) => columns.taken_from_input((candidate, law), shape),
            Law::Force(_) | Law::Sensor(_) | Law::Structure(_) => 0.0,
        };
        let all =
            candidate.shapes_of_forces(&scales).into_iter().map(|shape| (taken(&shape), shape));
        let all = all.filter(|(taken, _)| *taken < MOST_TAKEN);
        let (shares, shapes): (Vec<f64>, Vec<Vec<f64>>) = all.unzip();
        Self { columns: columns.of(candidate, &shapes), shares, shapes }
    }

    fn numbers(&self) -> usize {
        self.columns.iter().flatten().flatten().map(|(_, entries)| entries.len()).sum()
    }
}
