//! Laws of structure against what they say in words: bodies made of points, frames turned one axis after
//! the other.

use lacuna_effects::{AnyStructureLaw, Law, find};
use lacuna_numbers::{Dual, Number};

fn law(class: &str) -> &'static dyn AnyStructureLaw {
    let Law::Structure(law) = find(class).expect("in the catalogue").law else {
        panic!("{class} is no law of structure")
    };
    law
}

/// The ten numbers of some points: mass and place.
fn of_points(points: &[(f64, [f64; 3])]) -> [f64; 10] {
    let mut sum = [0.0; 10];
    for &(m, [x, y, z]) in points {
        let numbers =
            [1.0, x, y, z, y * y + z * z, -x * y, -x * z, x * x + z * z, -y * z, x * x + y * y];
        sum.iter_mut().zip(numbers).for_each(|(s, n)| *s += m * n);
    }
    sum
}

/// A compact body is one point at its centre, or six around it: two on every axis, which for a radius of
/// gyration r stand sqrt(3/2) r off.
#[test]
fn a_payload_is_a_body_of_points() {
    let (mass, centre, radius) = (1.3, [0.2, -0.1, 0.05], 0.04);
    let around = |k: usize| {
        let mut place = centre;
        place[k / 2] += (1.5f64).sqrt() * radius * if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        (mass / 6.0, place)
    };
    let six: Vec<_> = (0..6).map(around).collect();
    for (radius, points) in [(0.0, vec![(mass, centre)]), (radius, six)] {
        let [x, y, z] = centre;
        let numbers = law("payload").plain().numbers(&[mass, x, y, z, radius]);
        for (found, expected) in numbers.iter().zip(of_points(&points)) {
            assert!((found - expected).abs() < 1e-15, "{numbers:?}");
        }
    }
}

#[test]
fn the_numbers_of_a_tilt_are_its_angles() {
    assert_eq!(law("base_tilt").plain().numbers(&[0.1, -0.2]), [0.1, -0.2]);
}

/// Nothing is nothing, amplitudes are what the numbers are linear in, and derivatives are exact.
#[test]
fn numbers_are_linear_in_amplitudes_and_carry_derivatives() {
    for (class, parameters) in
        [("payload", &[0.7, 0.1, 0.2, -0.3, 0.05][..]), ("base_tilt", &[0.02, -0.01])]
    {
        let law = law(class);
        let at = |share: f64| {
            let mut all = parameters.to_vec();
            all[..law.amplitudes()].iter_mut().for_each(|a| *a *= share);
            law.plain().numbers(&all)
        };
        let (none, one, three) = (at(0.0), at(1.0), at(3.0));
        assert!(none.iter().all(|n| *n == 0.0), "{class}");
        assert!(one.iter().zip(&three).all(|(a, b)| (3.0 * a - b).abs() < 1e-15), "{class}");
        for k in 0..parameters.len() {
            const STEP: f64 = 1e-6;
            let mut along: Vec<Dual> = parameters.iter().map(|p| Dual::constant(*p)).collect();
            along[k] = Dual::direction(parameters[k], 2);
            let moved = |by: f64| {
                let mut all = parameters.to_vec();
                all[k] += by;
                law.plain().numbers(&all)
            };
            let differences = moved(STEP).into_iter().zip(moved(-STEP)).map(|(a, b)| a - b);
            for (exact, difference) in law.dual().numbers(&along).iter().zip(differences) {
                assert!((exact.tangent[2] - difference / (2.0 * STEP)).abs() < 1e-8, "{class}");
            }
        }
    }
}
