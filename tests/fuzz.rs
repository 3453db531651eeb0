//! What is fuzzed survives its corpora, and what is drawn from them: bytes that are turned, lost, doubled and taken from
//! another input. A coverage-guided fuzzer goes further (`fuzz/run`); inputs that broke something once are in the corpora.

#[path = "../fuzz/src/lib.rs"]
mod fuzz;

use rand::RngExt;
use rand::rngs::StdRng;
use rand::seq::IndexedRandom;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// What is between the words of an input, and what numbers are that hurt.
const TOKENS: [&str; 18] = [
    "0",
    "-1",
    "1e308",
    "1e-308",
    "NaN",
    "inf",
    "18446744073709551615",
    "-9223372036854775808",
    ",",
    ";",
    "\n",
    "\"",
    "[",
    "{",
    "(",
    "<",
    "=",
    "\u{feff}",
];

/// The inputs of a target's corpus, in order of their names.
fn corpus(target: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(target);
    let entries = std::fs::read_dir(&folder).expect("it has a corpus");
    let mut files: Vec<_> = entries.map(|e| e.expect("an entry").path()).collect();
    files.sort();
    files.iter().map(|f| std::fs::read(f).expect("an input")).collect()
}

/// An input made from others.
fn drawn(inputs: &[Vec<u8>], rng: &mut StdRng) -> Vec<u8> {
    let mut input = inputs.choose(rng).expect("an input").clone();
    for _ in 0..rng.random_range(1..=4) {
        let at = rng.random_range(0..=input.len());
        let to = (at + rng.random_range(0..=16)).min(input.len());
        match rng.random_range(0..6) {
            0 if at < input.len() => input[at] ^= 1 << rng.random_range(0..8),
            1 if at < input.len() => input[at] = rng.random(),
            2 => drop(input.drain(at..to)),
            3 => drop(input.splice(at..at, input[at..to].to_vec())),
            4 => drop(input.splice(at..to, TOKENS.choose(rng).expect("one").bytes())),
            _ => {
                let other = inputs.choose(rng).expect("an input");
                let from = rng.random_range(0..=other.len());
                input.truncate(at);
                input.extend_from_slice(&other[from..]);
            }
        }
    }
    input
}

/// The corpus of a target, then so many inputs drawn from it; what breaks is kept and told.
fn survives(target: &str, draws: u64, survive: impl Fn(&[u8])) {
    let inputs = corpus(target);
    let check = |input: &[u8], name: &str| {
        if catch_unwind(AssertUnwindSafe(|| survive(input))).is_err() {
            let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{target}-{name}"));
            std::fs::write(&kept, input).expect("the input is kept");
            panic!("{target} broke: the input is {}", kept.display());
        }
    };
    for (k, input) in inputs.iter().enumerate() {
        check(input, &format!("corpus-{k}"));
    }
    for seed in 0..draws {
        check(&drawn(&inputs, &mut rand::SeedableRng::seed_from_u64(seed)), &seed.to_string());
    }
}

/// The same of a target that takes text.
fn survives_text(target: &str, draws: u64, survive: impl Fn(&str)) {
    survives(target, draws, |input| survive(&String::from_utf8_lossy(input)));
}

#[test]
fn commands_survive() {
    survives_text("command", 40, fuzz::command::survive);
}

#[test]
fn expressions_survive() {
    survives_text("expression", 100_000, fuzz::expression::survive);
}

#[test]
fn fleets_survive() {
    survives_text("fleet", 5_000, fuzz::fleet::survive);
}

#[test]
fn learned_models_survive() {
    survives("learned", 5_000, fuzz::learned::survive);
}

#[test]
fn logs_survive() {
    survives("log", 10_000, fuzz::log::survive);
}

#[test]
fn models_survive() {
    survives_text("model", 10_000, fuzz::model::survive);
}

#[test]
fn recordings_survive() {
    survives("recording", 20_000, fuzz::recording::survive);
}

#[test]
fn robots_survive() {
    survives_text("robot", 20_000, fuzz::robot::survive);
}
