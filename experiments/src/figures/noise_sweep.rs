//! Figure of the noise sweep.

use std::collections::BTreeMap;

use super::chart::{Axis, Panel, Series, line_figure};
use crate::StudyError;
use crate::duffing_montecarlo::Statistics;
use crate::noise_sweep::Level;

/// Where the errors without noise are drawn, as a share of the smallest noise.
const NO_NOISE: f64 = 0.4;

/// Median of the greatest errors against the noise, one curve a recipe; the errors without noise
/// as rings at the left edge.
///
/// # Errors
/// [`StudyError::Figure`] when it cannot be drawn.
pub fn errors(levels: &[Level]) -> Result<String, StudyError> {
    let smallest = levels.iter().map(|l| l.noise).filter(|n| *n > 0.0).fold(f64::MAX, f64::min);
    let panel = |title, label, pick: fn(&Statistics) -> f64| {
        let mut series = Vec::new();
        for (colour, (recipe, points)) in (1..).zip(by_recipe(levels, pick)) {
            let (without, with): (Vec<_>, Vec<_>) = points.into_iter().partition(|p| p.0 == 0.0);
            series.push(Series::dots(recipe, colour, with));
            let at_the_edge = without.into_iter().map(|(_, e)| (NO_NOISE * smallest, e)).collect();
            series.push(Series::rings(colour, at_the_edge));
        }
        let x = Axis::log("sd of the noise on the position (rings: no noise)");
        Panel { title, x, y: Axis::log(label), series }
    };
    line_figure(&[
        panel("Duffing: drift", "median of max |f error| (1/s\u{b2})", |s| s.max_f.median),
        panel("Duffing: control effectiveness", "median of max |g error| (1/s\u{b2})", |s| {
            s.max_g.median
        }),
    ])
}

/// `(noise, error)` of each recipe where it made a model in any trial.
fn by_recipe(levels: &[Level], pick: fn(&Statistics) -> f64) -> BTreeMap<&str, Vec<(f64, f64)>> {
    let mut curves: BTreeMap<&str, Vec<(f64, f64)>> = BTreeMap::new();
    for level in levels {
        for (recipe, found) in &level.recipes {
            let point = found.errors.map(|s| (level.noise, pick(&s)));
            curves.entry(recipe).or_default().extend(point);
        }
    }
    curves
}
