//! A model, and the same moved a little: what predictions are linearised by.

use lacuna_plants::model::ModelEffect;
use lacuna_plants::{Model, System};

use super::sensor::Sensor;
use super::windows::Shown;

/// Share of a tolerance by which a parameter is moved to see what it does.
const NUDGE: f64 = 0.02;

/// Something that might explain the truth as well.
#[derive(Clone, Debug)]
pub enum Rival {
    /// An effect of the catalogue of small amplitude, on force channels or inputs.
    Effect(ModelEffect),
    /// A sensor that is slightly wrong on an output.
    Sensor(usize, Sensor),
}

/// A model that is moved a little, and by how much.
pub struct Variant {
    /// The plant.
    pub system: System,
    /// Effective inputs of each motion.
    pub inputs: Vec<Vec<f64>>,
    /// An output whose sensor is wrong.
    pub sensor: Option<(usize, Sensor)>,
    /// By how much the model is moved.
    pub nudge: f64,
}

/// The model itself, then each uncertain parameter and each rival moved a little.
pub fn variants(believed: &Model, shown: &[Shown], rivals: &[Rival]) -> Vec<Variant> {
    let values = believed.values();
    let inputs = |effects: &[ModelEffect]| -> Vec<Vec<f64>> {
        let mut model = believed.clone();
        model.effects = effects.to_vec();
        shown.iter().map(|(m, _)| model.effective_inputs(&m.times, &m.commands)).collect()
    };
    let variant = |values: &[f64], effects: &[ModelEffect], sensor, nudge| Variant {
        system: System::with(believed, values, effects),
        inputs: inputs(effects),
        sensor,
        nudge,
    };
    let mut variants = vec![variant(&values, &believed.effects, None, 1.0)];
    for (k, p) in believed.parameters.iter().enumerate().filter(|(_, p)| p.std() > 0.0) {
        let mut moved = values.clone();
        moved[k] += NUDGE * p.std();
        variants.push(variant(&moved, &believed.effects, None, NUDGE));
    }
    for rival in rivals {
        variants.push(match rival {
            Rival::Effect(effect) => {
                let effects = [&believed.effects[..], std::slice::from_ref(effect)].concat();
                variant(&values, &effects, None, 1.0)
            }
            Rival::Sensor(k, sensor) => {
                variant(&values, &believed.effects, Some((*k, *sensor)), 1.0)
            }
        });
    }
    variants
}

/// A series through a sensor that is slightly wrong; a delay to first order.
pub fn distorted(series: &[f64], times: &[f64], sensor: Sensor) -> Vec<f64> {
    let last = series.len() - 1;
    let slope = |k: usize| {
        let (a, b) = (k.saturating_sub(1), (k + 1).min(last));
        (series[b] - series[a]) / (times[b] - times[a])
    };
    let one = |(k, x): (usize, &f64)| match sensor {
        Sensor::Scale(scale) => scale * x,
        Sensor::Bias(bias) => x + bias,
        Sensor::Delay(delay) => x - delay * slope(k),
    };
    series.iter().enumerate().map(one).collect()
}
