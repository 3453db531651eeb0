//! Position servos, `[[actuator]]` with `template = "pd_servo"`, in models of equations and of robots.

mod support;

use lacuna_numbers::{Dual, LANES, Number};
use lacuna_plants::model::{Augmentation, Direction, ModelEffect, StepInput};
use lacuna_plants::{Hold, Model, SampledInput, Substeps, System, rk4};
use support::Folder;

/// A joint that a servo moves, beside what is said of the servo.
const JOINT: &str = r#"
name = "joint"
[parameters]
J = { value = 0.03, unit = "kg m^2", tolerance = 0.3 }
m = { value = 0.4, unit = "N m" }
[[input]]
name = "elbow_command"
unit = "rad"
[[coordinate]]
name = "elbow"
velocity = "elbow_vel"
unit = "rad"
[mechanics]
mass = [["J"]]
force = ["-m*sin(elbow)"]
"#;
const SERVO: &str = r#"
[[actuator]]
template = "pd_servo"
channel = "elbow"
kp = { value = 17.8, unit = "N m/rad", tolerance = 0.2 }
kd = { value = 0.6, unit = "N m s/rad", tolerance = 0.5 }
saturation = { value = 1.9, unit = "N m", std = 0.1 }
backlash = { value = 0.05, unit = "rad" }
"#;
/// The same as an equation.
const BY_HAND: &str = r#"
name = "joint"
[parameters]
J = { value = 0.03, unit = "kg m^2", tolerance = 0.3 }
m = { value = 0.4, unit = "N m" }
kp = { value = 17.8, unit = "N m/rad", tolerance = 0.2 }
kd = { value = 0.6, unit = "N m s/rad", tolerance = 0.5 }
most = { value = 1.9, unit = "N m", std = 0.1 }
play = { value = 0.05, unit = "rad" }
[define]
d = "elbow_command - elbow"
e = "d - max(-play/2, min(play/2, d))"
[[input]]
name = "elbow_command"
unit = "rad"
[[coordinate]]
name = "elbow"
velocity = "elbow_vel"
unit = "rad"
[mechanics]
mass = [["J"]]
force = ["-m*sin(elbow) + max(-most, min(most, kp*e - kd*elbow_vel))"]
"#;

fn model(text: &str) -> Model {
    Model::from_text(text, "model.toml").expect("a model")
}

fn with_servo(servo: &str) -> Model {
    model(&format!("{JOINT}{servo}"))
}

/// Where a command that leaps takes a model.
fn run(model: &Model, width: usize) -> Vec<f64> {
    let times: Vec<f64> = (0..200).map(|k| 0.01 * f64::from(k)).collect();
    let leaps = |k: usize| 0.4 * ((k / 20) as f64 * 1.3).sin();
    let values: Vec<f64> = (0..times.len() * width).map(|k| leaps(k / width)).collect();
    let values = model.effective_inputs(&times, &values);
    let input = SampledInput { times: &times, values: &values, hold: Hold::ZeroOrder };
    let system = System::new(model);
    let begin = system.at_rest(&vec![0.0; model.machine_states()]);
    let path = rk4(&system, &begin, &input, &times, 1e-3).expect("it does not diverge");
    (0..times.len()).flat_map(|k| path.state(k).to_vec()).collect()
}

