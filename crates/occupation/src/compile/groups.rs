//! Functions that are evaluated together.

use std::collections::BTreeSet;

use lacuna_realtime::{Eight, Group, MOST_ENTRIES};

use super::cost;
use super::prune::Pruned;

/// Functions that share blocks, merged as long as that makes the evaluation cheaper.
pub(crate) fn groups(series: &[Pruned]) -> Vec<Group<'static>> {
    let mut sets: Vec<(Vec<usize>, BTreeSet<[u16; 2]>)> =
        (0..series.len()).map(|k| (vec![k], series[k].blocks.keys().copied().collect())).collect();
    while let Some((a, b)) = best_merger(&sets) {
        let (members, blocks) = sets.remove(b);
        sets[a].0.extend(members);
        sets[a].1.extend(blocks);
    }
    sets.iter().map(|(members, blocks)| group(series, members, blocks)).collect()
}

fn best_merger(sets: &[(Vec<usize>, BTreeSet<[u16; 2]>)]) -> Option<(usize, usize)> {
    let mut best = (0, None);
    for (b, (second, second_blocks)) in sets.iter().enumerate() {
        for (a, (first, first_blocks)) in sets[..b].iter().enumerate() {
            if first.len() + second.len() > MOST_ENTRIES {
                continue;
            }
            let common = first_blocks.intersection(second_blocks).count();
            let together = first_blocks.len() + second_blocks.len() - common;
            let apart = cost::group(first_blocks.len(), first.len())
                + cost::group(second_blocks.len(), second.len());
            let saved = apart.saturating_sub(cost::group(together, first.len() + second.len()));
            if saved > best.0 {
                best = (saved, Some((a, b)));
            }
        }
    }
    best.1
}

/// All that is known of its blocks, also of those which a function could do without: they cost nothing more.
fn group(series: &[Pruned], members: &[usize], blocks: &BTreeSet<[u16; 2]>) -> Group<'static> {
    let mut coefficients = Vec::with_capacity(blocks.len() * members.len());
    for at in blocks {
        for &member in members {
            coefficients.push(Eight(series[member].blocks.get(at).copied().unwrap_or_default()));
        }
    }
    let entries: Vec<u16> = members.iter().map(|&k| series[k].function as u16).collect();
    Group {
        entries: entries.into(),
        blocks: blocks.iter().copied().collect::<Vec<_>>().into(),
        coefficients: coefficients.into(),
    }
}
