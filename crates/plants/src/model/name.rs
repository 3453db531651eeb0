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
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let plain =
        name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') && name.chars().all(word);
    if !plain {
        return Err(NameError::Characters { name: name.to_owned() });
    }
    if name == "pi" {
        return Err(NameError::Number);
    }
    if taken.iter().any(|t| t == name) {
        return Err(NameError::Twice { name: name.to_owned() });
    }
    Ok(())
}
