//! Backlash against the play operator, which is exact for any path of the coordinate.

mod support;

use support::{Force, Local};

const GAP: f64 = 0.3;

fn backlash() -> Force {
    Force::named("backlash")
}

/// `z` along a motion `t -> (q, v)`, by RK4 steps of `h` from rest, at the end of each step.
fn far_side(gap: f64, motion: impl Fn(f64) -> (f64, f64), h: f64, steps: usize) -> Vec<f64> {
    let law = backlash();
    let local = |t: f64| {
        let (q, v) = motion(t);
        Local { t, q, v, ..Local::default() }
    };
    let mut z = [0.0];
    law.memory_at_rest(&local(0.0), &mut z);
    let rate = |t: f64, z: f64| {
        let mut rate = [f64::NAN];
        law.memory_rate(&[gap], &local(t), &[z], &mut rate);
        rate[0]
    };
    (0..steps)
        .map(|k| {
            let t = h * k as f64;
            let k1 = rate(t, z[0]);
            let k2 = rate(t + 0.5 * h, z[0] + 0.5 * h * k1);
            let k3 = rate(t + 0.5 * h, z[0] + 0.5 * h * k2);
            let k4 = rate(t + h, z[0] + h * k3);
            z[0] += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            z[0]
        })
        .collect()
}

/// The play operator: `z <- clamp(z, q - gap/2, q + gap/2)` along the path.
fn play(gap: f64, path: &[f64], start: f64) -> Vec<f64> {
    let mut z = start;
    let follow = |&q: &f64| {
        z = z.clamp(q - 0.5 * gap, q + 0.5 * gap);
        z
    };
    path.iter().map(follow).collect()
}

/// A motion with reversals of many sizes.
fn wandering(t: f64) -> (f64, f64) {
    let q = (1.1 * t).sin() + 0.4 * (3.7 * t).sin();
    (q, 1.1 * (1.1 * t).cos() + 0.4 * 3.7 * (3.7 * t).cos())
}

#[test]
fn the_far_side_moves_as_the_play_operator_does() {
    for (h, tolerance) in [(1e-3, 0.02), (1e-2, 0.03)] {
        let steps = (20.0 / h) as usize;
        let path: Vec<f64> = (1..=steps).map(|k| wandering(h * k as f64).0).collect();
        let expected = play(GAP, &path, 0.0);
        let found = far_side(GAP, wandering, h, steps);
        let largest =
            found.iter().zip(&expected).map(|(z, e)| (z - e).abs()).fold(0.0f64, f64::max);
        assert!(largest < tolerance * GAP, "step {h}: off by {largest} of a gap of {GAP}");
    }
}

/// At rest nothing pushes; after a reversal the gap is lost motion, and then z runs along.
#[test]
fn a_reversal_loses_the_gap() {
    // Up to 1, then down, at speed 1.
    let turn = |t: f64| if t < 1.0 { (t, 1.0) } else { (2.0 - t, -1.0) };
    let h = 1e-4;
    let z = far_side(GAP, turn, h, 20_000);
    let at = |t: f64| z[(t / h).round() as usize - 1];
    assert!(at(0.5 * GAP * 0.9).abs() < 1e-12, "half a gap is free from the middle");
    assert!((at(0.9) - (0.9 - 0.5 * GAP)).abs() < 1e-6, "{}", at(0.9));
    // The last twentieth of the half gap is the edge.
    assert_eq!(at(1.0 + 0.97 * GAP), at(1.0001), "z stays while the play closes");
    assert!((at(1.9) - (0.1 + 0.5 * GAP)).abs() < 1e-6, "{}", at(1.9));
}

/// Force against coordinate: two parallel lines a gap apart. The force lags behind the
/// coordinate, so that a cycle puts the area between them, `stiffness gap (2 amplitude - gap)`, in.
#[test]
fn the_loop_is_as_wide_as_the_gap() {
    let stiffness = 7.0;
    let h = std::f64::consts::TAU / 20_000.0;
    for amplitude in [0.2, 0.7, 2.0] {
        let motion = |t: f64| (amplitude * t.sin(), amplitude * t.cos());
        let z = far_side(GAP, motion, h, 60_000);
        let last = &z[40_000..];
        let work: f64 = (0..20_000)
            .map(|k| {
                let t = h * (40_001 + k) as f64;
                -stiffness * last[k] * motion(t).1 * h
            })
            .sum();
        let area = stiffness * GAP * (2.0 * amplitude - GAP);
        assert!((work - area).abs() < 0.02 * area, "{amplitude}: work {work}, area {area}");
        // The force passes through zero where q is half a gap on, and half a gap back.
        let zero = last.windows(2).position(|z| z[0] < 0.0 && z[1] >= 0.0).expect("rises");
        let q = motion(h * (40_001 + zero) as f64).0;
        assert!((q - 0.5 * GAP).abs() < 0.002, "{amplitude}: rises through zero at {q}");
    }
}

/// A motion that stays within the play moves nothing.
#[test]
fn small_motions_are_lost_altogether() {
    let small = |t: f64| (0.9 * 0.5 * GAP * t.sin(), 0.9 * 0.5 * GAP * t.cos());
    assert!(far_side(GAP, small, 1e-3, 20_000).iter().all(|z| z.abs() < 1e-12));
}

/// A gap far narrower than a step of the motion is a plain spring, and stays one.
#[test]
fn a_gap_narrower_than_a_step_is_no_trouble() {
    let h = 0.02;
    for gap in [1e-3, 1e-9, 1e-300] {
        let z = far_side(gap, wandering, h, 1000);
        for (k, z) in z.iter().enumerate() {
            let (q, v) = wandering(h * (k + 1) as f64);
            let reach = 2.0 * h * (v.abs() + 6.0 * h) + gap;
            assert!((z - q).abs() < reach, "gap {gap}: {z} at {q}");
        }
    }
}

/// A far side that begins outside the play, as a fitted initial state may, is taken back in by
/// a motion of its own size in either direction.
#[test]
fn a_state_outside_the_play_returns() {
    let law = backlash();
    for (z0, v) in [(0.6, 1.0), (0.6, -1.0), (-0.6, 1.0), (-0.6, -1.0)] {
        let (mut z, h) = (z0, 1e-3);
        for k in 0..1500 {
            let mut rate = [0.0];
            let at = Local { q: v * h * f64::from(k), v, ..Local::default() };
            law.memory_rate(&[GAP], &at, &[z], &mut rate);
            z += h * rate[0];
        }
        let offset = (1.5 * v - z).abs();
        assert!(offset < 0.5 * GAP + 2.0 * h, "from {z0} at {v}: {offset}");
    }
    let mut rate = [f64::NAN];
    law.memory_rate(&[GAP], &Local { q: 0.0, v: 0.0, ..Local::default() }, &[5.0], &mut rate);
    assert_eq!(rate[0], 0.0, "at standstill nothing moves");
}
