//! What an evaluation costs, in operations on vectors of eight: counted, so that the choice is the same on every machine.

use lacuna_realtime::{Evaluator, LANES, LandmarkSum, Profile};

/// A group of so many blocks and functions: one product and its two loads, one multiplication and addition a function.
pub(crate) fn group(blocks: usize, functions: usize) -> usize {
    blocks * (3 + functions)
}

/// A sum over so many landmarks of d arguments for so many functions.
pub(crate) fn landmarks(
    profile: Profile,
    points: usize,
    arguments: usize,
    functions: usize,
) -> usize {
    // The exponential is a polynomial of degree 13 and what surrounds it; a root takes as long.
    let kernel = match profile {
        Profile::Power { degree, .. } => 2 * degree.max(1).ilog2() as usize + 2,
        Profile::Exponential | Profile::Gaussian => 24,
        Profile::MaternHalf | Profile::MaternThreeHalves | Profile::MaternFiveHalves => 48,
    };
    points.div_ceil(LANES) * (2 * arguments + kernel + functions)
}

/// All of an evaluator.
pub(crate) fn evaluator(evaluator: &Evaluator<'_>) -> usize {
    let of_sum = |sum: &LandmarkSum<'_>| {
        let (d, functions) = (sum.centre.len(), sum.entries.len());
        landmarks(sum.profile, LANES * sum.tiles.len() / (d + functions), d, functions)
    };
    let of_series = evaluator.series().map_or(0, |series| {
        let tables = series.outer.parents.len() + series.inner.parents.len();
        let groups = series.groups.iter().map(|g| group(g.blocks.len(), g.entries.len()));
        tables + groups.sum::<usize>()
    });
    of_series + evaluator.sums().iter().map(of_sum).sum::<usize>()
}
