//! The search for series.

use lacuna_realtime::{MOST_FACTORS, MOST_PRODUCTS};

use super::build::Work;
use super::fit::{self, Fit};
use super::layout::Layout;
use super::samples::Samples;
use super::{CompileError, cost, degrees, sums};

/// The first set of terms is smaller than what the degrees along lines ask for: they may be too many together.
const FIRST_THETA: f64 = 0.75;
/// Part of the tolerance that a whole series may take; the rest is for what is left out of it.
const FIT_SHARE: f64 = 0.6;

impl Work<'_> {
    /// Series for as many functions as can be had at less than their sums' cost.
    pub fn fits(&self) -> Result<Vec<Fit>, CompileError> {
        let degrees =
            degrees::degrees(self.model, self.domain, &self.magnitudes, 0.25 * self.tolerance)?;
        let mut samples = Samples::default();
        let mut fits = Vec::new();
        for functions in self.alike(&degrees) {
            let highest = |i: usize| functions.iter().map(|&k| degrees[k][i]).max().unwrap_or(0);
            // One degree more than the lines ask for, so that the outermost coefficients are small.
            let highest: Vec<usize> = (0..self.domain.arguments())
                .map(highest)
                .map(|d| if d == 0 { 0 } else { (d + 1).clamp(3, degrees::MOST_DEGREE) })
                .collect();
            self.fit(functions, &highest, &mut samples, &mut fits)?;
        }
        Ok(within_room(fits, self.domain.arguments()))
    }

    /// Functions whose degrees are alike, so that one set of terms serves them; zero ones are left out.
    fn alike(&self, degrees: &[Vec<usize>]) -> Vec<Vec<usize>> {
        let near = |a: usize, b: usize| {
            let (low, high) = (a.min(b), a.max(b));
            (low == 0) == (high == 0) && 2 * high <= 3 * low + 4
        };
        let pairs = |j: usize, k: usize| degrees[j].iter().zip(&degrees[k]);
        let mut alike: Vec<Vec<usize>> = Vec::new();
        for k in (0..degrees.len()).filter(|&k| self.magnitudes[k] > 0.0) {
            match alike.iter_mut().find(|some| pairs(some[0], k).all(|(a, b)| near(*a, *b))) {
                Some(some) => some.push(k),
                None => alike.push(vec![k]),
            }
        }
        alike
    }

    /// Raises theta until all functions have their series, or it is not worth while.
    fn fit(
        &self,
        mut functions: Vec<usize>,
        degrees: &[usize],
        samples: &mut Samples,
        fits: &mut Vec<Fit>,
    ) -> Result<(), CompileError> {
        let components = sums::components(self.model);
        let mut theta = FIRST_THETA;
        let mut terms = fit::terms(degrees, theta);
        while let Some(found) = terms.take() {
            let count = found.len();
            // A quarter of the terms may be all that is needed.
            let series = cost::group(count.div_ceil(32), functions.len());
            let direct: usize = components
                .iter()
                .filter(|(members, _)| members.iter().any(|k| functions.contains(k)))
                .map(|(_, cost)| cost)
                .sum();
            if functions.is_empty() || series > direct {
                break;
            }
            self.sample(samples, 3 * count + 64)?;
            if let Some(mut fit) = Fit::new(functions.clone(), found, samples) {
                let errors = fit.errors(&self.choice);
                let enough = |k: usize| FIT_SHARE * self.tolerance * self.magnitudes[k];
                let met: Vec<bool> =
                    functions.iter().zip(&errors).map(|(k, e)| *e <= enough(*k)).collect();
                functions = functions.into_iter().zip(&met).filter(|p| !p.1).map(|p| p.0).collect();
                fit.keep(&met);
                if !fit.functions.is_empty() {
                    fits.push(fit);
                }
            }
            (theta, terms) = larger(degrees, theta, count);
        }
        Ok(())
    }

    /// At least so many points for least squares; those that are known remain.
    fn sample(&self, samples: &mut Samples, count: usize) -> Result<(), CompileError> {
        let known = samples.points.len();
        if count > known {
            let new = self.domain.arcsine(count).split_off(known);
            let new = Samples::of(self.model, self.domain, new)?;
            samples.points.extend(new.points);
            samples.values.extend(new.values);
        }
        Ok(())
    }
}

/// The next set of terms, about a third larger.
fn larger(degrees: &[usize], theta: f64, count: usize) -> (f64, Option<Vec<fit::Term>>) {
    let mut theta = theta;
    // Where all degrees are at their highest, there is no larger one.
    while theta < degrees.len() as f64 + 8.0 {
        theta *= 1.03;
        match fit::terms(degrees, theta) {
            Some(terms) if 3 * terms.len() >= 4 * count => return (theta, Some(terms)),
            Some(_) => {}
            None => break,
        }
    }
    (theta, None)
}

/// Fits whose tables have room in an evaluator; the largest ones are given up first.
fn within_room(mut fits: Vec<Fit>, arguments: usize) -> Vec<Fit> {
    loop {
        let layout = Layout::new(&fits, arguments);
        let factors: usize = layout.degrees.iter().map(|d| usize::from(*d)).sum();
        let products = layout.outer.len().max(layout.inner.len());
        if factors <= MOST_FACTORS && products <= MOST_PRODUCTS {
            return fits;
        }
        let largest = (0..fits.len()).max_by_key(|&k| fits[k].terms.len());
        match largest {
            Some(largest) => drop(fits.remove(largest)),
            None => return fits,
        }
    }
}
