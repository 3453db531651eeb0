//! How a recording was sampled: its step, the steps' jitter, and the gaps that dropped
//! rows leave.

use crate::signal::median;

/// A step this many times the usual one is a gap, if it is near a whole number of steps.
const GAP_RATIO: f64 = 1.5;
/// How near, in usual steps.
const GAP_SLACK: f64 = 0.25;
/// A pause of this many steps is a gap whatever its fraction.
const PAUSE_RATIO: f64 = 4.0;
/// Steps of uniform sampling differ by less than this share.
const UNIFORM_SLACK: f64 = 0.05;

/// Rows that were dropped between two rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Row before the gap, from 0.
    pub after_row: usize,
    /// Its time, s.
    pub from: f64,
    /// Time of the next row, s.
    pub to: f64,
    /// Estimated number of dropped rows: the gap in steps, rounded, less one.
    pub missing: usize,
}

/// How times are spaced.
#[derive(Clone, Debug, PartialEq)]
pub struct Sampling {
    /// Usual step, s: the median of the steps; where sampling is uniform, the mean of the
    /// steps that are no gaps, which is not spoilt by the rounding of printed times. NaN
    /// with fewer than two rows.
    pub step: f64,
    /// Standard deviation of the steps that are no gaps, relative to `step`.
    pub jitter: f64,
    /// Where rows were dropped, in order.
    pub gaps: Vec<Gap>,
    /// Whether all steps but gaps are within 5 % of `step`.
    pub uniform: bool,
}

impl Sampling {
    /// The sampling of strictly increasing times, in seconds.
    pub fn of(time: &[f64]) -> Self {
        let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let usual = median(&mut steps.clone());
        let gaps = find_gaps(time, &steps, usual);
        let regular = without_gaps(&steps, &gaps);
        let uniform = !regular.is_empty()
            && regular.iter().all(|step| (step - usual).abs() <= UNIFORM_SLACK * usual);
        let count = regular.len().max(1) as f64;
        let step = if uniform { regular.iter().sum::<f64>() / count } else { usual };
        let variance = regular.iter().map(|s| (s / step - 1.0).powi(2)).sum::<f64>() / count;
        Self { step, jitter: variance.sqrt(), gaps, uniform }
    }

    /// Where each of `rows` rows stands among all rows, dropped ones included.
    pub fn positions(&self, rows: usize) -> Vec<usize> {
        let mut dropped = 0;
        let mut gaps = self.gaps.iter().peekable();
        let position = |row: usize| {
            while let Some(gap) = gaps.next_if(|gap| gap.after_row < row) {
                dropped += gap.missing;
            }
            row + dropped
        };
        (0..rows).map(position).collect()
    }

    /// The times of all rows, dropped ones included: the times given, unchanged, and
    /// between them the missing ones, each gap divided evenly.
    ///
    /// `time` must be the times that `self` was made of.
    pub fn filled_times(&self, time: &[f64]) -> Vec<f64> {
        let missing: usize = self.gaps.iter().map(|gap| gap.missing).sum();
        let mut filled = Vec::with_capacity(time.len() + missing);
        let mut next = 0;
        for gap in &self.gaps {
            filled.extend_from_slice(&time[next..=gap.after_row]);
            filled.extend(gap.slots());
            next = gap.after_row + 1;
        }
        filled.extend_from_slice(&time[next..]);
        filled
    }
}

impl Gap {
    /// Estimated times of the dropped rows, s.
    pub fn slots(self) -> impl Iterator<Item = f64> {
        let step = (self.to - self.from) / (self.missing + 1) as f64;
        (1..=self.missing).map(move |slot| self.from + slot as f64 * step)
    }
}

fn find_gaps(time: &[f64], steps: &[f64], usual: f64) -> Vec<Gap> {
    let is_gap = |ratio: f64| {
        let whole = (ratio - ratio.round()).abs() <= GAP_SLACK;
        ratio >= GAP_RATIO && (whole || ratio >= PAUSE_RATIO)
    };
    let steps = steps.iter().enumerate();
    let gaps = steps.filter(|(_, step)| is_gap(*step / usual)).map(|(row, step)| Gap {
        after_row: row,
        from: time[row],
        to: time[row + 1],
        missing: (step / usual).round() as usize - 1,
    });
    gaps.collect()
}

fn without_gaps(steps: &[f64], gaps: &[Gap]) -> Vec<f64> {
    let is_gap = |row: &usize| gaps.binary_search_by_key(row, |gap| gap.after_row).is_ok();
    (0..steps.len()).filter(|row| !is_gap(row)).map(|row| steps[row]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dropped_rows_are_found_and_filled() {
        let kept = [0, 1, 2, 4, 5, 6, 7, 12, 13, 14];
        let time: Vec<f64> = kept.iter().map(|&k| 0.01 * f64::from(k)).collect();
        let sampling = Sampling::of(&time);
        assert!((sampling.step - 0.01).abs() < 1e-15);
        assert!(sampling.uniform && sampling.jitter < 1e-12);
        let found: Vec<_> = sampling.gaps.iter().map(|g| (g.after_row, g.missing)).collect();
        assert_eq!(found, [(2, 1), (6, 4)]);
        assert_eq!(sampling.positions(10), kept.map(|k| k as usize));
        let filled = sampling.filled_times(&time);
        assert_eq!(filled.len(), 15);
        for (k, t) in filled.iter().enumerate() {
            assert!((t - 0.01 * k as f64).abs() < 1e-15);
        }
    }

    #[test]
    fn printed_times_do_not_spoil_the_step() {
        // 610.3516 Hz, printed with five decimals.
        let time: Vec<f64> =
            (0..5000).map(|k| (f64::from(k) * 0.0016384 * 1e5).round() / 1e5).collect();
        let sampling = Sampling::of(&time);
        assert!(sampling.uniform && sampling.gaps.is_empty());
        assert!((sampling.step - 0.0016384).abs() < 1e-8);
    }

    #[test]
    fn uneven_sampling_is_not_called_dropped_rows() {
        let time: Vec<f64> = (0..200).map(|k| f64::from(k) + 0.24 * f64::from(k).sin()).collect();
        let sampling = Sampling::of(&time);
        assert!(!sampling.uniform && sampling.gaps.is_empty());
        assert!(sampling.jitter > 0.1 && sampling.jitter < 0.25);
    }

    #[test]
    fn one_row_has_no_step() {
        let sampling = Sampling::of(&[3.0]);
        assert!(sampling.step.is_nan() && !sampling.uniform && sampling.gaps.is_empty());
        assert_eq!(sampling.filled_times(&[3.0]), [3.0]);
    }
}
