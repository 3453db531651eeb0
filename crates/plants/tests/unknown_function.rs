//! Learned curves in model files: read, simulated, written, and their mistakes told.

mod support;

use lacuna_effects::Variable;
use lacuna_plants::integrate::rk4_sampled;
use lacuna_plants::model::{Augmentation, NewEffect};
use lacuna_plants::{Plant, System};
use support::{error, read};

const MODEL: &str = r#"
name = "arm over a tank"
[[input]]
name = "tau"
unit = "N m"
[[coordinate]]
name = "theta"
velocity = "omega"
unit = "rad"
[mechanics]
mass = [["2.0"]]
force = ["tau"]
[[state]]
name = "h"
unit = "m"
derivative = "-0.1*h"
[recordings]
time = "time_s"
"#;

const KNOTS: usize = 24;

fn numbers(f: impl Fn(f64) -> f64, from: f64, to: f64) -> String {
    let at = |k: usize| f(from + (to - from) * k as f64 / (KNOTS - 1) as f64);
    format!("{:?}", (0..KNOTS).map(at).collect::<Vec<_>>())
}

/// A curve on a channel over a variable from -2 to 2.
fn curve(channel: &str, over: &str, [range, force]: [&str; 2], values: &str) -> String {
    format!(
        "{MODEL}\n[[effect]]\nclass = \"unknown_function\"\nchannel = \"{channel}\"\nover = \"{over}\"\n\
         from = {{ value = -2, unit = \"{range}\" }}\nto = {{ value = 2.0, unit = \"{range}\" }}\n\
         force = {{ values = {values}, unit = \"{force}\" }}\n"
    )
}

#[test]
fn curves_act_over_the_variable_that_they_name() {
    let line = numbers(|x| 3.0 + x, -2.0, 2.0);
    let state = [0.5, -0.75, 1.25];
    let arm = ["rad", "rad/s", "s"];
    for (over, unit, variable, x) in [
        ("theta", arm[0], Variable::Coordinate, state[0]),
        ("omega", arm[1], Variable::Velocity, state[1]),
        ("time_s", arm[2], Variable::Time, 0.25),
    ] {
        let model = read(&curve("theta", over, [unit, "N m"], &line));
        assert_eq!(model.effects[0].depends_on(), [variable]);
        let mut rate = [0.0; 3];
        System::new(&model).derivative(0.25, &state, &[0.0], &mut rate);
        assert!((rate[1] - (3.0 + x) / 2.0).abs() < 1e-12, "over {over}: {rate:?}");
    }
    let model = read(&curve("h", "h", ["m", "m/s"], &line));
    let mut rate = [0.0; 3];
    System::new(&model).derivative(0.0, &state, &[0.0], &mut rate);
    assert!((rate[2] - (3.0 + state[2] - 0.125)).abs() < 1e-12, "{rate:?}");
}

/// A curve that is a spring swings as the spring of the catalogue does.
#[test]
fn a_curve_of_a_spring_is_that_spring() {
    let (times, inputs): (Vec<f64>, Vec<f64>) =
        (0..500).map(|k| (0.01 * f64::from(k), 0.0)).unzip();
    let swing = |text: &str| {
        let model = read(text);
        let system = System::new(&model);
        let start = system.at_rest(&[0.9, 0.0, 0.0]);
        rk4_sampled(&system, &start, &times, &inputs, model.hold, 4).expect("finite")
    };
    let learned =
        swing(&curve("theta", "theta", ["rad", "N m"], &numbers(|x| -4.0 * x, -2.0, 2.0)));
    let formula = swing(&format!(
        "{MODEL}\n[[effect]]\nclass = \"linear_stiffness\"\nchannel = \"theta\"\nstiffness = 4\n"
    ));
    for (a, b) in learned.states.iter().zip(&formula.states) {
        assert!((a - b).abs() < 1e-10, "{a} {b}");
    }
}

