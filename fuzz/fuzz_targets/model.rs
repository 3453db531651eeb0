//! Fuzzes `model`.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| lacuna_fuzz::model::survive(text));
