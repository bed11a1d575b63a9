//! The archives of `tests/data/corpus`, unpacked once for each state of them.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

use ruzstd::decoding::StreamingDecoder;

/// Returns the folder into which an archive is unpacked, which holds one folder of the archive's name.
fn unpacked(name: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let archive = root.join(format!("tests/data/corpus/{name}.tar.zst"));
    let bytes = std::fs::read(&archive).expect("the corpus comes with the repository");
    let mut hasher = DefaultHasher::new();
    bytes.hash(&mut hasher);
    // Cargo names a folder for the temporary files of integration tests, but not for those of examples.
    let temporary = option_env!("CARGO_TARGET_TMPDIR").map_or(root.join("target/tmp"), PathBuf::from);
    let folder = temporary.join(format!("{name}-{:016x}", hasher.finish()));
    if !folder.is_dir() {
        // Tests of several processes may unpack at a time: the first to finish gives the folder its name.
        let unfinished = folder.with_extension(std::process::id().to_string());
        let decoder = StreamingDecoder::new(bytes.as_slice()).expect("a zstd archive");
        tar::Archive::new(decoder).unpack(&unfinished).expect("room for the corpus");
        if std::fs::rename(&unfinished, &folder).is_err() {
            std::fs::remove_dir_all(&unfinished).expect("a folder of this process");
        }
    }
    folder.join(name)
}

/// Returns the folder of the programs that `examples/corpus` wrote.
pub fn programs() -> PathBuf {
    static FOLDER: std::sync::LazyLock<PathBuf> = std::sync::LazyLock::new(|| unpacked("programs"));
    FOLDER.clone()
}

/// Returns the folder of our own recordings: `plant`, `linuxcnc`, `grbl`, `klipper`.
pub fn recordings() -> PathBuf {
    static FOLDER: std::sync::LazyLock<PathBuf> = std::sync::LazyLock::new(|| unpacked("recordings"));
    FOLDER.clone()
}
