//! The command as it was typed, for results to tell how they are repeated.

/// `lacuna` with the arguments of this run, quoted for a shell where they need it. What the
/// program was started as is left out: it may be a path that nobody typed.
pub fn typed() -> String {
    let arguments = std::env::args_os().skip(1);
    let words = arguments.map(|a| quoted(&a.to_string_lossy()));
    std::iter::once("lacuna".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}

/// A word as a POSIX shell reads it back.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn words_are_quoted_where_a_shell_would_change_them() {
        for (word, expected) in [
            ("run.csv", "run.csv"),
            ("--out=a/b", "--out=a/b"),
            ("run.csv#rows=1..2", "'run.csv#rows=1..2'"),
            ("my run's.csv", r"'my run'\''s.csv'"),
            ("$HOME", "'$HOME'"),
            ("", "''"),
        ] {
            assert_eq!(quoted(word), expected);
        }
    }
}
