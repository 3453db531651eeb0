//! Gram matrices of control occupation kernels, whatever the kernel.
//!
//! ```text
//! G = C M C^T,   M_kl = K(x_k, x_l) (1 + u_k . u_l),   C_ak = c_a(k)
//! ```
//!
//! | where | how | module |
//! | --- | --- | --- |
//! | one argument, exponential or Gaussian kernel | exact features, G = F F^T | `features` |
//! | functionals that do not overlap | eight occupation kernels at a time along the samples of each other | `lanes` |
//! | windows that overlap, kernels of other forms | tiles of kernel values, and matrix products | `tiles` |
//!
//! Tests: `tests/kernels.rs`, and the modules against one another.

mod features;
mod lanes;
mod tiles;

use faer::Mat;

use crate::kernel::Kernel;
use crate::occupation_kernels::OccupationKernels;

/// Functionals may look at this many samples for each that there is, before tiles are cheaper.
const OVERLAP: f64 = 1.5;

/// G_ab = sum_kl c_a(k) c_b(l) K(x_k, x_l) (1 + u_k . u_l), exactly symmetric.
///
/// The result does not depend on the number of threads.
pub fn gram_matrix<K: Kernel + ?Sized>(kernel: &K, occupation: &OccupationKernels) -> Mat<f64> {
    let Some(form) = kernel.form(occupation.argument_count()) else {
        return tiles::gram(kernel, occupation);
    };
    if let Some(features) = features::Features::of(&form, occupation) {
        return features.gram(occupation);
    }
    let looked_at: usize = occupation.functionals().iter().map(|f| f.weights.len()).sum();
    if looked_at as f64 > OVERLAP * occupation.samples() as f64 {
        return tiles::gram(kernel, occupation);
    }
    lanes::gram(form, occupation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functional::Functional;
    use crate::kernel::{ExponentialDotProduct, Gaussian, KernelSpec, Matern, Smoothness};

    /// Functionals of 3 to 7 samples, one after the other.
    fn occupation(d: usize, m: usize) -> OccupationKernels {
        let mut occupation = OccupationKernels::new(d, m);
        for a in 0..21 {
            let samples = 3 + a % 5;
            let value = |k: usize| ((k * 7919 + a * 104_729) % 1000) as f64 / 400.0 - 1.2;
            let arguments: Vec<f64> = (0..samples * d).map(value).collect();
            let inputs: Vec<f64> = (0..samples * m).map(|k| value(k + 31)).collect();
            let weights = (0..samples).map(|k| value(k + 77)).collect();
            occupation.append(&arguments, &inputs, vec![Functional { first: 0, weights }]);
        }
        occupation
    }

    #[test]
    fn all_ways_give_the_same_matrix() {
        for (d, m) in [(1, 1), (1, 0), (2, 1), (4, 2), (5, 3), (4, 9)] {
            let occupation = occupation(d, m);
            let kernels: [KernelSpec; 4] = [
                ExponentialDotProduct { mu: 2.0 }.into(),
                Gaussian { widths: vec![0.7] }.into(),
                Gaussian { widths: (0..d).map(|i| 0.5 + i as f64).collect() }.into(),
                Matern { smoothness: Smoothness::FiveHalves, widths: vec![0.9] }.into(),
            ];
            for kernel in kernels {
                let expected = tiles::gram(&kernel, &occupation);
                let form = kernel.form(d).unwrap();
                let mut found = vec![lanes::gram(form.clone(), &occupation)];
                let features = features::Features::of(&form, &occupation);
                let smooth = !matches!(kernel, KernelSpec::Matern(_));
                assert_eq!(features.is_some(), d == 1 && smooth);
                found.extend(features.map(|f| f.gram(&occupation)));
                for found in found {
                    for a in 0..21 {
                        for b in 0..21 {
                            let size = (expected[(a, a)] * expected[(b, b)]).sqrt();
                            let off = (found[(a, b)] - expected[(a, b)]).abs();
                            assert!(off <= 2e-14 * size, "{kernel:?} {d} {m} {a} {b}: {off}");
                            assert_eq!(found[(a, b)], found[(b, a)]);
                        }
                    }
                }
            }
        }
    }
}
