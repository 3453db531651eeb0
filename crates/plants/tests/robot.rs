//! A model whose equations are those of a robot's own file.

mod support;

use lacuna_numbers::{Dual, LANES, Number};
use lacuna_plants::model::{
    Augmentation, Direction, ModelEffect, NewEffect, StepInput, Strand, Uncertainty, Workspace,
    advance_together,
};
use lacuna_plants::{Model, Plant, Substeps, System};
use support::Folder;

/// Two links that swing in the x-z plane, a slide at the end, and a gripper.
const ARM: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 -0.2"/><mass value="2"/>
    <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.003"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0.01 0 -0.1"/><mass value="1"/>
    <inertia ixx="0.01" ixy="0" ixz="0.001" iyy="0.01" iyz="0" izz="0.001"/></inertial></link>
  <link name="tool"><inertial><origin xyz="0 0 0"/><mass value="0.5"/>
    <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial></link>
  <link name="finger"><inertial><origin xyz="0 0 0"/><mass value="0.1"/>
    <inertia ixx="0.0001" ixy="0" ixz="0" iyy="0.0001" iyz="0" izz="0.0001"/></inertial></link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
    <axis xyz="0 1 0"/><dynamics damping="0.4" friction="0.2"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="0 0 -0.4"/><axis xyz="0 1 0"/></joint>
  <joint name="slide" type="prismatic"><parent link="lower"/><child link="tool"/>
    <origin xyz="0 0 -0.2"/><axis xyz="0 0 -1"/>
    <limit lower="0" upper="1" effort="9" velocity="9"/></joint>
  <joint name="grip_left" type="revolute"><parent link="tool"/><child link="finger"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="1" effort="9" velocity="9"/></joint>
</robot>
"#;

const MODEL: &str = r#"name = "arm"
[robot]
file = "arm.urdf"
locked = ["grip_*"]
tolerance = { mass = 0.05, com = 0.01, inertia = 0.1 }
"#;

fn arm() -> Folder {
    let folder = Folder::new();
    folder.write("arm.urdf", ARM);
    folder
}

#[test]
fn its_joints_are_the_models_coordinates() {
    let model = arm().model(MODEL).expect("a model");
    let names: Vec<_> = (0..6).map(|s| (model.state_name(s), model.state_unit(s))).collect();
    let expected = [
        ("shoulder", "rad"),
        ("elbow", "rad"),
        ("slide", "m"),
        ("shoulder_vel", "rad/s"),
        ("elbow_vel", "rad/s"),
        ("slide_vel", "m/s"),
    ];
    assert_eq!(names, expected.map(|(name, unit)| (name, unit.to_owned())));
    let inputs: Vec<_> = model.inputs.iter().map(|i| (&*i.name, &*i.unit)).collect();
    let torques = [("shoulder_torque", "N m"), ("elbow_torque", "N m"), ("slide_force", "N")];
    assert_eq!(inputs, torques);
    assert_eq!(model.force_unit(0), "N m");
    assert_eq!(model.force_unit(2), "N");
    let find = |name: &str| model.parameters.iter().find(|p| p.name == name).expect("it is there");
    assert_eq!(find("lower.mass").std(), 0.05);
    assert_eq!(find("lower.com_x").std(), 0.01);
    // The finger is a part of the tool.
    assert!((find("tool.mass").value - 0.6).abs() < 1e-15);
    assert_eq!((find("shoulder.damping").value, find("slide.damping").std()), (0.4, 0.0));
    // The upper arm turns about y alone: of its inertia nothing else can matter.
    let uncertain = |name: &str| find(name).std() > 0.0;
    assert!(uncertain("upper.inertia_yy") && !uncertain("upper.inertia_xx"));
    assert!(!uncertain("upper.com_y") && uncertain("upper.com_z"));
}

/// What tells the finger apart from the tool that it is fixed to.
const FINGER: &str = "[parameters]\n\"finger.mass\" = { value = 0.1, tolerance = 0.3 }\n";

/// The state's rates, with derivatives by all that they depend on, against differences.
#[test]
fn derivatives_are_exact() {
    for text in [MODEL.to_owned(), format!("{MODEL}{FINGER}")] {
        are_exact(&arm().model(&text).expect("a model"));
    }
}

