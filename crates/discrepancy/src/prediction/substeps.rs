//! How many RK4 steps a model needs from one sample to the next.

use super::Series;
use crate::dataset::{Dataset, Observed};
use crate::diagnosis::Integration;
use lacuna_plants::Substeps;
use lacuna_plants::model::Measured;
use std::cell::OnceCell;
use std::ops::Range;

/// Most RK4 steps between two samples.
pub(super) const MOST: usize = 32;
/// Error of the steps as a share of the noise.
pub const TOLERANCE: f64 = 0.01;

/// Samples of a stretch on which steps are compared.
const STRETCH: usize = 400;

/// The stretches on which steps are compared, recording by recording: three of the first one, and that about the
/// steepest change in any, for a model is stiffest where the machine is fastest.
pub(super) fn stretches(dataset: &Dataset) -> Vec<(&Observed, Vec<Range<usize>>)> {
    let Some(first) = dataset.recordings.first() else { return vec![] };
    let of = |observed: &Observed, start: usize| {
        let length = observed.len().min(STRETCH);
        let start = start.min(observed.len() - length);
        start..start + length
    };
    let spread = [0, 1, 2].map(|k| of(first, k * first.len().saturating_sub(STRETCH) / 2));
    let mut all = vec![(first, spread.to_vec())];
    if let Some((recording, at)) = steepest(dataset) {
        let observed = &dataset.recordings[recording];
        let about = of(observed, at.saturating_sub(STRETCH / 2));
        match recording {
            0 if spread.iter().any(|s| s.contains(&at)) => {}
            0 => all[0].1.push(about),
            _ => all.push((observed, vec![about])),
        }
    }
    all
}

/// Recording and sample of the change from one sample to the next that stands out most among those of its output.
fn steepest(dataset: &Dataset) -> Option<(usize, usize)> {
    let most = |output: usize| {
        let (mut at, mut most, mut squares, mut count) = (None, 0.0, 0.0, 0);
        for (r, observed) in dataset.recordings.iter().enumerate() {
            for (k, pair) in observed.outputs[output].windows(2).enumerate() {
                let change = (pair[1] - pair[0]).abs();
                if change.is_finite() {
                    (squares, count) = (squares + change * change, count + 1);
                    if change >= most {
                        (at, most) = (Some((r, k)), change);
                    }
                }
            }
        }
        let peak = most / (squares / f64::from(count)).sqrt();
        Some((at?, peak)).filter(|_| peak.is_finite())
    };
    let all = (0..dataset.outputs.len()).filter_map(most);
    all.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(at, _)| at)
}

/// Runs along all stretches, and how many Runge-Kutta steps they took.
pub(super) type Runs = (Vec<Series>, usize);

/// Runs along the stretches of each recording, of what is driven as that is, each in at most so many steps; none
/// where they take more together.
pub(super) fn along<'d, D>(
    driven: impl IntoIterator<Item = (&'d D, Range<usize>)>,
    budget: usize,
    run: impl Fn(&D, Range<usize>, usize) -> (Series, usize),
) -> Option<Runs>
where
    D: 'd,
{
    let (mut all, mut steps) = (vec![], 0);
    for (driven, range) in driven {
        let (series, of) = run(driven, range, budget - steps);
        steps += of;
        if steps > budget {
            return None;
        }
        all.push(series);
    }
    Some((all, steps))
}

/// Stretches one by one.
pub(super) fn each<D>(
    driven: &[(D, Vec<Range<usize>>)],
) -> impl Iterator<Item = (&D, Range<usize>)> {
    driven.iter().flat_map(|(driven, ranges)| ranges.iter().map(move |r| (driven, r.clone())))
}

/// Where runs begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Beginning {
    /// Where the recordings say.
    Measured,
    /// All that is measured this share of its noise away.
    Moved(f64),
}

impl Beginning {
    /// A state that was measured, as the runs begin from it.
    pub(super) fn move_state(self, dataset: &Dataset, state: &mut [f64]) {
        let Self::Moved(share) = self else { return };
        for (k, output) in dataset.outputs.iter().enumerate() {
            if let Measured::State(entry) = output.of {
                state[entry] += share * dataset.noise_sd(k);
            }
        }
    }
}

