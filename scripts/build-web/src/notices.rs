//! Licences and copyright notices of what the modules carry, `notices.txt` of the package.
//!
//! They come from the packages as Cargo has them, at each build, so that the list is never an older one. A package
//! without a licence text, its own or one of its project, fails the build.

use std::collections::{BTreeMap, HashSet};
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;

use crate::{WASM_TARGET, cargo};

const NOTICES: &str = "notices.txt";

/// What no package of Cargo brings.
const HEAD: &str = "Truefeed is licensed under the MIT licence or the Apache licence, version 2.0, as you choose.
The modules beside this file carry the packages below, each under the licence that follows it, and the standard
library of Rust, Copyright (c) The Rust Project Contributors, MIT or Apache 2.0 (https://www.rust-lang.org).
";

/// How files with licences and notices are called, in lower case.
const NAMES: [&str; 4] = ["licen", "copying", "notice", "unlicense"];

#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
    resolve: Resolve,
}

#[derive(Deserialize)]
struct Package {
    id: String,
    name: String,
    version: String,
    license: Option<String>,
    repository: Option<String>,
    manifest_path: PathBuf,
    targets: Vec<PackageTarget>,
}

#[derive(Deserialize)]
struct PackageTarget {
    kind: Vec<String>,
}

#[derive(Deserialize)]
struct Resolve {
    root: String,
    nodes: Vec<Node>,
}

#[derive(Deserialize)]
struct Node {
    id: String,
    deps: Vec<Dependency>,
}

#[derive(Deserialize)]
struct Dependency {
    pkg: String,
    dep_kinds: Vec<DependencyKind>,
}

#[derive(Deserialize)]
struct DependencyKind {
    kind: Option<String>,
}

/// Writes the notices into the folder `package`.
pub fn write(package: &Path) -> Result<()> {
    let output = cargo()
        .args(["metadata", "--locked", "--format-version", "1", "--filter-platform", WASM_TARGET])
        .output()
        .context("cannot run cargo")?;
    ensure!(output.status.success(), "cargo metadata: {}", String::from_utf8_lossy(&output.stderr));
    let metadata: Metadata = serde_json::from_slice(&output.stdout).context("cargo metadata")?;
    let carried = carried(&metadata);
    // Most packages have one of few texts: each text once, below the packages it is of.
    let mut texts: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for package in &carried {
        let licence = package.license.as_deref().unwrap_or("no expression");
        let title = format!("{} {} ({licence})", package.name, package.version);
        let own = licences(package)?;
        let texts_of = if own.is_empty() { relatives_licences(package, &carried)? } else { own };
        for text in texts_of {
            texts.entry(text).or_default().push(title.clone());
        }
    }
    let mut notices = HEAD.to_string();
    let rule = "-".repeat(79);
    for (text, titles) in &texts {
        notices += &format!("\n{rule}\n{}\n\n{text}\n", titles.join("\n"));
    }
    let path = package.join(NOTICES);
    fs::write(&path, notices).with_context(|| format!("cannot write {}", path.display()))?;
    println!("notices of {} packages are in {NOTICES}", carried.len());
    Ok(())
}

/// Texts below this length, bytes, are no licence: a link that a package took for a file, or a list of others.
const MIN_TEXT_BYTES: usize = 400;

/// The packages that become part of the module: neither tools of the build nor macros, nor the crate itself.
fn carried(metadata: &Metadata) -> Vec<&Package> {
    let Metadata { packages, resolve } = metadata;
    let packages: BTreeMap<&str, &Package> = packages.iter().map(|one| (&*one.id, one)).collect();
    let nodes: BTreeMap<&str, &Node> = resolve.nodes.iter().map(|one| (&*one.id, one)).collect();
    let is_macro =
        |id: &str| packages[id].targets.iter().any(|one| one.kind.iter().any(|kind| kind == "proc-macro"));
    let (mut seen, mut open) = (HashSet::from([&*resolve.root]), vec![&*resolve.root]);
    while let Some(id) = open.pop() {
        for dependency in &nodes[id].deps {
            let is_normal = dependency.dep_kinds.iter().any(|one| one.kind.is_none());
            if is_normal && !is_macro(&dependency.pkg) && seen.insert(&dependency.pkg) {
                open.push(&dependency.pkg);
            }
        }
    }
    let mut carried: Vec<&Package> =
        seen.into_iter().filter(|id| *id != resolve.root).map(|id| packages[id]).collect();
    carried.sort_by_key(|one| (&one.name, &one.version));
    carried
}

/// The texts that a package brings. Under a choice with MIT that text is chosen, as the shortest, with all notices.
fn licences(package: &Package) -> Result<Vec<String>> {
    let folder = package.manifest_path.parent().context("a manifest is in a folder")?;
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| format!("cannot list {}", folder.display()))? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
        if path.is_file() && NAMES.iter().any(|word| name.starts_with(word)) {
            files.push((name, path));
        }
    }
    files.sort();
    let is_choice = package.license.as_ref().is_some_and(|one| one.contains("MIT") && !one.contains("AND"));
    if is_choice && files.iter().any(|(name, _)| name.contains("mit")) {
        files.retain(|(name, _)| name.contains("mit") || name.contains("notice"));
    }
    let read =
        |path: &PathBuf| fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()));
    let texts: Vec<String> = files
        .iter()
        .map(|(_, path)| Ok(read(path)?.replace('\r', "").trim().to_string()))
        .collect::<Result<_>>()?;
    Ok(texts.into_iter().filter(|text| MIN_TEXT_BYTES <= text.len()).collect())
}

/// The texts of another package of the same project and licence, for one that brings none.
fn relatives_licences(package: &Package, carried: &[&Package]) -> Result<Vec<String>> {
    // `https://github.com/PROJECT/REPOSITORY`
    let project = |one: &Package| Some(one.repository.as_ref()?.rsplit_once('/')?.0.to_string());
    for other in carried {
        let is_relative = project(package).is_some() && project(other) == project(package);
        if is_relative && other.license == package.license {
            let texts = licences(other)?;
            if !texts.is_empty() {
                return Ok(texts);
            }
        }
    }
    bail!("{} {} brings no licence text", package.name, package.version)
}
