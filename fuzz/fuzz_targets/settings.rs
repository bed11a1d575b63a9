//! Text of a saved link or file → settings of the page.
#![no_main]

#[path = "../../tests/fuzz/borders.rs"]
mod borders;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| borders::settings(bytes));
