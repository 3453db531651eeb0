//! Friction of springs that slip one after the other, along prescribed motions.

mod support;

use lacuna_effects::{Prior, Scales, find};
use support::{Force, Local};

const CLASS: &str = "maxwell_slip";
/// Travels at which the springs slip, as shares of the travel.
const SLIP: [f64; 4] = [0.404_795, 1.277_327, 2.101_194, 3.692_635];

/// The force per unit of friction at the end of each RK4 step of `h` along `t -> v`, from rest.
fn along(travel: f64, velocity: impl Fn(f64) -> f64, h: f64, steps: usize) -> Vec<f64> {
    let at = |t: f64| Local { t, v: velocity(t), ..Local::default() };
    Force::named(CLASS).along(&[travel], at, h, steps)
}

/// From rest a spring that gives way as `1 - z^2` bends as `tanh(x / (s travel))`.
#[test]
fn the_virgin_curve_is_a_mean_of_saturating_springs() {
    let travel = 0.02;
    for v in [0.3, -0.3] {
        let found = along(travel, |_| v, 2e-5, 20_000);
        for (k, force) in found.iter().enumerate() {
            let x = v * 2e-5 * (k + 1) as f64;
            let expected = -0.25 * SLIP.iter().map(|s| (x / (s * travel)).tanh()).sum::<f64>();
            assert!((force - expected).abs() < 1e-7, "{x}: {force} {expected}");
        }
        assert!((found[found.len() - 1] + v.signum()).abs() < 0.03);
    }
}

/// The total stiffness is that of `1 / travel`, and each spring begins to slip where the law
/// `1 - exp(-x / travel)` has it: the shares are its quarters of equal friction.
#[test]
fn springs_are_the_quarters_of_an_exponential_law() {
    let stiffness: f64 = SLIP.iter().map(|s| 0.25 / s).sum();
    assert!((stiffness - 1.0).abs() < 1e-5, "{stiffness}");
    let tiny = along(0.1, |_| 1e-4, 1e-3, 10);
    assert!((tiny[9] + 1e-6 / 0.1).abs() < 1e-8 / 0.1, "{}", tiny[9]);
    // The friction of springs that slip before x is 1 - (1 + x) exp(-x), their stiffness 1 - exp(-x).
    let quartile = |share: f64| {
        let (mut low, mut high) = (0.0f64, 20.0f64);
        for _ in 0..80 {
            let x = 0.5 * (low + high);
            if 1.0 - (1.0 + x) * (-x).exp() < share { low = x } else { high = x }
        }
        low
    };
    let mut before = 0.0;
    for (k, slip) in SLIP.iter().enumerate() {
        let until = if k == 3 { 1.0 } else { 1.0 - (-quartile(0.25 * (k + 1) as f64)).exp() };
        assert!((0.25 / (until - before) - slip).abs() < 1e-5, "{slip}");
        before = until;
    }
}

/// After a small loop within a large one the force is back on the large loop: it remembers where
/// the motion turned. That of bristles, whose memory is one state, is not.
#[test]
fn small_loops_close_within_large_ones() {
    // To 1, back by 0.3 and forth again, in units of the travel.
    let speed = 1.0;
    let detour = |t: f64| match t {
        t if t < 1.0 => speed,
        t if t < 1.3 => -speed,
        _ => speed,
    };
    let h = 1e-3;
    let found = along(1.0, detour, h, 2600);
    let straight = along(1.0, |_| speed, h, 2000);
    // What is passed twice: x = 1 after 1.6 s, and x = 1 + d after 1.6 + d s.
    let lost = (found[1599] - straight[999]).abs();
    let bristles = |z: f64, x: f64| x.signum() + (z - x.signum()) * (-x.abs()).exp();
    let turned = bristles(0.0, 1.0);
    let forgotten = (bristles(bristles(turned, -0.3), 0.3) - turned).abs();
    assert!(lost < 0.4 * forgotten, "{lost} {forgotten}");
}

/// A cycle takes work out, whatever its size.
#[test]
fn it_dissipates() {
    for amplitude in [0.2, 1.0] {
        let h = std::f64::consts::TAU / 4000.0;
        let velocity = |t: f64| amplitude * t.cos();
        let found = along(0.1, velocity, h, 12_000);
        let work: f64 = (8000..12_000).map(|k| found[k] * velocity(h * (k + 1) as f64) * h).sum();
        assert!(work < -0.1 * amplitude, "{amplitude}: {work}");
    }
}

/// Where the machine moves at its usual greatest speed, the least travel that is looked for leaves the
/// force finite and near its magnitude at one step a sample.
#[test]
fn the_least_travel_is_stable_at_the_sample() {
    let (v, step) = (1.0, 0.02);
    let scales = Scales { q: (-1.0, 1.0), stroke: 1.0, v, force: 1.0, step, ..Scales::default() };
    let priors = (find(CLASS).expect("in the catalogue").priors)(&scales);
    let Prior::LogNormal { low, .. } = priors[1] else { panic!("a travel of unknown order") };
    for speed in [1.4, 2.0, 4.0] {
        let force = along(low, |t: f64| speed * (speed * t).cos(), step, 2000);
        let largest = force.iter().fold(0.0f64, |a, f| a.max(f.abs()));
        assert!((0.9..1.1).contains(&largest), "{speed}: {largest}");
    }
}
