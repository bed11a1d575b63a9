//! Tables of what the code makes of the corpus, kept beside it: moves and renames change none of their rows; what unifies a
//! rule or corrects a fault writes them again, with `TRUEFEED_UPDATE_EXPECTED=1`, and says which rows changed and why.

use std::path::{Path, PathBuf};

/// Returns the path of a table.
fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/corpus").join(name)
}

/// Returns the table that is kept under this name, which is `table` itself if it is to be written again.
pub fn kept(name: &str, table: &str) -> String {
    let path = path(name);
    if std::env::var_os("TRUEFEED_UPDATE_EXPECTED").is_some() {
        std::fs::write(&path, table).expect("the folder of the tests can be written");
    }
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Compares a table with the one kept under this name, row by row.
pub fn assert_kept(name: &str, table: &str) {
    let kept = kept(name, table);
    for (kept, now) in kept.lines().zip(table.lines()) {
        assert_eq!(now, kept, "{}", path(name).display());
    }
    assert_eq!(table.lines().count(), kept.lines().count());
}

/// Returns the FNV-1a hash of bytes, which no release of the compiler changes.
pub fn digest(bytes: impl IntoIterator<Item = u8>) -> u64 {
    bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}
