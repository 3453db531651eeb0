//! Some of many, evenly.

/// The golden ratio's fractional part: its multiples fill \[0, 1) evenly, however many there are.
pub(crate) const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// At most `most` of `count` indices, evenly but without a period: a stride would see only a part of data that are laid
/// out on a grid or a Halton sequence. The indices with the smallest fractional parts of multiples of the golden ratio.
pub fn sample(count: usize, most: usize) -> impl Iterator<Item = usize> {
    let share = most as f64 / count as f64;
    (0..count).filter(move |&k| (k as f64 * GOLDEN).fract() < share).take(most)
}
