//! Kernel values against their formulas, and vectorised rows against single values.

use lacuna_occupation::{
    ExponentialDotProduct, Gaussian, Kernel, KernelError, KernelSpec, Matern, Polynomial,
    Smoothness,
};
use proptest::prelude::*;

fn all_kernels() -> Vec<KernelSpec> {
    let widths = vec![0.5, 1.0, 2.0];
    let matern = |smoothness| KernelSpec::from(Matern { smoothness, widths: widths.clone() });
    vec![
        ExponentialDotProduct { mu: 5.0 }.into(),
        Gaussian { widths: widths.clone() }.into(),
        Gaussian { widths: vec![0.7] }.into(),
        matern(Smoothness::Half),
        matern(Smoothness::ThreeHalves),
        matern(Smoothness::FiveHalves),
        Polynomial { degree: 5, offset: 1.0, scale: 2.0 }.into(),
    ]
}

#[test]
fn values_follow_the_formulas() {
    let (x, y) = ([1.0, -2.0, 0.5], [0.5, 1.0, 3.0]);
    let product = 0.5 - 2.0 + 1.5;
    let squared: f64 = 1.0 + 9.0 + 1.25 * 1.25;
    let r = squared.sqrt();
    let (r3, r5) = (3.0_f64.sqrt() * r, 5.0_f64.sqrt() * r);
    let unscaled: f64 = 0.25 + 9.0 + 6.25;
    let expected = [
        f64::exp(product / 5.0),
        f64::exp(-squared / 2.0),
        f64::exp(-unscaled / (2.0 * 0.49)),
        f64::exp(-r),
        (1.0 + r3) * f64::exp(-r3),
        (1.0 + r5 + 5.0 * squared / 3.0) * f64::exp(-r5),
        (product / 2.0 + 1.0).powi(5),
    ];
    for (kernel, expected) in all_kernels().iter().zip(expected) {
        let found = kernel.evaluate(&x, &y);
        assert!(
            (found - expected).abs() <= 1e-14 * expected.abs(),
            "{kernel:?}: {found}, expected {expected}"
        );
    }
}

#[test]
fn parameters_out_of_range_are_refused() {
    let zero = KernelSpec::from(ExponentialDotProduct { mu: 0.0 });
    assert_eq!(zero.validate(1), Err(KernelError::NotPositive { parameter: "mu", found: 0.0 }));
    let two = KernelSpec::from(Gaussian { widths: vec![1.0, 1.0] });
    assert_eq!(two.validate(3), Err(KernelError::Widths { expected: 3, found: 2 }));
    assert_eq!(two.validate(2), Ok(()));
    let negative = KernelSpec::from(Matern { smoothness: Smoothness::Half, widths: vec![-1.0] });
    assert_eq!(
        negative.validate(3),
        Err(KernelError::NotPositive { parameter: "width", found: -1.0 })
    );
    let offset = KernelSpec::from(Polynomial { degree: 2, offset: -1.0, scale: 1.0 });
    assert_eq!(offset.validate(1), Err(KernelError::Negative { parameter: "offset", found: -1.0 }));
}

#[test]
fn kernels_are_saved_with_their_name() {
    let kernel =
        KernelSpec::from(Matern { smoothness: Smoothness::ThreeHalves, widths: vec![0.25] });
    let text = serde_json::to_string(&kernel).unwrap();
    assert_eq!(text, r#"{"kernel":"matern","smoothness":"3/2","widths":[0.25]}"#);
    for kernel in all_kernels() {
        let text = serde_json::to_string(&kernel).unwrap();
        assert_eq!(serde_json::from_str::<KernelSpec>(&text).unwrap(), kernel);
    }
}

/// A kernel from outside the crate: it has the default row.
struct Linear;

impl Kernel for Linear {
    fn evaluate(&self, x: &[f64], y: &[f64]) -> f64 {
        x.iter().zip(y).map(|(a, b)| a * b).sum()
    }
}

proptest! {
    #[test]
    fn rows_are_the_single_values(
        x in prop::collection::vec(-3.0..3.0f64, 3),
        coordinates in prop::collection::vec(-3.0..3.0f64, 3 * 11),
    ) {
        let specs = all_kernels();
        let mut kernels: Vec<&dyn Kernel> = specs.iter().map(|kernel| kernel as &dyn Kernel).collect();
        kernels.push(&Linear);
        for kernel in kernels {
            let mut values = [0.0; 11];
            kernel.evaluate_row(&x, &coordinates, &mut values);
            for (k, value) in values.iter().enumerate() {
                let point = [coordinates[k], coordinates[11 + k], coordinates[22 + k]];
                // Rounding of what the profile is taken of, with and without fused multiply-add.
                let single = kernel.evaluate(&x, &point);
                let size = (kernel.evaluate(&x, &x) * kernel.evaluate(&point, &point)).sqrt();
                prop_assert!((value - single).abs() <= 3e-14 * single.abs() + 2e-15 * size);
                prop_assert_eq!(kernel.evaluate(&x, &point), kernel.evaluate(&point, &x));
            }
        }
    }
}
