//! Derivatives of inverse dynamics by formula beside those that dual numbers carry along.

mod support;

use lacuna_numbers::{Dual, LANES, Number};
use lacuna_rigid::{Dynamics, Inertia, Motion, Room, Tree, urdf};
use support::{drawn_states, drawn_urdf, mass_and_bias};

const GRAVITY: [f64; 3] = [0.3, -1.0, -9.81];

/// Greatest difference as a share of the greatest entry.
fn difference(ours: &[f64], theirs: &[f64]) -> f64 {
    let size = theirs.iter().fold(0.0f64, |a, x| a.max(x.abs()));
    let off = ours.iter().zip(theirs).map(|(a, b)| (a - b).abs());
    off.fold(0.0, f64::max) / size.max(f64::MIN_POSITIVE)
}

fn drawn(joints: usize) -> Tree {
    let text = drawn_urdf(joints, 40 + joints as u64);
    urdf::read(&text).expect("a robot").tree(&[]).expect("a tree")
}

/// The forces of coordinates, velocities and accelerations, one after the other in `x`, in which lanes are
/// directions from `first` on.
fn inverse(tree: &Tree, x: &[f64], first: usize, inertia: &[Inertia<Dual>]) -> Vec<Dual> {
    let n = tree.bodies.len();
    let x: Vec<Dual> = x.iter().enumerate().map(|(i, x)| Dual::among(*x, i, first)).collect();
    let dynamics = Dynamics::new(tree, inertia, GRAVITY.map(Dual::constant));
    let (mut room, mut tau) = (Room::new(n), vec![Dual::constant(0.0); n]);
    dynamics.place(&mut room, &x[..n]);
    dynamics.inverse(&mut room, (&x[n..2 * n], &x[2 * n..]), &mut tau);
    tau
}

#[test]
fn those_by_formula_are_those_of_dual_numbers() {
    for joints in [1, 2, 6, 7, 19, 30] {
        let tree = drawn(joints);
        let n = tree.bodies.len();
        let inertia = tree.inertia();
        let dual: Vec<_> = inertia.iter().map(|i| i.map(Dual::constant)).collect();
        let dynamics = Dynamics::new(&tree, &inertia, GRAVITY);
        let mut motion = Motion::new(n);
        for (state, more) in drawn_states(n, 5, 1).iter().zip(drawn_states(n, 5, 2)) {
            let (q, v, a) = (&state[..n], &state[n..], &more[..n]);
            let (mut mass, mut bias) = (vec![0.0; n * n], vec![0.0; n]);
            dynamics.mass_and_bias(&mut motion, (q, v), &mut mass, &mut bias);
            let (expected_mass, expected_bias) = mass_and_bias(&tree, state, GRAVITY);
            assert!(difference(&mass, &expected_mass) < 1e-12, "{joints} joints, M");
            assert!(difference(&bias, &expected_bias) < 1e-12, "{joints} joints, h");

            let (mut by_q, mut by_v) = (vec![0.0; n * n], vec![0.0; n * n]);
            dynamics.derivatives(&mut motion, (v, a), &mut by_q, &mut by_v);
            let x: Vec<f64> = q.iter().chain(v).chain(a).copied().collect();
            let (mut dual_q, mut dual_v) = (vec![0.0; n * n], vec![0.0; n * n]);
            for first in (0..2 * n).step_by(LANES) {
                let tau = inverse(&tree, &x, first, &dual);
                for (l, k) in (first..(first + LANES).min(2 * n)).enumerate() {
                    for (i, tau) in tau.iter().enumerate() {
                        let to = if k < n { &mut dual_q } else { &mut dual_v };
                        to[i * n + k % n] = tau.tangent[l];
                    }
                }
            }
            // A joint alone has no derivative by its velocity: the greatest of both is the measure.
            let (ours, theirs) = ([by_q, by_v].concat(), [dual_q, dual_v].concat());
            assert!(difference(&ours, &theirs) < 1e-11, "{joints} joints");
        }
    }
}

/// Forces are linear in inertia: those that a body's inertia makes on its own add up to all.
#[test]
fn what_bodies_take_adds_up() {
    let tree = drawn(7);
    let n = tree.bodies.len();
    let inertia = tree.inertia();
    let dynamics = Dynamics::new(&tree, &inertia, GRAVITY);
    let mut motion = Motion::new(n);
    let dual: Vec<_> = inertia.iter().map(|i| i.map(Dual::constant)).collect();
    for (state, more) in drawn_states(n, 5, 3).iter().zip(drawn_states(n, 5, 4)) {
        let (q, v, a) = (&state[..n], &state[n..], &more[..n]);
        let (mut some, mut others) = (vec![0.0; n * n], vec![0.0; n * n]);
        dynamics.mass_and_bias(&mut motion, (q, v), &mut some, &mut others[..n]);
        dynamics.derivatives(&mut motion, (v, a), &mut some, &mut others);
        let mut tau = vec![0.0; n];
        for (i, inertia) in inertia.iter().enumerate() {
            dynamics.carry(&motion, i, inertia, &mut tau);
        }
        let x: Vec<f64> = q.iter().chain(v).chain(a).copied().collect();
        let expected: Vec<f64> =
            inverse(&tree, &x, usize::MAX / 2, &dual).iter().map(|t| t.value).collect();
        assert!(difference(&tau, &expected) < 1e-12);
    }
}
