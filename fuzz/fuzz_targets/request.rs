//! Text → request of a page that embeds quotes.
#![no_main]

#[path = "../../tests/fuzz/borders.rs"]
mod borders;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| borders::request(bytes));
