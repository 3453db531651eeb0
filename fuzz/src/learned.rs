//! Identified and compiled models.

use super::file;
use lacuna::models::{AnyModel, LearnedModel};

/// Neither may panic, whatever the bytes are.
pub fn survive(data: &[u8]) {
    let path = file("model.json", data);
    let _ = AnyModel::read(&path, None);
    let _ = LearnedModel::read(&path);
}
