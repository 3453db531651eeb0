//! Recordings arranged by what they hold, so that neither the order in which they are given, nor copies, nor where a
//! logger began a new file says anything.

use std::cmp::Ordering;

use crate::recording::{Column, Recording};
use crate::sampling::Sampling;

/// The next row of the same log comes after one step, give or take this share of it.
const STEP_SLACK: f64 = 0.5;
/// What goes on does not leap by more than this many times its largest change from row to row.
const LEAP: f64 = 2.0;

/// Each recording once, those that go on from another joined with it, ordered by their times and values; names
/// of files and columns, and the order of columns, do not matter.
///
/// A recording goes on from another where it has the same columns, begins one step after the other's last row, and no
/// column leaps there by more than twice its largest change from row to row.
#[must_use]
pub fn arranged(recordings: &[Recording]) -> Vec<Recording> {
    let mut ordered: Vec<&Recording> = recordings.iter().collect();
    ordered.sort_by(|a, b| by_content(a, b));
    ordered.dedup_by(|a, b| is_copy(a, b));
    let mut logs: Vec<Recording> = Vec::with_capacity(ordered.len());
    for recording in ordered {
        match logs.iter_mut().find(|log| goes_on(log, recording)) {
            Some(log) => append(log, recording),
            None => logs.push(recording.clone()),
        }
    }
    logs.sort_by(by_content);
    logs
}

/// Times first, then the values of the columns, these ordered by what they hold.
fn by_content(a: &Recording, b: &Recording) -> Ordering {
    let columns = |r| -> Vec<_> {
        let mut columns: Vec<&[f64]> = Recording::values(r).collect();
        columns.sort_by(|a, b| compare(a, b));
        columns
    };
    compare(&a.time, &b.time).then_with(|| {
        let (a, b) = (columns(a), columns(b));
        let pairs = a.iter().zip(&b).map(|(a, b)| compare(a, b));
        pairs.fold(Ordering::Equal, Ordering::then).then(a.len().cmp(&b.len()))
    })
}

fn compare(a: &[f64], b: &[f64]) -> Ordering {
    let first = a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
    first.unwrap_or(a.len().cmp(&b.len()))
}

/// Whether two recordings hold the same under the same names.
fn is_copy(a: &Recording, b: &Recording) -> bool {
    let same = |column: &Column| {
        b.column(&column.name).is_ok_and(|values| compare(values, &column.values).is_eq())
    };
    a.columns.len() == b.columns.len()
        && compare(&a.time, &b.time).is_eq()
        && a.columns.iter().all(same)
}

/// Whether `next` goes on from where `log` ends.
fn goes_on(log: &Recording, next: &Recording) -> bool {
    let (Some(end), Some(begin)) = (log.time.last(), next.time.first()) else { return false };
    let pause = begin - end;
    // Most recordings begin before others end: that is known without a look at the steps.
    if pause <= 0.0 || log.columns.len() != next.columns.len() {
        return false;
    }
    let in_step = |r: &Recording| {
        let step = Sampling::of(&r.time).step;
        (pause - step).abs() <= STEP_SLACK * step
    };
    let continues = |column: &Column| {
        next.column(&column.name).is_ok_and(|values| is_continuous(&column.values, values))
    };
    in_step(log) && in_step(next) && log.columns.iter().all(continues)
}

fn is_continuous(before: &[f64], after: &[f64]) -> bool {
    let measured = |x: &&f64| x.is_finite();
    let (Some(last), Some(first)) = (before.iter().rfind(measured), after.iter().find(measured))
    else {
        return true;
    };
    let change = |values: &[f64]| {
        let changes = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        changes.filter(|c| c.is_finite()).fold(0.0, f64::max)
    };
    (first - last).abs() <= LEAP * change(before).max(change(after))
}

fn append(log: &mut Recording, next: &Recording) {
    log.name = format!("{}, {}", log.name, next.name);
    log.time.extend_from_slice(&next.time);
    for column in &mut log.columns {
        // They have the same columns, or one would not go on from the other.
        let values = next.columns.iter().find(|c| c.name == column.name);
        column.values.extend(values.into_iter().flat_map(|c| &c.values));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(name: &str, rows: std::ops::Range<usize>, phase: f64) -> Recording {
        let time: Vec<f64> = rows.map(|k| 0.01 * k as f64).collect();
        let column = |name: &str, values: Vec<f64>| Column { name: name.into(), values };
        let q = column("q", time.iter().map(|t| (3.0 * t + phase).sin()).collect());
        let u = column("u", time.iter().map(|t| (5.0 * t + phase).cos()).collect());
        Recording { name: name.into(), time, columns: vec![q, u] }
    }

    fn names(recordings: &[Recording]) -> Vec<&str> {
        recordings.iter().map(|r| &*r.name).collect()
    }

    #[test]
    fn order_copies_and_names_say_nothing() {
        let [a, b, c] = [0.3, 0.1, 0.2].map(|phase| run("x", 0..200, phase));
        let as_given = arranged(&[a.clone(), b.clone(), c.clone()]);
        assert_eq!(arranged(&[c.clone(), a.clone(), b.clone(), a.clone()]), as_given);
        let other = |r: &Recording| {
            let mut r = r.clone();
            r.columns.iter_mut().zip(["z", "b"]).for_each(|(c, name)| c.name = name.into());
            r.columns.reverse();
            r
        };
        let renamed = arranged(&[other(&c), other(&b), other(&a)]);
        assert_eq!(renamed, as_given.iter().map(other).collect::<Vec<_>>());
        // A missing sample is no difference between copies.
        let mut gap = a.clone();
        gap.columns[0].values[7] = f64::NAN;
        assert_eq!(arranged(&[gap.clone(), gap]).len(), 1);
        // The same numbers under other names are no copy.
        let mut swapped = a.clone();
        swapped.columns[0].name = "u".into();
        swapped.columns[1].name = "q".into();
        assert_eq!(arranged(&[swapped, a]).len(), 2);
    }

    #[test]
    fn what_goes_on_is_joined() {
        let whole = run("whole", 0..300, 0.4);
        let parts = [run("c", 220..300, 0.4), run("a", 0..120, 0.4), run("b", 120..220, 0.4)];
        let joined = arranged(&parts);
        assert_eq!(names(&joined), ["a, b, c"]);
        assert_eq!((&joined[0].time, &joined[0].columns), (&whole.time, &whole.columns));
        assert!(arranged(&[]).is_empty());
    }

    #[test]
    fn what_begins_anew_is_not_joined() {
        let first = run("a", 0..100, 0.0);
        // Later than a step, elsewhere, and with other columns.
        assert_eq!(arranged(&[first.clone(), run("b", 103..200, 0.0)]).len(), 2);
        assert_eq!(arranged(&[first.clone(), run("b", 100..200, 2.0)]).len(), 2);
        let mut other = run("b", 100..200, 0.0);
        other.columns[1].name = "v".into();
        assert_eq!(arranged(&[first, other]).len(), 2);
    }
}
