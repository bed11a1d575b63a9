//! The text of a program as it comes from a file, piece by piece: it is whole only in the memory of this module.

use wasm_bindgen::prelude::*;

/// The bytes of a program that have come so far.
#[wasm_bindgen]
pub struct ProgramText {
    pub(super) bytes: Vec<u8>,
}

#[wasm_bindgen]
impl ProgramText {
    /// Room for a text of so many bytes.
    #[wasm_bindgen(constructor)]
    pub fn new(size: usize) -> Result<ProgramText, String> {
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(size).map_err(|_| "the program is larger than the memory".to_string())?;
        Ok(ProgramText { bytes })
    }

    /// Takes in the next piece.
    pub fn push(&mut self, piece: &[u8]) {
        self.bytes.extend_from_slice(piece);
    }
}

impl From<Vec<u8>> for ProgramText {
    fn from(bytes: Vec<u8>) -> ProgramText {
        ProgramText { bytes }
    }
}
