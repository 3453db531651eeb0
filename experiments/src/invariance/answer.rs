//! What a diagnosis says, and whether another says the same.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt;

/// Probabilities may differ by so much.
pub const WITHIN: f64 = 0.02;

/// A diagnosis.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Answer {
    /// The verdict.
    pub verdict: String,
    /// The findings.
    pub findings: Vec<Finding>,
    /// Digest of every number of `diagnosis.json` with its place.
    pub numbers: String,
}

/// A finding.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Finding {
    /// Class.
    pub class: String,
    /// Channel.
    pub channel: String,
    /// Probability.
    pub probability: Option<f64>,
}

#[derive(Deserialize)]
struct Said {
    verdict: String,
    findings: Vec<Finding>,
}

impl Answer {
    /// What `diagnosis.json` says, in which these names stand for others.
    ///
    /// # Errors
    /// A text that is no diagnosis.
    pub fn read(text: &str, names: &BTreeMap<String, String>) -> serde_json::Result<Self> {
        let mut text = text.to_owned();
        for (new, old) in names {
            text = text.replace(new, old);
        }
        let Said { verdict, findings } = serde_json::from_str(&text)?;
        let numbers = numbers(&serde_json::from_str(&text)?);
        Ok(Self { verdict, findings, numbers: digest(&numbers) })
    }

    fn names(&self) -> BTreeMap<(&str, &str), f64> {
        let of = |f: &'_ Finding| f.probability.unwrap_or(0.0);
        self.findings.iter().map(|f| ((&*f.class, &*f.channel), of(f))).collect()
    }

    /// Whether verdict and names are the same.
    pub fn is_same(&self, other: &Self) -> bool {
        self.verdict == other.verdict && self.names().keys().eq(other.names().keys())
    }

    /// Whether probabilities are, too, within [`WITHIN`].
    pub fn is_as_probable(&self, other: &Self) -> bool {
        let (a, b) = (self.names(), other.names());
        self.is_same(other) && a.values().zip(b.values()).all(|(a, b)| (a - b).abs() <= WITHIN)
    }

    /// Whether every number is the same to the last bit.
    pub fn is_identical(&self, other: &Self) -> bool {
        self.is_same(other) && self.numbers == other.numbers
    }
}

/// All but words and the names of files.
fn numbers(value: &Value) -> Value {
    match value {
        Value::String(_) => Value::Null,
        Value::Array(all) => all.iter().map(numbers).collect(),
        // What is said of each recording, whatever its file is called.
        Value::Object(all) if all.keys().any(|key| key.ends_with(".csv")) => {
            let mut all: Vec<Value> = all.values().map(numbers).collect();
            all.sort_by_key(Value::to_string);
            all.into()
        }
        Value::Object(all) => {
            // Ordered by key, whatever the order of the file.
            let all: BTreeMap<_, _> = all.iter().map(|(k, v)| (k.clone(), numbers(v))).collect();
            all.into_iter().collect()
        }
        other => other.clone(),
    }
}

/// FNV-1a, 64 bit: two diagnoses that differ have the same one once in 10^19.
fn digest(value: &Value) -> String {
    let fold = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    format!("{:016x}", value.to_string().bytes().fold(0xcbf2_9ce4_8422_2325, fold))
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.verdict)?;
        for finding in &self.findings {
            let probability = finding.probability.unwrap_or(f64::NAN);
            write!(f, "; {} on {} {probability:.3}", finding.class, finding.channel)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAID: &str = r#"{"verdict": "missing_physics", "findings": [{"class": "end_stop", "channel": "n1_q",
        "probability": 0.9, "says": "run1.csv"}], "fit": {"n1_q": {"noise": 0.25}}, "where": {"run1.csv": 7}}"#;

    #[test]
    fn names_are_as_they_were_and_words_do_not_count() {
        let names = BTreeMap::from([("n1_".to_owned(), String::new())]);
        let plain = SAID.replace("n1_q", "q");
        let other = Answer::read(SAID, &names).unwrap();
        let read = |text: &str| Answer::read(text, &BTreeMap::new()).unwrap();
        assert!(read(&plain).is_identical(&other));
        assert!(read(&plain.replace("run1", "run2")).is_identical(&other));
        assert!(!read(SAID).is_same(&other));
        let nearly = read(&plain.replace("0.9,", "0.91,"));
        assert!(nearly.is_as_probable(&other) && !nearly.is_identical(&other));
        let less = read(&plain.replace("0.9,", "0.8,"));
        assert!(less.is_same(&other) && !less.is_as_probable(&other));
        assert!(!read(&plain.replace("0.25", "0.26")).is_identical(&other));
    }
}
