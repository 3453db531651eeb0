//! What the coordinates are to follow.

/// A reference trajectory with its first two time derivatives.
pub trait Reference: Sync {
    /// `q_d`, `q_d'` and `q_d''` at time `t` in seconds, each of length `p`.
    fn at(&self, t: f64, position: &mut [f64], velocity: &mut [f64], acceleration: &mut [f64]);
}

/// The reference of a regulator: rest at the origin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Origin;

impl Reference for Origin {
    fn at(&self, _t: f64, position: &mut [f64], velocity: &mut [f64], acceleration: &mut [f64]) {
        position.fill(0.0);
        velocity.fill(0.0);
        acceleration.fill(0.0);
    }
}

/// A reference given as a function `(t, q_d, q_d', q_d'')` that fills the last three.
#[derive(Clone, Copy, Debug)]
pub struct ReferenceFn<F>(pub F);

impl<F: Fn(f64, &mut [f64], &mut [f64], &mut [f64]) + Sync> Reference for ReferenceFn<F> {
    fn at(&self, t: f64, position: &mut [f64], velocity: &mut [f64], acceleration: &mut [f64]) {
        (self.0)(t, position, velocity, acceleration);
    }
}
