//! The list of the page's files, for the service worker that keeps them.
//!
//! It is a script beside the package, `self.truefeedFiles = {"version": …, "files": […]}`: paths relative
//! to the page, and a version that is another one whenever a name or a byte of them is.

use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

use anyhow::{Context, Result};

use crate::QUICK;

const LIST: &str = "files.js";

/// What a visitor does not need: the worker that keeps the files and its list, types, what a server sends in the place
/// of the file itself, and the mark of a quick build.
const LEFT_OUT: [&str; 5] = ["sw.js", LIST, ".d.ts", ".br", QUICK];

/// Lists the files of the page that holds the folder `package`, and writes the list there.
pub fn write(package: &Path) -> Result<()> {
    let page = package.parent().context("the package stands in the folder of the page")?;
    let mut files = Vec::new();
    collect(page, page, &mut files)?;
    files.sort();
    // Only ever compared with another version of the same page, so that any good hash does.
    let mut version = DefaultHasher::new();
    for file in &files {
        let path = page.join(file);
        file.hash(&mut version);
        fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?.hash(&mut version);
    }
    let list = serde_json::json!({ "version": format!("{:016x}", version.finish()), "files": files });
    let path = package.join(LIST);
    fs::write(&path, format!("self.truefeedFiles = {list}\n"))
        .with_context(|| format!("cannot write {}", path.display()))?;
    println!("{} files of the page are listed in {}", files.len(), path.display());
    Ok(())
}

/// The files below a folder, as addresses relative to the page.
fn collect(folder: &Path, page: &Path, files: &mut Vec<String>) -> Result<()> {
    let entries = fs::read_dir(folder).with_context(|| format!("cannot list {}", folder.display()))?;
    for entry in entries {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, page, files)?;
            continue;
        }
        let name =
            path.strip_prefix(page).context("it is below the page")?.to_string_lossy().replace('\\', "/");
        if !LEFT_OUT.iter().any(|end| name.ends_with(end)) {
            files.push(name);
        }
    }
    Ok(())
}
