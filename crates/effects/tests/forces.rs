//! Force laws against their formulas, written out here by hand.

mod support;

use lacuna_effects::{Acts, At, CATALOGUE, Effect, Law, Range, Scales, Variable, find};
use support::{CHANNELS, Force, Local};

/// Points of all signs, at rest, slow and fast.
const POINTS: [Local; 7] = [
    point(0.0, 0.0, 0.0, 0.0, 0.0),
    point(0.3, 0.7, 0.4, -0.2, 1.1),
    point(1.7, -0.7, 0.4, 0.9, -0.3),
    point(2.9, 0.2, -0.05, -1.4, 0.6),
    point(4.1, -1.3, -2.2, 0.1, -1.7),
    point(5.5, 1.6, 0.003, 0.8, 0.2),
    point(9.0, -0.4, 3.1, -0.6, 0.0),
];

const fn point(t: f64, q: f64, v: f64, other_q: f64, other_v: f64) -> Local {
    Local { t, q, v, other_q, other_v, acceleration: q - 0.3 * v + 0.1, u: v - 0.6 * q - 0.2 }
}

fn law(class: &str) -> Force {
    Force::named(class)
}

/// Force under physical parameters, as a simulation computes it.
fn force(class: &str, physical: &[f64], at: &Local) -> f64 {
    let law = law(class);
    let internal = law.internal(physical);
    let (amplitudes, shape) = internal.split_at(law.amplitudes());
    let mut memory = vec![0.0; law.memory()];
    law.memory_at_rest(at, &mut memory);
    let mut basis = vec![f64::NAN; law.amplitudes()];
    law.basis(shape, at, &memory, &mut basis);
    amplitudes.iter().zip(&basis).map(|(a, b)| a * b).sum()
}

fn obeys(class: &str, physical: &[f64], formula: impl Fn(&Local) -> f64) {
    for at in &POINTS {
        let (found, expected) = (force(class, physical, at), formula(at));
        let close = (found - expected).abs() <= 1e-12 * (1.0 + expected.abs());
        assert!(close, "{class} at {at:?}: found {found}, expected {expected}");
    }
}

#[test]
fn friction_laws_obey_their_formulas() {
    obeys("viscous_friction", &[0.8], |p| -0.8 * p.v);
    obeys("coulomb_friction", &[2.35, 0.02], |p| -2.35 * (p.v / 0.02).tanh());
    obeys("quadratic_drag", &[0.6], |p| -0.6 * p.v * p.v.abs());
    obeys("position_damping", &[0.6], |p| -0.6 * p.q * p.q * p.v);
    obeys("asymmetric_friction", &[1.5, 0.4, 0.05], |p| {
        if p.v > 0.0 { -1.5 * (p.v / 0.05).tanh() } else { -0.4 * (p.v / 0.05).tanh() }
    });
    obeys("position_friction", &[1.5, -0.4, 0.05], |p| -(1.5 - 0.4 * p.q) * (p.v / 0.05).tanh());
    obeys("time_friction", &[1.5, 0.4, 2.0, 0.05, 1.2], |p| {
        let left = if p.t < 1.2 { 1.0 } else { (-(p.t - 1.2) / 2.0).exp() };
        -(0.4 + 1.1 * left) * (p.v / 0.05).tanh()
    });
    obeys("load_friction", &[1.5, 0.4, 0.05], |p| -(1.5 + 0.4 * p.u.abs()) * (p.v / 0.05).tanh());
    obeys("input_damping", &[0.6], |p| -0.6 * p.u.abs() * p.v);
    obeys("input_damping", &[-0.6], |p| 0.6 * p.u.abs() * p.v);
    let (coulomb, fixed, stribeck, smoothing) = (1.2, 1.9, 0.3, 0.01);
    obeys("stribeck_friction", &[coulomb, fixed, stribeck, smoothing], |p| {
        let peak = (fixed - coulomb) * (-(p.v * p.v) / (stribeck * stribeck)).exp();
        -(coulomb + peak) * (p.v / smoothing).tanh()
    });
}

