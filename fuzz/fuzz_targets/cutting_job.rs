//! Text → cutting job.
#![no_main]

#[path = "../../tests/fuzz/borders.rs"]
mod borders;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| borders::cutting_job(bytes));