/// The cheapest RK4 steps a sample whose error over some stretches stays well below the noise: of equal length, or cut
/// where slopes jump, twice as many of them until twice as many change little. `runs` are those of the stretches in
/// such steps; none where these cannot be cut, or are more than so many in all.
///
/// What is unstable carries any error away, those of the beginning first of all: there steps are enough where they
/// change the runs by no more than a beginning does that is off by as little as they are allowed. That this is the
/// machine's doing and not that of steps which are too long shows in that it is the same in half as long ones.
pub(super) fn fewest(
    dataset: &Dataset,
    (tolerance, most): (f64, usize),
    runs: impl Fn(Substeps, Beginning, usize) -> Option<Runs>,
) -> Integration {
    let trial = Trial { dataset, tolerance, runs };
    let mut found: Option<(Integration, usize)> = None;
    let mut last = Integration::in_steps(Substeps::even(most));
    // The finer of a round are the coarser of the next.
    let (mut even, mut cut) = (trial.run(Substeps::even(1), usize::MAX), None);
    // What is cut as often as this at one count is at every other, and rather runs in many even steps.
    let mut budget = even.as_ref().map_or(0, |once| once.steps * most / 2);
    for count in (0..).map(|k| 1 << k).take_while(|count| *count < most) {
        let Some(coarse) = even.take() else { break };
        // More steps of equal length than those that were found are no cheaper.
        if found.is_some_and(|(_, steps)| steps <= coarse.steps) {
            break;
        }
        even = trial.run(Substeps::even(2 * count), usize::MAX);
        let Some(fine) = &even else { break };
        let mut best = (trial.measured(&coarse, fine), coarse.steps);
        if best.0.error_over_noise >= tolerance && found.is_none() && budget > 0 {
            let tried = cut.take().or_else(|| trial.run(Substeps::cut(count), budget));
            // Where nothing jumps they are the steps of equal length once more, and finer ones are, too.
            let tried = tried.filter(|tried| tried.steps > coarse.steps);
            cut = tried.as_ref().and_then(|_| trial.run(Substeps::cut(2 * count), budget));
            match tried.zip(cut.as_ref()) {
                Some((tried, fine)) => best = (trial.measured(&tried, fine), tried.steps),
                None => budget = 0,
            }
        }
        let error = best.0.error_over_noise;
        if error < tolerance && found.is_none_or(|(_, steps)| best.1 < steps) {
            found = Some(best);
        }
        let finest = cut.as_ref().map_or(fine.substeps, |cut| cut.substeps);
        last = Integration { error_over_noise: error, ..Integration::in_steps(finest) };
    }
    found.map_or(last, |(found, _)| found)
}

/// Runs in some steps.
struct Tried {
    substeps: Substeps,
    series: Vec<Series>,
    /// How many they were.
    steps: usize,
    /// What they make of an error of the beginning, stretch by stretch, once that was asked for.
    grown: OnceCell<Vec<f64>>,
}

/// What steps are tried on.
struct Trial<'d, R> {
    dataset: &'d Dataset,
    tolerance: f64,
    runs: R,
}

impl<R: Fn(Substeps, Beginning, usize) -> Option<Runs>> Trial<'_, R> {
    fn run(&self, substeps: Substeps, budget: usize) -> Option<Tried> {
        let (series, steps) = (self.runs)(substeps, Beginning::Measured, budget)?;
        Some(Tried { substeps, series, steps, grown: OnceCell::new() })
    }

    /// Steps with their error, as finer ones show it.
    fn measured(&self, coarse: &Tried, fine: &Tried) -> Integration {
        let most = |errors: &[f64]| errors.iter().copied().fold(0.0, f64::max);
        let errors = self.apart(&coarse.series, &fine.series);
        let mut error = most(&errors);
        if error >= self.tolerance && error.is_finite() {
            let pairs = self.grown(coarse).iter().zip(self.grown(fine));
            let own = pairs.map(|(before, after)| grown_alike(*before, *after));
            error = most(&errors.iter().zip(own).map(|(e, own)| e / own).collect::<Vec<_>>());
        }
        Integration { error_over_noise: error, ..Integration::in_steps(coarse.substeps) }
    }

    fn apart(&self, a: &[Series], b: &[Series]) -> Vec<f64> {
        a.iter().zip(b).map(|(a, b)| weighted_distance(self.dataset, a, b)).collect()
    }

    fn grown<'t>(&self, tried: &'t Tried) -> &'t [f64] {
        tried.grown.get_or_init(|| {
            let moved = (self.runs)(tried.substeps, Beginning::Moved(self.tolerance), usize::MAX);
            let apart = moved.map(|(moved, _)| self.apart(&tried.series, &moved));
            apart.unwrap_or_default().into_iter().map(|d| d / self.tolerance).collect()
        })
    }
}