fn are_exact(model: &Model) {
    let values = model.values();
    let sizes = model.dynamics().sizes();
    let variables: Vec<f64> =
        (0..sizes.variables()).map(|k| (1.7 * k as f64).sin() * 0.8 + 0.1).collect();
    let rates = |values: &[f64], variables: &[f64]| {
        let mut rates = vec![0.0; sizes.rates()];
        model.dynamics().bind(values).evaluate_once(variables, &mut rates);
        rates
    };
    let all: Vec<f64> = values.iter().chain(&variables).copied().collect();
    let mut largest = 0.0f64;
    for first in (0..all.len()).step_by(LANES) {
        let along: Vec<Dual> =
            all.iter().enumerate().map(|(k, x)| Dual::among(*x, k, first)).collect();
        let (parameters, at) = along.split_at(values.len());
        let mut exact = vec![Dual::constant(0.0); sizes.rates()];
        model.dynamics().bind_dual(parameters).evaluate_once(at, &mut exact);
        for (lane, k) in (first..all.len()).take(LANES).enumerate() {
            let moved = |by: f64| {
                let mut all = all.clone();
                all[k] += by;
                let (values, variables) = all.split_at(values.len());
                rates(values, variables)
            };
            const STEP: f64 = 1e-5;
            for ((above, below), exact) in moved(STEP).iter().zip(moved(-STEP)).zip(&exact) {
                let slope = (above - below) / (2.0 * STEP);
                let off = (slope - exact.tangent[lane]).abs();
                assert!(off < 1e-6 * (1.0 + slope.abs()), "{k}: {slope} {}", exact.tangent[lane]);
                largest = largest.max(slope.abs());
            }
        }
    }
    assert!(largest > 1.0);
}

const EFFECTS: &str = r#"
[[effect]]
class = "added_inertia"
channel = "shoulder"
inertia = 0.05
[[effect]]
class = "hysteresis"
channel = "elbow"
stiffness = 2
beta = 3
gamma = 2
"#;

const SAMPLES: usize = 40;
const SAMPLE: f64 = 0.01;

/// Inputs at a sample.
fn driven(k: usize) -> [f64; 3] {
    let t = SAMPLE * k as f64;
    [3.0 * (4.0 * t).sin(), (7.0 * t).cos(), 2.0 * (3.0 * t).sin() - 5.0]
}

/// Where a simulation ends that begins at `all`: parameters, internal parameters of both effects, state.
fn end(model: &Model, all: &[f64]) -> Vec<f64> {
    let (parameters, rest) = all.split_at(model.parameters.len());
    let mut effects = model.effects.clone();
    effects[0].set_internal(&rest[..1]);
    effects[1].set_internal(&rest[1..4]);
    let system = System::with(model, parameters, &effects);
    let (mut x, mut w) = (rest[4..].to_vec(), system.workspace());
    for k in 0..SAMPLES {
        let t = SAMPLE * k as f64;
        let u = driven(k);
        system.advance(&mut w, (t, t + SAMPLE), StepInput::Line(&u, &u), Substeps::even(2), &mut x);
    }
    x
}

/// The derivatives of a whole simulation, all directions side by side, against differences.
#[test]
fn a_simulation_carries_its_derivatives() {
    for apart in ["", FINGER] {
        carries_its_derivatives(
            &arm().model(&format!("{MODEL}{apart}{EFFECTS}")).expect("a model"),
        );
    }
}

