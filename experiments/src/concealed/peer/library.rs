//! The library of forces, each with the class of the catalogue whose formula it is.

use lacuna_plants::Model;

use crate::concealed::sealed::Name;

/// What a term sees at a sample.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// State of the machine.
    pub state: &'a [f64],
    /// What the model's force on the channel gains by each whole input.
    pub input_forces: &'a [f64],
}

/// A term of the library.
pub struct Term {
    /// Class and channel that it stands for.
    pub name: Name,
    /// Its value.
    pub value: Box<dyn Fn(&Sample) -> f64>,
}

/// The library of a force channel.
pub fn terms(model: &Model, channel: usize) -> Vec<Term> {
    let mut terms = Vec::new();
    let name = model.channel_name(channel).to_owned();
    let mut add = |class: &str, on: &str, value: Box<dyn Fn(&Sample) -> f64>| {
        terms.push(Term { name: Name::new(class, on), value });
    };
    let (q, v) = (model.coordinate_index(channel), model.velocity_index(channel));
    add("constant_force", &name, Box::new(|_| 1.0));
    add("coulomb_friction", &name, Box::new(move |s| sign(s.state[v])));
    if model.is_coordinate(channel) {
        add("linear_stiffness", &name, Box::new(move |s| s.state[q]));
        add("cubic_stiffness", &name, Box::new(move |s| s.state[q].powi(3)));
        add("viscous_friction", &name, Box::new(move |s| s.state[v]));
        add("quadratic_drag", &name, Box::new(move |s| s.state[v] * s.state[v].abs()));
        if model.coordinates[channel].unit == "rad" {
            add("gravity_torque", &name, Box::new(move |s| s.state[q].sin()));
        }
        for other in (0..model.coordinates.len()).filter(|o| *o != channel) {
            let (oq, ov) = (model.coordinate_index(other), model.velocity_index(other));
            let spring = move |s: &Sample| s.state[oq] - s.state[q];
            add("coupling_stiffness", &name, Box::new(spring));
            add("coriolis_coupling", &name, Box::new(move |s| s.state[v] * s.state[ov]));
        }
    } else {
        add("linear_loss", &name, Box::new(move |s| s.state[q]));
        add("quadratic_loss", &name, Box::new(move |s| s.state[q] * s.state[q].abs()));
    }
    for (j, input) in model.inputs.iter().enumerate() {
        add("gain_error", &input.name, Box::new(move |s| s.input_forces[j]));
    }
    terms
}

fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}
