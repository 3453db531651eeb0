//! Derivatives for simulators that have none: differences whose error is measured.
//!
//! A derivative by a parameter or variable x is a central difference, extrapolated,
//!
//! ```text
//! D(h) = (F(x + h) - F(x - h)) / 2h,    dF/dx = (4 D(h/2) - D(h)) / 3
//! ```
//!
//! and its error is taken to be that of the better of the two differences, plus rounding:
//!
//! ```text
//! e = |D(h/2) - D(h)| / 3 + 8 eps max|F| / h
//! ```
//!
//! which bounds it where F is smooth over h, as the extrapolated value is better by another two
//! orders. h is a thousandth of the largest |x| met so far (of 1 while x has only been 0) and is
//! reduced where e is large beside `|dF/dx| + |F|/|x|` (C. Ridders, Adv. Eng. Softw. 4 (1982)
//! 75-76). One derivative costs four evaluations where the first h will do, and those of all derivatives at a
//! point are asked for together ([`Simulator::evaluate_all`]).

use super::{Bound, BoundDynamics, Dynamics, Mass, Point, Room, Sizes, mass_and_force};
use lacuna_numbers::Dual;
use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The first step as a share of the size of what is moved.
const STEP: f64 = 1e-3;
/// Each further step beside the one before it, and how many there are at most.
const SHRINK: f64 = 0.2;
const TRIES: usize = 5;
/// Share of error with which no smaller step is tried.
const GOOD: f64 = 1e-6;

/// A simulator that computes in plain numbers and has no derivatives.
pub trait Simulator: Debug + Send + Sync + 'static {
    /// Whether it gives the mass matrix.
    fn mass(&self) -> Mass;

    /// Mass matrix (row-major `n x n`; the identity on entry), and generalised forces followed by
    /// the rates of the first-order states (`n + s`). It depends on nothing but `at`.
    fn evaluate(&self, at: &Point<'_>, mass: &mut [f64], force: &mut [f64]);

    /// The same at several points: parameters and variables of one in a row of `points`, its mass matrix
    /// and what follows it in a row of `rates` ([`Sizes::rates`]). To be given where many at once cost less than
    /// one after the other.
    fn evaluate_all(&self, sizes: Sizes, points: &[f64], rates: &mut [f64]) {
        let rows = points.chunks_exact(sizes.parameters + sizes.variables());
        for (point, rates) in rows.zip(rates.chunks_exact_mut(sizes.rates())) {
            let (parameters, variables) = point.split_at(sizes.parameters);
            let (mass, force) = mass_and_force(sizes, rates);
            self.evaluate(&Point::new(sizes, parameters, variables), mass, force);
        }
    }

    /// Whether it has the derivatives of its rates by an entry of a point itself: by a parameter, or
    /// by a variable after all parameters.
    fn has_derivative(&self, sizes: Sizes, entry: usize) -> bool {
        let _ = (sizes, entry);
        false
    }

    /// As [`Simulator::evaluate_all`], and derivatives at the first point by `entries`, which all are such
    /// that it has ([`Simulator::has_derivative`]): a row of `slopes` each.
    fn evaluate_along(
        &self,
        sizes: Sizes,
        points: &[f64],
        rates: &mut [f64],
        (entries, slopes): (&[usize], &mut [f64]),
    ) {
        let _ = (entries, slopes);
        self.evaluate_all(sizes, points, rates);
    }

    /// Number of outputs of its own, beside the state's entries and the inputs.
    fn outputs(&self) -> usize {
        0
    }

    /// These outputs at several points, as [`Simulator::evaluate_all`] does with rates.
    fn observe_all(&self, sizes: Sizes, points: &[f64], outputs: &mut [f64]) {
        let _ = (sizes, points);
        outputs.fill(f64::NAN);
    }

    /// What went wrong so far, in a sentence ([`Dynamics::trouble`]).
    fn trouble(&self) -> Option<String> {
        None
    }
}

/// The dynamics of a [`Simulator`], derivatives by differences where it has none.
#[derive(Debug)]
pub struct Differences<S>(Arc<Shared<S>>);

#[derive(Debug)]
struct Shared<S> {
    simulator: S,
    sizes: Sizes,
    /// Bits of the largest share of error. Those of numbers that are not negative are ordered as
    /// the numbers are, so that the largest does not depend on which thread comes first.
    worst: AtomicU64,
}

