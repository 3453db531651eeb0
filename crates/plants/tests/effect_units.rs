//! Units of effects on the channels of a model: what is said of them, and what can be written.

mod support;

use lacuna_effects::find;
use lacuna_plants::model::{Augmentation, NewEffect, StepInput, System};
use lacuna_plants::{Model, Substeps};
use support::read;

const MODEL: &str = r#"
name = "motor on a slide"
[parameters]
J = { value = 0.2, unit = "kg m^2" }
[[input]]
name = "u"
unit = "V"
[[coordinate]]
name = "x"
velocity = "v"
unit = "m"
[[coordinate]]
name = "phi"
velocity = "omega"
unit = "rad"
[mechanics]
mass = [["1", "0"], ["0", "J"]]
force = ["u", "i"]
[[state]]
name = "i"
unit = "A"
derivative = "u - i"
[[state]]
name = "speed"
unit = "m/s"
derivative = "u - speed"
"#;

fn units(model: &Model, class: &str, channel: usize) -> Vec<String> {
    model.effect_units(find(class).expect("in the catalogue"), channel, None)
}

/// A first-order state is its own velocity: a smoothing velocity is in the state's unit. What acts
/// beside an input is in its unit; an armature current beside a torque says nothing.
#[test]
fn effects_carry_the_units_of_their_channel() {
    let model = read(MODEL);
    let table: &[(&str, usize, &[&str])] = &[
        ("coulomb_friction", 0, &["V", "m/s"]),
        ("coulomb_friction", 1, &["N m", "rad/s"]),
        ("coulomb_friction", 2, &["A/s", "A"]),
        ("coulomb_friction", 3, &["m/s^2", "m/s"]),
        ("linear_loss", 2, &["1/s"]),
        ("linear_loss", 3, &["1/s"]),
        ("quadratic_loss", 3, &["1/m"]),
        ("saturation", 0, &["V"]),
        // Sensors count the machine's states: x, phi, v, omega, i, speed.
        ("sensor_bias", 3, &["rad/s"]),
        ("sensor_bias", 5, &["m/s"]),
    ];
    for (class, channel, expected) in table {
        assert_eq!(units(&model, class, *channel), *expected, "{class} on {channel}");
    }
}

/// One coordinate `q`, one input `u`; the effects follow.
fn slide(unit: &str, parameters: &str, input: &str, mass: &str, force: &str) -> String {
    format!(
        "name = \"slide\"\n[parameters]\n{parameters}\n[[input]]\nname = \"u\"\nunit = \"{input}\"\n\
         [[coordinate]]\nname = \"q\"\nvelocity = \"dq\"\nunit = \"{unit}\"\n\
         [mechanics]\nmass = [[\"{mass}\"]]\nforce = [\"{force}\"]\n"
    )
}

const KILOGRAMS: &str = r#"m = { value = 2, unit = "kg" }"#;
const INERTIA: &str = r#"m = { value = 2, unit = "kg m^2" }"#;

