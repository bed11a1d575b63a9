//! Bytes → program → toolpath.
#![no_main]

#[path = "../../tests/fuzz/laws.rs"]
mod laws;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| laws::program(bytes));