fn carries_its_derivatives(model: &Model) {
    let mut all = model.values();
    all.extend(model.effects.iter().flat_map(ModelEffect::internal));
    let parameters = model.parameters.len();
    let from = all.len();
    all.extend([0.3, -0.4, 0.1, 0.1, 0.5, -0.2, 0.02]);
    let direction = |k: usize| match k {
        k if k < parameters => Direction::Parameter(k),
        k if k == parameters => Direction::Effect(0, 0),
        k => Direction::Effect(1, k - parameters - 1),
    };
    let systems: Vec<System<Dual>> = (0..all.len())
        .step_by(LANES)
        .map(|first| {
            let lanes = (first..from.min(first + LANES)).map(|k| (direction(k), k - first));
            let lanes: Vec<_> = lanes.collect();
            System::along(model, &model.values(), &model.effects, &lanes, SAMPLE)
        })
        .collect();
    let mut rooms: Vec<Workspace<Dual>> = systems.iter().map(System::workspace).collect();
    let begin = |chunk: usize| -> Vec<Dual> {
        let state = all.iter().enumerate().skip(from);
        state.map(|(k, x)| Dual::among(*x, k, chunk * LANES)).collect()
    };
    let mut states: Vec<Vec<Dual>> = (0..systems.len()).map(begin).collect();
    for k in 0..SAMPLES {
        let t = SAMPLE * k as f64;
        let u = driven(k).map(Dual::constant);
        let inputs = StepInput::Line(&u, &u);
        let parts = systems.iter().zip(&mut rooms).zip(&mut states);
        let mut strands: Vec<Strand<Dual>> = parts
            .map(|((system, workspace), state)| Strand { system, workspace, inputs, state })
            .collect();
        advance_together(&mut strands, (t, t + SAMPLE), Substeps::even(2));
    }
    let plain = end(model, &all);
    for state in &states {
        for (x, plain) in state.iter().zip(&plain) {
            assert!((x.value - plain).abs() < 1e-12 * (1.0 + plain.abs()));
        }
    }
    let mut largest = 0.0f64;
    for k in 0..all.len() {
        const STEP: f64 = 1e-6;
        let moved = |by: f64| {
            let mut all = all.clone();
            all[k] += by;
            end(model, &all)
        };
        for (i, (above, below)) in moved(STEP).iter().zip(moved(-STEP)).enumerate() {
            let (slope, exact) = ((above - below) / (2.0 * STEP), states[k / LANES][i]);
            let exact = exact.tangent[k % LANES];
            assert!((slope - exact).abs() < 1e-6 * (1.0 + slope.abs()), "{k}: {slope} {exact}");
            largest = largest.max(slope.abs());
        }
    }
    assert!(largest > 1.0);
}

/// Without friction and torque its energy stays: that of the bodies' motion in M, and of their height.
#[test]
fn energy_is_kept() {
    let folder = arm();
    let free = format!(
        "{MODEL}[parameters]\n\"shoulder.damping\" = {{ value = 0 }}\n\"shoulder.friction\" = {{ value = 0 }}\n"
    );
    let model = folder.model(&free).expect("a model");
    let system = System::new(&model);
    let mut state = vec![0.4, -0.9, 0.1, 1.0, -2.0, 0.3];
    let energy = |state: &[f64]| {
        let mut rates = vec![0.0; model.dynamics().sizes().rates()];
        let mut variables = state.to_vec();
        variables.extend([0.0; 4]);
        model.dynamics().bind(&model.values()).evaluate_once(&variables, &mut rates);
        let v = &state[3..];
        let kinetic: f64 = (0..9).map(|k| 0.5 * v[k / 3] * rates[k] * v[k % 3]).sum();
        // Turned by a about y the x axis sinks: (x, z) -> (x cos a + z sin a, z cos a - x sin a).
        let height = |x: f64, z: f64, a: f64| z * a.cos() - x * a.sin();
        let (a, b, s) = (state[0], state[0] + state[1], state[2]);
        let elbow = height(0.0, -0.4, a);
        kinetic
            + 9.81
                * (2.0 * height(0.0, -0.2, a)
                    + (elbow + height(0.01, -0.1, b))
                    + 0.6 * (elbow + height(0.0, -0.2 - s, b)))
    };
    let before = energy(&state);
    let h = 1e-3;
    let slope = |state: &[f64]| {
        let mut d = vec![0.0; 6];
        system.derivative(0.0, state, &[0.0; 3], &mut d);
        d
    };
    let step = |x: &[f64], d: &[f64], h: f64| -> Vec<f64> {
        x.iter().zip(d).map(|(x, d)| x + h * d).collect()
    };
    for _ in 0..500 {
        let k1 = slope(&state);
        let k2 = slope(&step(&state, &k1, 0.5 * h));
        let k3 = slope(&step(&state, &k2, 0.5 * h));
        let k4 = slope(&step(&state, &k3, h));
        for (i, x) in state.iter_mut().enumerate() {
            *x += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
        }
    }
    assert!((energy(&state) - before).abs() < 1e-8 * before.abs(), "{before} {}", energy(&state));
}

