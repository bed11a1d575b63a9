//! What several tests begin with: the size of a run, and the folders of programs and recordings.

pub mod corpus;
pub mod kept;
pub mod pages;
pub mod random;
pub mod samples;

use std::path::PathBuf;

/// Returns whether this is a run of the full suite, `scripts/test --all`.
fn is_full_suite() -> bool {
    std::env::var_os("TRUEFEED_ALL").is_some()
}

/// Returns the number of random cases a law is tried on: all of them in the full suite, a tenth in a quick run.
pub fn case_count(in_full_suite: usize) -> usize {
    if is_full_suite() { in_full_suite } else { in_full_suite.div_ceil(10) }
}

/// Returns what is added to the seed of random cases: 0, so that a run can be repeated, or `TRUEFEED_SEED`, which the
/// full suite draws and prints.
pub fn seed_offset() -> u64 {
    let seed = std::env::var("TRUEFEED_SEED").ok();
    seed.map_or(0, |seed| seed.parse().expect("TRUEFEED_SEED is a whole number"))
}

/// Returns a folder of recordings that others made, which lies outside the repository: in `../shared/recordings` or in
/// the folder that `TRUEFEED_RECORDINGS` names; `None`, with a line that says so, if it is absent.
pub fn recordings_of_others(name: &str) -> Option<PathBuf> {
    let named = std::env::var_os("TRUEFEED_RECORDINGS").map(PathBuf::from);
    let all = named.unwrap_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/recordings"));
    let folder = all.join(name);
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: recordings of others, {name}: not in {} (or set TRUEFEED_RECORDINGS)", all.display());
    None
}
