//! Eight numbers.

use crate::LANES;

/// Eight numbers in one line of the cache, so that a load never needs two.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct Eight(pub [f64; LANES]);

#[cfg(feature = "alloc")]
impl Eight {
    /// Numbers in eights; what is missing in the last is zero.
    pub fn table(numbers: &[f64]) -> alloc::vec::Vec<Self> {
        let eight = |some: &[f64]| {
            let mut eight = [0.0; LANES];
            eight.iter_mut().zip(some).for_each(|(to, from)| *to = *from);
            Self(eight)
        };
        numbers.chunks(LANES).map(eight).collect()
    }

    /// The numbers of a table.
    pub fn numbers(table: &[Self]) -> alloc::vec::Vec<f64> {
        table.iter().flat_map(|eight| eight.0).collect()
    }
}
