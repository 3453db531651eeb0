//! The computed-torque law.

use crate::{AccelerationModel, ControlError, Reference};
use nalgebra::{DMatrix, DVector, SVD};

/// Smallest ratio of singular values of `g2` at which it counts as invertible.
const RANK_TOLERANCE: f64 = 1e-10;

/// Diagonal gains of the error dynamics `e'' + Kv e' + Kp e = 0`.
#[derive(Clone, Debug, PartialEq)]
pub struct Gains {
    /// Diagonal of `Kp`, 1/s^2.
    pub position: Vec<f64>,
    /// Diagonal of `Kv`, 1/s.
    pub velocity: Vec<f64>,
}

impl Gains {
    /// `Kp = kp I` and `Kv = kv I` for `p` coordinates.
    pub fn uniform(p: usize, kp: f64, kv: f64) -> Self {
        Self { position: vec![kp; p], velocity: vec![kv; p] }
    }
}

/// `u = g2(x)^+ (q_d'' + Kp (q_d - q) + Kv (q_d' - q') - f2(x))`.
#[derive(Clone)]
pub struct ComputedTorque<'a> {
    model: &'a dyn AccelerationModel,
    reference: &'a dyn Reference,
    gains: Gains,
}

impl<'a> ComputedTorque<'a> {
    /// A law that inverts `model` to follow `reference`.
    ///
    /// # Errors
    /// [`ControlError::Underactuated`] for fewer inputs than coordinates,
    /// [`ControlError::Mismatch`] when the gains do not have one entry a coordinate.
    pub fn new(
        model: &'a dyn AccelerationModel,
        reference: &'a dyn Reference,
        gains: Gains,
    ) -> Result<Self, ControlError> {
        let (coordinates, inputs) = (model.coordinates(), model.inputs());
        if inputs < coordinates {
            return Err(ControlError::Underactuated { coordinates, inputs });
        }
        for (what, found) in
            [("position gains", gains.position.len()), ("velocity gains", gains.velocity.len())]
        {
            if found != coordinates {
                return Err(ControlError::Mismatch { what, expected: coordinates, found });
            }
        }
        Ok(Self { model, reference, gains })
    }

    /// Number `p` of coordinates that the law controls.
    pub fn coordinates(&self) -> usize {
        self.model.coordinates()
    }

    /// Number `m` of inputs that the law computes.
    pub fn inputs(&self) -> usize {
        self.model.inputs()
    }

    /// The input at time `t` (seconds) in `state`, whose first `2p` entries are the positions and
    /// the velocities, into `u` of length `m`. With more inputs than coordinates, the one of
    /// least norm.
    ///
    /// # Errors
    /// [`ControlError::Singular`] where `g2` has lost rank, [`ControlError::NotFinite`] where the
    /// model is not finite.
    pub fn input(&self, t: f64, state: &[f64], u: &mut [f64]) -> Result<(), ControlError> {
        let (p, m) = (self.coordinates(), self.inputs());
        let (mut f, mut g) = (vec![0.0; p], vec![0.0; p * m]);
        self.model.accelerations(&state[..2 * p], &mut f, &mut g);
        let mut wanted = self.wanted_acceleration(t, state);
        for (w, f) in wanted.iter_mut().zip(&f) {
            *w -= f;
        }
        if wanted.iter().chain(&g).any(|v| !v.is_finite()) {
            return Err(ControlError::NotFinite { time: t });
        }
        u.copy_from_slice(least_norm(t, DMatrix::from_row_slice(p, m, &g), wanted)?.as_slice());
        Ok(())
    }

    /// `q_d'' + Kp (q_d - q) + Kv (q_d' - q')`.
    fn wanted_acceleration(&self, t: f64, state: &[f64]) -> DVector<f64> {
        let p = self.coordinates();
        let (mut q, mut dq, mut ddq) = (vec![0.0; p], vec![0.0; p], vec![0.0; p]);
        self.reference.at(t, &mut q, &mut dq, &mut ddq);
        DVector::from_fn(p, |i, _| {
            ddq[i]
                + self.gains.position[i] * (q[i] - state[i])
                + self.gains.velocity[i] * (dq[i] - state[p + i])
        })
    }
}

/// `g^+ a`: with the columns of `g^T` made orthogonal, `g^T = Q R`, it is `Q R^-T a`. Where the diagonal of `R`, which falls,
/// tells of lost rank, singular values decide: they take several times as long.
fn least_norm(t: f64, g: DMatrix<f64>, a: DVector<f64>) -> Result<DVector<f64>, ControlError> {
    const DOUBTFUL: f64 = 1e3 * RANK_TOLERANCE;
    let qr = g.transpose().col_piv_qr();
    let r = qr.r();
    let diagonal = |i: usize| r[(i, i)].abs();
    // Also where squares overflow and nothing can be compared.
    let full_rank = diagonal(r.nrows() - 1) > DOUBTFUL * diagonal(0);
    if !full_rank {
        return least_norm_by_singular_values(t, g, a);
    }
    // g^T P = Q R, so g u = a is R^T Q^T u = P^T a.
    let mut permuted = a;
    qr.p().permute_rows(&mut permuted);
    let solved = r.tr_solve_upper_triangular(&permuted);
    Ok(qr.q() * solved.expect("no entry of the diagonal is zero"))
}

