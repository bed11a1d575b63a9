//! Text → machine, terms and offer by the forms of the page.
#![no_main]

#[path = "../../tests/fuzz/borders.rs"]
mod borders;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| borders::forms(bytes));
