//! Model files: what is read is what is simulated, and mistakes are told with their place.

mod support;

use lacuna_plants::{Model, Plant, System, TwoLinkArm};
use support::{error, read};

const TWO_LINK: &str = r#"
name = "two_link"
[parameters]
p1 = { value = 3.473, unit = "kg m^2", tolerance = 0.1 }
p2 = { value = 0.196, unit = "kg m^2" }
p3 = { value = 0.242, unit = "kg m^2" }
[[input]]
name = "tau1"
unit = "N m"
[[input]]
name = "tau2"
unit = "N m"
[[coordinate]]
name = "q1"
velocity = "dq1"
unit = "rad"
[[coordinate]]
name = "q2"
velocity = "dq2"
unit = "rad"
[mechanics]
mass  = [["p1 + 2*p3*cos(q2)", "p2 + p3*cos(q2)"], ["p2 + p3*cos(q2)", "p2"]]
force = ["tau1 + p3*sin(q2)*dq2*dq1 + p3*sin(q2)*(dq1 + dq2)*dq2 - 5.3*dq1 - 8.45*tanh(dq1)",
         "tau2 - p3*sin(q2)*dq1*dq1 - 1.1*dq2 - 2.35*tanh(dq2)"]
"#;

#[test]
fn a_model_file_moves_as_the_arm_written_in_rust() {
    let (file, native) = (System::new(&read(TWO_LINK)), TwoLinkArm::default());
    let (mut a, mut b) = ([0.0; 4], [0.0; 4]);
    for k in 0..50 {
        let s = |j: usize| (1.3 * (k * 7 + j * 3) as f64).sin() * 2.0;
        let (state, u) = ([s(0), s(1), s(2), s(3)], [s(4) * 10.0, s(5)]);
        file.derivative(0.0, &state, &u, &mut a);
        native.derivative(0.0, &state, &u, &mut b);
        for (x, y) in a.iter().zip(&b) {
            assert!((x - y).abs() < 1e-11 * (1.0 + y.abs()), "{a:?} {b:?}");
        }
    }
}

#[test]
fn columns_are_taken_in_the_unit_that_the_model_says() {
    let text =
        format!("{TWO_LINK}[[measurement]]\ncolumn = \"joint2\"\nof = \"q2\"\nunit = \"deg\"\n");
    let model = read(&text);
    let units = ["q1", "dq1", "tau2", "joint2", "temperature"].map(|c| model.column_unit(c));
    let said = units.each_ref().map(Option::as_deref);
    assert_eq!(said, [Some("rad"), Some("rad/s"), Some("N m"), Some("deg"), None]);
}

#[test]
fn three_coordinates_are_solved_like_a_known_inverse() {
    let text = r#"
name = "three"
[[coordinate]]
name = "a"
velocity = "da"
[[coordinate]]
name = "b"
velocity = "db"
[[coordinate]]
name = "c"
velocity = "dc"
[mechanics]
mass = [["0", "2", "1"], ["2", "3", "0"], ["1", "0", "4"]]
force = ["7", "8", "13"]
"#;
    // Forces made from accelerations (1, 2, 3): [0 2 1; 2 3 0; 1 0 4] (1, 2, 3) = (7, 8, 13).
    let mut derivative = [0.0; 6];
    System::new(&read(text)).derivative(0.0, &[0.0; 6], &[], &mut derivative);
    for (found, expected) in derivative[3..].iter().zip([1.0, 2.0, 3.0]) {
        assert!((found - expected).abs() < 1e-14);
    }
}

