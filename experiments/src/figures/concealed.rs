//! Figures of the proof on concealed physics.

use std::collections::{BTreeMap, BTreeSet};

use super::chart::{Axis, Matrix, Panel, Series, line_figure, matrix_figure};
use crate::StudyError;
use crate::concealed::summary::{Bin, NOTHING};

/// True classes against found ones.
///
/// # Errors
/// [`StudyError::Figure`] when it cannot be drawn.
pub fn confusion(
    confusion: &BTreeMap<String, BTreeMap<String, usize>>,
) -> Result<String, StudyError> {
    let found = confusion.values().flat_map(BTreeMap::keys);
    let rows = last_nothing(confusion.keys());
    let columns = last_nothing(confusion.keys().chain(found));
    let count = |row: &String, column: &String| {
        confusion.get(row).and_then(|r| r.get(column)).copied().unwrap_or(0)
    };
    let counts = rows.iter().map(|r| columns.iter().map(|c| count(r, c)).collect()).collect();
    matrix_figure(&Matrix {
        title: "Concealed physics: what is there and what is found",
        axes: ["concealed", "found (an accepted name counts as the concealed one)"],
        rows,
        columns,
        counts,
    })
}

/// Classes in alphabetical order, nothing after them.
fn last_nothing<'a>(classes: impl Iterator<Item = &'a String>) -> Vec<String> {
    let all: BTreeSet<&String> = classes.collect();
    let mut classes: Vec<String> =
        all.iter().filter(|c| **c != NOTHING).map(|c| (*c).clone()).collect();
    if all.iter().any(|c| *c == NOTHING) {
        classes.push(NOTHING.to_owned());
    }
    classes
}

/// Claimed probability of findings against the share that is right, with Wilson's intervals.
///
/// # Errors
/// [`StudyError::Figure`] when it cannot be drawn.
pub fn reliability(bins: &[Bin]) -> Result<String, StudyError> {
    let points = bins.iter().filter_map(|b| Some((b.claimed?, b.right.share?)));
    let mut series = vec![
        Series::dashed("as claimed", 0, vec![(0.0, 0.0), (1.0, 1.0)]),
        Series::dots("findings by claimed probability", 1, points.collect()),
    ];
    for bin in bins {
        if let (Some(claimed), Some([low, high])) = (bin.claimed, bin.right.interval) {
            series.push(Series::line("", 1, vec![(claimed, low), (claimed, high)]));
        }
    }
    line_figure(&[Panel {
        title: "Concealed physics: reliability",
        x: Axis::linear("claimed probability (mean of a bin)"),
        y: Axis::linear("share of right findings, 95 % interval"),
        series,
    }])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::concealed::proportion::Proportion;

    #[test]
    fn figures_hold_what_they_are_given() {
        let row = |pairs: &[(&str, usize)]| {
            pairs.iter().map(|(c, k)| ((*c).to_owned(), *k)).collect::<BTreeMap<_, _>>()
        };
        let matrix = BTreeMap::from([
            (NOTHING.to_owned(), row(&[("cogging", 2)])),
            ("viscous_friction".to_owned(), row(&[("viscous_friction", 3), (NOTHING, 1)])),
        ]);
        let svg = confusion(&matrix).unwrap();
        assert!(svg.contains("viscous_friction") && svg.contains(NOTHING));
        let bin = |from: f64, count| Bin {
            from,
            to: 1.0,
            claimed: (count > 0).then_some(0.9),
            right: Proportion::new(count, count),
        };
        assert!(reliability(&[bin(0.0, 0), bin(0.5, 4)]).unwrap().contains("as claimed"));
    }
}
