//! The model file of a case, and what is true of its parameters.

use lacuna_plants::Model;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use toml_edit::{DocumentMut, value};

use super::ConcealedError;
use super::effects::{sign, uniform};
use super::plants::PlantSpec;
use super::topic::Topic;
use crate::StudyError;

/// Parameters are drawn within this factor of those in the plant's file.
const SPREAD: f64 = 1.25;
/// Probability that a parameter of a machine with missing physics is wrong as well.
const ALSO_WRONG: f64 = 0.5;

/// The text of a model file with parameters of its own, and the model.
///
/// # Errors
/// [`ConcealedError::Plant`] for a plant's file that is wrong.
pub fn draw(spec: &PlantSpec, rng: &mut ChaCha8Rng) -> Result<(String, Model), StudyError> {
    let wrong = |reason: String| ConcealedError::Plant { reason };
    let mut document: DocumentMut =
        spec.model.parse().map_err(|e: toml_edit::TomlError| wrong(e.to_string()))?;
    let plain = Model::from_text(spec.model, "model.toml").map_err(|e| wrong(e.to_string()))?;
    for p in plain.parameters.iter().filter(|p| p.std() > 0.0) {
        let drawn = p.value * uniform(rng, -SPREAD.ln(), SPREAD.ln()).exp();
        document["parameters"][&p.name]["value"] = value(three_digits(drawn));
    }
    let text = document.to_string();
    let model = Model::from_text(&text, "model.toml").map_err(|e| wrong(e.to_string()))?;
    Ok((text, model))
}

fn three_digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// The model with the parameters that are true: some are off by about their tolerance.
pub fn miscalibrated(nominal: &Model, topic: Topic, rng: &mut ChaCha8Rng) -> Model {
    let mut model = nominal.clone();
    let uncertain: Vec<usize> =
        (0..model.parameters.len()).filter(|&k| model.parameters[k].std() > 0.0).collect();
    let wrong = match topic {
        Topic::Nothing(_) | Topic::Only(_) => 0,
        Topic::Parameter => rng.random_range(1..3),
        _ => usize::from(rng.random_range(0.0..1.0) < ALSO_WRONG),
    };
    for _ in 0..wrong {
        let p = &mut model.parameters[uncertain[rng.random_range(0..uncertain.len())]];
        p.value *= 1.0 + sign(rng) * uniform(rng, 0.4, 1.5) * p.tolerance();
    }
    model
}