#[test]
fn effects_of_the_file_act() {
    let effect = |class: &str, rest: &str| {
        format!("{TWO_LINK}\n[[effect]]\nclass = \"{class}\"\nchannel = \"q2\"\n{rest}\n")
    };
    let force_on_q2 = |text: &str, state: [f64; 4]| {
        let (model, plain) = (read(text), read(TWO_LINK));
        let system = System::new(&model);
        let (mut with, mut without) = ([0.0; 8], [0.0; 4]);
        let full = system.at_rest(&state);
        system.derivative(0.0, &full, &[0.0, 0.0], &mut with[..full.len()]);
        System::new(&plain).derivative(0.0, &state, &[0.0, 0.0], &mut without);
        // M (difference of accelerations) = added force; row 2 of M.
        let (p2, p3) = (0.196, 0.242);
        let m21 = p2 + p3 * state[1].cos();
        m21 * (with[2] - without[2]) + p2 * (with[3] - without[3])
    };
    let state = [0.2, -0.5, 0.7, -1.5];
    let coulomb =
        effect("coulomb_friction", "magnitude = { value = 2.0, std = 0.1, unit = \"N m\" }");
    assert!((force_on_q2(&coulomb, state) - 2.0).abs() < 1e-12);
    let drag = effect("quadratic_drag", "coefficient = 0.5");
    assert!((force_on_q2(&drag, state) - 0.5 * 1.5 * 1.5).abs() < 1e-12);
    let stop = effect("end_stop", "position = -0.4\nstiffness = 30");
    assert!((force_on_q2(&stop, state) - 30.0 * 0.1).abs() < 1e-12);
    let spring = effect("coupling_stiffness", "other = \"q1\"\nstiffness = 3");
    assert!((force_on_q2(&spring, state) - 3.0 * (0.2 + 0.5)).abs() < 1e-12);
}

#[test]
fn mistakes_are_told_with_line_and_column() {
    let e = error(&TWO_LINK.replace("- 1.1*dq2", "- 1.1*dq3"));
    assert!(e.starts_with("model.toml:24:43: "), "{e}");
    assert!(e.contains("unknown name 'dq3'") && e.contains("did you mean 'dq"), "{e}");
    assert!(e.contains("\"tau2 - p3*sin(q2)") && e.trim_end().ends_with("^^^"), "{e}");

    let e = error(&TWO_LINK.replace("tolerance = 0.1", "tolerence = 0.1"));
    assert!(e.starts_with("model.toml:4:") && e.contains("tolerence"), "{e}");
    let e = error(&TWO_LINK.replace("tolerance = 0.1", "tolerance = -0.1"));
    assert!(e.starts_with("model.toml:4:") && e.contains("-0.1"), "{e}");
    let e = error(&TWO_LINK.replace("value = 3.473", "value = \"3\""));
    assert!(e.starts_with("model.toml:4:"), "{e}");
    let e = error(&TWO_LINK.replace("name = \"tau2\"", "name = \"tau1\""));
    assert!(e.starts_with("model.toml:11:") && e.contains("declared twice"), "{e}");
    let e = error(&TWO_LINK.replace(", \"p2\"]]", "]]"));
    assert!(e.contains("2 x 2") && e.contains("2, 1"), "{e}");
    let e = error(&TWO_LINK.replace("p1 + 2*p3*cos(q2)", "0").replace("p2 + p3*cos(q2)", "0"));
    assert!(e.contains("singular"), "{e}");
    let e = error("name = \"empty\"");
    assert!(e.contains("nothing moves"), "{e}");
    let e = error("name = ");
    assert!(e.starts_with("model.toml:1:"), "{e}");
}

#[test]
fn parameters_are_uncertain_relatively_or_in_their_unit() {
    let with = |entry: &str| {
        TWO_LINK
            .replace("unit = \"kg m^2\", tolerance = 0.1", &format!("unit = \"kg m^2\", {entry}"))
    };
    assert!((read(TWO_LINK).parameters[0].std() - 0.3473).abs() < 1e-15);
    assert_eq!(read(&with("std = 0.5")).parameters[0].std(), 0.5);
    assert_eq!(read(&with("calibrated_std = 0.5")).parameters[0].std(), 0.0);

    let e = error(&with("std = -0.5"));
    assert!(e.starts_with("model.toml:4:") && e.contains("the std of 'p1'"), "{e}");
    let e = error(&with("tolerance = 0.1, std = 0.5"));
    assert!(e.starts_with("model.toml:4:63: ") && e.contains("say one of them"), "{e}");
    let e = error(&with("tolerance = 0.1").replace("3.473", "0"));
    assert!(e.starts_with("model.toml:4:48: ") && e.contains("'p1' is 0"), "{e}");
    assert!(e.contains("std = ..."), "{e}");
    assert_eq!(read(&with("std = 0.5").replace("3.473", "0")).parameters[0].std(), 0.5);
}

/// The arm with its mass matrix by name, the definitions in no order.
fn defined(define: &str) -> String {
    let mass = r#"[["m11", "m12"], ["m12", "p2"]]"#;
    let begin = TWO_LINK.find("[[\"p1").expect("a mass matrix");
    let end = begin + TWO_LINK[begin..].find('\n').expect("a line");
    let text = format!("{}{mass}{}", &TWO_LINK[..begin], &TWO_LINK[end..]);
    text.replace(
        "[[input]]\nname = \"tau1\"",
        &format!("[define]\n{define}\n[[input]]\nname = \"tau1\""),
    )
}

