//! Text → machine, or what is wrong with it.
#![no_main]

#[path = "../../tests/fuzz/laws.rs"]
mod laws;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| laws::machine_file(bytes));
