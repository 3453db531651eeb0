//! What was probably meant by a name that is not known.

/// The name among `known` that is nearest to `wanted`, if one is near enough to be meant.
pub fn nearest<'a>(wanted: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wanted = wanted.to_lowercase();
    let score = |name: &str| {
        let name = name.to_lowercase();
        // Of short names, most of what is similar goes with a letter. Of two letters, so does the name.
        let is_one_off = wanted.chars().count() > 2 && strsim::osa_distance(&wanted, &name) <= 1;
        if is_one_off { 1.0 } else { strsim::jaro_winkler(&wanted, &name) }
    };
    known
        .into_iter()
        .map(|name| (score(name), name))
        .filter(|(score, _)| *score >= 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}

/// The same as the end of a message; nothing where nothing is near.
pub fn did_you_mean(suggestion: &Option<String>) -> String {
    suggestion.as_ref().map_or_else(String::new, |name| format!(" (did you mean '{name}'?)"))
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn a_letter_off_or_much_alike_is_near() {
        let columns = ["tua", "theta", "q"];
        for (wanted, meant) in [
            ("tau", Some("tua")),
            ("thta", Some("theta")),
            ("Theta", Some("theta")),
            ("omega", None),
            ("u", None),
        ] {
            assert_eq!(nearest(wanted, columns), meant, "{wanted}");
        }
    }
}
