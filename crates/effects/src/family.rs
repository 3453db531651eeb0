//! Families of laws that are variants of one kind of physics.

use crate::{CATALOGUE, Effect, Scales};

/// Laws that are variants of one kind of physics, of which a channel has one: a second one on
/// the same channel says nothing new, but each may stand in the place of another.
#[derive(Debug)]
pub struct Family {
    /// What they are variants of.
    pub words: &'static str,
}

/// How a law belongs to its family: its parameters are translated to those of any other member
/// by way of numbers that all members share.
#[derive(Clone, Copy, Debug)]
pub struct Kin {
    /// The family.
    pub family: &'static Family,
    /// The family's shared numbers, of physical parameters.
    pub shared: fn(&[f64]) -> Vec<f64>,
    /// Physical parameters to begin from, of the family's shared numbers on a channel of these
    /// magnitudes: several where the shared numbers leave some of them open.
    pub begun: fn(&[f64], &Scales) -> Vec<Vec<f64>>,
}

impl Effect {
    /// Whether another effect is a variant of the same kind of physics, or the same.
    #[must_use]
    pub fn is_kin_of(&self, other: &Self) -> bool {
        let families = self.nature.kin.zip(other.nature.kin);
        families.is_some_and(|(a, b)| std::ptr::eq(a.family, b.family))
    }

    /// The laws of its family in the place of this one with these physical parameters, each
    /// with parameters to begin from. Itself is among them where it has several beginnings.
    #[must_use]
    pub fn siblings(&self, physical: &[f64], scales: &Scales) -> Vec<(&'static Self, Vec<f64>)> {
        let Some(own) = self.nature.kin else { return vec![] };
        let shared = (own.shared)(physical);
        let members = CATALOGUE.iter().copied().filter(|e| e.is_kin_of(self));
        let begun = |e: &'static Self| {
            let begun = e.nature.kin.map_or(vec![], |kin| (kin.begun)(&shared, scales));
            let again = e.class == self.class && begun.len() == 1;
            begun.into_iter().filter(move |_| !again).map(move |parameters| (e, parameters))
        };
        members.flat_map(begun).collect()
    }
}