/// Wherever it acts, a law that may be a simpler one beside a constant force has the force of both.
#[test]
fn a_law_that_may_be_another_beside_a_constant_force_is_it_where_it_acts() {
    let acting = [point(0.3, 0.7, 0.4, 0.0, 0.0), point(1.0, 0.2, -0.1, 0.0, 0.0)];
    let laws: [(&str, &[f64]); 3] = [
        ("end_stop", &[2.0, 0.1, 1.0]),
        ("overflow", &[0.7, 0.1]),
        ("asymmetric_friction", &[1.5, 0.4, 0.001]),
    ];
    for (class, physical) in laws {
        let biased = find(class).and_then(|e| e.nature.biased).expect("it may be another");
        let (parameters, constant) = (biased.numbers)(physical);
        for at in &acting {
            let together = force(biased.effect.class, &parameters, at) + constant;
            let found = force(class, physical, at);
            assert!((found - together).abs() < 1e-12, "{class} at {at:?}: {found} {together}");
        }
    }
    // Of what never relaxes its memory is where it is.
    let biased = find("viscoelastic").and_then(|e| e.nature.biased).expect("it may be another");
    let (parameters, constant) = (biased.numbers)(&[2.0, 1e9]);
    let (at, law) = (acting[0], law("viscoelastic"));
    let mut basis = [f64::NAN];
    law.basis(&law.internal(&[2.0, 1e9])[1..], &at, &[at.q], &mut basis);
    assert_eq!(force(biased.effect.class, &parameters, &at) + constant, 2.0 * basis[0]);
    let known = ["end_stop", "overflow", "asymmetric_friction", "viscoelastic"];
    let all = CATALOGUE.iter().filter(|e| e.nature.biased.is_some());
    assert!(all.map(|e| e.class).all(|class| known.contains(&class)));
}

#[test]
fn friction_far_above_the_smoothing_velocity_has_its_full_magnitude() {
    let fast = |v| Local { v, ..Local::default() };
    assert!((force("coulomb_friction", &[2.0, 0.01], &fast(1.0)) + 2.0).abs() < 1e-12);
    assert!((force("asymmetric_friction", &[2.0, 0.5, 0.01], &fast(-1.0)) - 0.5).abs() < 1e-12);
    // At the Stribeck velocity the peak has fallen to 1/e of its height.
    let at_stribeck = force("stribeck_friction", &[1.0, 3.0, 0.5, 1e-3], &fast(0.5));
    assert!((at_stribeck + 1.0 + 2.0 / std::f64::consts::E).abs() < 1e-12);
}

#[test]
fn laws_of_position_and_time_obey_their_formulas() {
    obeys("constant_force", &[-3.2], |_| -3.2);
    obeys("linear_stiffness", &[7.0], |p| -7.0 * p.q);
    obeys("quadratic_stiffness", &[-4.0], |p| 4.0 * p.q * p.q);
    obeys("cubic_stiffness", &[4.0], |p| -4.0 * p.q * p.q * p.q);
    obeys("saturating_stiffness", &[4.0, 0.3], |p| -4.0 * 0.3 * p.q / p.q.hypot(0.3));
    obeys("gravity_torque", &[9.0], |p| -9.0 * p.q.sin());
    obeys("cogging", &[0.7, 6.0, 0.9], |p| 0.7 * (6.0 * p.q + 0.9).sin());
    obeys("periodic_disturbance", &[0.5, 3.3, -2.1, 0.7], |p| {
        0.5 * (3.3 * (p.t - 0.7) - 2.1).sin()
    });
    obeys("step_change", &[1.4, 2.9], |p| if p.t < 2.9 { 0.0 } else { 1.4 });
}

#[test]
fn an_end_stop_pushes_back_from_its_side_alone() {
    obeys("end_stop", &[50.0, 0.5, 1.0], |p| if p.q > 0.5 { -50.0 * (p.q - 0.5) } else { 0.0 });
    obeys("end_stop", &[50.0, -0.5, -1.0], |p| if p.q < -0.5 { 50.0 * (-0.5 - p.q) } else { 0.0 });
    // A lower stop may stand at a positive position.
    obeys("end_stop", &[50.0, 0.5, -1.0], |p| if p.q < 0.5 { 50.0 * (0.5 - p.q) } else { 0.0 });
    // Without a side the stop stands on the side of its position.
    obeys("end_stop", &[50.0, -0.5, 0.0], |p| if p.q < -0.5 { 50.0 * (-0.5 - p.q) } else { 0.0 });
    obeys("end_stop", &[50.0, 0.5, 0.0], |p| if p.q > 0.5 { -50.0 * (p.q - 0.5) } else { 0.0 });
}