fn differ(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn it_moves_as_its_equations_do() {
    let (servo, by_hand) = (with_servo(SERVO), model(BY_HAND));
    let (moved, expected) = (run(&servo, 1), run(&by_hand, 1));
    assert!(differ(&moved, &expected) < 1e-12, "{}", differ(&moved, &expected));
    // Play and limit are felt.
    for part in ["saturation", "backlash"] {
        let text: String = SERVO
            .lines()
            .filter(|l| !l.starts_with(part))
            .fold(String::new(), |text, line| text + line + "\n");
        assert!(differ(&run(&with_servo(&text), 1), &expected) > 1e-3, "{part}");
    }
}

/// Rates with derivatives by all parameters and variables are those of the equations.
#[test]
fn its_derivatives_are_those_of_its_equations() {
    let (servo, by_hand) = (with_servo(SERVO), model(BY_HAND));
    assert_eq!(servo.values(), by_hand.values());
    let sizes = servo.dynamics().sizes();
    assert_eq!(sizes, by_hand.dynamics().sizes());
    // Between the kinks, in the play, and at the limit.
    for state in [[0.1, 0.2, 0.15], [0.1, 0.3, 0.11], [0.1, -0.4, 0.6]] {
        let variables = [&state[..], &[0.0]].concat();
        let all = [servo.values(), variables].concat();
        for first in (0..all.len()).step_by(LANES) {
            let along: Vec<Dual> =
                all.iter().enumerate().map(|(k, x)| Dual::among(*x, k, first)).collect();
            let (parameters, at) = along.split_at(sizes.parameters);
            let rates = |model: &Model| {
                let mut rates = vec![Dual::constant(0.0); sizes.rates()];
                model.dynamics().bind_dual(parameters).evaluate_once(at, &mut rates);
                rates
            };
            for (a, b) in rates(&servo).iter().zip(rates(&by_hand)) {
                assert!((a.value - b.value).abs() < 1e-12);
                assert!(differ(&a.tangent, &b.tangent) < 1e-12, "{state:?}: {a:?} {b:?}");
            }
        }
    }
}

#[test]
fn its_numbers_are_parameters() {
    let model = with_servo(SERVO);
    let known = |name: &str| {
        let p = model.parameters.iter().find(|p| p.name == name).expect("it is there");
        (p.value, p.unit.as_str(), p.std())
    };
    assert_eq!(known("elbow.kp"), (17.8, "N m/rad", 0.2 * 17.8));
    assert_eq!(known("elbow.kd"), (0.6, "N m s/rad", 0.3));
    assert_eq!(known("elbow.saturation"), (1.9, "N m", 0.1));
    assert_eq!(known("elbow.backlash"), (0.05, "rad", 0.0));
    // In other units, and damping that nothing is said of.
    let converted = with_servo(
        "[[actuator]]\ntemplate = \"pd_servo\"\nchannel = \"elbow\"\n\
         kp = { value = 17800, unit = \"mN m/rad\", std = 100 }\n",
    );
    let servo = &converted.parameters[2..];
    assert_eq!((servo[0].unit.as_str(), servo.len()), ("N m/rad", 2));
    assert!((servo[0].value - 17.8).abs() < 1e-12 && (servo[0].std() - 0.1).abs() < 1e-12);
    assert_eq!((servo[1].name.as_str(), servo[1].value), ("elbow.kd", 0.0));
}

#[test]
fn a_delay_is_that_of_its_command() {
    let delayed = format!("{SERVO}delay = {{ value = 20, unit = \"ms\" }}\n");
    let effect = "[[effect]]\nclass = \"input_delay\"\nchannel = \"elbow_command\"\ndelay = 0.02\n";
    let (stated, expected) = (with_servo(&delayed), with_servo(&format!("{SERVO}{effect}")));
    assert_eq!(stated.effects.len(), 1);
    assert!(differ(&run(&stated, 1), &run(&expected, 1)) == 0.0);
    assert!(differ(&run(&stated, 1), &run(&with_servo(SERVO), 1)) > 1e-2);
}

#[test]
fn what_was_calibrated_is_read_again() {
    let model = with_servo(&SERVO.replace("17.8, unit = \"N m", "17800, unit = \"mN m"));
    let found = [("elbow.kp", 19.5, 0.2), ("elbow.saturation", 2.1, 0.05), ("J", 0.028, 1e-3)];
    let parameters = found.map(|(name, value, std)| (name.to_owned(), value, std)).to_vec();
    let text = model.augmented_text(&Augmentation { parameters, effects: vec![] }).expect("text");
    let again = Model::from_text(&text, "augmented.toml").expect("it is read");
    for (name, value, _) in found {
        let p = again.parameters.iter().find(|p| p.name == name).expect("it is there");
        assert!((p.value - value).abs() < 1e-12, "{text}");
    }
    assert!(text.contains("kp = { value = 19500.0") && text.contains("calibrated_std"), "{text}");
    // In one list, where they cannot be told apart, nothing is written that says less.
    let inline = "actuator = [{ template = \"pd_servo\", channel = \"elbow\", kp = { value = 9, std = 1 } }]\n";
    let model = Model::from_text(&format!("{inline}{JOINT}"), "model.toml").expect("a model");
    let parameters = vec![("elbow.kp".to_owned(), 8.0, 0.1)];
    let error = model.augmented_text(&Augmentation { parameters, effects: vec![] });
    assert!(error.expect_err("no place").message.contains("[[actuator]] tables"));
}

#[test]
fn mistakes_are_told_with_their_place() {
    let mistake = |servo: &str| {
        let text = format!("{JOINT}{servo}");
        let error = Model::from_text(&text, "model.toml").expect_err(servo);
        let place = error.place.clone().expect("a place");
        (error.message.clone(), place.line - JOINT.lines().count(), place.column)
    };
    let told = |servo: &str, line: usize, column: usize, says: &str| {
        let (message, at, from) = mistake(servo);
        assert!(message.contains(says), "{message}");
        assert_eq!((at, from), (line, column), "{message}");
    };
    let swap = |from: &str, to: &str| SERVO.replace(from, to);
    told(&swap("pd_servo", "pid"), 3, 12, "unknown template \"pid\"; there is \"pd_servo\"");
    told(&swap("template = \"pd_servo\"\n", ""), 2, 1, "needs template");
    told(&swap("\"elbow\"", "\"elbwo\""), 4, 11, "did you mean 'elbow'");
    told(&swap("channel", "chanel"), 4, 1, "did you mean 'channel'");
    told(&swap("backlash", "backlashes"), 8, 1, "no 'backlashes', did you mean 'backlash'");
    told(&swap("kp = { value = 17.8", "kp = { value = -1"), 5, 6, "must be 0 or more; found -1");
    told(&swap("1.9", "0"), 7, 14, "more than 0");
    told(&swap("N m/rad", "N m s"), 5, 6, "'kp' is given in N m s");
    told(&swap("tolerance = 0.2", "tolerence = 0.2"), 5, 6, "a table with value");
    told(&swap("tolerance = 0.2", "tolerance = -0.2"), 5, 6, "0 or more");
    told(&swap("tolerance = 0.2", "tolerance = 0.2, std = 1"), 5, 6, "say one of them");
    told(&swap("kp = ", "# "), 2, 1, "needs kp");
    told(&format!("{SERVO}kp = \"17\"\n").replace("kp = {", "# {"), 9, 6, "is a number");
    let delay = format!("{SERVO}delay = {{ value = 0.02, std = 0.01 }}\n");
    told(&delay, 9, 9, "is not calibrated");
    let command = |name: &str| format!("{SERVO}command = \"{name}\"\n");
    told(&command("elbow_comand"), 9, 11, "no input, did you mean 'elbow_command'");
    told(&format!("{SERVO}{SERVO}"), 12, 11, "has an actuator already");
    let volts = JOINT.replace("unit = \"rad\"\n[[coord", "unit = \"V\"\n[[coord");
    let error = Model::from_text(&format!("{volts}{SERVO}"), "model.toml").expect_err("volts");
    assert!(error.message.contains("which is in V"), "{}", error.message);
    let none = JOINT.replace("name = \"elbow_command\"", "name = \"other\"");
    let error = Model::from_text(&format!("{none}{SERVO}"), "model.toml").expect_err("no input");
    assert!(error.message.contains("say [[input]] with name = \"elbow_command\""), "{error}");
}

/// An arm whose elbow follows a position servo.
const ARM: &str = r#"<mujoco model="arm">
  <default><joint axis="0 1 0" damping="0.3" armature="0.02"/></default>
  <worldbody>
    <body name="upper">
      <joint name="shoulder"/>
      <inertial pos="0 0 -0.15" mass="1.5" diaginertia="0.02 0.02 0.003"/>
      <body name="lower" pos="0 0 -0.3">
        <joint name="elbow"/>
        <inertial pos="0 0 -0.1" mass="0.8" diaginertia="0.01 0.01 0.001"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor joint="shoulder"/>
    <position joint="elbow" kp="4" kv="0.2" gear="3" forcerange="-2 2"/>
  </actuator>
</mujoco>
"#;
const OF_ARM: &str = "name = \"arm\"\n[robot]\nfile = \"arm.xml\"\n";

fn arm(file: &str) -> Folder {
    let folder = Folder::new();
    folder.write("arm.xml", file);
    folder
}

#[test]
fn a_robots_joint_follows_its_command() {
    let text = format!(
        "{OF_ARM}[parameters]\n\"elbow.kd\" = {{ value = 0.7, std = 0.1, unit = \"N m s/rad\" }}\n\
         [[actuator]]\ntemplate = \"pd_servo\"\nchannel = \"elbow\"\nkp = {{ value = 30, tolerance = 0.1 }}\n"
    );
    // Its own file is there as long as this is: what is written is read again.
    let folder = arm(ARM);
    let model = folder.model(&text).expect("a model");
    let inputs: Vec<_> = model.inputs.iter().map(|i| (&*i.name, &*i.unit)).collect();
    assert_eq!(inputs, [("shoulder_torque", "N m"), ("elbow_command", "rad")]);
    let known = |name: &str| {
        let p = model.parameters.iter().find(|p| p.name == name).expect("it is there");
        (p.value, p.unit.clone(), p.std())
    };
    // What the table does not say is the file's, on the joint's side of the gear.
    assert_eq!(known("elbow.kp"), (30.0, "N m/rad".to_owned(), 3.0));
    assert_eq!(known("elbow.kd"), (0.7, "N m s/rad".to_owned(), 0.1));
    assert_eq!(known("elbow.saturation"), (6.0, "N m".to_owned(), 0.0));
    let parameters = vec![("elbow.kp".to_owned(), 31.0, 0.1), ("elbow.kd".to_owned(), 0.6, 0.1)];
    let again = model.augmented_text(&Augmentation { parameters, effects: vec![] }).expect("text");
    assert!(
        again.contains("kp = { value = 31.0") && again.contains("\"elbow.kd\" = { value = 0.6")
    );
}

/// The torque of a joint, given a command, is what the servo makes of it.
#[test]
fn a_robots_servo_is_its_torque() {
    let folder = arm(ARM);
    let torque = folder.model(OF_ARM).expect("a model");
    let table = "[[actuator]]\ntemplate = \"pd_servo\"\nchannel = \"elbow\"\n";
    let servo = folder.model(&format!("{OF_ARM}{table}")).expect("a model");
    let sizes = servo.dynamics().sizes();
    let rates = |model: &Model, variables: &[f64]| {
        let mut rates = vec![0.0; sizes.rates()];
        model.dynamics().bind(&model.values()).evaluate_once(variables, &mut rates);
        rates
    };
    for (command, elbow, speed) in [(0.3, 0.1, 0.4), (0.9, 0.1, -0.4)] {
        let driven = (36.0 * (command - elbow) - 1.8 * speed).clamp(-6.0, 6.0);
        let at = |input: f64| [0.2, elbow, -0.3, speed, 0.1, input, 0.0];
        let (a, b) = (rates(&servo, &at(command)), rates(&torque, &at(driven)));
        assert!(differ(&a, &b) < 1e-13, "{a:?} {b:?}");
    }
    // Along a path, with derivatives that are shared: those of differences.
    let states = run(&servo, 2);
    assert!(states.iter().all(|x| x.is_finite()) && states.iter().any(|x| x.abs() > 0.1));
}

/// Damping as a share of the critical one is that of the inertia that the joint moves.
#[test]
fn a_damping_ratio_is_of_the_inertia_that_is_moved() {
    let ratio = ARM.replace("kv=\"0.2\"", "dampratio=\"0.5\"").replace(" forcerange=\"-2 2\"", "");
    let table = "[[actuator]]\ntemplate = \"pd_servo\"\nchannel = \"elbow\"\n";
    let model = arm(&ratio).model(&format!("{OF_ARM}{table}")).expect("a model");
    let inertia: f64 = 0.02 + 0.01 + 0.8 * 0.1 * 0.1;
    let kd = model.parameters.iter().find(|p| p.name == "elbow.kd").expect("it is there");
    assert!((kd.value - (36.0 * inertia).sqrt()).abs() < 1e-12, "{}", kd.value);
    assert!(model.parameters.iter().all(|p| p.name != "elbow.saturation"));
}

/// What is no plain position servo of one joint says nothing of one.
#[test]
fn other_actuators_are_no_servos() {
    let table = "[[actuator]]\ntemplate = \"pd_servo\"\nchannel = \"elbow\"\n";
    let position = "<position joint=\"elbow\" kp=\"4\" kv=\"0.2\" gear=\"3\" forcerange=\"-2 2\"/>";
    let general =
        "<general joint=\"elbow\" biastype=\"affine\" gainprm=\"36\" biasprm=\"0 -36 -1.8\"/>";
    let read = |actuators: &str| {
        let file = ARM.replace(position, actuators);
        arm(&file).model(&format!("{OF_ARM}{table}"))
    };
    let known = read(general).expect("a servo").parameters;
    let kp = known.iter().find(|p| p.name == "elbow.kp").expect("it is there");
    assert_eq!(kp.value, 36.0);
    for other in [
        "<motor joint=\"elbow\"/>",
        "<velocity joint=\"elbow\" kv=\"3\"/>",
        "<position joint=\"elbow\" kp=\"4\"/><velocity joint=\"elbow\" kv=\"3\"/>",
        "<position joint=\"elbow\" kp=\"4\" timeconst=\"0.1\"/>",
        "<position joint=\"elbow\" kp=\"4\" forcerange=\"-1 2\"/>",
        "<general joint=\"elbow\" gainprm=\"36\" biasprm=\"0 -36 -1.8\"/>",
        "<general joint=\"elbow\" biastype=\"affine\" gainprm=\"36\" biasprm=\"0 -30 -1.8\"/>",
    ] {
        let error = read(other).expect_err(other);
        assert!(error.contains("needs kp"), "{other}: {error}");
    }
}

#[test]
fn a_command_of_a_robot_has_a_name_of_its_own() {
    let table = |command: &str| {
        format!(
            "{OF_ARM}[[actuator]]\ntemplate = \"pd_servo\"\nchannel = \"elbow\"\ncommand = \"{command}\"\n"
        )
    };
    let folder = arm(ARM);
    let error = folder.model(&table("shoulder_torque")).expect_err("taken");
    assert!(error.contains("declared twice") && error.contains("model.toml:7:11"), "{error}");
    let model = folder.model(&table("goal")).expect("a model");
    assert_eq!(model.inputs[1].name, "goal");
}

const BARE: &str = "[[actuator]]\ntemplate = \"pd_servo\"\nchannel = \"elbow\"\n\
    kp = { value = 17.8, unit = \"N m/rad\" }\nkd = { value = 0.6, unit = \"N m s/rad\" }\n";
const WITHIN: &str = "[[effect]]\nclass = \"saturation\"\nchannel = \"elbow_command\"\n\
    limit = { value = 1900, unit = \"mN m\" }\n[[effect]]\nclass = \"dead_zone\"\n\
    channel = \"elbow_command\"\nhalf_width = { value = 0.025, unit = \"rad\" }\n";

/// A dead zone and a limit on a command act behind its comparison with the position.
#[test]
fn effects_act_within_a_servo() {
    let (stated, found) = (with_servo(SERVO), with_servo(&format!("{BARE}{WITHIN}")));
    assert!(differ(&run(&stated, 1), &run(&found, 1)) < 1e-12);
    assert!(differ(&run(&stated, 1), &run(&with_servo(BARE), 1)) > 1e-2);
    // Beside what is stated: the smaller limit, and both bands.
    let both = with_servo(&format!("{SERVO}{WITHIN}"));
    let wide = with_servo(&SERVO.replace("value = 0.05", "value = 0.1"));
    assert!(differ(&run(&both, 1), &run(&wide, 1)) < 1e-12);
    // On a torque they act as ever.
    let units = |model: &Model| {
        let units = |e: &ModelEffect| model.effect_units(e.effect, 0, None);
        model.effects.iter().flat_map(units).collect::<Vec<_>>()
    };
    assert_eq!(units(&found), ["N m", "rad"]);
}

/// A step's derivatives by what acts within a servo are those of differences.
#[test]
fn derivatives_by_what_acts_within_a_servo_are_exact() {
    let table = "[[actuator]]\ntemplate = \"pd_servo\"\nchannel = \"elbow\"\n";
    let within = WITHIN.replace("1900", "5000");
    let of_robot = format!("{OF_ARM}{table}{within}");
    let robot = arm(ARM).model(&of_robot).expect("a model");
    let joint = with_servo(&format!("{BARE}{WITHIN}"));
    // In the band's slope, and at the limit.
    for (model, inputs) in [(&joint, vec![0.05]), (&joint, vec![0.9]), (&robot, vec![0.0, 0.9])] {
        let machine: Vec<f64> = (0..model.machine_states()).map(|k| 0.01 * k as f64).collect();
        let advance = |effects: &[ModelEffect]| {
            let system = System::with(model, &model.values(), effects);
            let mut state = system.at_rest(&machine);
            let input = StepInput::Line(&inputs, &inputs);
            system.advance(
                &mut system.workspace(),
                (0.0, 0.01),
                input,
                Substeps::even(2),
                &mut state,
            );
            state
        };
        for effect in 0..2 {
            let along = [(Direction::Effect(effect, 0), 0)];
            let system = System::along(model, &model.values(), &model.effects, &along, 0.01);
            let constant = |x: &f64| Dual::constant(*x);
            let mut state: Vec<Dual> = machine.iter().map(constant).collect();
            let held: Vec<Dual> = inputs.iter().map(constant).collect();
            let input = StepInput::Line(&held, &held);
            system.advance(
                &mut system.workspace(),
                (0.0, 0.01),
                input,
                Substeps::even(2),
                &mut state,
            );
            let moved = |by: f64| {
                let mut effects = model.effects.clone();
                effects[effect].parameters[0] += by;
                advance(&effects)
            };
            for ((above, below), exact) in moved(1e-6).iter().zip(moved(-1e-6)).zip(&state) {
                let slope = (above - below) / 2e-6;
                assert!((slope - exact.tangent[0]).abs() < 1e-6, "{effect}: {slope} {exact:?}");
            }
        }
    }
}
