//! Units of effects on the channels of a model.

use lacuna_effects::find;
use lacuna_plants::Model;

const MODEL: &str = r#"
name = "motor on a slide"
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
mass = [["1", "0"], ["0", "1"]]
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

/// A first-order state is its own velocity: a smoothing velocity is in the state's unit.
#[test]
fn effects_carry_the_units_of_their_channel() {
    let model = Model::from_text(MODEL, "model.toml").expect("a model");
    let table: &[(&str, usize, &[&str])] = &[
        ("coulomb_friction", 0, &["N", "m/s"]),
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
        let effect = find(class).expect("in the catalogue");
        assert_eq!(model.effect_units(effect, *channel), *expected, "{class} on {channel}");
    }
}
