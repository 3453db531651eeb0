//! A learned curve: what it passes through, how smooth it is, and over what.

mod support;

use lacuna_effects::{At, Effect, Kind, Law, Variable, find};
use support::{CHANNELS, Force, Local};

const FROM: f64 = -1.2;
const TO: f64 = 1.1;
const KNOTS: usize = 24;

fn effect() -> &'static Effect {
    find("unknown_function").expect("in the catalogue")
}

fn basis(shape: &[f64], at: &Local) -> Vec<f64> {
    let law = Force::named("unknown_function");
    let mut basis = vec![f64::NAN; law.amplitudes()];
    law.basis(shape, at, &[], &mut basis);
    basis
}

fn curve(values: &[f64], x: f64) -> f64 {
    let at = Local { q: x, ..Local::default() };
    basis(&[FROM, TO, 0.0], &at).iter().zip(values).map(|(b, a)| a * b).sum()
}

fn knot(k: usize) -> f64 {
    FROM + (TO - FROM) * k as f64 / (KNOTS - 1) as f64
}

fn sampled(f: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..KNOTS).map(|k| f(knot(k))).collect()
}

#[test]
fn the_curve_passes_through_its_values_and_is_constant_beyond() {
    let values = sampled(|x| (5.0 * x).sin() + 0.3);
    for (k, value) in values.iter().enumerate() {
        assert!((curve(&values, knot(k)) - value).abs() < 1e-12, "knot {k}");
    }
    for (x, end) in [(FROM - 1e-9, 0), (-1e6, 0), (TO + 1e-9, 23), (1e6, 23)] {
        assert!((curve(&values, x) - values[end]).abs() < 1e-12, "at {x}");
    }
}

/// Weights worked out by hand: half way between two inner knots Catmull and Rom's are
/// (-1, 9, 9, -1) / 16; in the first interval the slope at the end is 0.
#[test]
fn weights_by_hand() {
    let at = |x: f64| basis(&[FROM, TO, 0.0], &Local { q: x, ..Local::default() });
    let check = |found: &[f64], first: usize, expected: &[f64]| {
        for (k, b) in found.iter().enumerate() {
            let e = k.checked_sub(first).and_then(|i| expected.get(i)).copied().unwrap_or(0.0);
            assert!((b - e).abs() < 1e-12, "weight {k}: {b}, expected {e}");
        }
    };
    let middle = |k: usize| 0.5 * (knot(k) + knot(k + 1));
    check(&at(middle(10)), 9, &[-0.0625, 0.5625, 0.5625, -0.0625]);
    check(&at(middle(0)), 0, &[0.5625, 0.5, -0.0625]);
    check(&at(middle(22)), 21, &[-0.0625, 0.5, 0.5625]);
    check(
        &at(knot(10) + 0.25 * (knot(11) - knot(10))),
        9,
        &[-9.0, 111.0, 29.0, -3.0].map(|w| w / 128.0),
    );
}

#[test]
fn weights_add_up_to_one_and_few_are_not_zero() {
    for k in 0..400 {
        let x = -1.5 + 3.0 * f64::from(k) / 399.0;
        let weights = basis(&[FROM, TO, 0.0], &Local { q: x, ..Local::default() });
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12, "at {x}");
        assert!(weights.iter().filter(|w| **w != 0.0).count() <= 4, "at {x}");
    }
}

/// Away from the ends straight lines and parabolas are exact; a smooth curve converges with
/// the third power of the knots' distance.
#[test]
fn smooth_curves_are_reproduced() {
    let inner = (0..300).map(|k| knot(1) + (knot(22) - knot(1)) * f64::from(k) / 299.0);
    for x in inner {
        assert!((curve(&sampled(|x| 2.0 - 3.0 * x), x) - (2.0 - 3.0 * x)).abs() < 1e-12);
        assert!((curve(&sampled(|x| x * x), x) - x * x).abs() < 1e-12);
        assert!((curve(&sampled(f64::sin), x) - x.sin()).abs() < 1e-4);
    }
}

/// The slope is continuous at every knot, the ends among them.
#[test]
fn the_slope_has_no_jump() {
    let values = sampled(|x| (7.0 * x).cos() * x.exp());
    let h = 1e-6;
    for k in 0..KNOTS {
        let before = (curve(&values, knot(k)) - curve(&values, knot(k) - h)) / h;
        let after = (curve(&values, knot(k) + h) - curve(&values, knot(k))) / h;
        assert!((before - after).abs() < 1e-3, "knot {k}: {before} {after}");
    }
}

#[test]
fn the_curve_is_over_the_variable_that_it_names() {
    let (t, q, v) = (0.3, -0.7, 0.9);
    let at = Local { t, q, v, other_q: 5.0, other_v: 5.0, acceleration: 5.0, u: 5.0 };
    for (code, (x, variable)) in
        [(at.q, Variable::Coordinate), (at.v, Variable::Velocity), (at.t, Variable::Time)]
            .into_iter()
            .enumerate()
    {
        let found = basis(&[FROM, TO, code as f64], &at);
        assert_eq!(found, basis(&[FROM, TO, 0.0], &Local { q: x, ..Local::default() }));
        let mut physical = vec![0.0; KNOTS];
        physical.extend([FROM, TO, code as f64]);
        assert_eq!(effect().variables(&physical), [variable]);
        assert_eq!(effect().over(&physical), Some(variable));
    }
    let friction = find("viscous_friction").expect("in the catalogue");
    assert_eq!(friction.variables(&[1.0]), friction.depends_on);
    assert_eq!(friction.over(&[1.0]), None);
}

/// The values in a row: those of the knots, then the range and the variable.
#[test]
fn parameters_count_their_values() {
    let Law::Force(law) = effect().law else { panic!("a force") };
    assert_eq!(law.amplitudes(), KNOTS);
    assert!(std::ptr::eq(lacuna_effects::curve(), effect()));
    let names: Vec<_> = effect().values().map(|p| p.name).collect();
    assert_eq!(names.len(), KNOTS + 3);
    assert!(names[..KNOTS].iter().all(|n| *n == "force"));
    assert_eq!(names[KNOTS..], ["from", "to", "over"]);
    assert_eq!(effect().parameters[0].kind, Kind::Numbers(KNOTS));
}

/// A range that is given backwards or has no length, and variables far away, are no trouble.
#[test]
fn odd_ranges_stay_finite() {
    for (from, to) in [(1.0, 1.0), (2.0, -1.0), (0.0, 1e-300), (-1e300, 1e300)] {
        for q in [0.0, 1.0, -1e6, 1e6] {
            let weights = basis(&[from, to, 0.0], &Local { q, ..Local::default() });
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{from} {to} at {q}");
        }
    }
}

/// Its force is summed over the few knots that have a weight.
#[test]
fn the_force_is_the_sum_of_values_times_weights() {
    let Law::Force(law) = effect().law else { panic!("a force") };
    let (values, shape) = (sampled(|x| (3.0 * x).sin() + x), [FROM, TO, 0.0]);
    for k in 0..200 {
        let local = Local { q: -1.5 + 0.015 * f64::from(k), ..Local::default() };
        let state = local.state();
        let found = law.plain().force(&values, &shape, &At::new(0.0, &state, &CHANNELS));
        assert!((found - curve(&values, local.q)).abs() < 1e-14, "at {}", local.q);
    }
}
