//! What several tests begin with.

use std::path::PathBuf;

/// A folder of the recordings that lie outside the repository; none, with a word, where it is absent.
pub fn recordings(name: &str) -> Option<PathBuf> {
    let named = std::env::var_os("TRUEFEED_RECORDINGS").map(PathBuf::from);
    let all = named.unwrap_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/recordings"));
    let folder = all.join(name);
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: there are no recordings at {}", folder.display());
    None
}
