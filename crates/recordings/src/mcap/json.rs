//! Messages as JSON: their numbers by the same names as those of other messages.

use serde_json::Value;

use super::message::{NAMING, Numbers, unique};
use crate::parquet::LONGEST_LIST;

/// Reads a message, whatever its schema; its shape is its names.
///
/// Returns what is wrong with it.
pub(super) fn read(data: &[u8], found: &mut Numbers) -> Result<(), String> {
    let value: Value = serde_json::from_slice(data).map_err(|e| e.to_string())?;
    let mut names = Vec::new();
    walk(&value, String::new(), &[], &mut names, &mut found.values);
    found.shape = names.join("\n").into_bytes();
    found.names = Some(names);
    Ok(())
}

fn walk(
    value: &Value,
    path: String,
    joints: &[String],
    names: &mut Vec<String>,
    out: &mut Vec<f64>,
) {
    let mut number = |value| {
        names.push(path.clone());
        out.push(value);
    };
    match value {
        Value::Bool(value) => number(f64::from(u8::from(*value))),
        Value::Number(value) => number(value.as_f64().unwrap_or(f64::NAN)),
        Value::Array(list) if list.len() <= LONGEST_LIST => {
            for (k, entry) in list.iter().enumerate() {
                let joint = joints.get(k).filter(|_| joints.len() == list.len());
                let own = joint.map_or_else(|| format!("{path}[{k}]"), |n| format!("{path}[{n}]"));
                walk(entry, own, joints, names, out);
            }
        }
        Value::Object(fields) => {
            let own = NAMING.iter().find_map(|&name| fields.get(name)?.as_array());
            let own = own.and_then(|list| {
                list.iter().map(|v| v.as_str().map(str::to_owned)).collect::<Option<Vec<_>>>()
            });
            let own = own.map(unique);
            for (name, field) in fields {
                let below = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                walk(field, below, own.as_deref().unwrap_or(joints), names, out);
            }
        }
        _ => {}
    }
}
