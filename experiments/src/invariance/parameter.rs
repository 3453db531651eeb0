//! A parameter in place of another: the reciprocal of the first.

use super::{Agreement, Posed, Subject, Transformation};
use crate::StudyError;
use std::collections::BTreeMap;
use toml_edit::{Item, value};

pub(super) struct Parameter;

impl Transformation for Parameter {
    fn name(&self) -> &'static str {
        "parameter"
    }

    fn agreement(&self) -> Agreement {
        Agreement::Same
    }

    fn apply(&self, subject: &Subject) -> Result<Option<Posed>, StudyError> {
        let mut posed = subject.posed.clone();
        let Some(name) = posed.parameters().into_iter().next() else { return Ok(None) };
        let Some(table) = posed.model["parameters"][&name].as_table_like_mut() else {
            return Ok(None);
        };
        let Some(number) = table.get("value").and_then(Item::as_float) else { return Ok(None) };
        let unit = table.get("unit").and_then(Item::as_str).unwrap_or("1").to_owned();
        table.insert("value", value(1.0 / number));
        table.insert("unit", value(format!("1/({unit})")));
        posed.substitute(&BTreeMap::from([(name.clone(), format!("(1/{name})"))]));
        Ok(Some(posed))
    }
}