#[test]
fn a_damped_stop_pushes_and_never_pulls() {
    let push = |depth: f64, speed: f64| 50.0 * depth.max(0.0) * (1.0 + 0.9 * speed).max(0.0);
    obeys("damped_stop", &[50.0, 0.9, 0.5, 1.0], |p| -push(p.q - 0.5, p.v));
    obeys("damped_stop", &[50.0, 0.9, -0.5, -1.0], |p| push(-0.5 - p.q, -p.v));
    obeys("damped_stop", &[50.0, 0.9, -0.5, 0.0], |p| push(-0.5 - p.q, -p.v));
    // Without dissipation it is the elastic one.
    obeys("damped_stop", &[50.0, 0.0, 0.5, 1.0], |p| -push(p.q - 0.5, 0.0));
}

/// Along a given motion; in a simulation it is part of the mass matrix.
#[test]
fn an_added_inertia_resists_acceleration() {
    obeys("added_inertia", &[1.7], |p| -1.7 * p.acceleration);
    for effect in CATALOGUE {
        let Law::Force(law) = effect.law else { continue };
        let internal = law.internal(&some_physical(effect.class));
        let (amplitudes, shape) = internal.split_at(law.amplitudes());
        let at = POINTS[1];
        let state = at.state();
        let memory = vec![0.35; law.memory()];
        let at = At { memory: &memory, ..At::new(at.t, &state, &CHANNELS) };
        let inertia = law.plain().inertia(amplitudes, shape, &at);
        let declared = effect.depends_on.contains(&Variable::Acceleration);
        assert_eq!(inertia != 0.0, declared, "{}", effect.class);
    }
}

#[test]
fn couplings_obey_their_formulas() {
    obeys("coupling_stiffness", &[3.0], |p| 3.0 * (p.other_q - p.q));
    obeys("coriolis_coupling", &[0.4], |p| 0.4 * p.v * p.other_v);
    obeys("cross_damping", &[0.4], |p| -0.4 * p.other_v);
    for ratio in [1.0, -1.0, 0.4] {
        let slip = |p: &Local| ratio * p.other_v - p.v;
        obeys("coupling_friction", &[0.7, 0.05, ratio], |p| 0.7 * (slip(p) / 0.05).tanh());
        // What it does to both together takes power, whichever way they move.
        assert_eq!(law("coupling_friction").plain().passed_on(&[0.05, ratio]), ratio);
    }
    assert!(law("coupling_stiffness").reacts() && law("coupling_friction").reacts());
    assert!(!law("coriolis_coupling").reacts() && !law("cross_damping").reacts());
}

/// With the shaft that the model has it makes one that pushes beyond its gap alone.
#[test]
fn backlash_in_a_transmission_takes_the_shaft_back_within_its_gap() {
    let (stiffness, gap) = (3.0, 0.8);
    let shaft = |p: &Local| stiffness * (p.other_q - p.q);
    let dead = |x: f64| if x.abs() < 0.5 * gap { 0.0 } else { x - 0.5 * gap * x.signum() };
    obeys("transmission_backlash", &[stiffness, gap], |p| {
        stiffness * dead(p.other_q - p.q) - shaft(p)
    });
    obeys("transmission_backlash", &[stiffness, 0.0], |_| 0.0);
    // A gap wider than the motion leaves no shaft.
    obeys("transmission_backlash", &[stiffness, 100.0], |p| -shaft(p));
    assert!(law("transmission_backlash").reacts());
}

/// Of what runs over, so much arrives.
#[test]
fn a_spill_is_an_overflow_that_arrives_elsewhere() {
    let law = law("spill");
    obeys("spill", &[2.0, 0.5, 0.7], |p| if p.q > 0.5 { -2.0 * (p.q - 0.5) } else { 0.0 });
    assert!(law.reacts());
    assert_eq!(law.plain().passed_on(&[0.5, 0.7]), 0.7);
    // Whatever else reacts gives back all.
    let shared = ["spill", "coupling_friction"];
    for (class, law) in force_laws().filter(|(class, _)| !shared.contains(class)) {
        assert_eq!(law.plain().passed_on(&some_physical(class)), 1.0, "{class}");
    }
}

