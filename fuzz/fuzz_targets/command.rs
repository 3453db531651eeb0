//! Fuzzes `command`.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| lacuna_fuzz::command::survive(text));
