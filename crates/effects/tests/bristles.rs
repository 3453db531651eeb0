//! Friction of bristles, a spring before it slips, along prescribed motions.

mod support;

use lacuna_effects::{Prior, Scales, find};
use support::{Force, Local};

const CLASS: &str = "lugre_friction";

/// The force per unit of magnitude at the end of each RK4 step of `h` along `t -> (q, v)`.
fn along(shape: &[f64], motion: impl Fn(f64) -> (f64, f64), h: f64, steps: usize) -> Vec<f64> {
    let at = |t: f64| {
        let (q, v) = motion(t);
        Local { t, q, v, ..Local::default() }
    };
    Force::named(CLASS).along(shape, at, h, steps)
}

/// At constant speed v the bristles bend as `h (1 - exp(-v t / (travel h)))`.
#[test]
fn bristles_settle_on_the_stribeck_curve() {
    let (ratio, stribeck, travel) = (1.8, 0.3, 0.02);
    for v in [0.01, 0.3, 2.0, -0.3] {
        let speed = f64::abs(v);
        let settled = 1.0 + (ratio - 1.0) * (-(v / stribeck).powi(2)).exp();
        let (h, steps) = (0.02 * travel / speed, 1000);
        let found = along(&[ratio, stribeck, travel], |t| (v * t, v), h, steps);
        for (k, force) in found.iter().enumerate() {
            let bent = 1.0 - (-speed * h * (k + 1) as f64 / (travel * settled)).exp();
            let expected = -v.signum() * settled * bent;
            assert!((force - expected).abs() < 1e-7, "{v}: {force} {expected}");
        }
    }
}

/// Before it slips a bristle is a spring of stiffness `coulomb / travel`.
#[test]
fn small_motions_bend_bristles_as_a_spring() {
    let tiny = |t: f64| (1e-4 * t.sin(), 1e-4 * t.cos());
    let found = along(&[1.5, 0.3, 0.1], tiny, 1e-3, 6000);
    for (k, force) in found.iter().enumerate() {
        let spring = -tiny(1e-3 * (k + 1) as f64).0 / 0.1;
        assert!((force - spring).abs() < 0.003 * 1e-3, "{force} {spring}");
    }
}

/// A cycle takes work out, whatever its size.
#[test]
fn bristles_dissipate() {
    for shape in [[1.8, 0.3, 0.1], [1.0, 0.3, 0.1]] {
        for amplitude in [0.2, 1.0] {
            let motion = |t: f64| (amplitude * t.sin(), amplitude * t.cos());
            let h = std::f64::consts::TAU / 4000.0;
            let found = along(&shape, motion, h, 12_000);
            let power = |k: usize| found[k] * motion(h * (k + 1) as f64).1;
            let work: f64 = (8000..12_000).map(|k| power(k) * h).sum();
            assert!(work < -0.1 * amplitude, "{shape:?} at {amplitude}: work {work}");
        }
    }
}

/// Where the machine moves at four times its usual speed, the least travel that is looked for leaves the
/// force finite and near its magnitude at four steps a sample: at one it oscillates, which the choice of steps sees.
#[test]
fn the_least_travel_is_stable_at_four_steps_a_sample() {
    let scales = Scales {
        q: (-1.0, 1.0),
        stroke: 1.0,
        v: 1.0,
        force: 1.0,
        step: 0.02,
        time: (0.0, 10.0),
        ..Scales::default()
    };
    let priors = (find(CLASS).expect("in the catalogue").priors)(&scales);
    let low = |p: &Prior| match *p {
        Prior::LogNormal { low, .. } => low,
        _ => panic!("a shape of unknown order"),
    };
    let shape: Vec<f64> = priors[1..].iter().map(low).collect();
    let largest = |steps: usize| {
        let step = scales.step / steps as f64;
        let force = along(&shape, |t| (4.0 * t.sin(), 4.0 * t.cos()), step, 2000 * steps);
        force.iter().fold(0.0f64, |a, f| a.max(f.abs()))
    };
    assert!((0.9..1.3).contains(&largest(4)), "{shape:?}: {}", largest(4));
    assert!(!(0.9..1.3).contains(&largest(1)), "{shape:?}: {}", largest(1));
}