const DEFINITIONS: &str =
    "m11 = \"p1 + 2*bend\"\nbend = \"p3*c2\"\nm12 = \"p2 + bend\"\nc2 = \"cos(q2)\"";

#[test]
fn definitions_stand_for_their_expressions() {
    let text = defined(DEFINITIONS)
        + "[[measurement]]\ncolumn = \"a\"\nof = \"bend\"\nunit = \"kg m^2\"\n";
    let (model, plain) = (read(&text), read(TWO_LINK));
    let (state, u) = ([0.3, -0.8, 1.2, 0.4], [1.5, -0.2]);
    let derivative = |model: &Model| {
        let mut rates = [0.0; 4];
        System::new(model).derivative(0.0, &state, &u, &mut rates);
        rates
    };
    assert_eq!(derivative(&model), derivative(&plain));
    assert_eq!(model.force_unit(0), plain.force_unit(0));
    let mut out = [0.0];
    let bound = model.dynamics().bind(&model.values());
    bound.observe(&[state[0], state[1], state[2], state[3], u[0], u[1], 0.0], &mut out);
    assert!((out[0] - 0.242 * state[1].cos()).abs() < 1e-15);
    // A parameter that is found stands in a text that keeps its definitions.
    let augmentation = lacuna_plants::model::Augmentation {
        parameters: vec![("p3".into(), 0.3, 0.01)],
        effects: vec![],
    };
    let again = model.augmented_text(&augmentation).expect("written");
    assert!(again.contains("bend = \"p3*c2\"") && read(&again).values()[2] == 0.3, "{again}");
}

#[test]
fn mistakes_in_definitions_are_told_with_line_and_column() {
    let with = |define: &str| error(&defined(&format!("{DEFINITIONS}\n{define}")));
    let e = error(&defined(&DEFINITIONS.replace("cos(q2)", "cos(q3)")));
    assert!(e.starts_with("model.toml:11:11: "), "{e}");
    assert!(e.contains("unknown name 'q3'") && e.contains("did you mean"), "{e}");
    let e = error(&defined(&DEFINITIONS.replace("cos(q2)", "cos(q2) + m11")));
    assert!(e.starts_with("model.toml:8:1: "), "{e}");
    assert!(e.contains("'m11' is defined by itself (m11 needs bend needs c2 needs m11)"), "{e}");
    let e = with("self_made = \"2*self_made\"");
    assert!(e.starts_with("model.toml:12:1: ") && e.contains("(self_made needs self_made)"), "{e}");
    let e = with("tau1 = \"2\"");
    assert!(e.starts_with("model.toml:12:1: ") && e.contains("'tau1' is declared twice"), "{e}");
    let e = with("cos = \"2\"");
    assert!(e.starts_with("model.toml:12:1: ") && e.contains("is a function"), "{e}");
    let e = with("half = 0.5");
    assert!(e.starts_with("model.toml:12:8: ") && e.contains("string"), "{e}");
    let e = with("open = \"2*(1\"");
    assert!(e.starts_with("model.toml:12:13: ") && e.contains("expected ')'"), "{e}");
    // What nothing uses must be right, too.
    let e = with("unused = \"zzzzzz\"");
    assert!(e.starts_with("model.toml:12:11: ") && e.contains("declare it"), "{e}");
}

#[test]
fn inputs_say_what_stands_behind_them() {
    let plain = &read(TWO_LINK).inputs[1];
    assert_eq!((&*plain.name, plain.actuator, plain.noise), ("tau2", true, None));
    let with =
        |more: &str| TWO_LINK.replace("name = \"tau2\"", &format!("name = \"tau2\"\n{more}"));
    let input = &read(&with("actuator = false\nnoise = 0.1")).inputs[1];
    assert_eq!((input.actuator, input.noise), (false, Some(0.1)));
    let e = error(&with("noise = -0.1"));
    assert!(e.starts_with("model.toml:12:9: ") && e.contains("the noise of 'tau2'"), "{e}");
    let e = error(&with("actuator = \"no\""));
    assert!(e.starts_with("model.toml:12:12: ") && e.contains("bool"), "{e}");
    let built = Model::builder("cart").input("u", "N").no_actuator().input_noise(0.2);
    let built = built.coordinate("x", "v", "m").rates(|at| [at.inputs[0]]).build().expect("right");
    assert_eq!((built.inputs[0].actuator, built.inputs[0].noise), (false, Some(0.2)));
}

