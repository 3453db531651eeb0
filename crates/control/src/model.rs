//! What a control law must know of a plant: its accelerations.

use crate::ControlError;
use lacuna_plants::Plant;

/// A model `q'' = f2(x) + g2(x) u` with `x = (q, q')`, true or identified.
pub trait AccelerationModel: Sync {
    /// Number `p` of coordinates.
    fn coordinates(&self) -> usize;

    /// Number `m` of inputs.
    fn inputs(&self) -> usize;

    /// `f2` (length `p`) and `g2` (row-major `p x m`) at `state`, which holds the `p` positions
    /// and then the `p` velocities.
    fn accelerations(&self, state: &[f64], f: &mut [f64], g: &mut [f64]);
}

/// The accelerations of a true plant: of order 2, or of order 1 with the states `(q, q')`.
#[derive(Clone, Copy)]
pub struct PlantAccelerations<'a> {
    plant: &'a dyn Plant,
}

impl<'a> PlantAccelerations<'a> {
    /// View a plant as a model of accelerations.
    ///
    /// # Errors
    /// [`ControlError::NotMechanical`] when the order is not 2 and the states are not an even
    /// number, so that they cannot be positions and velocities.
    pub fn new(plant: &'a dyn Plant) -> Result<Self, ControlError> {
        match (plant.order(), plant.dimension()) {
            (2, _) => Ok(Self { plant }),
            (1, n) if n % 2 == 0 => Ok(Self { plant }),
            (order, dimension) => Err(ControlError::NotMechanical { order, dimension }),
        }
    }
}

impl AccelerationModel for PlantAccelerations<'_> {
    fn coordinates(&self) -> usize {
        self.plant.order() * self.plant.dimension() / 2
    }

    fn inputs(&self) -> usize {
        self.plant.inputs()
    }

    fn accelerations(&self, state: &[f64], f: &mut [f64], g: &mut [f64]) {
        if self.plant.order() == 2 {
            self.plant.drift(state, f);
            self.plant.control_effectiveness(state, g);
            return;
        }
        lower_rows(self.coordinates(), self.inputs(), f, g, |f, g| {
            self.plant.drift(state, f);
            self.plant.control_effectiveness(state, g);
        });
    }
}

/// A first-order model of the states `(q, q')`, such as an identified one, given as a function
/// `(x, f, g)` that fills `f in R^2p` and `g` (row-major `2p x m`). Its lower rows are the
/// accelerations; the upper ones, which say `q' = q'`, are not used.
#[derive(Clone, Copy, Debug)]
pub struct VelocityRows<F> {
    coordinates: usize,
    inputs: usize,
    evaluate: F,
}

impl<F: Fn(&[f64], &mut [f64], &mut [f64]) + Sync> VelocityRows<F> {
    /// A model of `coordinates` positions and as many velocities, driven by `inputs` inputs.
    pub fn new(coordinates: usize, inputs: usize, evaluate: F) -> Self {
        Self { coordinates, inputs, evaluate }
    }
}

impl<F: Fn(&[f64], &mut [f64], &mut [f64]) + Sync> AccelerationModel for VelocityRows<F> {
    fn coordinates(&self) -> usize {
        self.coordinates
    }

    fn inputs(&self) -> usize {
        self.inputs
    }

    fn accelerations(&self, state: &[f64], f: &mut [f64], g: &mut [f64]) {
        lower_rows(self.coordinates, self.inputs, f, g, |f, g| (self.evaluate)(state, f, g));
    }
}

/// Fill all `2p` rows by `evaluate` and keep the lower `p`.
fn lower_rows(
    p: usize,
    m: usize,
    f: &mut [f64],
    g: &mut [f64],
    evaluate: impl FnOnce(&mut [f64], &mut [f64]),
) {
    let (mut all_f, mut all_g) = (vec![0.0; 2 * p], vec![0.0; 2 * p * m]);
    evaluate(&mut all_f, &mut all_g);
    f.copy_from_slice(&all_f[p..]);
    g.copy_from_slice(&all_g[p * m..]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use lacuna_plants::{Duffing, TwoLinkArm};

    #[test]
    fn orders_one_and_two_give_accelerations() {
        let duffing = Duffing::default();
        let model = PlantAccelerations::new(&duffing).unwrap();
        assert_eq!((model.coordinates(), model.inputs()), (1, 1));
        let (mut f, mut g) = ([0.0], [0.0]);
        model.accelerations(&[0.5, 9.0], &mut f, &mut g);
        assert_eq!((f[0], g[0]), (0.5 - 0.125, 2.0 + 0.5_f64.sin()));

        let arm = TwoLinkArm::default();
        let model = PlantAccelerations::new(&arm).unwrap();
        let (x, u) = ([0.3, 1.1, -0.4, 0.8], [2.0, -1.0]);
        let (mut f, mut g, mut slope) = ([0.0; 2], [0.0; 4], [0.0; 4]);
        model.accelerations(&x, &mut f, &mut g);
        arm.derivative(0.0, &x, &u, &mut slope);
        for i in 0..2 {
            let acceleration = f[i] + g[2 * i] * u[0] + g[2 * i + 1] * u[1];
            assert!((acceleration - slope[2 + i]).abs() < 1e-12);
        }
    }

    /// A tank has a level but no velocity.
    struct Tank;

    impl Plant for Tank {
        fn order(&self) -> usize {
            1
        }
        fn dimension(&self) -> usize {
            1
        }
        fn inputs(&self) -> usize {
            1
        }
        fn derivative(&self, _t: f64, x: &[f64], u: &[f64], dx: &mut [f64]) {
            dx[0] = u[0] - x[0];
        }
    }

    #[test]
    fn a_plant_without_velocities_is_refused() {
        let refused = PlantAccelerations::new(&Tank).err();
        assert_eq!(refused, Some(ControlError::NotMechanical { order: 1, dimension: 1 }));
    }
}
