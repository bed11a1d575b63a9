//! The text of a program that arrives from a file piece by piece; only the WebAssembly module holds the whole
//! text.

use wasm_bindgen::prelude::*;

/// The bytes of a program that have arrived.
#[wasm_bindgen]
pub struct ProgramText {
    pub(super) bytes: Vec<u8>,
}

#[wasm_bindgen]
impl ProgramText {
    /// Reserves memory for a text of `size` bytes.
    #[wasm_bindgen(constructor)]
    pub fn new(size: usize) -> Result<ProgramText, String> {
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(size).map_err(|_| "the program does not fit into memory".to_string())?;
        Ok(ProgramText { bytes })
    }

    /// Appends the next piece.
    pub fn push(&mut self, piece: &[u8]) {
        self.bytes.extend_from_slice(piece);
    }
}

impl From<Vec<u8>> for ProgramText {
    fn from(bytes: Vec<u8>) -> ProgramText {
        ProgramText { bytes }
    }
}
