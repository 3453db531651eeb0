//! Fuzzes `robot`.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| lacuna_fuzz::robot::survive(text));
