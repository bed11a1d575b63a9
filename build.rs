//! Sets `TRUEFEED_VERSION` for the crate: a version that is unique to each commit.
//!
//! ```text
//! 0.1.0                            at the tag v0.1.0, or where there is no repository, as in a source archive
//! 0.1.0+12.gc32ad9a                12 commits after the tag; before the first tag, after the beginning
//! 0.1.0+12.gc32ad9a.dirty-5f0c83e1 with changes that are not committed, told apart by a digest of them
//! ```

use std::env;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use std::process::Command;

/// The sources of the crate. A change of the tests does not change the model.
const SOURCES: [&str; 4] = ["build.rs", "Cargo.lock", "Cargo.toml", "src"];

/// Files of git that change with each commit, checkout and tag. In a worktree they lie outside its `.git`.
const GIT_FILES: [&str; 4] = ["HEAD", "logs/HEAD", "packed-refs", "refs/tags"];

fn main() {
    let package = variable("CARGO_PKG_VERSION");
    let version = described(&package).unwrap_or(package);
    println!("cargo::rustc-env=TRUEFEED_VERSION={version}");
    for source in SOURCES {
        rerun_if_changed(source);
    }
}

/// Returns the version by git, or `None` if this folder is not a repository or git is not installed.
fn described(package: &str) -> Option<String> {
    let root = variable("CARGO_MANIFEST_DIR");
    let top = git(&["rev-parse", "--show-toplevel"])?;
    // The folder may be an unpacked archive inside another repository.
    if Path::new(&top).canonicalize().ok()? != Path::new(&root).canonicalize().ok()? {
        return None;
    }
    // Under the profile of tests a build takes minutes, so that a commit that changes no source keeps the
    // version of the last build.
    let is_test_profile = variable("PROFILE") == "debug" && variable("OPT_LEVEL") != "0";
    if !is_test_profile {
        let branch = git(&["symbolic-ref", "--quiet", "HEAD"]);
        for name in GIT_FILES.into_iter().chain(branch.as_deref()) {
            rerun_if_changed(&git(&["rev-parse", "--git-path", name])?);
        }
    }
    let commit = git(&["rev-parse", "--short", "HEAD"])?;
    // `TAG-COMMITS-gHASH`; a tag may contain hyphens.
    let described = git(&["describe", "--tags", "--long", "--match", "v[0-9]*"]);
    let by_tag = described.as_deref().and_then(|text| {
        let (tag_and_commits, _) = text.rsplit_once('-')?;
        let (tag, commits) = tag_and_commits.rsplit_once('-')?;
        Some((tag.trim_start_matches('v'), commits.to_string()))
    });
    let (release, commits) = match by_tag {
        Some(found) => found,
        None => (package, git(&["rev-list", "--count", "HEAD"])?),
    };
    let changes = git(&[&["status", "--porcelain", "--"][..], &SOURCES].concat())?;
    let dirty = if changes.is_empty() { None } else { Some(format!("dirty-{:08x}", digest(&changes)?)) };
    let parts = match (&*commits, dirty) {
        ("0", None) => return Some(release.to_string()),
        (_, dirty) => [Some(commits), Some(format!("g{commit}")), dirty],
    };
    Some(format!("{release}+{}", parts.into_iter().flatten().collect::<Vec<_>>().join(".")))
}

/// Returns a digest of the changes that are not committed. New files enter it by their names.
fn digest(changes: &str) -> Option<u32> {
    let mut digest = DefaultHasher::new();
    changes.hash(&mut digest);
    git(&[&["diff", "--no-ext-diff", "HEAD", "--"][..], &SOURCES].concat())?.hash(&mut digest);
    Some(digest.finish() as u32)
}

/// Tells Cargo to run this script again when the file changes. A missing file would make Cargo run it every
/// time.
fn rerun_if_changed(path: &str) {
    if Path::new(path).exists() {
        println!("cargo::rerun-if-changed={path}");
    }
}

/// Returns the output of git, or `None` if it fails. Git takes no lock for which other commands might wait.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").env("GIT_OPTIONAL_LOCKS", "0").args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim_end().to_string())
}

fn variable(name: &str) -> String {
    env::var(name).expect("Cargo sets it")
}
