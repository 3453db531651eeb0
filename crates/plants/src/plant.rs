//! The [`Plant`] trait.

/// A system `x^(s) = f + g u`, written as a first-order equation of its whole state.
///
/// The state holds the `n` coordinates, then (for order 2) their `n` velocities, then
/// any memory of effects such as hysteresis: `states() >= order() * dimension()`.
pub trait Plant: Send + Sync {
    /// Order `s` of the differential equation.
    fn order(&self) -> usize;

    /// Number `n` of coordinates.
    fn dimension(&self) -> usize;

    /// Number `m` of inputs.
    fn inputs(&self) -> usize;

    /// Length of the state vector, memory included.
    fn states(&self) -> usize {
        self.order() * self.dimension()
    }

    /// Time derivative of the whole state at time `t` under input `u`, into `derivative`.
    ///
    /// `state` and `derivative` have length [`Plant::states`], `u` has [`Plant::inputs`].
    fn derivative(&self, t: f64, state: &[f64], u: &[f64], derivative: &mut [f64]);

    /// Drift `f` at a state: the highest derivative of each coordinate without input.
    /// `f` has length [`Plant::dimension`].
    fn drift(&self, state: &[f64], f: &mut [f64]) {
        let zero = vec![0.0; self.inputs()];
        let mut derivative = vec![0.0; self.states()];
        self.derivative(0.0, state, &zero, &mut derivative);
        f.copy_from_slice(highest(self.order(), self.dimension(), &derivative));
    }

    /// Control effectiveness `g` at a state, row-major `n x m`: what a unit of each input
    /// adds to the highest derivative. Exact for plants that are affine in the input.
    fn control_effectiveness(&self, state: &[f64], g: &mut [f64]) {
        let (n, m) = (self.dimension(), self.inputs());
        let mut f = vec![0.0; n];
        self.drift(state, &mut f);
        let mut u = vec![0.0; m];
        let mut derivative = vec![0.0; self.states()];
        for j in 0..m {
            u[j] = 1.0;
            self.derivative(0.0, state, &u, &mut derivative);
            u[j] = 0.0;
            let top = highest(self.order(), n, &derivative);
            for i in 0..n {
                g[i * m + j] = top[i] - f[i];
            }
        }
    }
}

/// The block of the state's derivative that holds `x^(s)`.
fn highest(order: usize, dimension: usize, derivative: &[f64]) -> &[f64] {
    &derivative[(order - 1) * dimension..order * dimension]
}
