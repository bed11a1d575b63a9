//! Two words → probe.
#![no_main]

#[path = "../../tests/fuzz/borders.rs"]
mod borders;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| borders::probe_request(bytes));