impl<S: Simulator> Differences<S> {
    /// The dynamics of a simulator of these sizes.
    #[must_use]
    pub fn new(simulator: S, sizes: Sizes) -> Self {
        Self(Arc::new(Shared { simulator, sizes, worst: AtomicU64::new(0) }))
    }
}

impl<S: Simulator> Dynamics for Differences<S> {
    fn sizes(&self) -> Sizes {
        self.0.sizes
    }

    fn mass(&self) -> Mass {
        self.0.simulator.mass()
    }

    fn outputs(&self) -> usize {
        self.0.simulator.outputs()
    }

    fn derivative_error(&self) -> Option<f64> {
        let Sizes { parameters, .. } = self.0.sizes;
        let entries = parameters + self.0.sizes.variables() - 1;
        let known = |k: usize| self.0.simulator.has_derivative(self.0.sizes, k);
        let worst = f64::from_bits(self.0.worst.load(Ordering::Relaxed));
        // Those by parameters that are known exactly are never asked for.
        (worst > 0.0 || !(parameters..entries).all(known)).then_some(worst)
    }

    fn trouble(&self) -> Option<String> {
        self.0.simulator.trouble()
    }

    fn bind(&self, parameters: &[f64]) -> Bound {
        Arc::new(BoundSimulator { shared: self.0.clone(), parameters: parameters.to_vec() })
    }

    fn bind_dual(&self, parameters: &[Dual]) -> Bound<Dual> {
        Arc::new(BoundSimulator { shared: self.0.clone(), parameters: parameters.to_vec() })
    }
}

impl<S: Simulator> Shared<S> {
    fn rates(&self, parameters: &[f64], variables: &[f64], rates: &mut [f64]) {
        let at = Point::new(self.sizes, parameters, variables);
        let (mass, force) = mass_and_force(self.sizes, rates);
        self.simulator.evaluate(&at, mass, force);
    }
}

#[derive(Debug)]
struct BoundSimulator<S, T> {
    shared: Arc<Shared<S>>,
    parameters: Vec<T>,
}

impl<S: Simulator> BoundDynamics<f64> for BoundSimulator<S, f64> {
    fn evaluate(&self, _room: &mut Room<f64>, variables: &[f64], rates: &mut [f64]) {
        self.shared.rates(&self.parameters, variables, rates);
    }

    fn observe(&self, variables: &[f64], outputs: &mut [f64]) {
        let point = [&self.parameters, variables].concat();
        self.shared.simulator.observe_all(self.shared.sizes, &point, outputs);
    }
}

impl<S: Simulator> BoundDynamics<Dual> for BoundSimulator<S, Dual> {
    fn room(&self) -> Room<Dual> {
        let Sizes { parameters, .. } = self.shared.sizes;
        let entries = parameters + self.shared.sizes.variables();
        Room::new(vec![], vec![0.0; Nearby::length(entries, self.shared.sizes.rates())])
    }

    fn evaluate(&self, room: &mut Room<Dual>, variables: &[Dual], rates: &mut [Dual]) {
        let entries = self.parameters.len() + variables.len();
        let mut near = Nearby::of(&mut room.plain, entries, rates.len());
        let Shared { simulator, sizes, .. } = &*self.shared;
        let known = |entry: usize| simulator.has_derivative(*sizes, entry);
        self.differentiate(&mut near, variables, &known, &|points, rates, along| {
            simulator.evaluate_along(*sizes, points, rates, along);
        });
        near.write(self.parameters.iter().chain(variables), rates);
    }

    fn observe(&self, variables: &[Dual], outputs: &mut [Dual]) {
        let entries = self.parameters.len() + variables.len();
        let mut plain = vec![0.0; Nearby::length(entries, outputs.len())];
        let mut near = Nearby::of(&mut plain, entries, outputs.len());
        let Shared { simulator, sizes, .. } = &*self.shared;
        self.differentiate(&mut near, variables, &|_| false, &|points, outputs, _| {
            simulator.observe_all(*sizes, points, outputs);
        });
        near.write(self.parameters.iter().chain(variables), outputs);
    }
}

/// What is differentiated: values at points, and derivatives at the first of them that are known.
type Evaluate<'a> = dyn Fn(&[f64], &mut [f64], (&[usize], &mut [f64])) + 'a;

