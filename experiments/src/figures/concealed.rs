//! Figures of the proof on concealed physics.

use lacuna_charts::{Axis, Colour, Figure, Line, Matrix, Size, Style, Surface, matrix_svg};
use std::collections::{BTreeMap, BTreeSet};

use super::drawn;
use crate::StudyError;
use crate::concealed::summary::{Bin, NOTHING};

/// True classes against found ones.
pub fn confusion(confusion: &BTreeMap<String, BTreeMap<String, usize>>) -> String {
    let found = confusion.values().flat_map(BTreeMap::keys);
    let rows = last_nothing(confusion.keys());
    let columns = last_nothing(confusion.keys().chain(found));
    let count = |row: &String, column: &String| {
        confusion.get(row).and_then(|r| r.get(column)).copied().unwrap_or(0)
    };
    let counts = rows.iter().map(|r| columns.iter().map(|c| count(r, c)).collect()).collect();
    let axes = ["concealed", "found (an accepted name counts as the concealed one)"];
    let matrix = Matrix {
        description: "How often each class is found in the place of each concealed one.".into(),
        title: "Concealed physics: what is there and what is found".into(),
        axes: axes.map(str::to_owned),
        rows,
        columns,
        counts,
    };
    matrix_svg(&matrix, Surface::Own)
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
    let ideal = vec![(0.0, 0.0), (1.0, 1.0)];
    let mut lines = vec![
        Line::new("as claimed", Colour::Ink, Style::Dashed, ideal),
        Line::new("findings by claimed probability", Colour::Blue, Style::Joined, points.collect()),
    ];
    for bin in bins {
        if let (Some(claimed), Some([low, high])) = (bin.claimed, bin.right.interval) {
            let interval = vec![(claimed, low), (claimed, high)];
            lines.push(Line::new("", Colour::Blue, Style::Thin, interval));
        }
    }
    drawn(&Figure {
        description: "Share of right findings against the probability that they claim.".into(),
        title: "Concealed physics: reliability".into(),
        size: Size::Wide,
        lines,
        ..Figure::new(
            Axis::linear("claimed probability (mean of a bin)", ""),
            Axis::linear("share of right findings, 95 % interval", ""),
        )
    })
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
        let svg = confusion(&matrix);
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
