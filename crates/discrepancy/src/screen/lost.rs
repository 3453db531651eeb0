//! Inputs that nobody recorded, because their rows were dropped: what they do to predictions is no physics.

use super::Screen;
use super::local::Along;
use crate::dataset::LostInput;
use crate::likelihood::lanes::Lanes;
use crate::likelihood::maps::{Drive, Driven};
use lacuna_numbers::{LANES, Linear};
use rayon::prelude::*;

/// Lost inputs of a recording that are followed, spread evenly: enough for a mean.
const ENOUGH: usize = 16 * LANES;

/// Standard deviations by which squares may be larger than is expected: once in hundreds.
const UNLIKELY: f64 = 3.0;

impl Screen<'_> {
    /// Largest mean square by which lost inputs are likely to move what is predicted, in units of the noise, as
    /// far as the states of the windows do not take it up: with the responses Y to all of them, each one
    /// standard deviation away, the squares are `tr Y'Y` on average with a variance of `2 tr (Y'Y)^2`.
    #[must_use]
    pub fn blurred_by_lost_inputs(&self) -> f64 {
        let recordings = self.problem.dataset.recordings.par_iter().zip(&self.recordings);
        let parts: Vec<Vec<(f64, f64)>> =
            recordings.map(|(observed, along)| self.blurs(&observed.lost, along)).collect();
        let (mean, variance) = parts
            .iter()
            .flatten()
            .fold((0.0, 0.0), |(mean, variance), (m, v)| (mean + m, variance + v));
        (mean + UNLIKELY * variance.sqrt()) / self.fit.count.max(1) as f64
    }

    /// Squares that lost inputs of a recording are expected to move its predictions by, and their variance,
    /// input by input.
    fn blurs(&self, lost: &[LostInput], along: &Along) -> Vec<(f64, f64)> {
        let every = lost.len().div_ceil(ENOUGH).max(1);
        let of_input = |input: usize| {
            let of: Vec<&LostInput> =
                lost.iter().filter(|l| l.input == input).step_by(every).collect();
            let some = of.chunks(LANES);
            let driven: Vec<Driven> =
                some.map(|some| impulses(input, some, along.motion.len())).collect();
            let (mean, variance) = match driven.is_empty() {
                true => (0.0, 0.0),
                false => self.sums(of.len(), true, &driven, along).squares(),
            };
            let share = every as f64;
            (share * mean, share * share * variance)
        };
        (0..self.problem.model.inputs.len()).map(of_input).collect()
    }
}

/// Each lost input one standard deviation away, one a lane.
fn impulses(input: usize, lost: &[&LostInput], samples: usize) -> Driven {
    let mut series = vec![Lanes::ZERO; samples];
    for (lane, lost) in lost.iter().enumerate() {
        series[lost.row].0[lane] = lost.sd;
    }
    let places = vec![(Drive::Input(input), Lanes([1.0; LANES]))];
    Driven { series, at_once: vec![], places, apart: vec![], seen: vec![] }
}