#[test]
fn couplings_name_another_channel_and_springs_count_once() {
    let of = |is: fn(&Effect) -> bool| -> Vec<_> {
        CATALOGUE.iter().filter(|e| is(e)).map(|e| e.class).collect()
    };
    let mutual = ["coupling_stiffness", "coupling_friction", "transmission_backlash"];
    assert_eq!(of(Effect::is_mutual), mutual);
    let one_sided = ["coriolis_coupling", "cross_damping", "spill"];
    assert_eq!(of(Effect::couples), [&mutual[..], &one_sided].concat());
    assert_eq!(of(Effect::names_input), ["load_friction", "input_damping"]);
}

#[test]
fn losses_of_first_order_states_obey_their_formulas() {
    obeys("linear_loss", &[0.3], |p| -0.3 * p.q);
    obeys("quadratic_loss", &[0.3], |p| -0.3 * p.q * p.q.abs());
    obeys("overflow", &[2.0, 0.5], |p| if p.q > 0.5 { -2.0 * (p.q - 0.5) } else { 0.0 });
    // A brim may stand below zero; below it nothing runs over.
    obeys("overflow", &[2.0, -0.5], |p| if p.q > -0.5 { -2.0 * (p.q + 0.5) } else { 0.0 });
}

/// Physical parameters that are inside every range, the phases within (-pi, pi].
fn some_physical(class: &str) -> Vec<f64> {
    let value = |(k, name): (usize, &str)| match name {
        "side" => -1.0,
        "phase" => 2.4,
        "from" => -1.5,
        "to" => 2.0,
        "over" => 0.0,
        _ => 0.7 + 0.55 * k as f64,
    };
    let effect = find(class).expect("in the catalogue");
    effect.values().map(|p| p.name).enumerate().map(value).collect()
}

fn force_laws() -> impl Iterator<Item = (&'static str, Force)> {
    CATALOGUE.iter().filter_map(|e| Some((e.class, Force::of(e)?)))
}

#[test]
fn physical_parameters_survive_the_way_to_internal_ones_and_back() {
    for (class, law) in force_laws() {
        let physical = some_physical(class);
        let internal = law.internal(&physical);
        assert!(internal.len() >= law.amplitudes(), "{class}");
        let back = law.physical(&internal);
        assert_eq!(back.len(), physical.len(), "{class}");
        for (found, expected) in back.iter().zip(&physical) {
            assert!((found - expected).abs() < 1e-12, "{class}: {back:?} {physical:?}");
        }
    }
}

/// Amplitudes scale and add: the force of a + b is the force of a plus that of b.
#[test]
fn forces_are_linear_in_their_amplitudes() {
    for (class, law) in force_laws() {
        let internal = law.internal(&some_physical(class));
        let shape = &internal[law.amplitudes()..];
        let memory: Vec<f64> = (0..law.memory()).map(|k| 0.4 - 0.9 * k as f64).collect();
        let sum = |amplitudes: &[f64], at: &Local| {
            let mut basis = vec![0.0; law.amplitudes()];
            law.basis(shape, at, &memory, &mut basis);
            amplitudes.iter().zip(basis).map(|(a, b)| a * b).sum::<f64>()
        };
        let a: Vec<f64> = (0..law.amplitudes()).map(|k| 1.3 + k as f64).collect();
        for at in &POINTS {
            // Doubling every physical amplitude must double the force of the simulation, too.
            let doubled: Vec<f64> = a.iter().map(|a| 2.0 * a).collect();
            let physical = law.physical(&[&a[..], shape].concat());
            let physical_doubled = law.physical(&[&doubled[..], shape].concat());
            let once = sum(&law.internal(&physical)[..law.amplitudes()], at);
            let twice = sum(&law.internal(&physical_doubled)[..law.amplitudes()], at);
            assert!((twice - 2.0 * once).abs() < 1e-12 * (1.0 + twice.abs()), "{class}");
            assert!((once - sum(&a, at)).abs() < 1e-12 * (1.0 + once.abs()), "{class}");
        }
    }
}

