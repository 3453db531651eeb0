//! Effects in the words of the sealed truth: names, variables, numbers, and where they act.

use lacuna_effects::{Law as CatalogueLaw, Variable};
use lacuna_plants::Model;
use lacuna_plants::model::ModelEffect;
use serde_json::json;

use super::draw::Draft;
use super::off_formula::Law;
use super::sealed::{Area, Name, SealedEffect};
use super::several::nearest;

/// An effect of the catalogue under seal.
pub fn catalogued(draft: &Draft, e: &ModelEffect) -> SealedEffect {
    let model = &draft.nominal;
    let class = e.effect.class;
    let channel = model.effect_channel_name(e.effect, e.channel).to_owned();
    let other = e.other.map(|o| model.effect_other_name(e.effect, o).to_owned());
    let depends_on = match e.effect.law {
        CatalogueLaw::Force(_) => {
            e.effect.depends_on.iter().map(|v| variable(model, e, *v)).collect()
        }
        CatalogueLaw::Input(_) | CatalogueLaw::Sensor(_) | CatalogueLaw::Structure(_) => {
            vec![channel.clone()]
        }
    };
    let parameters = e.effect.parameters.iter().zip(&e.parameters);
    let parameters: serde_json::Map<_, _> =
        parameters.map(|(p, v)| (p.name.to_owned(), json!(v))).collect();
    let mut accept = Vec::new();
    // Coulomb friction and a constant force are the same law.
    if class == "asymmetric_friction" {
        accept.push(Name::new("coulomb_friction", &channel));
    }
    accept.extend(nearest(class).iter().map(|near| Name::new(near, &channel)));
    if let (true, Some(other)) = (e.effect.couples(), &other) {
        accept.push(Name::new(class, other));
    }
    // One measured channel that lags behind one input: nobody can say which of them is late.
    if let ("sensor_delay" | "input_delay", [one], [input]) =
        (class, draft.outputs.as_slice(), model.inputs.as_slice())
    {
        accept.push(Name::new("sensor_delay", model.state_name(one.entry)));
        accept.push(Name::new("input_delay", &input.name));
    }
    accept.retain(|n| n.class != class || n.channel != channel);
    SealedEffect {
        area: area(model, e),
        name: Name::new(class, &channel),
        other,
        depends_on,
        parameters: parameters.into(),
        accept,
        catalogue: true,
        gap_over_noise: 0.0,
    }
}

fn variable(model: &Model, e: &ModelEffect, v: Variable) -> String {
    let other = e.other.unwrap_or(e.channel);
    match v {
        Variable::Coordinate => model.state_name(model.coordinate_index(e.channel)).to_owned(),
        Variable::Velocity => model.state_name(model.velocity_index(e.channel)).to_owned(),
        Variable::Acceleration => format!("acceleration of {}", model.channel_name(e.channel)),
        Variable::OtherCoordinate => model.state_name(model.coordinate_index(other)).to_owned(),
        Variable::OtherVelocity => model.state_name(model.velocity_index(other)).to_owned(),
        Variable::OtherInput => model.effect_other_name(e.effect, other).to_owned(),
        // Laws on inputs name their input themselves.
        Variable::Time | Variable::Input => model.time_column.clone(),
    }
}

/// Where or when an effect of the catalogue acts, for those that do not always.
fn area(model: &Model, e: &ModelEffect) -> Option<Area> {
    let number = |name: &str| {
        let place = e.effect.parameters.iter().position(|p| p.name == name);
        place.map(|k| e.parameters[k])
    };
    match e.effect.class {
        "step_change" => number("time").map(Area::From),
        "end_stop" => {
            let variable = model.state_name(model.coordinate_index(e.channel)).to_owned();
            let (position, upper) = (number("position"), number("side")? > 0.0);
            let (from, to) = if upper { (position, None) } else { (None, position) };
            Some(Area::Region { variable, from, to })
        }
        _ => None,
    }
}

/// A law beyond the catalogue under seal.
pub fn beyond(model: &Model, law: &Law, channel: usize) -> SealedEffect {
    let name = model.channel_name(channel);
    let coordinate = model.state_name(model.coordinate_index(channel)).to_owned();
    let velocity = model.state_name(model.velocity_index(channel)).to_owned();
    let (on_coordinate, on_velocity) = law.depends_on();
    let mut depends_on = Vec::new();
    if on_coordinate {
        depends_on.push(coordinate.clone());
    }
    if on_velocity && (!on_coordinate || velocity != coordinate) {
        depends_on.push(velocity);
    }
    let nearest = law.nearest().iter().chain(&["unknown_function"]);
    let finite = |x: f64| x.is_finite().then_some(x);
    SealedEffect {
        name: Name::new(law.class(), name),
        other: None,
        depends_on,
        parameters: json!(format!("{law:?}")),
        accept: nearest.map(|class| Name::new(class, name)).collect(),
        catalogue: false,
        area: law.region().map(|[from, to]| Area::Region {
            variable: coordinate,
            from: finite(from),
            to: finite(to),
        }),
        gap_over_noise: 0.0,
    }
}
