//! The pages that people read: Markdown at the root, in `docs/`, and beside what it describes.

use std::path::{Path, PathBuf};

/// The project's folder.
pub const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Folders with pages.
const FOLDERS: [&str; 6] =
    ["", "docs", "npm", "examples/archive", "tests/data/recordings", ".github/ISSUE_TEMPLATE"];

/// The pages of one folder, sorted.
pub fn markdown(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut found: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|end| end == "md")).collect();
    found.sort();
    found
}

/// Every page with its text.
pub fn pages() -> Vec<(PathBuf, String)> {
    let paths = FOLDERS.iter().flat_map(|folder| markdown(&Path::new(ROOT).join(folder)));
    let pages: Vec<_> = paths
        .map(|path| {
            let text = std::fs::read_to_string(&path).expect("pages are text");
            (path, text)
        })
        .collect();
    assert!(15 < pages.len(), "the pages were not found");
    pages
}

/// A page without its blocks of code and its code spans, line by line as it was.
pub fn without_code(text: &str) -> String {
    let mut is_code = false;
    let lines = text.lines().map(|line| {
        let is_fence = line.trim_start().starts_with("```");
        is_code ^= is_fence;
        if is_code || is_fence {
            return String::new();
        }
        // Odd parts are between backticks.
        line.split('`').enumerate().map(|(part, text)| if part % 2 == 0 { text } else { "" }).collect()
    });
    lines.collect::<Vec<String>>().join("\n")
}
