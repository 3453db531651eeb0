//! What a robot is made of and how it stands: torques of its joints along a motion, `M q'' - F`.

use lacuna_charts::{Axis, Colour, Line, Style};
use lacuna_effects::Effect;
use lacuna_plants::Model;
use lacuna_plants::model::ModelEffect;
use std::f64::consts::TAU;

use super::rig::Rig;
use super::{Drawn, typical};
use crate::StudyError;
use crate::concealed::machine::Files;

/// A column that pans and an arm that it lifts.
const ROBOT: &str = include_str!("robot.urdf");
/// Its model.
const MODEL: &str = "name = \"robot\"\n[robot]\nfile = \"robot.urdf\"\n";
/// Length of the motion (s), and its samples.
const DURATION: f64 = 4.0;
const SAMPLES: usize = 401;

/// Torques with the effect on the last link, or of the base, and without it, dashed.
///
/// # Errors
/// [`StudyError`] when the robot cannot be read.
pub fn drawn(effect: &'static Effect) -> Result<Drawn, StudyError> {
    let model = Files { model: MODEL.to_owned(), robot: Some(ROBOT.to_owned()) }.read()?;
    let parameters = typical::parameters(effect, &Rig::joint().scales);
    let std = vec![None; parameters.len()];
    let channel = model.structures(effect).len().saturating_sub(1);
    let effects = [ModelEffect { effect, channel, other: None, parameters, std }];
    let (with, without) = (torques(&model, &effects), torques(&model, &[]));
    let looks = [Colour::Blue, Colour::Green];
    let mut lines = vec![];
    for (k, (joint, colour)) in model.coordinates.iter().zip(looks).enumerate() {
        let without = without.iter().map(|(t, all)| (*t, all[k])).collect();
        let with = with.iter().map(|(t, all)| (*t, all[k])).collect();
        let says = format!("{} without", joint.name);
        lines.push(Line::new(&says, colour, Style::Dashed, without));
        lines.push(Line::new(&joint.name, colour, Style::Solid, with));
    }
    Ok((Axis::linear("time", "s"), Axis::linear("torque", "N m"), lines))
}

/// Torques of all joints along a motion.
fn torques(model: &Model, effects: &[ModelEffect]) -> Vec<(f64, Vec<f64>)> {
    let dynamics = model.dynamics();
    let bound = dynamics.bind(&model.with_structure(&model.values(), effects));
    let n = model.coordinates.len();
    let at = |k: usize| {
        let t = DURATION * k as f64 / (SAMPLES - 1) as f64;
        let [q, v, a] = motion(n, t);
        let mut variables = [q, v].concat();
        variables.resize(dynamics.sizes().variables(), 0.0);
        let mut rates = vec![0.0; dynamics.sizes().rates()];
        bound.evaluate_once(&variables, &mut rates);
        let (mass, force) = rates.split_at(n * n);
        let torque = |i: usize| {
            let row = mass[i * n..(i + 1) * n].iter().zip(&a);
            row.map(|(m, a)| m * a).sum::<f64>() - force[i]
        };
        (t, (0..n).map(torque).collect())
    };
    (0..SAMPLES).map(at).collect()
}

/// Positions, velocities and accelerations of all joints.
fn motion(joints: usize, t: f64) -> [Vec<f64>; 3] {
    let w = TAU / DURATION;
    let phase = |joint: usize| w * (1 + joint) as f64 * t;
    let of = |f: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
        (0..joints).map(|j| f(phase(j), w * (1 + j) as f64)).collect()
    };
    [of(&|p, _| p.sin()), of(&|p, w| w * p.cos()), of(&|p, w| -w * w * p.sin())]
}
