//! A concealed effect is named, on the right channel, with its size.

use crate::machines::{Bench, ON_PENDULUM, ON_TANKS, ON_TWO_MASS, diagnosed};
use lacuna_discrepancy::diagnosis::{Diagnosis, Estimate, Verdict};

/// A number with its standard deviation is right if it is within four of them, or 5 %.
fn is_right(found: &Estimate, truth: f64) -> bool {
    found.std > 0.0 && (found.value - truth).abs() < (4.0 * found.std).max(0.05 * truth.abs())
}

pub fn conceal(bench: Bench, seed: u64, effect: &str) -> Diagnosis {
    let recordings = bench.record(&bench.truth(effect), seed, 3);
    diagnosed(&bench.model(), &recordings).diagnosis
}

/// The classes of all findings, by name.
pub fn classes(d: &Diagnosis) -> Vec<&str> {
    let mut all: Vec<_> = d.findings.iter().map(|f| &*f.class).collect();
    all.sort_unstable();
    all
}

/// A parameter of the finding of a class.
pub fn number(d: &Diagnosis, class: &str, name: &str) -> f64 {
    let finding = d.findings.iter().find(|f| f.class == class).expect("it was found");
    finding.parameters[name].value
}

/// The first finding is `class` on `channel` with these parameters, and the augmented model
/// predicts the held-out recordings down to the noise.
pub fn names(d: &Diagnosis, class: &str, channel: &str, parameters: &[(&str, f64)]) {
    assert_eq!(d.verdict, Verdict::MissingPhysics, "{class}: {:?}", d.findings);
    let first = &d.findings[0];
    let rest: Vec<_> = d.findings.iter().skip(1).map(|f| (&f.class, &f.channel)).collect();
    assert_eq!((first.class.as_str(), first.channel.as_str()), (class, channel), "{}", first.says);
    assert!(rest.is_empty(), "{class} on {channel} is joined by {rest:?}");
    for (name, truth) in parameters {
        let found = &first.parameters[*name];
        assert!(is_right(found, *truth), "{class} {name}: {found:?}, truth {truth}");
    }
    assert!(first.probability > 0.5, "{class}: {}", first.probability);
    for (channel, fit) in &d.fit.held_out {
        assert!(fit.rmse_after < 1.2 * fit.noise, "{class}: {channel} {fit:?}");
    }
}

#[test]
fn dry_friction_on_a_pendulum() {
    let effect = "[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"q\"\nmagnitude = 0.06\nsmoothing_velocity = 0.2";
    let d = conceal(ON_PENDULUM, 212, effect);
    names(&d, "coulomb_friction", "q", &[("magnitude", 0.06)]);
    assert_eq!(d.findings[0].parameters["magnitude"].unit, "N m");
    assert_eq!(d.findings[0].depends_on, ["dq"]);
}

#[test]
fn a_constant_torque_on_a_pendulum() {
    let effect = "[[effect]]\nclass = \"constant_force\"\nchannel = \"q\"\nforce = -0.08";
    names(&conceal(ON_PENDULUM, 12, effect), "constant_force", "q", &[("force", -0.08)]);
}

#[test]
fn quadratic_drag_on_the_second_of_two_masses() {
    let effect = "[[effect]]\nclass = \"quadratic_drag\"\nchannel = \"x2\"\ncoefficient = 2.5";
    let d = conceal(ON_TWO_MASS, 13, effect);
    names(&d, "quadratic_drag", "x2", &[("coefficient", 2.5)]);
    assert_eq!(d.findings[0].parameters["coefficient"].unit, "N s^2/m^2");
}

/// More than the tolerance of the mass leaves room for.
#[test]
fn an_added_inertia_on_the_second_of_two_masses() {
    let effect = "[[effect]]\nclass = \"added_inertia\"\nchannel = \"x2\"\ninertia = 0.9";
    let d = conceal(ON_TWO_MASS, 21, effect);
    names(&d, "added_inertia", "x2", &[("inertia", 0.9)]);
    assert_eq!(d.findings[0].parameters["inertia"].unit, "N s^2/m");
    assert_eq!(d.findings[0].depends_on, ["acceleration of x2"]);
}

#[test]
fn cubic_stiffness_on_the_first_of_two_masses() {
    let effect = "[[effect]]\nclass = \"cubic_stiffness\"\nchannel = \"x1\"\nstiffness = 60";
    let d = conceal(ON_TWO_MASS, 14, effect);
    names(&d, "cubic_stiffness", "x1", &[("stiffness", 60.0)]);
}

#[test]
fn an_end_stop_on_a_pendulum() {
    let effect = "[[effect]]\nclass = \"end_stop\"\nchannel = \"q\"\nstiffness = 3.0\nposition = 0.6\nside = 1";
    let d = conceal(ON_PENDULUM, 15, effect);
    names(&d, "end_stop", "q", &[("stiffness", 3.0), ("position", 0.6)]);
}

#[test]
fn a_late_command_on_a_pendulum() {
    let bench = ON_PENDULUM;
    // Two and a half samples, so that the delay is no whole number of them.
    let recordings = bench.record_late(&bench.model(), 16, 3, 0.025);
    let d = diagnosed(&bench.model(), &recordings).diagnosis;
    names(&d, "input_delay", "tau", &[("delay", 0.025)]);
    assert_eq!(d.findings[0].parameters["delay"].unit, "s");
}

