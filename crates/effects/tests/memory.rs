//! Laws with memory, integrated here by a fine Runge-Kutta and compared with closed forms.

mod support;

use lacuna_effects::{Law, Scales};
use support::{Force, Local};

fn law(class: &str) -> Force {
    Force::named(class)
}

/// RK4 of `x' = rate(t, x)`.
fn integrate(
    rate: impl Fn(f64, &[f64]) -> Vec<f64>,
    start: Vec<f64>,
    end: f64,
    steps: usize,
    mut seen: impl FnMut(f64, &[f64]),
) -> Vec<f64> {
    let h = end / steps as f64;
    let moved = |x: &[f64], k: &[f64], h: f64| -> Vec<f64> {
        x.iter().zip(k).map(|(x, k)| x + h * k).collect()
    };
    let mut x = start;
    for step in 0..steps {
        let t = h * step as f64;
        let k1 = rate(t, &x);
        let k2 = rate(t + 0.5 * h, &moved(&x, &k1, 0.5 * h));
        let k3 = rate(t + 0.5 * h, &moved(&x, &k2, 0.5 * h));
        let k4 = rate(t + h, &moved(&x, &k3, h));
        for i in 0..x.len() {
            x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
        seen(t + h, &x);
    }
    x
}

/// Memory of a law after a prescribed motion `t -> (q, v)`.
fn memory_along(
    law: Force,
    shape: &[f64],
    motion: impl Fn(f64) -> (f64, f64),
    end: f64,
    seen: impl FnMut(f64, &[f64]),
) -> Vec<f64> {
    let at = |t: f64| {
        let (q, v) = motion(t);
        Local { t, q, v, ..Local::default() }
    };
    let mut start = vec![0.0; law.memory()];
    law.memory_at_rest(&at(0.0), &mut start);
    let rate = |t: f64, z: &[f64]| {
        let mut rate = vec![0.0; z.len()];
        law.memory_rate(shape, &at(t), z, &mut rate);
        rate
    };
    integrate(rate, start, end, 4000, seen)
}

fn basis(law: Force, shape: &[f64], at: &Local, memory: &[f64]) -> f64 {
    let mut out = [0.0];
    law.basis(shape, at, memory, &mut out);
    out[0]
}

/// Stretched at constant speed v, then held: z = v tau (1 - exp(-t/tau)), then exp(-t/tau).
#[test]
fn a_maxwell_element_relaxes_with_its_time_constant() {
    let (law, tau, v, ramp) = (law("viscoelastic"), 0.4, 0.7, 0.5);
    let end = memory_along(
        law,
        &[tau],
        |t| (v * t, v),
        ramp,
        |t, z| {
            let expected = v * tau * (1.0 - (-t / tau).exp());
            assert!((z[0] - expected).abs() < 1e-10, "{} {expected}", z[0]);
        },
    );
    let mut held = vec![];
    let rest = |_: f64, z: &[f64]| {
        let mut rate = [0.0];
        law.memory_rate(&[tau], &Local { q: v * ramp, ..Local::default() }, z, &mut rate);
        rate.to_vec()
    };
    integrate(rest, end.clone(), 2.0, 4000, |t, z| held.push((t, z[0])));
    for (t, z) in held {
        assert!((z - end[0] * (-t / tau).exp()).abs() < 1e-10);
    }
    // It pulls back: the force per unit of stiffness is -z.
    assert_eq!(basis(law, &[tau], &Local::default(), &end), -end[0]);
}

/// Much slower than its time constant a Maxwell element is a damper of stiffness tau, much
/// faster a spring.
#[test]
fn a_maxwell_element_is_a_damper_when_slow_and_a_spring_when_fast() {
    let law = law("viscoelastic");
    let slow = memory_along(law, &[0.01], |t| (0.3 * t, 0.3), 1.0, |_, _| {});
    assert!((slow[0] - 0.3 * 0.01).abs() < 1e-12);
    let fast = memory_along(law, &[1e6], |t| (0.3 * t, 0.3), 1.0, |_, _| {});
    assert!((fast[0] - 0.3).abs() < 1e-6);
}

/// What a search fits of beta and gamma.
fn bouc_wen(beta: f64, gamma: f64) -> Vec<f64> {
    let law = law("hysteresis");
    let internal = law.internal(&[1.0, beta, gamma]);
    let back = law.physical(&internal);
    assert!((back[1] - beta).abs() + (back[2] - gamma).abs() < 1e-12, "{back:?}");
    internal[1..].to_vec()
}

/// Bouc-Wen with beta = gamma, loading: z' = v (1 - (beta + gamma) z), so that
/// z = (1 - exp(-(beta + gamma) q)) / (beta + gamma).
#[test]
fn bouc_wen_saturates_at_one_over_beta_plus_gamma() {
    let (law, beta, gamma, v) = (law("hysteresis"), 3.0, 2.0, 0.5);
    let shape = bouc_wen(beta, gamma);
    let limit = 1.0 / (beta + gamma);
    let end = memory_along(
        law,
        &shape,
        |t| (v * t, v),
        6.0,
        |t, z| {
            let expected = limit * (1.0 - (-(beta + gamma) * v * t).exp());
            assert!((z[0] - expected).abs() < 1e-9, "{} {expected}", z[0]);
        },
    );
    assert!((end[0] - limit).abs() < 1e-6);
    let down = memory_along(law, &shape, |t| (-v * t, -v), 6.0, |_, _| {});
    assert!((down[0] + limit).abs() < 1e-6);
    // The force of a stiffness of 1.
    let force = law.internal(&[1.0, beta, gamma])[0] * basis(law, &shape, &Local::default(), &end);
    assert!((force + end[0]).abs() < 1e-12, "{force}");
}

/// Unloading from saturation: z' = v (1 - (gamma - beta) |z|) for z > 0 and v < 0, which with
/// beta = gamma is elastic: z falls as q does.
#[test]
fn bouc_wen_with_equal_beta_and_gamma_unloads_elastically() {
    let (law, shape) = (law("hysteresis"), bouc_wen(2.5, 2.5));
    let loaded = memory_along(law, &shape, |t| (t, 1.0), 3.0, |_, _| {})[0];
    let back = |_: f64, z: &[f64]| {
        let mut rate = [0.0];
        law.memory_rate(&shape, &Local { v: -1.0, ..Local::default() }, z, &mut rate);
        rate.to_vec()
    };
    let after = integrate(back, vec![loaded], 0.15, 2000, |_, _| {})[0];
    assert!((after - (loaded - 0.15)).abs() < 1e-12, "{loaded} {after}");
}

/// Bouc-Wen with gamma = -beta, loading: z' = v, a spring; unloading from z: z' = v (1 + 2 beta z).
#[test]
fn bouc_wen_with_a_negative_gamma_unloads_faster_than_it_loads() {
    let (law, beta) = (law("hysteresis"), 1.5);
    let shape = bouc_wen(beta, -beta);
    let loaded = memory_along(law, &shape, |t| (t, 1.0), 0.8, |_, _| {})[0];
    assert!((loaded - 0.8).abs() < 1e-12, "{loaded}");
    let back = |_: f64, z: &[f64]| {
        let mut rate = [0.0];
        law.memory_rate(&shape, &Local { v: -1.0, ..Local::default() }, z, &mut rate);
        rate.to_vec()
    };
    let after = integrate(back, vec![loaded], 0.2, 2000, |_, _| {})[0];
    let expected =
        ((1.0 + 2.0 * beta * loaded) * (-2.0 * beta * 0.2f64).exp() - 1.0) / (2.0 * beta);
    assert!((after - expected).abs() < 1e-10, "{after} {expected}");
    // It is what a search begins from, too.
    let scales = Scales { q: (-1.0, 1.0), stroke: 1.0, ..Scales::default() };
    let effect = lacuna_effects::find("hysteresis").expect("in the catalogue");
    assert!((effect.shapes)(&scales).iter().any(|s| s[1] == shape[1]));
}

/// A closed loop of a hysteretic force takes work out, whatever its size.
#[test]
fn hysteresis_and_maxwell_elements_dissipate_over_a_cycle() {
    let loops = [(3.0, 2.0), (3.0, -2.0), (1.0, -1.4)];
    let loops = loops.map(|(beta, gamma)| ("hysteresis", bouc_wen(beta, gamma)));
    for (class, shape) in loops.into_iter().chain([("viscoelastic", vec![0.3])]) {
        let law = law(class);
        for amplitude in [0.02, 0.2, 2.0] {
            let motion = |t: f64| (amplitude * t.sin(), amplitude * t.cos());
            // The work of the last of three cycles, the memory being periodic by then.
            let (mut work, mut before) = (0.0, 0.0);
            let cycle = std::f64::consts::TAU;
            memory_along(law, &shape, motion, 3.0 * cycle, |t, z| {
                let (q, v) = motion(t);
                let power = basis(law, &shape, &Local { t, q, v, ..Local::default() }, z) * v;
                if t > 2.0 * cycle {
                    work += power * (t - before);
                }
                before = t;
            });
            assert!(work < 0.0, "{class} at amplitude {amplitude}: work {work}");
        }
    }
}

/// The hung mass at a coordinate that stands still: y'' = -w^2 y - 2 D w y'.
#[test]
fn a_hung_mass_swings_at_its_frequency_and_damping() {
    let (law, w, damping) = (law("hidden_resonance"), 12.0, 0.05);
    let still = Local::default();
    let rate = |_: f64, z: &[f64]| {
        let mut rate = [0.0; 2];
        law.memory_rate(&[w, damping], &still, z, &mut rate);
        rate.to_vec()
    };
    let damped = w * (1.0 - damping * damping).sqrt();
    integrate(rate, vec![0.1, 0.0], 3.0, 12_000, |t, z| {
        let (sine, cosine) = (damped * t).sin_cos();
        let expected = 0.1 * (-damping * w * t).exp() * (cosine + damping * w / damped * sine);
        assert!((z[0] - expected).abs() < 1e-9, "{} {expected}", z[0]);
    });
}

/// Action and reaction: no momentum is made, and without damping no energy is lost.
#[test]
fn a_hung_mass_and_its_machine_keep_their_momentum_and_energy() {
    let (machine, mass, w) = (2.0, 0.6, 9.0);
    // A mass that hangs on the model's, and one of those that the model fixes to each other.
    let laws = [("hidden_resonance", machine), ("elastic_drive", machine + mass)];
    for ((class, fixed), damping) in laws.into_iter().flat_map(|l| [(l, 0.0), (l, 0.1)]) {
        let (law, shape) = (law(class), [w, damping]);
        let pushed = Local { acceleration: 1.0, ..Local::default() };
        let added = -basis(law, &shape, &pushed, &[0.0; 2]);
        assert_eq!(fixed + mass * added, machine, "{class}");
        let local = |x: &[f64]| Local { q: x[0], v: x[1], ..Local::default() };
        let rate = |_: f64, x: &[f64]| {
            let at = local(x);
            let mut hung = [0.0; 2];
            law.memory_rate(&shape, &at, &x[2..], &mut hung);
            vec![x[1], mass * basis(law, &shape, &at, &x[2..]) / machine, hung[0], hung[1]]
        };
        let energy = |x: &[f64]| {
            0.5 * machine * x[1] * x[1]
                + 0.5 * mass * x[3] * x[3]
                + 0.5 * mass * w * w * (x[2] - x[0]).powi(2)
        };
        let mut start = vec![0.0, 0.8, 0.0, 0.0];
        law.memory_at_rest(&local(&start), &mut start[2..]);
        // At rest the mass moves along with the coordinate and pulls at nothing.
        assert_eq!(basis(law, &shape, &local(&start), &start[2..]), 0.0);
        start[3] = -0.4;
        let (momentum, begin) = (machine * start[1] + mass * start[3], energy(&start));
        let end = integrate(rate, start, 4.0, 16_000, |_, x| {
            assert!((machine * x[1] + mass * x[3] - momentum).abs() < 1e-10);
        });
        let share = energy(&end) / begin;
        // With damping what is left is the motion of the common centre of mass.
        let centre = 0.5 * momentum * momentum / (machine + mass) / begin;
        let expected = if damping == 0.0 { 1.0 } else { centre };
        assert!((share - expected).abs() < 1e-3, "{damping}: {share} {expected}");
    }
}

#[test]
fn screened_shapes_are_in_range_for_any_machine() {
    let scales = |size: f64| Scales {
        q: (-0.7 * size, 1.1 * size),
        v: 2.0 * size,
        apart: (0.4 * size, 3.0 * size),
        input: (3.0, 8.0),
        link: (2.0 * size, 0.3 * size),
        step: 0.01,
        time: (0.0, 30.0),
        ..Scales::default()
    };
    for size in [1e-6, 1.0, 1e4] {
        for effect in lacuna_effects::CATALOGUE {
            let (shapes, shift) = match effect.law {
                Law::Force(law) => ((effect.shapes)(&scales(size)), law.amplitudes()),
                Law::Input(_) => ((effect.shapes)(&scales(size)), 0),
                Law::Structure(law) => ((effect.shapes)(&scales(size)), law.amplitudes()),
                Law::Sensor(_) => continue,
            };
            // What is learned is not screened; a variation may be reached from what it varies alone.
            let unscreened = effect.class == "unknown_function";
            assert!(!unscreened || shapes.is_empty(), "{}", effect.class);
            let reached = unscreened || effect.nature.variation_of.is_some();
            assert!(reached || !shapes.is_empty(), "{}", effect.class);
            for shape in shapes {
                let amplitudes = vec![1.0; shift];
                let physical = match effect.law {
                    Law::Force(law) => law.physical(&[&amplitudes[..], &shape].concat()),
                    Law::Structure(_) => [&amplitudes[..], &shape].concat(),
                    _ => shape,
                };
                assert_eq!(physical.len(), effect.parameters.len(), "{}", effect.class);
                for (value, p) in physical.iter().zip(effect.parameters) {
                    assert!(p.range.contains(*value), "{} {}: {value}", effect.class, p.name);
                }
            }
        }
    }
}
