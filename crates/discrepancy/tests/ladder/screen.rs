//! The linearised likelihood against simulations: what a small effect changes is what the
//! screening says it changes.

use crate::machines::{Bench, ON_PENDULUM, ON_TANKS, ON_TWO_MASS};
use lacuna_discrepancy::Dataset;
use lacuna_discrepancy::candidates::{Candidate, Term};
use lacuna_discrepancy::likelihood::{FULL, Fit, Hypothesis, Problem};
use lacuna_discrepancy::screen::Screen;
use lacuna_plants::Model;

/// What the screening of the plain model says of recordings of the truth.
fn on_plain<T>(bench: Bench, truth: &Model, seed: u64, says: impl FnOnce(&Screen) -> T) -> T {
    let model = bench.model();
    let dataset = Dataset::new(&model, &bench.record(truth, seed, 2)).expect("a dataset");
    let problem = Problem::new(&model, &dataset).expect("a problem");
    let plain = Fit::begin(&problem, Hypothesis::of(&model), 2).expect("a fit");
    let plain = plain.refit(plain.hypothesis.clone(), FULL).expect("a fit");
    says(&Screen::new(&plain).expect("a finite trajectory"))
}

/// Amplitude that the screening reads off a small concealed effect, with its deviation.
fn screened(bench: Bench, seed: u64, effect: &str, shape: &[f64]) -> (f64, f64, f64) {
    let truth = bench.truth(effect);
    let e = &truth.effects[0];
    let candidate = Candidate { effect: e.effect, channel: e.channel, other: e.other };
    let term = Term { candidate, shape: shape.to_vec() };
    let scored = on_plain(bench, &truth, seed, |screen| screen.gain(term)).expect("a finite gain");
    (scored.amplitudes[0], scored.std[0], scored.gain)
}

#[test]
fn small_forces_are_read_off_on_every_kind_of_channel() {
    let constant = |channel: &str, force: f64| {
        format!("[[effect]]\nclass = \"constant_force\"\nchannel = \"{channel}\"\nforce = {force}")
    };
    let cases =
        [(ON_PENDULUM, 31, "q", 0.02), (ON_TWO_MASS, 32, "x2", 0.3), (ON_TANKS, 33, "h1", 0.002)];
    for (bench, seed, channel, force) in cases {
        let (found, std, gain) = screened(bench, seed, &constant(channel, force), &[]);
        let close = (found - force).abs() < 4.0 * std + 0.1 * force;
        assert!(close, "{channel}: {found} +- {std}, truth {force}");
        assert!(gain > 10.0, "{channel}: {gain} nats");
    }
}

#[test]
fn a_small_late_command_is_read_off() {
    let bench = ON_PENDULUM;
    let effect = "[[effect]]\nclass = \"input_delay\"\nchannel = \"tau\"\ndelay = 0.01";
    let (share, std, gain) = screened(bench, 34, effect, &[0.01]);
    // All of a delay of this length acts.
    assert!((share - 1.0).abs() < 4.0 * std + 0.1, "{share} +- {std}");
    assert!(gain > 10.0, "{gain} nats");
}

#[test]
fn nothing_gains_where_nothing_is_missing() {
    on_plain(ON_PENDULUM, &ON_PENDULUM.model(), 35, |screen| {
        for curve in screen.curves() {
            assert!(curve.gain < 5.0, "{}", curve.gain);
        }
        let remainder = screen.remainder(0).expect("the pendulum moves");
        assert!(remainder < 5.0, "{remainder}");
    });
}

/// Of a small force a surface without a formula knows as much as the right law, at the price of its
/// freedom; a wrong law knows less.
#[test]
fn a_force_without_a_formula_lies_between_the_right_law_and_a_wrong_one() {
    let effect = |class: &str, number: &str| {
        format!("[[effect]]\nclass = \"{class}\"\nchannel = \"q\"\n{number}")
    };
    let concealed = effect("position_damping", "coefficient = 0.02");
    on_plain(ON_PENDULUM, &ON_PENDULUM.truth(&concealed), 36, |screen| {
        let gain = |class: &str| {
            let effect = lacuna_effects::find(class).expect("in the catalogue");
            let candidate = Candidate { effect, channel: 0, other: None };
            screen.gain(Term { candidate, shape: vec![] }).expect("a finite gain").gain
        };
        let (right, wrong) = (gain("position_damping"), gain("cubic_stiffness"));
        let remainder = screen.remainder(0).expect("the pendulum moves");
        assert!(right > 30.0, "{right}");
        assert!(remainder < right && remainder > wrong + 5.0, "{right}, {remainder}, {wrong}");
    });
}