fn least_norm_by_singular_values(
    t: f64,
    g: DMatrix<f64>,
    a: DVector<f64>,
) -> Result<DVector<f64>, ControlError> {
    let svd = SVD::new(g, true, true);
    let (smallest, largest) = (svd.singular_values.min(), svd.singular_values.max());
    let singular = ControlError::Singular { time: t, smallest, largest };
    if smallest <= RANK_TOLERANCE * largest {
        return Err(singular);
    }
    svd.solve(&a, 0.0).map_err(|_| singular)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Origin, PlantAccelerations, ReferenceFn, VelocityRows};
    use lacuna_plants::{Plant, TwoLinkArm};

    #[test]
    fn the_true_model_gives_the_wanted_acceleration() {
        let arm = TwoLinkArm::default();
        let model = PlantAccelerations::new(&arm).unwrap();
        let reference = ReferenceFn(|_, q: &mut [f64], dq: &mut [f64], ddq: &mut [f64]| {
            q.copy_from_slice(&[0.1, -0.2]);
            dq.copy_from_slice(&[0.5, 0.0]);
            ddq.copy_from_slice(&[2.0, 3.0]);
        });
        let gains = Gains { position: vec![20.0, 10.0], velocity: vec![30.0, 5.0] };
        let law = ComputedTorque::new(&model, &reference, gains).unwrap();
        let x = [0.4, 0.3, -0.2, 0.6];
        let (mut u, mut slope) = ([0.0; 2], [0.0; 4]);
        law.input(0.0, &x, &mut u).unwrap();
        arm.derivative(0.0, &x, &u, &mut slope);
        let wanted = [2.0 + 20.0 * -0.3 + 30.0 * 0.7, 3.0 + 10.0 * -0.5 + 5.0 * -0.6];
        for i in 0..2 {
            assert!((slope[2 + i] - wanted[i]).abs() < 1e-10, "{slope:?}");
        }
    }

    #[test]
    fn a_redundant_input_is_shared_with_least_norm() {
        // q'' = 3 u1 + 4 u2: the least-norm input for acceleration a is a (3, 4) / 25.
        let model = VelocityRows::new(1, 2, |_: &[f64], f: &mut [f64], g: &mut [f64]| {
            f.fill(0.0);
            g.copy_from_slice(&[0.0, 0.0, 3.0, 4.0]);
        });
        let law = ComputedTorque::new(&model, &Origin, Gains::uniform(1, 25.0, 0.0)).unwrap();
        let mut u = [0.0; 2];
        law.input(0.0, &[-1.0, 0.0], &mut u).unwrap();
        assert!((u[0] - 3.0).abs() < 1e-12 && (u[1] - 4.0).abs() < 1e-12, "{u:?}");
    }

    /// Both ways to the input of least norm, for square and for wide matrices in any order of their rows.
    #[test]
    fn orthogonal_columns_and_singular_values_agree() {
        let value = |k: usize| ((k * 7919 + 31) % 97) as f64 / 40.0 - 1.21;
        for (p, m) in [(1, 1), (2, 2), (3, 3), (2, 5), (3, 4)] {
            for seed in 0..20 {
                let g = DMatrix::from_fn(p, m, |i, j| value(100 * seed + 7 * i + j));
                let a = DVector::from_fn(p, |i, _| value(seed + 1000 * i));
                let (quick, exact) = (
                    least_norm(0.0, g.clone(), a.clone()).unwrap(),
                    least_norm_by_singular_values(0.0, g, a).unwrap(),
                );
                assert!((&quick - &exact).norm() < 1e-10 * (1.0 + exact.norm()), "{quick} {exact}");
            }
        }
    }

    #[test]
    fn a_singular_model_is_a_typed_error() {
        let model = VelocityRows::new(2, 2, |_: &[f64], _: &mut [f64], g: &mut [f64]| {
            g[4..].copy_from_slice(&[1.0, 2.0, 2.0, 4.0]);
        });
        let law = ComputedTorque::new(&model, &Origin, Gains::uniform(2, 1.0, 1.0)).unwrap();
        let error = law.input(1.5, &[1.0; 4], &mut [0.0; 2]).unwrap_err();
        assert!(
            matches!(error, ControlError::Singular { time, largest, .. }
                if time == 1.5 && (largest - 5.0).abs() < 1e-12),
            "{error:?}"
        );
    }

    #[test]
    fn a_model_that_is_not_finite_is_a_typed_error() {
        let model = VelocityRows::new(1, 1, |_: &[f64], f: &mut [f64], g: &mut [f64]| {
            f[1] = f64::NAN;
            g[1] = 1.0;
        });
        let law = ComputedTorque::new(&model, &Origin, Gains::uniform(1, 1.0, 1.0)).unwrap();
        let error = law.input(0.5, &[1.0; 2], &mut [0.0]).unwrap_err();
        assert_eq!(error, ControlError::NotFinite { time: 0.5 });
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let narrow = VelocityRows::new(2, 1, |_: &[f64], _: &mut [f64], _: &mut [f64]| {});
        let refused = ComputedTorque::new(&narrow, &Origin, Gains::uniform(2, 1.0, 1.0)).err();
        assert_eq!(refused, Some(ControlError::Underactuated { coordinates: 2, inputs: 1 }));
        let square = VelocityRows::new(2, 2, |_: &[f64], _: &mut [f64], _: &mut [f64]| {});
        let refused = ComputedTorque::new(&square, &Origin, Gains::uniform(1, 1.0, 1.0)).err();
        assert_eq!(
            refused,
            Some(ControlError::Mismatch { what: "position gains", expected: 2, found: 1 })
        );
    }
}