#[test]
fn an_input_is_one_column() {
    let of =
        |column: &str, of: &str| format!("[[measurement]]\ncolumn = \"{column}\"\nof = \"{of}\"\n");
    let two_sensors = format!("{TWO_LINK}{}{}", of("encoder", "q1"), of("camera", "q1"));
    assert_eq!(read(&two_sensors).measurements.len(), 2);
    let e = error(&format!("{TWO_LINK}{}{}", of("i1", "tau1"), of("i2", "tau1")));
    assert!(e.starts_with("model.toml:30:6: ") && e.contains("'i1' already is"), "{e}");
}

#[test]
fn a_mass_may_be_an_input() {
    let cart = |mass: &str| {
        format!(
            "name = \"cart\"\n[[input]]\nname = \"u\"\nunit = \"N\"\n[[input]]\nname = \"load\"\n\
             unit = \"kg\"\nactuator = false\n[[coordinate]]\nname = \"x\"\nvelocity = \"v\"\n\
             unit = \"m\"\n[mechanics]\nmass = [[\"{mass}\"]]\nforce = [\"u\"]\n"
        )
    };
    let mut rates = [0.0; 2];
    System::new(&read(&cart("load"))).derivative(0.0, &[0.0, 0.0], &[3.0, 1.5], &mut rates);
    assert_eq!(rates, [0.0, 2.0]);
    assert_eq!(read(&cart("load")).force_unit(0), "N");
    let e = error(&cart("load*x"));
    assert!(e.contains("singular"), "{e}");
}

#[test]
fn mistakes_in_effects_are_told() {
    let with = |effect: &str| error(&format!("{TWO_LINK}\n[[effect]]\n{effect}\n"));
    let e = with("class = \"coulomb\"\nchannel = \"q1\"");
    assert!(
        e.contains("did you mean 'coulomb_friction'") && e.starts_with("model.toml:27:9: "),
        "{e}"
    );
    let e = with("class = \"coulomb_friction\"\nchannel = \"q9\"\nmagnitude = 1");
    assert!(e.contains("unknown channel 'q9'; there are q1, q2"), "{e}");
    let e = with("class = \"coulomb_friction\"\nchannel = \"q1\"");
    assert!(e.contains("needs 'magnitude' (N m)"), "{e}");
    let e = with("class = \"coulomb_friction\"\nchannel = \"q1\"\nmagnitude = -1");
    assert!(e.contains("0 or more"), "{e}");
    let e = with(
        "class = \"coulomb_friction\"\nchannel = \"q1\"\nmagnitude = { value = 1, unit = \"kg\" }",
    );
    assert!(e.contains("given in kg") && e.contains("N m"), "{e}");
    let e = with("class = \"input_delay\"\nchannel = \"q1\"\ndelay = 0.1");
    assert!(e.contains("acts on an input"), "{e}");
    let e = with("class = \"coupling_stiffness\"\nchannel = \"q1\"\nstiffness = 1");
    assert!(e.contains("other"), "{e}");
    let e = with("class = \"coupling_stiffness\"\nchannel = \"q1\"\nother = \"q1\"\nstiffness = 1");
    assert!(e.starts_with("model.toml:29:9: ") && e.contains("'q1' is named twice"), "{e}");
    let e = with("class = \"load_friction\"\nchannel = \"q1\"\nmagnitude = 1\nshare = 1");
    assert!(e.contains("depends on an input, one of tau"), "{e}");
    let e = with("class = \"input_damping\"\nchannel = \"q1\"\nother = \"q2\"\ncoefficient = 1");
    assert!(e.starts_with("model.toml:29:9: ") && e.contains("'q2' is none of tau"), "{e}");
    let e = with("class = \"linear_stiffness\"\nchannel = \"q1\"\nother = \"q2\"\nstiffness = 1");
    assert!(e.starts_with("model.toml:29:9: ") && e.contains("one channel alone"), "{e}");
    let e = with("class = \"linear_stiffness\"\nchannel = \"q1\"\nstifness = 1");
    assert!(e.starts_with("model.toml:29:1: ") && e.contains("no parameter 'stifness'"), "{e}");
}
