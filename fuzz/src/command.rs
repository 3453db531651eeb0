//! A model and a recording, between them a line of `===`: checked, simulated, and diagnosed for a moment.

use super::{file, parts};
use lacuna::check;
use lacuna::diagnosed::datasets;
use lacuna::discrepancy::Watch;
use lacuna::discrepancy::diagnose::{Options, diagnose};
use lacuna::models::AnyModel;
use lacuna::plants::Model;
use lacuna::recordings::{RecordingSource, read};
use lacuna::simulation::{Settings, Simulation};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Nothing that is done with them may panic, whatever they are.
pub fn survive(text: &str) {
    let mut parts = parts(text);
    let (Some(model), Some(recording)) = (parts.next(), parts.next()) else { return };
    let Ok(model) = Model::from_text(model, "model.toml") else { return };
    let path = file("command.csv", recording.as_bytes());
    let Ok(recording) = read(&RecordingSource::file(path), &model.time_column) else { return };
    let _ = check::Report::of(&model, vec![recording.clone().into()]).map(|r| r.text());
    let any = AnyModel::Equations(Box::new(model.clone()));
    let settings = Settings { horizon: None, warmup: 20 };
    let _ = Simulation::of((&any, "model.toml"), &recording, settings);
    // The recording is its own proof: a quarter of a short one is nothing.
    let recordings = [recording];
    let Ok((training, held_out)) = datasets(&model, &recordings, &recordings) else { return };
    let nobody = AtomicBool::new(false);
    let watch = Watch::new(&|_| (), &nobody).within(Duration::from_millis(100));
    let _ = diagnose(&model, &training, &held_out, Options::default(), &watch);
}