#[test]
fn what_is_found_is_written_beside_the_robot() {
    let folder = arm();
    let text = format!(
        "{MODEL}[parameters]\n\"slide.armature\" = {{ value = 0.2, unit = \"kg\", std = 0.1 }}\n"
    );
    let model = folder.model(&text).expect("a model");
    let armature = model.parameters.iter().find(|p| p.name == "slide.armature").expect("it");
    assert_eq!((armature.value, armature.uncertainty), (0.2, Uncertainty::Absolute(0.1)));
    let found = NewEffect {
        effect: lacuna_effects::find("coulomb_friction").expect("in the catalogue"),
        channel: "elbow".to_owned(),
        other: None,
        parameters: vec![(0.7, Some(0.1), "N m".to_owned()), (0.01, None, "rad/s".to_owned())],
    };
    let parameters =
        vec![("lower.mass".to_owned(), 1.07, 0.01), ("slide.armature".to_owned(), 0.25, 0.02)];
    let written =
        model.augmented_text(&Augmentation { parameters, effects: vec![found] }).expect("text");
    // Read from another folder.
    let again = Model::from_text(&written, "/nowhere/augmented.toml").expect("a model");
    let value = |name: &str| again.parameters.iter().find(|p| p.name == name).expect("it").value;
    assert_eq!((value("lower.mass"), value("slide.armature")), (1.07, 0.25));
    let mass = again.parameters.iter().find(|p| p.name == "lower.mass").expect("it");
    assert_eq!(mass.std(), 0.05, "how sure the model was stays as it was");
    assert_eq!(again.effects.len(), 1);
    assert_eq!(
        again.effect_channel_name(again.effects[0].effect, again.effects[0].channel),
        "elbow"
    );
}

/// A link that is fixed to another is a part of it, unless the model file says something of its inertia.
#[test]
fn a_fixed_link_is_told_apart_where_it_is_named() {
    let folder = arm();
    let rates = |model: &Model| {
        let sizes = model.dynamics().sizes();
        let variables: Vec<f64> = (0..sizes.variables()).map(|k| (1.3 * k as f64).sin()).collect();
        let mut rates = vec![0.0; sizes.rates()];
        model.dynamics().bind(&model.values()).evaluate_once(&variables, &mut rates);
        rates
    };
    let alike = |a: &Model, b: &Model| {
        rates(a).iter().zip(rates(b)).all(|(a, b)| (a - b).abs() < 1e-13 * (1.0 + b.abs()))
    };
    let whole = folder.model(MODEL).expect("a model");
    let apart = folder.model(&format!("{MODEL}{FINGER}")).expect("a model");
    let find = |model: &Model, name: &str| {
        let parameter = model.parameters.iter().find(|p| p.name == name);
        parameter.map(|p| (p.value, p.std(), p.unit.clone()))
    };
    assert_eq!(find(&whole, "finger.mass"), None);
    assert_eq!(find(&apart, "finger.mass"), Some((0.1, 0.03, "kg".to_owned())));
    assert_eq!(find(&apart, "finger.com_x"), Some((0.0, 0.01, "m".to_owned())));
    assert_eq!(find(&apart, "tool.mass").map(|p| p.0), Some(0.5));
    assert!(alike(&apart, &whole));
    // Another mass of the finger is what its own file would say, where and how the finger stands.
    let turned = ARM.replace(
        "<child link=\"finger\"/>",
        "<child link=\"finger\"/><origin xyz=\"0.02 -0.05 0.1\" rpy=\"0.3 -0.5 1.1\"/>",
    );
    folder.write("arm.urdf", &turned);
    let heavy = folder.model(&format!("{MODEL}{}", FINGER.replace("0.1", "0.7"))).expect("a model");
    folder.write("arm.urdf", turned.replace("mass value=\"0.1\"", "mass value=\"0.7\""));
    let its_own = folder.model(MODEL).expect("a model");
    assert!(alike(&heavy, &its_own) && !alike(&heavy, &apart));
    // Where all that has mass is told apart, it is moved all the same.
    let flange = ARM.replace("<mass value=\"0.5\"/>", "<mass value=\"0\"/>");
    folder.write("arm.urdf", flange.replace("\"0.001\"", "\"0\""));
    folder.model(&format!("{MODEL}{FINGER}")).expect("the finger has mass");
    // Of what no mass is known, something may be believed.
    let payload = FINGER.replace("0.1, tolerance = 0.3", "0, std = 0.5").replace("finger", "base");
    let said = folder.model(&format!("{MODEL}{payload}")).expect_err("the base stands still");
    assert!(said.contains("base.mass"), "{said}");
}

