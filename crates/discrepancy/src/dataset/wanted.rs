//! Which columns of a file a model uses, and what they do between samples.

use lacuna_occupation::{InputPath, Names};
use lacuna_plants::model::Measured;
use lacuna_plants::{Hold, Model};
use lacuna_recordings::Wanted;

/// Of a model of equations: the columns of its measurements, and those with the name of a channel or an input that
/// no measurement speaks of.
pub(super) fn of_equations(model: &Model) -> Wanted {
    let is_measured = |of: Measured| model.measurements.iter().any(|m| m.of == of);
    let is_spoken_for = |name: &str| model.measurements.iter().any(|m| m.column == name);
    let is_imposed = |of| matches!(of, Measured::State(i) if model.is_imposed_state(i));
    let is_input = |of| matches!(of, Measured::Input(_));
    let named = (0..model.machine_states()).map(|i| (Measured::State(i), model.state_name(i)));
    let named: Vec<_> =
        named.filter(|(of, name)| !is_measured(*of) && !is_spoken_for(name)).collect();
    let by_column = model.measurements.iter().map(|m| (m.of, &*m.column));
    let plain_inputs = model.inputs.iter().enumerate().map(|(j, u)| (Measured::Input(j), &*u.name));
    let plain_inputs: Vec<_> = plain_inputs.filter(|(of, _)| !is_measured(*of)).collect();
    let names = |of: &[(Measured, &str)]| of.iter().map(|u| u.1.to_owned()).collect::<Vec<_>>();

    let of_positions = named.iter().filter(|(of, _)| {
        matches!(of, Measured::State(i) if model.imposed().any(|coordinate| coordinate == *i))
    });
    let of_positions: Vec<_> = of_positions.copied().collect();
    let needed: Vec<_> = by_column.chain(plain_inputs).collect();
    let all = needed.iter().chain(&named).copied();
    let measured: Vec<_> = all.filter(|u| !is_input(u.0) && !is_imposed(u.0)).collect();
    let inputs: Vec<_> = needed.iter().copied().filter(|u| is_input(u.0)).collect();
    let wanted = Wanted::only(&model.time_column, names(&named))
        .counting(model.time_seconds)
        .needing(names(&needed))
        .needing(names(&of_positions))
        .measuring(names(&measured));
    match model.hold {
        Hold::ZeroOrder => wanted.holding(names(&inputs)),
        Hold::Linear | Hold::BandLimited => wanted,
    }
}

/// Of an identified model of this order: its coordinates, their rates and its inputs.
pub(super) fn of_identified(names: &Names, order: usize) -> Wanted {
    let rates = names.rates.iter().flatten().filter(|_| order == 2).cloned();
    let wanted = Wanted::only(&names.time, rates)
        .needing(names.coordinates.iter().chain(&names.inputs).cloned())
        .measuring(names.coordinates.iter().cloned());
    match names.input_path {
        InputPath::Held => wanted.holding(names.inputs.iter().cloned()),
        InputPath::Linear | InputPath::Smooth => wanted,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: &str = r#"
name = "crane"
[[input]]
name = "F"
unit = "N"
[[input]]
name = "tau"
unit = "N m"
[[coordinate]]
name = "x"
unit = "m"
velocity = "v"
[[coordinate]]
name = "phi"
unit = "rad"
velocity = "dphi"
[mechanics]
mass = [["1", "0"], ["0", "1"]]
force = ["F", "tau - phi"]
[recordings]
time = "stamp"
[[measurement]]
column = "/joint.x"
of = "x"
[[measurement]]
column = "phi"
of = "dphi"
[[measurement]]
column = "/command.F"
of = "F"
"#;

    /// A column that measures something else is not the channel of its name.
    #[test]
    fn columns_are_those_of_measurements_and_names() {
        let wanted = |text: &str| of_equations(&Model::from_text(text, "crane.toml").unwrap());
        let with = wanted(MODEL);
        let kept = |wanted: &Wanted| {
            let names = ["/joint.x", "x", "v", "phi", "dphi", "/command.F", "F", "tau", "stamp"];
            names.into_iter().filter(|name| wanted.keeps(name)).collect::<Vec<_>>()
        };
        assert_eq!(kept(&with), ["/joint.x", "v", "phi", "/command.F", "tau"]);
        assert_eq!(with.time, "stamp");
        let without = wanted(MODEL.split("[[measurement]]").next().unwrap());
        assert_eq!(kept(&without), ["x", "v", "phi", "dphi", "F", "tau"]);
    }
}
