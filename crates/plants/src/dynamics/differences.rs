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
//! 75-76). One derivative costs four evaluations where the first h will do.

use super::{Bound, BoundDynamics, Dynamics, Mass, Point, Room, Sizes, mass_and_force};
use lacuna_numbers::Dual;
use std::fmt::Debug;
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
}

/// The dynamics of a [`Simulator`], derivatives by differences.
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

    fn derivative_error(&self) -> Option<f64> {
        Some(f64::from_bits(self.0.worst.load(Ordering::Relaxed)))
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

    /// The rates at parameters and variables, one after the other.
    fn rates_at(&self, point: &[f64], rates: &mut [f64]) {
        let (parameters, variables) = point.split_at(self.sizes.parameters);
        self.rates(parameters, variables, rates);
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
}

impl<S: Simulator> BoundDynamics<Dual> for BoundSimulator<S, Dual> {
    fn room(&self) -> Room<Dual> {
        let Sizes { parameters, .. } = self.shared.sizes;
        let entries = parameters + self.shared.sizes.variables();
        let plain = vec![0.0; 2 * entries + Table::ROWS * self.shared.sizes.rates()];
        Room::new(vec![], plain)
    }

    fn evaluate(&self, room: &mut Room<Dual>, variables: &[Dual], rates: &mut [Dual]) {
        let entries = self.parameters.len() + variables.len();
        let (point, rest) = room.plain.split_at_mut(entries);
        let (sizes, rest) = rest.split_at_mut(entries);
        let mut table = Table::of(rest);
        let all = || self.parameters.iter().chain(variables);
        for (plain, x) in point.iter_mut().zip(all()) {
            *plain = x.value;
        }
        self.shared.rates_at(point, table.here);
        for (rate, &value) in rates.iter_mut().zip(&*table.here) {
            *rate = Dual { value, tangent: [0.0; lacuna_numbers::LANES] };
        }
        for (i, x) in all().enumerate() {
            if x.tangent.iter().all(|&t| t == 0.0) {
                continue;
            }
            sizes[i] = sizes[i].max(x.value.abs());
            let size = if sizes[i] > 0.0 { sizes[i] } else { 1.0 };
            let error = table.differentiate(&self.shared, point, (i, size));
            self.shared.worst.fetch_max(error.to_bits(), Ordering::Relaxed);
            for (rate, slope) in rates.iter_mut().zip(&*table.slope) {
                for (to, from) in rate.tangent.iter_mut().zip(&x.tangent) {
                    *to += slope * from;
                }
            }
        }
    }
}

/// Rates at a point and near it.
struct Table<'a> {
    here: &'a mut [f64],
    above: &'a mut [f64],
    below: &'a mut [f64],
    coarse: &'a mut [f64],
    fine: &'a mut [f64],
    slope: &'a mut [f64],
}

impl<'a> Table<'a> {
    const ROWS: usize = 6;

    fn of(plain: &'a mut [f64]) -> Self {
        let width = plain.len() / Self::ROWS;
        let (here, rest) = plain.split_at_mut(width);
        let (above, rest) = rest.split_at_mut(width);
        let (below, rest) = rest.split_at_mut(width);
        let (coarse, rest) = rest.split_at_mut(width);
        let (fine, slope) = rest.split_at_mut(width);
        Self { here, above, below, coarse, fine, slope }
    }

    /// Derivatives by one entry, into `slope`, and their largest share of error: infinite, with
    /// derivatives of 0, where the simulator is not finite on both sides at any step.
    fn differentiate<S: Simulator>(
        &mut self,
        shared: &Shared<S>,
        point: &mut [f64],
        (entry, size): (usize, f64),
    ) -> f64 {
        self.slope.fill(0.0);
        let (mut best, mut h) = (f64::INFINITY, STEP * size);
        for _ in 0..TRIES {
            let error = self.extrapolate(shared, point, (entry, h), size);
            if error < best {
                best = error;
                for (slope, (fine, coarse)) in
                    self.slope.iter_mut().zip(self.fine.iter().zip(&*self.coarse))
                {
                    *slope = (4.0 * fine - coarse) / 3.0;
                }
            }
            if best <= GOOD {
                break;
            }
            h *= SHRINK;
        }
        best
    }

    /// Differences of steps h and h/2, and the largest share of error of their extrapolation.
    fn extrapolate<S: Simulator>(
        &mut self,
        shared: &Shared<S>,
        point: &mut [f64],
        (entry, h): (usize, f64),
        size: f64,
    ) -> f64 {
        self.difference(shared, point, (entry, h));
        self.coarse.copy_from_slice(self.fine);
        self.difference(shared, point, (entry, 0.5 * h));
        let mut worst = 0.0f64;
        for j in 0..self.here.len() {
            let largest = self.here[j].abs().max(self.above[j].abs()).max(self.below[j].abs());
            let slope = (4.0 * self.fine[j] - self.coarse[j]) / 3.0;
            let error =
                (self.fine[j] - self.coarse[j]).abs() / 3.0 + 8.0 * f64::EPSILON * largest / h;
            if !error.is_finite() {
                return f64::INFINITY;
            }
            if error > 0.0 {
                worst = worst.max(error / (slope.abs() + largest / size));
            }
        }
        worst
    }

    /// The central difference of step h, into `fine`.
    fn difference<S: Simulator>(
        &mut self,
        shared: &Shared<S>,
        point: &mut [f64],
        (entry, h): (usize, f64),
    ) {
        let before = point[entry];
        point[entry] = before + h;
        let above = point[entry];
        shared.rates_at(point, self.above);
        point[entry] = before - h;
        // The distance that is really between the two.
        let width = above - point[entry];
        shared.rates_at(point, self.below);
        point[entry] = before;
        for ((d, a), b) in self.fine.iter_mut().zip(&*self.above).zip(&*self.below) {
            *d = (a - b) / width;
        }
    }
}