/// With inertia and weight known exactly, a gain cannot hide in them.
#[test]
fn a_wrong_gain_on_a_pendulum_of_known_inertia() {
    const KNOWN: &str = r#"
name = "pendulum"
[parameters]
J = { value = 0.05, unit = "kg m^2" }
b = { value = 0.03, unit = "N m s/rad", tolerance = 0.1 }
mgl = { value = 0.4, unit = "N m" }
[[input]]
name = "tau"
unit = "N m"
[[coordinate]]
name = "q"
velocity = "dq"
unit = "rad"
[mechanics]
mass = [["J"]]
force = ["tau - b*dq - mgl*sin(q)"]
"#;
    let bench = Bench { text: KNOWN, ..ON_PENDULUM };
    let d =
        conceal(bench, 17, "[[effect]]\nclass = \"gain_error\"\nchannel = \"tau\"\ngain = 0.85");
    names(&d, "gain_error", "tau", &[("gain", 0.85)]);
}

#[test]
fn a_leak_of_the_second_tank() {
    let effect = "[[effect]]\nclass = \"linear_loss\"\nchannel = \"h2\"\nrate = 0.012";
    let d = conceal(ON_TANKS, 18, effect);
    names(&d, "linear_loss", "h2", &[("rate", 0.012)]);
    assert_eq!(d.findings[0].parameters["rate"].unit, "1/s");
}

#[test]
fn a_constant_inflow_of_the_first_tank() {
    let effect = "[[effect]]\nclass = \"constant_force\"\nchannel = \"h1\"\nforce = 0.008";
    let d = conceal(ON_TANKS, 19, effect);
    names(&d, "constant_force", "h1", &[("force", 0.008)]);
    assert_eq!(d.findings[0].parameters["force"].unit, "m/s");
}

/// The curve that is learned without a formula follows the law that was concealed.
#[test]
fn the_learned_curve_shows_the_concealed_force() {
    let effect = "[[effect]]\nclass = \"coulomb_friction\"\nchannel = \"q\"\nmagnitude = 0.06\nsmoothing_velocity = 0.02";
    let d = conceal(ON_PENDULUM, 20, effect);
    let curve = d.findings[0].curve.as_ref().expect("a law of one variable has a curve");
    assert_eq!((curve.variable.as_str(), curve.force_unit.as_str()), ("dq", "N m"));
    // Viscous friction is free within its tolerance and may take a slope from the curve.
    let well_away = curve.at.iter().zip(&curve.learned).filter(|(v, _)| v.abs() > 0.5);
    for (v, force) in well_away {
        assert_eq!(force.signum(), -v.signum(), "force {force} at {v}");
        assert!((0.03..0.12).contains(&force.abs()), "force {force} at {v}");
    }
}

/// Threads decide how fast it goes, never what comes out.
#[test]
fn one_thread_finds_what_two_find() {
    let effect = "[[effect]]\nclass = \"quadratic_drag\"\nchannel = \"q\"\ncoefficient = 0.02";
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        serde_json::to_value(pool.install(|| conceal(ON_PENDULUM, 21, effect))).expect("JSON")
    };
    same(&with(1), &with(2), "");
}

/// Equal to 1e-9, number by number.
fn same(a: &serde_json::Value, b: &serde_json::Value, path: &str) {
    use serde_json::Value::{Array, Number, Object};
    match (a, b) {
        (Number(x), Number(y)) => {
            let (x, y) = (x.as_f64().expect("a number"), y.as_f64().expect("a number"));
            assert!((x - y).abs() <= 1e-9 * (1.0 + x.abs()), "{path}: {x} {y}");
        }
        (Array(x), Array(y)) => {
            assert_eq!(x.len(), y.len(), "{path}");
            x.iter().zip(y).enumerate().for_each(|(k, (x, y))| same(x, y, &format!("{path}/{k}")));
        }
        (Object(x), Object(y)) => {
            assert!(x.keys().eq(y.keys()), "{path}");
            x.iter().for_each(|(k, x)| same(x, &y[k], &format!("{path}/{k}")));
        }
        _ => assert_eq!(a, b, "{path}"),
    }
}

/// A mass on a spring, of which the cubic part, missing, leaves far more than quadratic drag and quadratic stiffness,
/// of which each is but a part of what is left then.
#[test]
fn two_small_laws_are_found_together_beside_a_large_one() {
    const SPRING: &str = r#"
name = "spring"
[parameters]
d = { value = 0.42, unit = "N s/m", tolerance = 0.3 }
k = { value = 19.1, unit = "N/m", tolerance = 0.3 }
[[input]]
name = "u"
unit = "N"
[[coordinate]]
name = "y"
velocity = "dy"
unit = "m"
[mechanics]
mass = [["1"]]
force = ["u - k*y - d*dy"]
"#;
    const LAWS: [(&str, &str, f64); 3] = [
        ("cubic_stiffness", "stiffness", 73.0),
        ("quadratic_drag", "coefficient", 0.08),
        ("quadratic_stiffness", "stiffness", -1.5),
    ];
    let effect = |(class, name, value): &(&str, &str, f64)| {
        format!("[[effect]]\nclass = \"{class}\"\nchannel = \"y\"\n{name} = {value}\n")
    };
    let (amplitude, frequency) = ((0.3, 0.9), (1.0, 7.0));
    let bench =
        Bench { text: SPRING, samples: 2000, amplitude, frequency, noise: 1e-4, ..ON_PENDULUM };
    let d = conceal(bench, 31, &LAWS.iter().map(effect).collect::<String>());
    assert_eq!(classes(&d), LAWS.map(|l| l.0));
    for (class, name, truth) in LAWS {
        let f = d.findings.iter().find(|f| f.class == class).expect("it is found");
        assert!(is_right(&f.parameters[name], truth), "{class}: {:?}, truth {truth}", f.parameters);
    }
    let fit = &d.fit.held_out["y"];
    assert!(fit.rmse_after < 1.2 * fit.noise, "{fit:?}");
}