impl<S: Simulator> BoundSimulator<S, Dual> {
    /// Values and derivatives at a point.
    fn differentiate(
        &self,
        near: &mut Nearby<'_>,
        variables: &[Dual],
        known: &dyn Fn(usize) -> bool,
        evaluate: &Evaluate<'_>,
    ) {
        let all = || self.parameters.iter().chain(variables);
        near.begin(all());
        let along: Vec<usize> = near.moved().filter(|&entry| known(entry)).collect();
        near.leave(&along);
        for attempt in 0..TRIES {
            let rows = near.lay_out();
            if rows == 1 && attempt > 0 {
                break;
            }
            // The point itself is evaluated with the first of those around it.
            match attempt {
                0 => near.evaluate_along(rows, &along, evaluate),
                _ => near.evaluate(1..rows, evaluate),
            }
            near.differentiate();
        }
        for (i, _) in all().enumerate().filter(|(_, x)| moves(x)) {
            self.shared.worst.fetch_max(near.errors[i].to_bits(), Ordering::Relaxed);
        }
    }
}

/// Whether an entry carries a derivative.
fn moves(x: &Dual) -> bool {
    x.tangent.iter().any(|&t| t != 0.0)
}

/// A point, points around it, and rates and derivatives there. An entry is a parameter or variable.
struct Nearby<'a> {
    entries: usize,
    width: usize,
    /// Largest size of each entry met so far: kept from one point to the next.
    sizes: &'a mut [f64],
    /// Step of each entry; 0 where it is not moved.
    steps: &'a mut [f64],
    /// Share of error of each entry's best derivative: infinite, with derivatives of 0, where the
    /// simulator is not finite on both sides at any step.
    errors: &'a mut [f64],
    /// Those derivatives, a row an entry.
    slopes: &'a mut [f64],
    /// The point, then [`AROUND`] points for each entry that is still moved.
    points: &'a mut [f64],
    /// Rates there.
    rates: &'a mut [f64],
}

/// Points around a point for one entry: a step above and below it, and half a step.
const AROUND: usize = 4;

impl<'a> Nearby<'a> {
    fn length(entries: usize, width: usize) -> usize {
        (3 + width) * entries + (1 + AROUND * entries) * (entries + width)
    }

    fn of(plain: &'a mut [f64], entries: usize, width: usize) -> Self {
        let (sizes, rest) = plain.split_at_mut(entries);
        let (steps, rest) = rest.split_at_mut(entries);
        let (errors, rest) = rest.split_at_mut(entries);
        let (slopes, rest) = rest.split_at_mut(width * entries);
        let (points, rates) = rest.split_at_mut((1 + AROUND * entries) * entries);
        Self { entries, width, sizes, steps, errors, slopes, points, rates }
    }

    fn rates_of(&self, row: usize) -> &[f64] {
        &self.rates[row * self.width..(row + 1) * self.width]
    }

    fn slopes_of(&self, entry: usize) -> &[f64] {
        &self.slopes[entry * self.width..(entry + 1) * self.width]
    }

