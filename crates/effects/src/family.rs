//! Families of laws that are variants of one kind of physics.

use crate::{Effect, Scales};

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
    /// The family's shared numbers, of physical parameters on a channel of these magnitudes.
    pub shared: fn(&[f64], &Scales) -> Vec<f64>,
    /// Physical parameters to begin from, of the family's shared numbers on a channel of these
    /// magnitudes: several where the shared numbers leave some of them open.
    pub begun: fn(&[f64], &Scales) -> Vec<Vec<f64>>,
}

impl Kin {
    /// A law whose own parameters are the numbers that its family shares.
    #[must_use]
    pub(crate) const fn of(family: &'static Family) -> Self {
        let begun: fn(&[f64], &Scales) -> Vec<Vec<f64>> = |shared, _| vec![shared.to_vec()];
        Self { family, shared: |physical, _| physical.to_vec(), begun }
    }
}

impl Effect {
    /// Whether another effect is a variant of the same kind of physics, or the same.
    #[must_use]
    pub fn is_kin_of(&self, other: &Self) -> bool {
        let families = self.nature.kin.zip(other.nature.kin);
        families.is_some_and(|(a, b)| std::ptr::eq(a.family, b.family))
    }

    /// Physical parameters to begin from of another law of its family in the place of this one
    /// with these physical parameters; none where they are no kin.
    #[must_use]
    pub fn written_as(&self, other: &Self, physical: &[f64], scales: &Scales) -> Vec<Vec<f64>> {
        match (self.nature.kin, other.nature.kin) {
            (Some(own), Some(kin)) if self.is_kin_of(other) => {
                (kin.begun)(&(own.shared)(physical, scales), scales)
            }
            _ => vec![],
        }
    }
}
