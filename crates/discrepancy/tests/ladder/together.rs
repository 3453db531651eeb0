//! Laws that are right only together.

use crate::findings::classes;
use crate::machines::{Bench, ON_PENDULUM, diagnosed};
use lacuna_discrepancy::diagnosis::{Finding, Verdict};

const OSCILLATOR: &str = r#"
name = "oscillator"
[parameters]
d = { value = 0.8, unit = "kg/s", tolerance = 0.3 }
k = { value = 40, unit = "N/m", tolerance = 0.3 }
b = { value = 1, unit = "1", tolerance = 0.3 }
[[input]]
name = "u"
unit = "N"
[[coordinate]]
name = "q"
velocity = "v"
unit = "m"
[mechanics]
mass = [["1"]]
force = ["b*u - k*q - d*v"]
"#;

const BENCH: Bench = Bench {
    text: OSCILLATOR,
    samples: 3000,
    step: 0.02,
    amplitude: (0.6, 1.2),
    frequency: (2.0, 9.0),
    start: 0.0,
    noise: 2e-5,
    ..ON_PENDULUM
};

/// What one law of the catalogue leaves of a force by another formula is no second law: others on the
/// same channel would nibble at it, here quadratic drag at a stop that damps.
#[test]
fn what_a_formula_leaves_is_no_further_effect() {
    let damped = OSCILLATOR.replace("- d*v", "- d*v - max(q - 0.05, 0)*(300 + 60*v)");
    let bench = Bench { noise: 1e-3, ..BENCH };
    let truth = Bench { text: Box::leak(damped.into_boxed_str()), ..bench }.model();
    let d = diagnosed(&bench.model(), &bench.record(&truth, 102, 4)).diagnosis;
    assert_eq!(d.verdict, Verdict::MissingPhysics);
    let [f] = &d.findings[..] else { panic!("{:?}", d.findings) };
    assert_eq!((f.class.as_str(), f.channel.as_str()), ("end_stop", "q"), "{}", f.says);
}

/// A spring that hardens and a force that is always there. A force periodic in position, its
/// phase free, does the work of both better than either of them; a curve shows that it is they.
#[test]
fn two_laws_are_found_where_one_with_more_freedom_comes_near_both() {
    let truth = "[[effect]]\nclass = \"cubic_stiffness\"\nchannel = \"q\"\nstiffness = 150\n\
                 [[effect]]\nclass = \"constant_force\"\nchannel = \"q\"\nforce = 0.05";
    let d = diagnosed(&BENCH.model(), &BENCH.record(&BENCH.truth(truth), 101, 4)).diagnosis;
    assert_eq!(d.verdict, Verdict::MissingPhysics);
    assert_eq!(classes(&d), ["constant_force", "cubic_stiffness"]);
    let near = |class: &str, name: &str, value: f64| {
        let f: Vec<&Finding> = d.findings.iter().filter(|f| f.class == class).collect();
        let e = &f[0].parameters[name];
        assert!((e.value - value).abs() < 4.0 * e.std + 1e-3 * value, "{class}: {e:?}");
    };
    near("cubic_stiffness", "stiffness", 150.0);
    near("constant_force", "force", 0.05);
}
