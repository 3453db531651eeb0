//! Random streams that do not depend on the number of threads.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Generator number `stream` of the family `seed`.
///
/// The streams of one seed are independent of each other (ChaCha's nonce), so that trial `k` of
/// a study draws from `rng(seed, k)` whichever thread runs it and in whatever order. Checked by
/// the test `streams_do_not_depend_on_the_number_of_threads`.
pub fn rng(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream(stream);
    generator
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rayon::prelude::*;

    fn draws(threads: usize) -> Vec<Vec<u64>> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let trial = |k: u64| {
            let mut generator = rng(7, k);
            (0..5).map(|_| generator.random::<u64>()).collect()
        };
        pool.install(|| (0..64).into_par_iter().map(trial).collect())
    }

    #[test]
    fn streams_do_not_depend_on_the_number_of_threads() {
        assert_eq!(draws(1), draws(2));
    }

    #[test]
    fn streams_and_seeds_differ() {
        let mut all = draws(1).concat();
        let mut other = rng(8, 0);
        all.extend((0..5).map(|_| other.random::<u64>()));
        let count = all.len();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), count);
    }
}
