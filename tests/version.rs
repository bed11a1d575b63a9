//! The version of a build: `build.rs` in a crate of its own, over the life of a repository.

use std::fs::{create_dir_all, remove_dir_all, rename, write};
use std::path::{Path, PathBuf};
use std::process::Command;

use truefeed::project::VERSION;

const MANIFEST: &str =
    "[package]\nname = \"versioned\"\nversion = \"0.1.0\"\nedition = \"2024\"\n[workspace]\n";

struct Crate(PathBuf);

impl Crate {
    fn new(name: &str) -> Crate {
        let parent =
            Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("version-{name}-{}", std::process::id()));
        let _ = remove_dir_all(&parent);
        let root = parent.join("repository");
        create_dir_all(root.join("src")).expect("a writable folder");
        write(root.join("Cargo.toml"), MANIFEST).expect("a writable folder");
        write(root.join("build.rs"), include_str!("../build.rs")).expect("a writable folder");
        let made = Crate(root);
        made.write(1);
        // Cargo would write it at the first build, after the first commit.
        made.run(env!("CARGO"), &["generate-lockfile", "--offline"], &made.0);
        made
    }

    /// A source that says the version, and a number that makes it another.
    fn write(&self, number: u32) {
        let text = format!("fn main() {{ print!(\"{{}}\", env!(\"TRUEFEED_VERSION\")); }} // {number}\n");
        write(self.0.join("src/main.rs"), text).expect("a writable folder");
    }

    fn run(&self, program: &str, arguments: &[&str], folder: &Path) -> String {
        let output = Command::new(program)
            .args(arguments)
            .current_dir(folder)
            .env("CARGO_TARGET_DIR", self.0.with_file_name("target"))
            .envs([("GIT_CONFIG_GLOBAL", "/dev/null"), ("GIT_CONFIG_NOSYSTEM", "1")])
            .envs([("GIT_AUTHOR_NAME", "a"), ("GIT_AUTHOR_EMAIL", "a"), ("GIT_COMMITTER_NAME", "a")])
            .env("GIT_COMMITTER_EMAIL", "a")
            .output()
            .expect("the program starts");
        assert!(
            output.status.success(),
            "{program} {arguments:?}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
        String::from_utf8(output.stdout).expect("UTF-8").trim_end().to_string()
    }

    fn git(&self, arguments: &[&str]) -> String {
        self.run("git", arguments, &self.0)
    }

    /// Version of what Cargo builds in a folder.
    fn version_in(&self, folder: &Path) -> String {
        self.run(env!("CARGO"), &["run", "--quiet", "--offline"], folder)
    }

    fn version(&self) -> String {
        self.version_in(&self.0)
    }

    /// Commits everything; the short hash.
    fn commit(&self) -> String {
        self.git(&["add", "."]);
        self.git(&["commit", "--quiet", "--allow-empty", "--message", "next"]);
        self.git(&["rev-parse", "--short", "HEAD"])
    }
}

impl Drop for Crate {
    fn drop(&mut self) {
        let _ = remove_dir_all(self.0.parent().expect("a folder"));
    }
}

#[test]
fn a_version_tells_commits_and_changes_apart_and_is_rebuilt_with_them() {
    let made = Crate::new("commits");
    made.git(&["init", "--quiet"]);
    let first = made.commit();
    assert_eq!(made.version(), format!("0.1.0+1.g{first}"), "before the first tag");
    let second = made.commit();
    assert_eq!(made.version(), format!("0.1.0+2.g{second}"), "of a commit that changes no file");
    made.write(2);
    let dirty = made.version();
    assert!(dirty.starts_with(&format!("0.1.0+2.g{second}.dirty-")), "{dirty}");
    made.write(3);
    assert_ne!(made.version(), dirty, "two changes that are not committed");
}

#[test]
#[ignore = "full suite: it builds a crate seven times"]
fn a_version_follows_tags_and_worktrees_and_is_the_package_s_without_a_repository() {
    let made = Crate::new("tags");
    assert_eq!(made.version(), "0.1.0", "a source archive has no repository");
    made.git(&["init", "--quiet"]);
    // Cargo asks again when a source is newer; it cannot wait for a repository that may never be.
    made.write(1);
    made.commit();
    made.git(&["tag", "v0.2.0-beta"]);
    assert_eq!(made.version(), "0.2.0-beta");
    let next = made.commit();
    assert_eq!(made.version(), format!("0.2.0-beta+1.g{next}"));

    let tree = made.0.with_file_name("worktree");
    let branch = ["worktree", "add", "--quiet", "-b", "other", tree.to_str().expect("UTF-8")];
    made.git(&branch);
    assert_eq!(made.version_in(&tree), format!("0.2.0-beta+1.g{next}"));
    made.run("git", &["commit", "--quiet", "--allow-empty", "--message", "other"], &tree);
    let other = made.run("git", &["rev-parse", "--short", "HEAD"], &tree);
    assert_eq!(made.version_in(&tree), format!("0.2.0-beta+2.g{other}"));
    assert_eq!(made.version(), format!("0.2.0-beta+1.g{next}"));

    // Unpacked within a repository of something else.
    rename(made.0.join(".git"), made.0.with_file_name(".git")).expect("a folder");
    assert_eq!(made.version(), "0.1.0");
}

#[test]
fn the_command_says_the_version_of_the_library() {
    let said = Command::new(env!("CARGO_BIN_EXE_truefeed")).arg("--version").output().expect("it starts");
    assert_eq!(String::from_utf8_lossy(&said.stdout), format!("truefeed {VERSION}\n"));
    let package = env!("CARGO_PKG_VERSION");
    let is_built_on =
        VERSION.strip_prefix(package).is_some_and(|rest| rest.is_empty() || rest.starts_with('+'));
    assert!(is_built_on, "{VERSION}: the last tag is of the version in Cargo.toml, {package}");
}
