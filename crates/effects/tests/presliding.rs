//! Friction that is a spring before it slips, along prescribed motions.

mod support;

use lacuna_effects::{Law, Scales, find};
use support::{Force, Local};

/// The force per unit of magnitude at the end of each RK4 step of `h` along `t -> (q, v)`.
fn along(
    class: &str,
    shape: &[f64],
    motion: impl Fn(f64) -> (f64, f64),
    h: f64,
    steps: usize,
) -> Vec<f64> {
    let law = Force::named(class);
    let local = |t: f64| {
        let (q, v) = motion(t);
        Local { t, q, v, ..Local::default() }
    };
    let rate = |t: f64, z: &[f64], slope: &[f64], by: f64| {
        let moved: Vec<f64> = z.iter().zip(slope).map(|(z, s)| z + by * s).collect();
        let mut rate = vec![f64::NAN; z.len()];
        law.memory_rate(shape, &local(t), &moved, &mut rate);
        rate
    };
    let mut z = vec![f64::NAN; law.memory()];
    law.memory_at_rest(&local(0.0), &mut z);
    let still = vec![0.0; z.len()];
    (0..steps)
        .map(|k| {
            let t = h * k as f64;
            let k1 = rate(t, &z, &still, 0.0);
            let k2 = rate(t + 0.5 * h, &z, &k1, 0.5 * h);
            let k3 = rate(t + 0.5 * h, &z, &k2, 0.5 * h);
            let k4 = rate(t + h, &z, &k3, h);
            for (i, z) in z.iter_mut().enumerate() {
                *z += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
            }
            let mut basis = [f64::NAN];
            law.basis(shape, &local(t + h), &z, &mut basis);
            basis[0]
        })
        .collect()
}

/// Up to `far` at speed 1, then down again.
fn turn(far: f64) -> impl Fn(f64) -> (f64, f64) {
    move |t| if t < far { (t, 1.0) } else { (2.0 * far - t, -1.0) }
}

/// At constant speed v the bristles bend as `h (1 - exp(-v t / (travel h)))`.
#[test]
fn bristles_settle_on_the_stribeck_curve() {
    let (ratio, stribeck, travel) = (1.8, 0.3, 0.02);
    for v in [0.01, 0.3, 2.0, -0.3] {
        let speed = f64::abs(v);
        let settled = 1.0 + (ratio - 1.0) * (-(v / stribeck).powi(2)).exp();
        let (h, steps) = (0.02 * travel / speed, 1000);
        let found = along("lugre_friction", &[ratio, stribeck, travel], |t| (v * t, v), h, steps);
        for (k, force) in found.iter().enumerate() {
            let bent = 1.0 - (-speed * h * (k + 1) as f64 / (travel * settled)).exp();
            let expected = -v.signum() * settled * bent;
            assert!((force - expected).abs() < 1e-7, "{v}: {force} {expected}");
        }
    }
}

/// Before it slips a bristle is a spring of stiffness `coulomb / travel`.
#[test]
fn small_motions_bend_bristles_and_elements_as_a_spring() {
    let tiny = |t: f64| (1e-4 * t.sin(), 1e-4 * t.cos());
    for (class, shape) in
        [("lugre_friction", [1.5, 0.3, 0.1].as_slice()), ("maxwell_slip", &[0.1, 2.0])]
    {
        let found = along(class, shape, tiny, 1e-3, 6000);
        for (k, force) in found.iter().enumerate() {
            let spring = -tiny(1e-3 * (k + 1) as f64).0 / 0.1;
            assert!((force - spring).abs() < 0.003 * 1e-3, "{class}: {force} {spring}");
        }
    }
}

/// The first loading of three Jenkins elements is a line of three bends, and all slip at last.
#[test]
fn elements_slip_one_after_the_other() {
    let (travel, spread) = (0.3, 2.0);
    let unit = travel * 3.0 / 3.5;
    let limits = [0.5 * unit, unit, 2.0 * unit];
    let h = 1e-4;
    let found = along("maxwell_slip", &[travel, spread], |t| (t, 1.0), h, 10_000);
    for (k, force) in found.iter().enumerate() {
        let q = h * (k + 1) as f64;
        let sharp = limits.iter().map(|l| q.min(*l)).sum::<f64>() / (3.0 * travel);
        // The edges are ramps of a quarter of each limit.
        assert!((force + sharp).abs() < 0.06, "at {q}: {force} {sharp}");
    }
    assert!((found[9999] + 1.0).abs() < 2e-3, "{}", found[9999]);
}