    /// Go to a point.
    fn begin<'x>(&mut self, all: impl Iterator<Item = &'x Dual>) {
        self.slopes.fill(0.0);
        self.errors.fill(f64::INFINITY);
        for (i, x) in all.enumerate() {
            self.points[i] = x.value;
            self.steps[i] = 0.0;
            if moves(x) {
                self.sizes[i] = self.sizes[i].max(x.value.abs());
                self.steps[i] = STEP * self.size(i);
            }
        }
    }

    /// The entries that are moved.
    fn moved(&self) -> impl Iterator<Item = usize> {
        (0..self.entries).filter(|&entry| self.steps[entry] > 0.0)
    }

    /// Move these no more: their derivatives are known.
    fn leave(&mut self, entries: &[usize]) {
        entries.iter().for_each(|&entry| self.steps[entry] = 0.0);
    }

    /// The rates at the point, with the derivatives that are carried by all entries.
    fn write<'x>(&self, all: impl Iterator<Item = &'x Dual>, rates: &mut [Dual]) {
        for (rate, &value) in rates.iter_mut().zip(self.rates_of(0)) {
            *rate = Dual { value, tangent: [0.0; lacuna_numbers::LANES] };
        }
        for (i, x) in all.enumerate().filter(|(_, x)| moves(x)) {
            for (rate, slope) in rates.iter_mut().zip(self.slopes_of(i)) {
                for (to, from) in rate.tangent.iter_mut().zip(&x.tangent) {
                    *to += slope * from;
                }
            }
        }
    }

    /// The size that an entry's steps are shares of.
    fn size(&self, entry: usize) -> f64 {
        if self.sizes[entry] > 0.0 { self.sizes[entry] } else { 1.0 }
    }

    /// Whether an entry is still moved.
    fn is_pending(&self, entry: usize) -> bool {
        self.steps[entry] > 0.0 && self.errors[entry] > GOOD
    }

    /// Write the points around for the entries that are still moved; how many rows there are then.
    fn lay_out(&mut self) -> usize {
        let mut row = 1;
        for entry in 0..self.entries {
            if !self.is_pending(entry) {
                continue;
            }
            let h = self.steps[entry];
            for step in [h, -h, 0.5 * h, -0.5 * h] {
                let to = row * self.entries;
                self.points.copy_within(..self.entries, to);
                self.points[to + entry] += step;
                row += 1;
            }
        }
        row
    }

    fn evaluate(&mut self, rows: Range<usize>, evaluate: &Evaluate<'_>) {
        let points = &self.points[rows.start * self.entries..rows.end * self.entries];
        let rates = &mut self.rates[rows.start * self.width..rows.end * self.width];
        evaluate(points, rates, (&[], &mut []));
    }

    /// The first rows, the point itself among them, with the derivatives there that are known.
    fn evaluate_along(&mut self, rows: usize, along: &[usize], evaluate: &Evaluate<'_>) {
        let mut slopes = vec![0.0; along.len() * self.width];
        let points = &self.points[..rows * self.entries];
        evaluate(points, &mut self.rates[..rows * self.width], (along, &mut slopes));
        for (&entry, slopes) in along.iter().zip(slopes.chunks_exact(self.width)) {
            if slopes.iter().all(|slope| slope.is_finite()) {
                self.errors[entry] = 0.0;
                self.slopes[entry * self.width..(entry + 1) * self.width].copy_from_slice(slopes);
            }
        }
    }

    /// Derivatives by the entries that are still moved, and smaller steps for the next time.
    fn differentiate(&mut self) {
        let mut row = 1;
        for entry in 0..self.entries {
            if !self.is_pending(entry) {
                continue;
            }
            let error = self.error(entry, row);
            if error < self.errors[entry] {
                self.errors[entry] = error;
                for j in 0..self.width {
                    self.slopes[entry * self.width + j] = self.extrapolated(entry, row, j).slope;
                }
            }
            self.steps[entry] *= SHRINK;
            row += AROUND;
        }
    }

    /// Largest share of error of the derivatives by an entry, whose points begin at a row.
    fn error(&self, entry: usize, row: usize) -> f64 {
        let (h, size) = (self.steps[entry], self.size(entry));
        let mut worst = 0.0f64;
        for j in 0..self.width {
            // The points of half a step tell how large rates are: those that the better difference is of.
            let near = [0, row + 2, row + 3].map(|r| self.rates[r * self.width + j].abs());
            let largest = near.into_iter().fold(0.0, f64::max);
            let Extrapolated { slope, change } = self.extrapolated(entry, row, j);
            let error = change / 3.0 + 8.0 * f64::EPSILON * largest / h;
            if !error.is_finite() {
                return f64::INFINITY;
            }
            if error > 0.0 {
                worst = worst.max(error / (slope.abs() + largest / size));
            }
        }
        worst
    }

    /// The derivative of a rate by an entry, whose points begin at a row.
    fn extrapolated(&self, entry: usize, row: usize, rate: usize) -> Extrapolated {
        let difference = |above: usize| {
            let of = |values: &[f64], width: usize, k: usize| {
                values[above * width + k] - values[(above + 1) * width + k]
            };
            // The distance that is really between the two.
            of(self.rates, self.width, rate) / of(self.points, self.entries, entry)
        };
        let (coarse, fine) = (difference(row), difference(row + 2));
        Extrapolated { slope: (4.0 * fine - coarse) / 3.0, change: (fine - coarse).abs() }
    }
}

/// A derivative from differences of steps h and h/2, and how these differ.
struct Extrapolated {
    slope: f64,
    change: f64,
}
