//! Fuzzes `expression`.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| lacuna_fuzz::expression::survive(text));