/// A friction or loss takes power out, never puts it in.
#[test]
fn friction_and_loss_laws_dissipate() {
    let dissipative = [
        "viscous_friction",
        "coulomb_friction",
        "stribeck_friction",
        "asymmetric_friction",
        "time_friction",
        "load_friction",
        "quadratic_drag",
        "position_damping",
        "linear_loss",
        "quadratic_loss",
    ];
    for class in dissipative {
        let amplitudes = law(class).amplitudes();
        for pattern in 0..1 << amplitudes {
            let mut physical = some_physical(class);
            for (k, p) in physical.iter_mut().enumerate().take(amplitudes) {
                *p = if pattern >> k & 1 == 1 { 1.8 } else { 0.0 };
            }
            for k in -300..=300 {
                let v = 0.01 * f64::from(k);
                // The velocity of a first-order state is the state.
                let power =
                    force(class, &physical, &Local { q: v, v, u: v - 0.4, ..Local::default() }) * v;
                assert!(power <= 0.0, "{class} {physical:?} at v = {v}: power {power}");
                if pattern + 1 == 1 << amplitudes && k != 0 {
                    assert!(power < 0.0, "{class} does nothing at v = {v}");
                }
            }
        }
    }
}

/// A law must not read what it does not declare: reports and regions rely on it.
#[test]
fn laws_depend_on_what_they_declare_and_on_nothing_else() {
    for effect in CATALOGUE {
        let Some(law) = Force::of(effect) else { continue };
        let internal = law.internal(&some_physical(effect.class));
        let shape = &internal[law.amplitudes()..];
        let memory = vec![0.35; law.memory()];
        let evaluate = |at: &Local| {
            let mut out = vec![0.0; law.amplitudes() + law.memory()];
            let (basis, rate) = out.split_at_mut(law.amplitudes());
            law.basis(shape, at, &memory, basis);
            law.memory_rate(shape, at, &memory, rate);
            out
        };
        for variable in [
            Variable::Coordinate,
            Variable::Velocity,
            Variable::Acceleration,
            Variable::OtherCoordinate,
            Variable::OtherVelocity,
            Variable::Time,
            Variable::OtherInput,
        ] {
            let moves = POINTS.iter().any(|at| {
                [-2.7, -0.9, 0.8, 2.1].iter().any(|by| {
                    let mut moved = *at;
                    match variable {
                        Variable::Coordinate => moved.q += by,
                        Variable::Velocity => moved.v += by,
                        Variable::Acceleration => moved.acceleration += by,
                        Variable::OtherCoordinate => moved.other_q += by,
                        Variable::OtherVelocity => moved.other_v += by,
                        Variable::OtherInput => moved.u += by,
                        Variable::Time | Variable::Input => moved.t += by,
                    }
                    evaluate(at) != evaluate(&moved)
                })
            });
            let declared = effect.variables(&some_physical(effect.class)).contains(&variable);
            assert_eq!(moves, declared, "{} and {variable:?}", effect.class);
        }
    }
}

#[test]
fn one_sided_amplitudes_are_those_of_energy_losses_and_of_springs_that_only_push() {
    let range = |class: &str, k: usize| find(class).expect("in the catalogue").parameters[k].range;
    for class in ["viscous_friction", "coulomb_friction", "quadratic_drag", "linear_loss"] {
        assert_eq!(range(class, 0), Range::NonNegative, "{class}");
    }
    assert_eq!(range("end_stop", 0), Range::NonNegative);
    assert_eq!(range("damped_stop", 1), Range::NonNegative);
    assert_eq!(range("overflow", 0), Range::NonNegative);
    assert_eq!(range("constant_force", 0), Range::Any);
    assert_eq!(range("cubic_stiffness", 0), Range::Any);
    assert!(!Range::NonNegative.contains(-1e-9) && Range::NonNegative.contains(0.0));
    assert!(!Range::Positive.contains(0.0) && !Range::Any.contains(f64::NAN));
    assert!(!Range::Any.contains(f64::INFINITY));
}

#[test]
fn effects_that_act_on_states_alone_are_the_losses() {
    let on_states: Vec<_> =
        CATALOGUE.iter().filter(|e| e.acts == Acts::States).map(|e| e.class).collect();
    assert_eq!(on_states, ["linear_loss", "quadratic_loss", "overflow", "spill"]);
}

/// Its parameters have either sign, for the friction where the coordinate is 0 may lie outside the range; in the range
/// it must not be negative.
#[test]
fn friction_that_depends_on_position_does_not_drive() {
    let possible = find("position_friction").unwrap().nature.possible.expect("it is asked");
    let scales = Scales { q: (1.0, 3.0), ..Scales::default() };
    for (magnitude, slope, expected) in
        [(-1.0, 0.6, true), (-1.0, 0.4, false), (1.0, -0.4, true), (-0.1, 0.0, false)]
    {
        assert_eq!(possible(&[magnitude, slope, 0.01], &scales), expected, "{magnitude} {slope}");
    }
}
