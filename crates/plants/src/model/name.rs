//! What a parameter, channel or input may be called.

use thiserror::Error;

/// What is wrong with a name.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum NameError {
    /// It has other characters than names have.
    #[error("'{name}' cannot be a name: names begin with a letter and hold letters, digits and _")]
    Characters {
        /// The name.
        name: String,
    },
    /// It stands for a number.
    #[error("'pi' is the number and cannot be a name")]
    Number,
    /// Something else has it.
    #[error("'{name}' is declared twice: each name stands for one thing")]
    Twice {
        /// The name.
        name: String,
    },
}

/// Check a name beside those that are taken.
pub(super) fn check_name(name: &str, taken: &[String]) -> Result<(), NameError> {
    if !is_word(name) {
        return Err(NameError::Characters { name: name.to_owned() });
    }
    if name == "pi" {
        return Err(NameError::Number);
    }
    unlike(name, taken)
}

/// The same of a parameter of a model that is built, which no expression names: it may be that of a
/// part, `elbow.damping`.
pub(super) fn check_part_name(name: &str, taken: &[String]) -> Result<(), NameError> {
    match name.split_once('.') {
        Some((of, part)) if is_word(of) && is_word(part) => unlike(name, taken),
        _ => check_name(name, taken),
    }
}

fn is_word(name: &str) -> bool {
    let within = |c: char| c.is_ascii_alphanumeric() || c == '_';
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') && name.chars().all(within)
}

/// That nothing else has a name.
pub(super) fn unlike(name: &str, taken: &[String]) -> Result<(), NameError> {
    if taken.iter().any(|t| t == name) {
        return Err(NameError::Twice { name: name.to_owned() });
    }
    Ok(())
}
