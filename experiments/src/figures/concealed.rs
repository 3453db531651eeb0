//! Figures of the proof on concealed physics.

use lacuna_charts::{
    Axis, Colour, Figure, Grid, Line, Matrix, Style, Surface, grid_svg, matrix_svg,
};
use std::collections::{BTreeMap, BTreeSet};

use crate::StudyError;
use crate::concealed::reliability::{Bin, Reliability};
use crate::concealed::summary::NOTHING;

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

/// Claimed probability of findings against the share that is right, with Wilson's intervals, and below it how
/// many findings claim so much.
///
/// # Errors
/// [`StudyError::Figure`] when it cannot be drawn.
pub fn reliability(reliability: &Reliability) -> Result<String, StudyError> {
    let bins = &reliability.bins;
    let points = bins.iter().filter_map(|b| Some((b.claimed?, b.right.share?)));
    let ideal = vec![(0.0, 0.0), (1.0, 1.0)];
    let stem = |x, low, high| Line::new("", Colour::Blue, Style::Thin, vec![(x, low), (x, high)]);
    let mut lines = vec![
        Line::new("as claimed", Colour::Ink, Style::Dashed, ideal),
        Line::new("findings by claimed probability", Colour::Blue, Style::Joined, points.collect()),
    ];
    lines.extend(bins.iter().filter_map(|b| {
        let [low, high] = b.right.interval?;
        Some(stem(b.claimed?, low, high))
    }));
    let error = reliability.calibration_error.map_or("-".to_owned(), |e| format!("{e:.3}"));
    let claimed = || Axis::linear("claimed probability (mean of a bin)", "");
    let shares = Figure {
        title: format!("Claims: expected calibration error {error}"),
        lines,
        ..Figure::new(claimed(), Axis::linear("share of right findings, 95 % interval", ""))
    };
    let many = |b: &Bin| Some((b.claimed?, b.right.of as f64));
    let counted: Vec<(f64, f64)> = bins.iter().filter_map(many).collect();
    let mut lines = vec![Line::new("", Colour::Blue, Style::Dots, counted.clone())];
    lines.extend(counted.into_iter().map(|(x, count)| stem(x, 0.0, count)));
    // Along the same axis as the shares above.
    lines.push(Line::new("", Colour::Blue, Style::Thin, vec![(0.0, 0.0), (1.0, 0.0)]));
    let counts = Figure {
        title: format!("{} findings", reliability.findings),
        lines,
        ..Figure::new(claimed(), Axis::linear("findings of the bin", ""))
    };
    let description =
        "Share of right findings against the probability that they claim, and their number.";
    // A share and a number have no range in common: each has a row of its own.
    let counts = (reliability.findings > 0).then(|| vec![counts]);
    let rows = std::iter::once(vec![shares]).chain(counts).collect();
    Ok(grid_svg(&Grid { description: description.to_owned(), rows })?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::concealed::reliability::Claim;

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
        let claim = |probability, right| Claim { probability, right };
        let claims = [claim(0.6, true), claim(0.97, true), claim(0.96, false)];
        assert!(reliability(&Reliability::of(&[])).unwrap().contains("as claimed"));
        let svg = reliability(&Reliability::of(&claims)).unwrap();
        for words in ["as claimed", "3 findings", "expected calibration error 0.443"] {
            assert!(svg.contains(words), "{words}");
        }
    }
}
