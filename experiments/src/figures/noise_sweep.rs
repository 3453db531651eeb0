//! Figure of the noise sweep.

use lacuna_charts::{Axis, Figure, Line, Style};
use std::collections::BTreeMap;

use super::{legend, side_by_side};
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
    let panel = |title: &str, label, pick: fn(&Statistics) -> f64| {
        let mut lines = Vec::new();
        for (recipe, points) in by_recipe(levels, pick) {
            let (without, with): (Vec<_>, Vec<_>) = points.into_iter().partition(|p| p.0 == 0.0);
            let at_the_edge = without.into_iter().map(|(_, e)| (NO_NOISE * smallest, e)).collect();
            let (words, colour) = (legend::words(recipe), legend::colour(recipe));
            lines.push(Line::new(words, colour, Style::Joined, with));
            lines.push(Line::new("", colour, Style::Rings, at_the_edge));
        }
        let x = Axis::log("noise on the position, sd (rings: none)", "");
        Figure { title: title.to_owned(), lines, ..Figure::new(x, Axis::log(label, "1/s\u{b2}")) }
    };
    let panels = vec![
        panel("Duffing: drift f", "median of max |error of f|", |s| s.max_f.median),
        panel("Duffing: control effectiveness g", "median of max |error of g|", |s| s.max_g.median),
    ];
    side_by_side("Greatest errors of f and g against the noise on the position.", panels)
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
