//! What some recordings have in common with others, so that nothing is proved on what it was fitted to.

use crate::recording::{Column, Recording};
use std::cmp::Ordering;
use std::ops::Range;

/// What is left of `recordings` without the rows that `others` have as well, in pieces of at least `fewest` rows; none
/// where they share nothing.
///
/// Rows are the same where their times and all columns are, whatever the files' names. A single one, and some along
/// which no column changes, may be of two runs that begin at rest: they are shared by nobody.
#[must_use]
pub fn without_shared(
    recordings: &[Recording],
    others: &[Recording],
    fewest: usize,
) -> Option<Vec<Recording>> {
    let shared: Vec<Vec<bool>> = recordings.iter().map(|r| shared_rows(r, others)).collect();
    if !shared.iter().flatten().any(|shared| *shared) {
        return None;
    }
    let left = |(recording, shared): (&Recording, &Vec<bool>)| match shared.contains(&true) {
        true => pieces(recording, shared, fewest),
        false => vec![recording.clone()],
    };
    Some(recordings.iter().zip(&shared).flat_map(left).collect())
}

/// Which rows of a recording any of the others has as well.
fn shared_rows(recording: &Recording, others: &[Recording]) -> Vec<bool> {
    let mut shared = vec![false; recording.len()];
    for other in others {
        let Some(columns) = paired(recording, other) else { continue };
        let same = |row: usize| {
            let time = recording.time[row];
            let place = other.time.binary_search_by(|t| t.total_cmp(&time)).ok();
            place.is_some_and(|p| columns.iter().all(|(a, b)| a[row].total_cmp(&b[p]).is_eq()))
        };
        let same: Vec<bool> = (0..recording.len()).map(same).collect();
        for run in runs(&same, true) {
            if columns.iter().any(|(values, _)| changes(&values[run.clone()])) {
                shared[run].fill(true);
            }
        }
    }
    shared
}

/// The columns of a recording beside those of the same names of another; none where the names differ.
fn paired<'a>(
    recording: &'a Recording,
    other: &'a Recording,
) -> Option<Vec<(&'a [f64], &'a [f64])>> {
    let pair = |column: &'a Column| Some((&column.values[..], other.column(&column.name).ok()?));
    let same_number = recording.columns.len() == other.columns.len();
    recording.columns.iter().filter(|_| same_number).map(pair).collect()
}

fn changes(values: &[f64]) -> bool {
    values.windows(2).any(|pair| pair[0].total_cmp(&pair[1]) != Ordering::Equal)
}

/// The ranges of consecutive entries that are `wanted`.
fn runs(marks: &[bool], wanted: bool) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = vec![];
    for k in (0..marks.len()).filter(|&k| marks[k] == wanted) {
        match runs.last_mut() {
            Some(run) if run.end == k => run.end += 1,
            _ => runs.push(k..k + 1),
        }
    }
    runs
}

/// The pieces of a recording that are not shared.
fn pieces(recording: &Recording, shared: &[bool], fewest: usize) -> Vec<Recording> {
    let long = runs(shared, false).into_iter().filter(|rows| rows.len() >= fewest);
    let piece = |rows: Range<usize>| {
        let time = recording.time[rows.clone()].to_vec();
        let values = |c: &Column| c.values[rows.clone()].to_vec();
        let column = |c: &Column| Column { name: c.name.clone(), values: values(c) };
        let columns = recording.columns.iter().map(column).collect();
        let (from, to) = (time[0], time[time.len() - 1]);
        Recording { name: format!("{} ({from:.3} to {to:.3} s)", recording.name), time, columns }
    };
    long.map(piece).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(name: &str, rows: Range<usize>, phase: f64) -> Recording {
        let time: Vec<f64> = rows.map(|k| 0.01 * k as f64).collect();
        let q = time.iter().map(|t| (3.0 * t + phase).sin()).collect();
        let u = time.iter().map(|t| if *t < 1.0 { 0.0 } else { t.cos() }).collect();
        let column = |name: &str, values| Column { name: name.into(), values };
        Recording { name: name.into(), columns: vec![column("q", q), column("u", u)], time }
    }

    /// First row of each piece, and the one after its last.
    fn left(recording: Recording, others: &[Recording]) -> Option<Vec<[usize; 2]>> {
        let rows = |r: &Recording| {
            let first = (r.time[0] / 0.01).round() as usize;
            [first, first + r.len()]
        };
        Some(without_shared(&[recording], others, 50)?.iter().map(rows).collect())
    }

    #[test]
    fn shared_rows_are_left_out_wherever_they_are() {
        let training = [run("other", 0..300, 0.7), run("a", 100..300, 0.4)];
        assert_eq!(left(run("b", 250..600, 0.4), &training), Some(vec![[300, 600]]));
        assert_eq!(left(run("b", 0..400, 0.4), &training), Some(vec![[0, 100], [300, 400]]));
        // Too short a rest is none, and of a copy there is none, whatever its name.
        assert_eq!(left(run("b", 60..300, 0.4), &training), Some(vec![]));
        assert_eq!(left(run("a copy", 100..300, 0.4), &training), Some(vec![]));
        let mut gap = run("a", 100..300, 0.4);
        gap.columns[0].values[7] = f64::NAN;
        assert_eq!(left(gap.clone(), &[gap]), Some(vec![]));
        let kept = without_shared(&[run("b", 250..400, 0.4)], &training, 50).unwrap();
        assert_eq!(kept[0].name, "b (3.000 to 3.990 s)");
        assert_eq!(kept[0].columns, run("b", 300..400, 0.4).columns);
    }

    #[test]
    fn runs_of_their_own_share_nothing() {
        let training = [run("a", 0..300, 0.4)];
        // The same machine under the same input, moved otherwise; and other columns.
        assert_eq!(left(run("b", 0..300, 0.5), &training), None);
        let mut other = run("b", 0..300, 0.4);
        other.columns[1].name = "v".into();
        assert_eq!(left(other, &training), None);
        assert_eq!(left(run("b", 300..500, 0.4), &training), None);
        // Two simulations that begin at the same rest.
        let resting = |phase: f64| {
            let mut r = run("r", 0..300, phase);
            r.columns[0].values[..100].fill(0.0);
            r
        };
        assert_eq!(left(resting(0.5), &[resting(0.4)]), None);
    }
}
