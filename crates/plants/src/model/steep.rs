//! Steps of Runge-Kutta along friction that is steep about rest.
//!
//! Dry friction that lets next to nothing creep falls with the velocity at a rate `lambda` of 10^4 to 10^6 a second where
//! a machine sticks, and steps of order four are stable up to `2.78 / lambda`, though nothing moves. There the rate
//! of each velocity is solved exactly and all else beside it:
//!
//! ```text
//! v' = -lambda (v - v_n) + g,    lambda = (M^-1)_cc (-dr/dv)(v_n) held over the step,    g = v' + lambda (v - v_n)
//! a = v_n + h/2 phi_1 g_1,    b = v_n + h/2 phi_1 g_2,    c = v_n + h/2 phi_1 (2 g_3 - (1 - e^-z) g_1),    z = lambda h/2
//! v_n+1 = v_n + h (b_1 g_1 + b_2 (g_2 + g_3) + b_3 g_4)
//! b_1 = phi_1 - 3 phi_2 + 4 phi_3,    b_2 = 2 phi_2 - 4 phi_3,    b_3 = 4 phi_3 - phi_2    of lambda h
//! phi_1 = (1 - e^-x) / x,    phi_2 = (1 - phi_1) / x,    phi_3 = (1/2 - phi_2) / x
//! ```
//!
//! (exponential time differencing of order four: S. M. Cox, P. C. Matthews, Journal of Computational Physics 176, 2002,
//! equations 26 to 29), which for lambda = 0 is the classical step. It is of that order whatever lambda is: it need
//! not be exact, carries no derivatives, and leaves out what one coordinate's rest is to another. Where g jumps the
//! step is cut ([`crate::substeps`]), and lambda found again at the beginning of each piece.

use super::mass::{factor, impose, solve_factored};
use lacuna_numbers::Number;

/// Rates up to this share of one over the step are resolved by it as they are.
const RESOLVED: f64 = 0.2;

/// The rates of the velocities over a step, and room to find them.
#[derive(Clone, Debug, Default)]
pub(super) struct Steep {
    /// Coordinates; their velocities stand behind them in the state.
    coordinates: usize,
    /// lambda of each channel (1/s).
    rates: Vec<f64>,
    /// Whether any is more than nothing.
    is_any: bool,
    mass: Vec<f64>,
    column: Vec<f64>,
}

impl Steep {
    /// Of so many coordinates and states.
    pub fn new(coordinates: usize, states: usize) -> Self {
        Self {
            coordinates,
            rates: vec![0.0; coordinates + states],
            is_any: false,
            mass: vec![0.0; coordinates * coordinates],
            column: vec![0.0; coordinates],
        }
    }

    /// Find the rates anew: `damp` adds to `-dr/dv` of each channel and says whether it did.
    #[inline(always)]
    pub fn find(&mut self, damp: impl FnOnce(&mut [f64]) -> bool) -> bool {
        if self.is_any {
            self.rates.fill(0.0);
        }
        self.is_any = damp(&mut self.rates);
        self.is_any
    }

    /// Divide them by what each coordinate has of inertia, the others being free to follow; those that are imposed rest
    /// for no friction.
    pub fn over_mass<T: Number>(&mut self, mass: &[T], imposed: &[usize]) {
        for (to, from) in self.mass.iter_mut().zip(mass) {
            *to = from.value();
        }
        impose(imposed, |_| 0.0, &mut self.mass, &mut self.column);
        for &c in imposed {
            self.rates[c] = 0.0;
        }
        factor(&mut self.mass, self.coordinates);
        let factors = std::mem::take(&mut self.mass);
        self.over_factors(&factors);
        self.mass = factors;
    }

    /// The same, given the factors of the mass matrix.
    pub fn over_factors(&mut self, factors: &[f64]) {
        for c in 0..self.coordinates {
            if self.rates[c] > 0.0 {
                self.column.fill(0.0);
                self.column[c] = 1.0;
                solve_factored(factors, &mut self.column);
                self.rates[c] *= self.column[c];
            }
        }
    }

    /// Be as another.
    pub fn copy(&mut self, other: &Self) {
        self.is_any = other.is_any;
        self.rates.copy_from_slice(&other.rates);
    }

    /// The rate of an entry of the state, velocities and what stands behind them.
    #[inline(always)]
    pub fn rate(&self, entry: usize) -> f64 {
        self.rates.get(entry - self.coordinates).copied().unwrap_or(0.0)
    }

    /// The entries of the state that a step of `h` does not resolve, with their rates.
    #[inline(always)]
    fn entries(&self, h: f64) -> impl Iterator<Item = (usize, f64)> + '_ {
        let rates: &[f64] = if self.is_any { &self.rates } else { &[] };
        let all = rates.iter().enumerate().map(|(c, rate)| (self.coordinates + c, *rate));
        all.filter(move |(_, rate)| rate * h > RESOLVED)
    }

    /// Where the `k`-th stage of a step is, the state moved by `step` along the slope before it.
    #[inline(always)]
    pub fn moved<T: Number>(
        &self,
        k: usize,
        step: f64,
        state: &[T],
        slope: &[Vec<T>; 4],
        to: &mut [T],
    ) {
        for (i, rate) in self.entries(length(k, step)) {
            let half = 0.5 * length(k, step);
            let z = rate * half;
            let first = -f64::exp_m1(-z);
            let along = match k {
                3 => slope[2][i] * 2.0 - slope[0][i] * first,
                _ => slope[k - 1][i],
            };
            to[i] = state[i] + along * (first / z * half);
        }
    }

    /// Make a slope at the `k`-th stage that relative to the rate.
    #[inline(always)]
    pub fn relative<T: Number>(
        &self,
        k: usize,
        step: f64,
        state: &[T],
        stage: &[T],
        slope: &mut [T],
    ) {
        if k > 0 {
            for (i, rate) in self.entries(length(k, step)) {
                slope[i] = slope[i] + (stage[i] - state[i]) * rate;
            }
        }
    }

    /// Where a step of `h` ends, from its four slopes.
    #[inline(always)]
    pub fn ended<T: Number>(&self, h: f64, state: &[T], slope: &[Vec<T>; 4], to: &mut [T]) {
        for (i, rate) in self.entries(h) {
            let [first, middle, last] = weights(rate * h);
            let [g1, g2, g3, g4] = slope;
            let sum = g1[i] * first + (g2[i] + g3[i]) * middle + g4[i] * last;
            to[i] = state[i] + sum * h;
        }
    }

    /// Take the entries that a step of `h` does not resolve from where it [`ended`](Self::ended).
    #[inline(always)]
    pub fn set<T: Number>(&self, h: f64, from: &[T], state: &mut [T]) {
        for (i, _) in self.entries(h) {
            state[i] = from[i];
        }
    }
}

/// How long a step is of which the `k`-th stage, beyond the first, is `step` behind its beginning.
#[inline(always)]
const fn length(k: usize, step: f64) -> f64 {
    if k == 3 { step } else { 2.0 * step }
}

/// Weights of the first slope, of the second and third, of the fourth.
#[inline(always)]
fn weights(x: f64) -> [f64; 3] {
    let phi_1 = -f64::exp_m1(-x) / x;
    let phi_2 = (1.0 - phi_1) / x;
    let phi_3 = (0.5 - phi_2) / x;
    [phi_1 - 3.0 * phi_2 + 4.0 * phi_3, 2.0 * phi_2 - 4.0 * phi_3, 4.0 * phi_3 - phi_2]
}
