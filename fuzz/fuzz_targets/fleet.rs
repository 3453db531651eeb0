//! Fuzzes `fleet`.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| lacuna_fuzz::fleet::survive(text));