/// Masing's rule: what is turned unloads along the first loading curve, twice as large; a small loop
/// within a large one closes, and the large one goes on as if it had not been.
#[test]
fn elements_remember_where_they_turned() {
    let shape = [0.3, 2.0];
    let h = 1e-4;
    let first = along("maxwell_slip", &shape, |t| (t, 1.0), h, 30_000);
    let turned = along("maxwell_slip", &shape, turn(2.0), h, 35_000);
    let at = |series: &[f64], q: f64| series[(q / h).round() as usize - 1];
    for back in [0.1, 0.4, 0.8, 1.4] {
        let unloaded = at(&turned, 2.0 + back) - at(&turned, 2.0);
        let doubled = -2.0 * at(&first, 0.5 * back);
        assert!((unloaded - doubled).abs() < 0.06, "{back}: {unloaded} {doubled}");
    }
    // Down from 2 to 1.6, up to 1.8, and down again.
    let nested = |t: f64| match t {
        t if t < 2.4 => turn(2.0)(t),
        t if t < 2.6 => (1.6 + t - 2.4, 1.0),
        t => (1.8 - (t - 2.6), -1.0),
    };
    let with = along("maxwell_slip", &shape, nested, h, 35_000);
    let gap = at(&with, 2.4 + 0.4 + 0.3) - at(&turned, 2.4 + 0.3);
    assert!(gap.abs() < 0.03, "{gap}");
}

/// A cycle takes work out, whatever its size.
#[test]
fn friction_before_slipping_dissipates() {
    for (class, shape) in [
        ("lugre_friction", [1.8, 0.3, 0.1].as_slice()),
        ("lugre_friction", &[1.0, 0.3, 0.1]),
        ("maxwell_slip", &[0.1, 1.0]),
        ("maxwell_slip", &[0.1, 3.0]),
    ] {
        for amplitude in [0.2, 1.0] {
            let motion = |t: f64| (amplitude * t.sin(), amplitude * t.cos());
            let h = std::f64::consts::TAU / 4000.0;
            let found = along(class, shape, motion, h, 12_000);
            let power = |k: usize| found[k] * motion(h * (k + 1) as f64).1;
            let work: f64 = (8000..12_000).map(|k| power(k) * h).sum();
            assert!(work < -0.1 * amplitude, "{class} {shape:?} at {amplitude}: work {work}");
        }
    }
}

/// Where the machine moves at four times its usual speed, the least travel that is looked for leaves the
/// force finite and near its magnitude at one step a sample.
#[test]
fn the_least_travel_is_stable_at_the_sample() {
    let scales = Scales {
        q: (-1.0, 1.0),
        stroke: 1.0,
        v: 1.0,
        force: 1.0,
        step: 0.02,
        time: (0.0, 10.0),
        ..Scales::default()
    };
    let fast = |t: f64| (4.0 * t.sin(), 4.0 * t.cos());
    for class in ["lugre_friction", "maxwell_slip"] {
        let effect = find(class).expect("in the catalogue");
        let Law::Force(law) = effect.law else { panic!("{class} is a force") };
        let low = |p: &lacuna_effects::Prior| match *p {
            lacuna_effects::Prior::LogNormal { low, .. } => low,
            _ => panic!("{class}: a shape of unknown order"),
        };
        let shape: Vec<f64> =
            (effect.priors)(&scales)[law.amplitudes()..].iter().map(low).collect();
        let force = along(class, &shape, fast, scales.step, 2000);
        let largest = force.iter().fold(0.0f64, |a, f| a.max(f.abs()));
        assert!((0.9..1.3).contains(&largest), "{class} {shape:?}: {largest}");
    }
}
