//! A new effect touches its file, its line in the catalogue and its test: no other source knows
//! an effect by name, and the guide lists the catalogue.

use lacuna_effects::{Acts, CATALOGUE};
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// All Rust sources in a folder.
fn sources(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder of the project") {
        let path = entry.expect("a readable entry").path();
        if path.is_dir() {
            sources(&path, out);
        } else if path.extension().is_some_and(|e| e == "rs") {
            out.push(path);
        }
    }
}

#[test]
fn no_source_but_its_own_names_an_effect() {
    let mut files = vec![];
    for entry in std::fs::read_dir(root().join("crates")).expect("the crates") {
        let source = entry.expect("a readable entry").path().join("src");
        if !source.starts_with(root().join("crates/effects")) && source.is_dir() {
            sources(&source, &mut files);
        }
    }
    assert!(files.len() > 100, "only {} sources were found", files.len());
    // The demo conceals effects of its own choice, as the experiments do.
    files.retain(|f| !f.ends_with("lacuna/src/commands/demo.rs"));
    for file in files {
        let text = std::fs::read_to_string(&file).expect("text");
        // Tests say what they are about.
        let text = text.split("#[cfg(test)]").next().unwrap_or_default();
        for class in CATALOGUE.iter().map(|e| e.class) {
            let named =
                [format!("\"{class}\""), format!("\"{class}\\"), format!("{class}::EFFECT")];
            let found = named.iter().any(|literal| text.contains(literal.as_str()));
            assert!(!found, "{} knows {class} by name: ask its Effect", file.display());
        }
    }
}

/// Every effect has its file, its `mod` line and its line in the catalogue, once.
#[test]
fn every_effect_has_a_file_and_a_line() {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let lib = std::fs::read_to_string(own.join("lib.rs")).expect("text");
    for effect in CATALOGUE {
        let class = effect.class;
        let text = std::fs::read_to_string(own.join(format!("{class}.rs"))).expect("its own file");
        assert!(text.contains(&format!("class: \"{class}\"")), "{class}");
        assert_eq!(lib.matches(&format!("&{class}::EFFECT,")).count(), 1, "{class}");
        assert_eq!(lib.matches(&format!("mod {class};")).count(), 1, "{class}");
    }
}

/// The table of the guide, row by row: class, what it acts on, law.
#[test]
fn guide_lists_the_catalogue() {
    let page = std::fs::read_to_string(root().join("docs/guide/catalogue.md"))
        .expect("the guide's page on the catalogue");
    let rows: Vec<&str> = page
        .lines()
        .skip_while(|l| !l.starts_with("| `"))
        .take_while(|l| l.starts_with('|'))
        .collect();
    let expected: Vec<String> = CATALOGUE
        .iter()
        .map(|e| {
            let acts = match e.acts {
                Acts::Coordinates => "coordinate",
                Acts::States => "first-order state",
                Acts::CoordinatesAndStates => "coordinate or state",
                Acts::CoordinatesAndSpeeds => "coordinate or speed",
                Acts::Inputs => "input",
                Acts::Sensors => "sensor",
                Acts::Links => "link of a robot",
                Acts::Base => "base of a robot",
            };
            // A bar within a table's cell has to be written as a character of HTML.
            let law = match e.formula.contains('|') {
                true => format!("<code>{}</code>", e.formula.replace('|', "&#124;")),
                false => format!("`{}`", e.formula),
            };
            format!("| `{}` | {acts} | {law} |", e.class)
        })
        .collect();
    assert_eq!(rows, expected);
}
