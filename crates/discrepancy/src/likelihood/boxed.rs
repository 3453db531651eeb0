//! The least value of a quadratic form in a box.

use nalgebra::{DMatrix, DVector};

/// The x within bounds that minimises `x' H x - 2 g' x` for a positive definite H; bounds hold 0. None where H
/// is not positive definite.
///
/// The primal method of active sets: from 0 towards the minimiser of the entries that are free, as far as the
/// first bound, where that entry stays; and where none is in the way, an entry that would rather leave its
/// bound is set free. The value falls with every move, so that no set comes back.
#[must_use]
pub(super) fn minimiser(
    h: &DMatrix<f64>,
    g: &DVector<f64>,
    within: &[(f64, f64)],
) -> Option<DVector<f64>> {
    let n = g.len();
    let mut x = DVector::zeros(n);
    // What is on its bound and would leave the box stays there.
    let on_bound = |i: usize| {
        let (low, high) = within[i];
        (low >= 0.0 && g[i] < 0.0) || (high <= 0.0 && g[i] > 0.0)
    };
    let mut free: Vec<bool> = (0..n).map(|i| !on_bound(i)).collect();
    // Rounding may make a set come back all the same.
    for _ in 0..8 * (n + 1) {
        let pull = g - h * &x;
        let active: Vec<usize> = (0..n).filter(|&i| free[i]).collect();
        let matrix = h.select_rows(&active).select_columns(&active);
        let towards = matrix.cholesky()?.solve(&pull.select_rows(&active));
        match first_bound(&x, &active, &towards, within) {
            Some((share, k)) => {
                for (&i, d) in active.iter().zip(towards.iter()) {
                    x[i] += share * d;
                }
                let i = active[k];
                x[i] = if towards[k] < 0.0 { within[i].0 } else { within[i].1 };
                free[i] = false;
            }
            None => {
                for (&i, d) in active.iter().zip(towards.iter()) {
                    x[i] += d;
                }
                let Some(i) = most_held(h, g, &x, &free, within) else { break };
                free[i] = true;
            }
        }
    }
    Some(x)
}

/// The share of a move at which its first entry meets a bound, and which of them.
fn first_bound(
    x: &DVector<f64>,
    active: &[usize],
    towards: &DVector<f64>,
    within: &[(f64, f64)],
) -> Option<(f64, usize)> {
    let share = |(k, &i): (usize, &usize)| {
        let (d, (low, high)) = (towards[k], within[i]);
        let bound = if d < 0.0 { low } else { high };
        (x[i] + d < low || x[i] + d > high).then(|| (((bound - x[i]) / d).max(0.0), k))
    };
    active.iter().enumerate().filter_map(share).min_by(|a, b| a.0.total_cmp(&b.0))
}

/// The entry on a bound that would gain most within the box; none where all are held for good.
fn most_held(
    h: &DMatrix<f64>,
    g: &DVector<f64>,
    x: &DVector<f64>,
    free: &[bool],
    within: &[(f64, f64)],
) -> Option<usize> {
    let pull = g - h * x;
    let gain = |i: usize| {
        let inwards = if x[i] <= within[i].0 { pull[i] } else { -pull[i] };
        // By how much it would change the value alone; rounding is no gain.
        let gain = inwards * inwards / h[(i, i)];
        let matters = inwards > 0.0 && within[i].1 > within[i].0 && gain > 1e-12 * g.dot(x).abs();
        matters.then_some((gain, i))
    };
    let held = (0..free.len()).filter(|&i| !free[i]).filter_map(gain);
    held.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i)| i)
}

#[cfg(test)]
mod tests {
    use super::minimiser;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    /// A positive definite H, g, and bounds of which some hold 0 on their edge.
    fn problem() -> impl Strategy<Value = (DMatrix<f64>, DVector<f64>, Vec<(f64, f64)>)> {
        (1usize..8).prop_flat_map(|n| {
            let numbers = |count: usize| proptest::collection::vec(-1.0..1.0f64, count);
            let edge = prop_oneof![Just(0.0), Just(f64::INFINITY), 0.01..2.0f64];
            let edges = proptest::collection::vec((edge.clone(), edge), n);
            (numbers(n * n), numbers(n), edges).prop_map(move |(a, g, edges)| {
                let a = DMatrix::from_vec(n, n, a);
                let h = a.tr_mul(&a) + DMatrix::identity(n, n) * 1e-3;
                let within = edges.into_iter().map(|(low, high)| (-low, high)).collect();
                (h, DVector::from_vec(g), within)
            })
        })
    }

    proptest! {
        /// It lies in the box; where it is free nothing pulls, and on a bound all that pulls pulls outwards.
        #[test]
        fn nothing_in_the_box_pulls_at_it((h, g, within) in problem()) {
            let x = minimiser(&h, &g, &within).expect("positive definite");
            let pull = &g - &h * &x;
            for (i, (low, high)) in within.into_iter().enumerate() {
                prop_assert!(low <= x[i] && x[i] <= high, "{x} {i}");
                prop_assert!(pull[i] < 1e-6 || x[i] >= high, "{i}: {pull} {x}");
                prop_assert!(pull[i] > -1e-6 || x[i] <= low, "{i}: {pull} {x}");
            }
        }
    }

    #[test]
    fn what_is_not_positive_definite_has_none() {
        let h = DMatrix::from_row_slice(1, 1, &[-1.0]);
        assert!(minimiser(&h, &DVector::from_vec(vec![1.0]), &[(-1.0, 1.0)]).is_none());
    }
}
