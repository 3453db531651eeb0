//! Angles that are recorded within one turn, made continuous.
//!
//! A wrapped angle leaps by a turn T between two samples while the machine moves on. The leap from
//! y_i to y_j is one of n turns,
//!
//! ```text
//! n = round((y_j - y_i - v (t_j - t_i)) / T),   |y_j - y_i - n T - v (t_j - t_i)| <= T / 8
//! ```
//!
//! with v the mean of the rates before and after it, each up to whole turns. All later samples
//! lose n T.

use crate::sampling::Sampling;

/// Share of a turn by which a leap may miss what the motion around it predicts, and by which
/// noise may leave the range of one turn: a half of what tells n from n + 1, and a half of that
/// for a motion that changes its rate.
const SLACK: f64 = 0.125;
/// Share of a turn that the motion may make from sample to sample: beyond it, a step and its way
/// round differ too little to be told apart.
const FASTEST: f64 = 0.25;
/// Steps over which rates extrapolate.
const LONGEST_GAP: f64 = 4.0;
/// Share of the samples on either side that may lie out of the range of one turn: outliers.
const BEYOND: f64 = 0.005;

/// Makes the samples of an angle continuous where they leap by whole turns of size `turn` (2 pi
/// for rad, 360 for deg), and returns the rows after the leaps. NaN values are missing samples. Nothing
/// is changed unless the samples keep to the range of one turn and most steps beyond half a turn
/// are such leaps.
///
/// `time` must be as long as `values` and increase.
pub fn unwrap_turns(time: &[f64], values: &mut [f64], turn: f64) -> Vec<usize> {
    let rows: Vec<usize> = (0..values.len()).filter(|&row| !values[row].is_nan()).collect();
    if !within_one_turn(values, turn) {
        return vec![];
    }
    let longest = LONGEST_GAP * Sampling::of(time).step;
    let step = |pair: usize| {
        let (&i, &j) = (rows.get(pair)?, rows.get(pair + 1)?);
        Some((time[j] - time[i], values[j] - values[i]))
    };
    // Steps up to whole turns, as rates.
    let rate = |pair: Option<usize>| {
        let (seconds, size) = step(pair?)?;
        let rest = size - turn * (size / turn).round();
        (seconds <= longest && rest.abs() <= FASTEST * turn).then(|| rest / seconds)
    };
    let large = |&pair: &usize| step(pair).is_some_and(|(_, size)| size.abs() > 0.5 * turn);
    let leap = |pair: usize| {
        let (seconds, size) = step(pair).filter(|(seconds, _)| *seconds <= longest)?;
        // At either end, and beside a gap, there is one.
        let (before, after) = (rate(pair.checked_sub(1)), rate(Some(pair + 1)));
        let motion = seconds * 0.5 * (before.or(after)? + after.or(before)?);
        let turns = ((size - motion) / turn).round();
        let missed = (size - turns * turn - motion).abs();
        (turns != 0.0 && missed <= SLACK * turn).then_some((rows[pair + 1], turns))
    };
    let beyond: Vec<usize> = (0..rows.len()).filter(large).collect();
    let leaps: Vec<(usize, f64)> = beyond.iter().filter_map(|&pair| leap(pair)).collect();
    if 2 * leaps.len() < beyond.len() {
        return vec![];
    }
    let (mut turns, mut next) = (0.0, leaps.iter().peekable());
    for (row, value) in values.iter_mut().enumerate() {
        while let Some(leap) = next.next_if(|leap| leap.0 == row) {
            turns += leap.1;
        }
        *value -= turns * turn;
    }
    leaps.into_iter().map(|leap| leap.0).collect()
}

/// Whether all but outliers lie within one turn, wherever it begins.
fn within_one_turn(values: &[f64], turn: f64) -> bool {
    let mut present: Vec<f64> = values.iter().copied().filter(|v| !v.is_nan()).collect();
    if present.is_empty() {
        return false;
    }
    let last = present.len() - 1;
    let beyond = (BEYOND * last as f64) as usize;
    let mut at = |rank: usize| *present.select_nth_unstable_by(rank, f64::total_cmp).1;
    at(last - beyond) - at(beyond) <= (1.0 + SLACK) * turn
}