#[test]
fn its_text_may_stand_in_the_model_file() {
    let folder = arm();
    let inline = format!("text = '''\n{ARM}'''");
    let text = MODEL.replace("file = \"arm.urdf\"", &inline);
    let (own, named) = (Model::from_text(&text, "m.toml"), folder.model(MODEL));
    let (own, named) = (own.expect("a model"), named.expect("a model"));
    assert_eq!((own.parameters.clone(), own.inputs.clone()), (named.parameters, named.inputs));
    // It is written as it was read.
    let written = own.augmented_text(&Augmentation::default()).expect("a text");
    assert_eq!(Model::from_text(&written, "m.toml").expect("a model").parameters, own.parameters);
    let said = |text: &str| Model::from_text(text, "m.toml").expect_err("a mistake").to_string();
    let heavy = said(&text.replace("value=\"2\"", "value=\"-2\""));
    assert!(heavy.contains("m.toml") && heavy.contains("line 3 of the robot's text"), "{heavy}");
    assert!(said(&MODEL.replace("file = \"arm.urdf\"\n", "")).contains("found neither"));
    assert!(said(&text.replace("text =", "file = \"arm.urdf\"\ntext =")).contains("found both"));
}

#[test]
fn mistakes_are_told_with_their_place() {
    let folder = arm();
    let cases: [(&str, &str, &[&str]); 9] = [
        ("arm.urdf", "leg.urdf", &["model.toml:3", "leg.urdf", "cannot be read"]),
        ("grip_*", "wrist_*", &["model.toml:4", "wrist_*", "shoulder, elbow, slide, grip_left"]),
        ("mass = 0.05", "mass = -1", &["model.toml:5", "0 or more"]),
        ("mass = 0.05", "weight = 1", &["model.toml:5", "weight"]),
        (
            "[robot]",
            "[[coordinate]]\nname = \"q\"\nvelocity = \"v\"\n[robot]",
            &["[[coordinate]]", "[robot]"],
        ),
        (
            "[robot]",
            "[parameters]\n\"hand.mass\" = { value = 1 }\n[robot]",
            &["model.toml:3", "hand.mass"],
        ),
        ("[robot]", "[[input]]\nname = \"u\"\n[robot]", &["'u'", "slide_force"]),
        (
            "[robot]",
            "[[measurement]]\ncolumn = \"c\"\nof = \"grip_left\"\n[robot]",
            &["grip_left", "elbow_vel"],
        ),
        ("locked = [\"grip_*\"]", "gravity = [0, 0, inf]", &["gravity", "finite"]),
    ];
    for (from, to, words) in cases {
        let said = folder.model(&MODEL.replace(from, to)).expect_err(to);
        for word in words {
            assert!(said.contains(word), "{to}: {said}");
        }
    }
    // Mistakes in the robot's file are told with its own lines.
    folder.write("arm.urdf", ARM.replace("value=\"2\"", "value=\"-2\""));
    let said = folder.model(MODEL).expect_err("a negative mass");
    assert!(said.contains("arm.urdf:3") && said.contains("upper"), "{said}");
    // A link that weighs nothing cannot be simulated, but for its rotor.
    let weightless = ARM.replace("<mass value=\"0.5\"/>", "<mass value=\"0\"/>");
    let weightless = weightless.replace("<mass value=\"0.1\"/>", "<mass value=\"0\"/>");
    folder.write("arm.urdf", weightless);
    let said = folder.model(MODEL).expect_err("no inertia");
    assert!(said.contains("'slide' moves what has no inertia: link 'tool'"), "{said}");
    let rotor = format!("{MODEL}[parameters]\n\"slide.armature\" = {{ value = 0.2, std = 0.1 }}\n");
    folder.model(&rotor).expect("a rotor has inertia");
    // Inertia that its file rounds to 0 is that of a rotor, as large as what the joint before it moves.
    let rounded = ARM.replace("\"0.0001\"", "\"0.000\"");
    folder.write("arm.urdf", rounded);
    let model = folder.model(&MODEL.replace("\"grip_*\"", "")).expect("a rotor stands for it");
    let rotor = model.parameters.iter().find(|p| p.name == "grip_left.armature").expect("it");
    assert!(rotor.value > 0.0 && rotor.std() == rotor.value, "{}", rotor.value);
    assert!(model.assumptions[0].contains("'grip_left'"), "{:?}", model.assumptions);
}

