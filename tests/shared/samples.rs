//! The programs of the corpus, each with its dialect.

use truefeed::simulation::gcode::{Dialect, Options};

use crate::shared::corpus;

/// A program of the corpus, whose file is called KIND-DIALECT.
pub struct Sample {
    /// The kind of job.
    pub kind: String,
    /// The word of its dialect.
    pub word: String,
    /// How it is read.
    pub options: Options,
    /// Its text.
    pub bytes: Vec<u8>,
}

impl Sample {
    /// Returns the name of its file without the ending.
    pub fn name(&self) -> String {
        format!("{}-{}", self.kind, self.word)
    }
}

/// Returns the programs of the corpus in the order of their files' paths.
pub fn samples() -> Vec<Sample> {
    let entries = std::fs::read_dir(corpus::programs()).expect("the corpus is unpacked");
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("a readable folder").path()).collect();
    paths.sort();
    let sample = |path: std::path::PathBuf| {
        let name = path.file_stem().expect("a file").to_string_lossy();
        let (kind, word) = name.split_once('-').expect("files are called KIND-DIALECT");
        Sample {
            kind: kind.to_string(),
            word: word.to_string(),
            options: Options { dialect: Dialect::from_word(word), ..Options::default() },
            bytes: std::fs::read(&path).expect("a readable file"),
        }
    };
    paths.into_iter().map(sample).collect()
}