/// What the equations are in, and nothing else: in mm and kg a force is in kg mm/s^2 = mN; in
/// degrees a torque is in kg m^2 deg/s^2, unless the equations turn them to radians.
#[test]
fn a_force_is_in_the_unit_of_the_equations() {
    let rows = [
        ("m", KILOGRAMS, "N", "m", "u", "N"),
        ("m", KILOGRAMS, "N", "m", "-u", "N"),
        ("mm", KILOGRAMS, "N", "m", "1000*u", "kg mm/s^2"),
        ("mm", r#"m = { value = 2, unit = "g" }"#, "uN", "m", "u", "uN"),
        ("cm", KILOGRAMS, "V", "m", "3*u", "kg cm/s^2"),
        ("deg", INERTIA, "N m", "m", "57.29577951308232*u", "kg m^2 deg/s^2"),
        ("deg", INERTIA, "N*m", "m*pi/180", "u - 0.1*dq", "N m"),
        ("rad", INERTIA, "V", "m", "0.2*u - 0.1*q", "N m"),
        ("rad", "m.value = 1", "Nm", "1", "u - sin(q)", "N m"),
        ("rad", "m.value = 1", "kNm", "1", "max(u, 0)", "kNm"),
        ("V", r#"k = { value = 3, unit = "1/s^2" }"#, "V", "1", "k*u - k*q", "force"),
        ("V", "k.value = 1", "V/s^2", "1", "u - q", "V/s^2"),
        // A coefficient that is 1 today is none of the number 1.
        ("m", r#"k = { value = 1, unit = "N/V" }"#, "V", "1", "k*u", "force"),
        ("m", "", "", "1", "u", "force"),
        // Equations in two units at once are in none that could be said.
        ("mm", KILOGRAMS, "N", "m", "u", "force"),
        ("deg", INERTIA, "N m", "m", "u", "force"),
    ];
    for (unit, parameters, input, mass, force, expected) in rows {
        let model = read(&slide(unit, parameters, input, mass, force));
        assert_eq!(model.force_unit(0), expected, "{unit} {parameters} {input} {mass} {force}");
    }
}

#[test]
fn stiffnesses_and_coefficients_follow() {
    let of = |text: &str, class| units(&read(text), class, 0);
    let mm = slide("mm", KILOGRAMS, "N", "m", "1000*u");
    assert_eq!(of(&mm, "linear_stiffness"), ["kg/s^2"]);
    assert_eq!(of(&mm, "viscous_friction"), ["kg/s"]);
    assert_eq!(of(&mm, "added_inertia"), ["kg"]);
    assert_eq!(of(&mm, "coulomb_friction"), ["kg mm/s^2", "mm/s"]);
    let deg = slide("deg", INERTIA, "N m", "m*pi/180", "u");
    assert_eq!(of(&deg, "linear_stiffness"), ["N m/deg"]);
    assert_eq!(of(&deg, "cogging"), ["N m", "1/deg", "rad"]);
    assert_eq!(of(&deg, "periodic_disturbance"), ["N m", "rad/s", "rad", "s"]);
    let unsaid = slide("mm", "", "", "1", "u");
    assert_eq!(of(&unsaid, "linear_stiffness"), ["force/mm"]);
}

fn with(effect: &str, model: &str) -> Result<Vec<f64>, String> {
    let text = format!("{model}[[effect]]\nchannel = \"q\"\n{effect}\n");
    Model::from_text(&text, "model.toml")
        .map(|m| m.effects[0].parameters.clone())
        .map_err(|e| e.to_string())
}

/// However it is spelled, and converted where it is another unit of the same kind.
#[test]
fn units_are_compared_by_what_they_measure() {
    let arm = slide("rad", INERTIA, "N m", "m", "u");
    for unit in ["N m", "N*m", "Nm", "kg m^2 s^-2", "kg m^2/s^2", "J", "N m/rad"] {
        let effect = format!(
            "class = \"coulomb_friction\"\nmagnitude = {{ value = 2.35, unit = \"{unit}\" }}"
        );
        assert_eq!(with(&effect, &arm).unwrap()[0], 2.35, "{unit}");
    }
    let effect = "class = \"coulomb_friction\"\n\
         magnitude = { value = 2350, std = 30, unit = \"N mm\" }\n\
         smoothing_velocity = { value = 3, unit = \"deg/s\" }";
    let text = format!("{arm}[[effect]]\nchannel = \"q\"\n{effect}\n");
    let model = read(&text);
    let found = &model.effects[0];
    let close = |a: f64, b: f64| (a - b).abs() < 1e-12 * b;
    assert!(close(found.parameters[0], 2.35) && close(found.std[0].unwrap(), 0.03));
    assert!(close(found.parameters[1], 3f64.to_radians()));
    // A frequency in Hz counts turns.
    let sine = "class = \"periodic_disturbance\"\namplitude = 1\n\
         angular_frequency = { value = 2, unit = \"Hz\" }";
    assert!(close(with(sine, &arm).unwrap()[1], 4.0 * std::f64::consts::PI));
    let phase = |unit: &str| {
        let sine = "class = \"periodic_disturbance\"\namplitude = 1\nangular_frequency = 2";
        with(&format!("{sine}\nphase = {{ value = 90, unit = \"{unit}\" }}"), &arm).unwrap()[2]
    };
    assert_eq!([phase("rad"), phase("1")], [90.0; 2]);
    assert!(close(phase("deg"), std::f64::consts::FRAC_PI_2));
}

#[test]
fn units_that_do_not_fit_are_refused_with_their_place() {
    let arm = slide("rad", INERTIA, "N m", "m", "u");
    let friction = |unit: &str| {
        format!("class = \"coulomb_friction\"\nmagnitude = {{ value = 1, unit = \"{unit}\" }}")
    };
    let e = with(&friction("N"), &arm).unwrap_err();
    assert!(e.starts_with("model.toml:17:13: 'magnitude' is given in N; "), "{e}");
    assert!(e.contains("must be in N m: cannot convert 'N' (m kg s^-2) to 'N m'"), "{e}");
    let e = with(&friction("Mn m"), &arm).unwrap_err();
    assert!(e.starts_with("model.toml:17:13: ") && e.contains("'Mn' is not a known unit"), "{e}");
    let unsaid = slide("rad", "", "", "1", "u");
    for unit in ["N m", "force"] {
        assert_eq!(with(&friction(unit), &unsaid).unwrap()[0], 1.0, "nothing contradicts {unit}");
    }
}

#[test]
fn a_model_states_the_unit_of_a_force() {
    let state = |text: String, unit: &str| {
        text.replace("[mechanics]", &format!("force_unit = \"{unit}\"\n[mechanics]"))
    };
    let unsaid = slide("mm", "", "", "1", "u");
    let model = read(&state(unsaid, "mN"));
    assert_eq!(model.force_unit(0), "mN");
    let e = Model::from_text(&state(slide("mm", KILOGRAMS, "A", "m", "2*u"), "N"), "model.toml");
    let e = e.unwrap_err().to_string();
    assert!(e.starts_with("model.toml:11:14: "), "{e}");
    assert!(e.contains("said to be in N; by the unit of 'm' it is in kg mm/s^2"), "{e}");
    read(&state(slide("mm", KILOGRAMS, "A", "m", "2*u"), "mN"));
}

/// What is written of an effect reads back as the same effect.
#[test]
fn written_models_read_back() {
    for text in [
        slide("mm", KILOGRAMS, "N", "m", "1000*u"),
        slide("deg", INERTIA, "N m", "m*pi/180", "u"),
        slide("count", "", "", "1", "u"),
        slide("m", "", "count/s", "1", "3*u"),
    ] {
        let model = read(&text);
        for class in ["coulomb_friction", "cubic_stiffness", "periodic_disturbance", "cogging"] {
            let effect = find(class).expect("in the catalogue");
            let values = model.effect_units(effect, 0, None).into_iter().enumerate();
            let parameters: Vec<_> =
                values.map(|(k, unit)| (0.3 + k as f64, Some(0.1), unit)).collect();
            let new = NewEffect {
                effect,
                channel: "q".to_owned(),
                other: None,
                parameters: parameters.clone(),
            };
            let augmentation = Augmentation { effects: vec![new], ..Augmentation::default() };
            let written = model.augmented_text(&augmentation).unwrap();
            let back = read(&written);
            let expected: Vec<f64> = parameters.iter().map(|p| p.0).collect();
            assert_eq!(back.effects[0].parameters, expected, "{written}");
        }
    }
}

/// The angle of a gravity torque is in radians, whatever the coordinate's unit.
#[test]
fn a_gravity_torque_turns_degrees_to_radians() {
    let effect = "[[effect]]\nclass = \"gravity_torque\"\nchannel = \"q\"\nmagnitude = 3\n";
    // In rad, in deg with the torque in N m, and a carriage in mm.
    for (unit, si, mass) in
        [("rad", 1.0, "m"), ("deg", 1f64.to_radians(), "m*pi/180"), ("mm", 1e-3, "m/1000")]
    {
        let model = read(&format!("{}{effect}", slide(unit, INERTIA, "N m", mass, "u")));
        let system = System::new(&model);
        let mut state = vec![0.7 / si, 0.0];
        let input = StepInput::Line(&[0.0], &[0.0]);
        system.advance(&mut system.workspace(), (0.0, 1e-4), input, Substeps::even(1), &mut state);
        let expected = -3.0 * 0.7f64.sin() / 2.0 * 1e-4 / si;
        assert!((state[1] / expected - 1.0).abs() < 1e-6, "{unit}: {} {expected}", state[1]);
    }
}