#[test]
fn a_robots_file_is_a_model() {
    let folder = arm();
    let model = Model::read(&folder.file("arm.urdf")).expect("a model");
    assert_eq!((&*model.name, model.coordinates.len()), ("arm", 4));
    assert!(model.parameters.iter().all(|p| p.std() == 0.0));
}

/// A pendulum on a spring, in degrees, as MuJoCo's files are, with a field of gravity of its own.
const PENDULUM: &str = r#"<mujoco model="pendulum"><option gravity="0 0 -2"/><worldbody>
  <body name="rod"><joint name="pivot" axis="0 1 0" stiffness="3" springref="30" armature="0.5"/>
    <inertial pos="0 0 -0.5" mass="2" diaginertia="0.1 0.1 0.1"/></body>
</worldbody></mujoco>
"#;

#[test]
fn an_mjcf_is_a_model() {
    let folder = arm();
    folder.write("rod.xml", PENDULUM);
    let model = Model::read(&folder.file("rod.xml")).expect("a model");
    let find = |name: &str| model.parameters.iter().find(|p| p.name == name).expect("it is there");
    let stiffness = find("pivot.stiffness");
    assert_eq!((stiffness.value, &*stiffness.unit, stiffness.std()), (3.0, "N m/rad", 0.0));
    assert_eq!(find("pivot.armature").value, 0.5);
    let acceleration = |model: &Model, angle: f64| {
        let mut rates = [0.0; 2];
        System::new(model).derivative(0.0, &[angle, 0.0], &[0.0], &mut rates);
        rates[1]
    };
    let expected = |gravity: f64, angle: f64| {
        let spring = 3.0 * (angle - std::f64::consts::FRAC_PI_6);
        (-gravity * 2.0 * 0.5 * angle.sin() - spring) / (0.1 + 2.0 * 0.25 + 0.5)
    };
    for angle in [0.0, 0.4, 2.0] {
        assert!((acceleration(&model, angle) - expected(2.0, angle)).abs() < 1e-12);
        let text = "name = \"rod\"\n[robot]\nfile = \"rod.xml\"\ngravity = [0, 0, -5]\n";
        let heavier = folder.model(text).expect("a model");
        assert!((acceleration(&heavier, angle) - expected(5.0, angle)).abs() < 1e-12);
    }
    // The text says what it is, whatever the file is called.
    folder.write("rod.txt", PENDULUM);
    assert_eq!(Model::read(&folder.file("rod.txt")).expect("a model").name, "rod");
    folder.write("rod.xml", PENDULUM.replace("mass=\"2\"", ""));
    let said = Model::read(&folder.file("rod.xml")).expect_err("no mass").to_string();
    assert!(said.contains("rod.xml:3") && said.contains("'mass'"), "{said}");
    folder.write("rod.xml", "<sdf/>");
    let said = Model::read(&folder.file("rod.xml")).expect_err("another format").to_string();
    assert!(said.contains("<mujoco> (MJCF)") && said.contains("<sdf>"), "{said}");
}