#[test]
fn curves_are_written_and_read_again() {
    let values = numbers(|x| (3.0 * x).sin() / 3.0, -2.0, 2.0);
    let std = format!(", std = {}", numbers(|x| 0.01 + 0.1 * x * x, -2.0, 2.0));
    for (over, unit) in [("theta", "rad"), ("omega", "rad/s"), ("time_s", "s")] {
        for std in ["", &std] {
            let text = curve("theta", over, [unit, "N m"], &format!("{values}{std}"));
            let model = read(&text);
            let effect = &model.effects[0];
            let effects = vec![NewEffect::of(&model, effect)];
            let augmentation = Augmentation { parameters: vec![], effects };
            let written = read(MODEL).augmented_text(&augmentation).expect("written");
            assert!(written.contains(&format!("over = \"{over}\"")), "{written}");
            let again = &read(&written).effects[0];
            assert_eq!(again.parameters, effect.parameters, "{written}");
            assert_eq!(again.std, effect.std, "{written}");
            assert_eq!(effect.std[0].is_some(), !std.is_empty());
        }
    }
}

/// A list alone is enough, and whole numbers are numbers.
#[test]
fn values_may_stand_alone() {
    let whole: Vec<usize> = (0..KNOTS).collect();
    let text = format!(
        "{MODEL}\n[[effect]]\nclass = \"unknown_function\"\nchannel = \"theta\"\nover = \"omega\"\n\
         from = -1\nto = 1\nforce = {whole:?}\n"
    );
    assert_eq!(read(&text).effects[0].parameters[KNOTS - 1], 23.0);
}

#[test]
fn mistakes_are_told_where_they_stand() {
    let arm = |over: &str, units: [&str; 2], values: &str| curve("theta", over, units, values);
    let units = ["rad", "N m"];
    let good = numbers(|x| x, -2.0, 2.0);
    let text = arm("theta", units, &good);
    read(&text);
    let line = |key: &str, text: &str| {
        let lines: Vec<_> = text.lines().collect();
        let at = lines.iter().rposition(|l| l.starts_with(key)).expect("the key is there");
        format!("model.toml:{}:{}: ", at + 1, key.len() + 4)
    };
    let said = |key: &str, text: &str, parts: &[&str]| {
        let e = error(text);
        assert!(e.starts_with(&line(key, text)), "{e}");
        assert!(parts.iter().all(|part| e.contains(part)), "{e}");
    };
    said("force", &arm("theta", units, "[1.0, 2.0, 3.0]"), &["24 values", "found 3"]);
    let short = format!("{good}, std = [0.1, 0.2]");
    said("force", &arm("theta", units, &short), &["24 standard deviations", "found 2"]);
    let infinite = good.replacen("-2.0", "inf", 1);
    said("force", &arm("theta", units, &infinite), &["finite", "inf"]);
    said("force", &arm("theta", ["rad", "N"], &good), &["given in N;", "in N m"]);
    said("from", &arm("omega", units, &good), &["given in rad;", "in rad/s"]);
    let other = arm("tau", units, &good);
    said("over", &other, &["unknown variable 'tau'", "theta, omega, time_s"]);
    said("over", &curve("h", "omega", units, &good), &["unknown variable 'omega'", "h, time_s"]);
    said("over", &text.replace("over = \"theta\"", "over = 1"), &["'over' is a name"]);
    said("to", &text.replace("value = 2.0", "value = -2.0"), &["more than 'from' (-2)", "-2"]);
    let scalar = text.replace(&format!("values = {good}"), "value = 1.0");
    said("force", &scalar, &["'force' holds 24 values"]);
    said("force", &text.replace("unit = \"N m\" }", "units = \"N m\" }"), &["value (or values)"]);
    let list = text.replace("from = { value = -2, unit = \"rad\" }", "from = [1.0, 2.0]");
    said("from", &list, &["'from' is one number"]);

    let without = |key: &str| {
        let (head, effect) = text.split_once("[[effect]]").expect("an effect");
        let kept: Vec<_> = effect.lines().filter(|l| !l.starts_with(key)).collect();
        error(&format!("{head}[[effect]]{}", kept.join("\n")))
    };
    assert!(without("over").contains("needs 'over', one of theta, omega, time_s"));
    assert!(without("force").contains("needs 'force' (N m)"));
    assert!(without("to").contains("needs 'to' (rad)"));
    assert!(without("class").contains("needs class"));
    assert!(without("channel = ").contains("needs channel"));
}
