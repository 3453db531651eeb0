//! The guide shows what the laws of the catalogue draw now.

use experiments::signatures::{COMMAND, FOLDER, PAGE, page, picture, rig::Rig, typical};
use lacuna_effects::CATALOGUE;
use std::path::{Path, PathBuf};

fn guide() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/guide")
}

/// A text as its words, without spaces, and its numbers.
fn read(text: &str) -> (String, Vec<f64>) {
    let (mut words, mut numbers) = (String::new(), vec![]);
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let sign = usize::from(first == '-');
        let digits = rest[sign..].find(|c: char| !c.is_ascii_digit() && c != '.');
        let end = sign + digits.unwrap_or(rest.len() - sign);
        match rest[..end].parse() {
            Ok(number) => numbers.push(number),
            Err(_) => {
                words.extend(Some(first).filter(|c| !c.is_whitespace()));
                rest = &rest[first.len_utf8()..];
                continue;
            }
        }
        words.push('0');
        rest = &rest[end..];
    }
    (words, numbers)
}

/// Coordinates are whole tenths of a unit, of which there are two in a pixel: the last one may differ
/// between machines.
#[test]
fn every_class_has_the_picture_that_its_law_draws() {
    let mut expected = vec![];
    for effect in CATALOGUE {
        let name = format!("{}.svg", effect.class);
        let committed = std::fs::read_to_string(guide().join(FOLDER).join(&name));
        let committed = committed.unwrap_or_else(|e| panic!("{name}: {e}; make it by `{COMMAND}`"));
        let (words, numbers) = read(&committed);
        let (drawn_words, drawn) = read(&picture(effect).expect("a picture"));
        assert!(words == drawn_words, "{name} is not what is drawn now: `{COMMAND}`");
        for (a, b) in numbers.iter().zip(&drawn) {
            let near = (a - b).abs() <= 1.0 + 1e-6 * a.abs();
            assert!(near, "{name} has {a} in the place of {b}: `{COMMAND}`");
        }
        assert!(committed.len() < 12_000, "{name} has {} bytes", committed.len());
        expected.push(name);
    }
    let files = std::fs::read_dir(guide().join(FOLDER)).expect("the pictures");
    let mut found: Vec<_> =
        files.map(|f| f.expect("a file").file_name().into_string().expect("a name")).collect();
    found.sort();
    expected.sort();
    assert_eq!(found, expected);
}

#[test]
fn the_page_shows_each_picture_once() {
    let text = std::fs::read_to_string(guide().join(PAGE)).expect("the page");
    assert_eq!(text, page::with_pictures(&text), "the page is an older one: `{COMMAND}`");
    for effect in CATALOGUE {
        let shown = format!("src=\"{FOLDER}/{}.svg\"", effect.class);
        assert_eq!(text.matches(&shown).count(), 1, "{}", effect.class);
    }
}

/// What is drawn is what a model file may state.
#[test]
fn typical_parameters_are_possible() {
    for effect in CATALOGUE {
        let scales = Rig::of(effect).scales;
        let physical = typical::physical(effect, &typical::parameters(effect, &scales));
        assert_eq!(physical.len(), effect.values().count(), "{}", effect.class);
        for (p, value) in effect.values().zip(&physical) {
            assert!(p.range.contains(*value), "{}: {} = {value}", effect.class, p.name);
        }
    }
}
