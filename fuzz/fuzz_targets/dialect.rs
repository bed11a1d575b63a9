//! Bytes → program in one dialect → toolpath; which one is in the variable `TRUEFEED_DIALECT`.
#![no_main]

use std::sync::LazyLock;

use truefeed::simulation::gcode::Dialect;

#[path = "../../tests/fuzz/laws.rs"]
mod laws;

static DIALECT: LazyLock<Dialect> = LazyLock::new(|| {
    let word = std::env::var("TRUEFEED_DIALECT").expect("TRUEFEED_DIALECT names the dialect");
    Dialect::from_word(&word).expect("TRUEFEED_DIALECT is a word that --dialect takes")
});

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| laws::program_in(bytes, Some(*DIALECT)));