/// By how much the machine itself makes more of an error, of what two runs in other steps made of it.
fn grown_alike(before: f64, after: f64) -> f64 {
    /// By what factor they may differ and be the same.
    const SAME: f64 = 2.0;
    let alike = before < SAME * after && after < SAME * before;
    if alike { before.min(after).max(1.0) } else { 1.0 }
}

/// Largest difference of two sets of series in units of the noise, or of a thousandth of
/// the channel's range where the noise is finer than any model follows.
fn weighted_distance(dataset: &Dataset, a: &Series, b: &Series) -> f64 {
    let mut largest = 0.0f64;
    for (k, (a, b)) in a.iter().zip(b).enumerate() {
        let w = (1.0 / dataset.noise_sd(k)).min(1e3 / dataset.half_range(k));
        for (x, y) in a.iter().zip(b) {
            // Where both diverge nothing can be compared.
            if x.is_finite() || y.is_finite() {
                let d = ((x - y) * w).abs();
                largest = if d.is_nan() { f64::INFINITY } else { largest.max(d) };
            }
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::{STRETCH, steepest, stretches};
    use crate::Dataset;
    use lacuna_plants::Model;
    use lacuna_recordings::{Column, Recording};

    const MODEL: &str = "name = \"mass\"\n[[coordinate]]\nname = \"q\"\nvelocity = \"v\"\n\
        [mechanics]\nmass = [[\"1\"]]\nforce = [\"-q\"]\n";

    /// A slow wave of so many samples that leaps between some of them.
    fn wave(name: &str, samples: usize, leap: Option<usize>) -> Recording {
        let time: Vec<f64> = (0..samples).map(|k| 0.01 * k as f64).collect();
        let leapt = |k: usize| leap.is_some_and(|at| k > at);
        let value = |k: usize| (0.01 * k as f64).sin() + if leapt(k) { 3.0 } else { 0.0 };
        let values = (0..samples).map(value).collect();
        Recording { name: name.into(), time, columns: vec![Column { name: "q".into(), values }] }
    }

    #[test]
    fn where_the_machine_is_fastest_steps_are_compared() {
        let model = Model::from_text(MODEL, "model.toml").expect("a model");
        let leaping = |leaps: [Option<usize>; 2]| {
            let all = [wave("a", 3000, leaps[0]), wave("b", 1000, leaps[1])];
            Dataset::new(&model, &all).expect("a dataset")
        };
        // Not in the first recording.
        let dataset = leaping([None, Some(700)]);
        assert_eq!(steepest(&dataset), Some((1, 700)));
        let all = stretches(&dataset);
        let of = |k: usize| (&*all[k].0.name, &all[k].1[..]);
        assert_eq!(of(0), ("a", &[0..400, 1300..1700, 2600..3000][..]));
        assert_eq!(of(1), ("b", std::slice::from_ref(&(500..900))));
        assert_eq!(all.len(), 2);
        // In it, between the three stretches; and at its end, where no stretch goes beyond.
        let dataset = leaping([Some(800), None]);
        assert_eq!(stretches(&dataset)[0].1[3], 600..600 + STRETCH);
        let dataset = leaping([Some(2990), None]);
        assert_eq!(stretches(&dataset).iter().map(|s| s.1.len()).collect::<Vec<_>>(), [3]);
    }
}
