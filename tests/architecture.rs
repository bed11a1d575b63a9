//! The shape of the crate: data flows one way, every border has one keeper, every module says
//! what it models.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Stages in the order data flows. A stage uses only those before it.
const FLOW: &[&str] = &[
    "units",
    "machine",
    "simulation/compact",
    "simulation/running_sum",
    "simulation/sampled",
    "simulation/gcode",
    "simulation/toolpath",
    "simulation/filter",
    "simulation/feed",
    "simulation/profile",
    "simulation/drive",
    "simulation/contour",
    "simulation/simulate",
    "cutting",
    "quote",
    "identification/recording",
    "identification/alignment",
    "identification/comparison",
    "identification/fit",
    "identification/effects",
    "identification/calibration",
    "identification/diagnosis",
    "identification/probe",
    "identification/step",
    "plot",
    "project",
    "web",
];

/// Files that only list modules.
const CONTENTS: &[&str] = &["lib", "simulation/mod", "identification/mod"];

/// All sources but the command line, which like a test stands outside: path below `src` without
/// its extension, and text.
fn sources() -> Vec<(String, String)> {
    fn collect(folder: &Path, root: &Path, into: &mut Vec<(String, String)>) {
        for entry in std::fs::read_dir(folder).expect("src can be listed") {
            let path = entry.expect("src can be listed").path();
            if path.is_dir() {
                collect(&path, root, into);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let name = path.strip_prefix(root).expect("below src").with_extension("");
                let name = name.to_str().expect("names are ASCII").replace('\\', "/");
                into.push((name, std::fs::read_to_string(&path).expect("sources are UTF-8")));
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut sources = Vec::new();
    collect(&root, &root, &mut sources);
    sources.retain(|(path, _)| path != "main" && !path.starts_with("command/"));
    assert!(10 < sources.len(), "the sources were found");
    sources
}

/// Code without comments.
fn code(text: &str) -> String {
    text.lines().filter(|line| !line.trim_start().starts_with("//")).map(|line| format!("{line}\n")).collect()
}

/// Position in `FLOW` of the stage that holds `path`.
fn stage(path: &str) -> usize {
    let holds = |stage: &&str| path == *stage || path.starts_with(&format!("{stage}/"));
    FLOW.iter().position(holds).unwrap_or_else(|| panic!("`{path}` is in no stage of FLOW"))
}

#[test]
fn data_flows_one_way() {
    for (path, text) in sources().into_iter().filter(|(path, _)| !CONTENTS.contains(&path.as_str())) {
        let own = stage(&path);
        let code = code(&text);
        assert!(!code.contains("crate::{"), "{path}: one `use crate::stage::…` per stage");
        assert!(!code.contains("super::super"), "{path}: write `crate::…`, which this test can see");
        for used in code.split("crate::").skip(1) {
            let end = used.find(|c: char| !c.is_alphanumeric() && c != '_' && c != ':').unwrap_or(used.len());
            let used = used[..end].replace("::", "/");
            assert!(stage(&used) <= own, "{path}: must not use `{used}`");
        }
    }
}

#[test]
fn every_module_says_what_it_models() {
    for (path, text) in sources() {
        if path.ends_with("tests") {
            continue;
        }
        let head: Vec<&str> = text.lines().take_while(|line| line.starts_with("//!")).collect();
        assert!(!head.is_empty(), "{path}: begins with `//!`");
        let lines = text.lines().count();
        assert!(lines <= 600, "{path}: {lines} lines; split it by meaning");
    }
}

#[test]
fn every_border_has_one_keeper() {
    let keepers: &[(&str, &[&str])] = &[
        ("serde", &["project", "web", "identification/recording/siemens_recorder"]),
        ("toml::", &["project"]),
        ("wasm_bindgen", &["web"]),
        ("js_sys", &["web"]),
        ("web_sys", &["web"]),
        ("plotters", &["plot", "web"]),
        ("std::fs", &[]),
        // Readers of packed recordings take bytes that are in memory.
        ("std::io", &["identification/recording/packed"]),
        ("std::time", &[]),
        ("std::env", &[]),
        ("println!", &[]),
    ];
    // Tests of a stage may read files.
    for (path, text) in sources().into_iter().filter(|(path, _)| !path.ends_with("/tests")) {
        let code = code(&text);
        let code = code.split("#[cfg(test)]").next().expect("split gives a first part");
        for (word, allowed) in keepers {
            let kept =
                allowed.iter().any(|keeper| path == *keeper || path.starts_with(&format!("{keeper}/")));
            assert!(kept || !code.contains(word), "{path}: `{word}` is kept by {allowed:?}");
        }
    }
}

/// Rooms whose modules still use each other in circles.
const TANGLED: &[&str] = &["simulation/toolpath", "simulation/gcode", "project/offer"];

/// The modules that each module uses, by `use` and by paths, but for those above and below it: the module of a folder
/// is its front.
fn uses() -> BTreeMap<String, BTreeSet<String>> {
    let modules: BTreeMap<String, String> = (sources().into_iter())
        .map(|(path, text)| (path.strip_suffix("/mod").unwrap_or(&path).to_string(), text))
        .filter(|(path, _)| !path.ends_with("tests"))
        .collect();
    let of = |(path, text): (&String, &String)| {
        let code = code(text);
        let code = code.split("#[cfg(test)]\nmod ").next().expect("split gives a first part");
        let is_beside = |other: &&str| {
            let is_below = |one: &str, other: &str| one.starts_with(&format!("{other}/"));
            *other != path && !is_below(path, other) && !is_below(other, path)
        };
        let used = code.split("crate::").skip(1).flat_map(|rest| {
            let end = rest.find(|c: char| !c.is_alphanumeric() && !"_:".contains(c)).unwrap_or(rest.len());
            let stem = rest[..end].trim_end_matches(':').replace("::", "/");
            // What stands in the brackets may be modules too.
            let inside = rest[end..].strip_prefix('{').and_then(|list| list.split('}').next()).unwrap_or("");
            let items = inside.split(',').map(|item| item.trim().replace("::", "/"));
            items.map(|item| format!("{stem}/{item}")).chain([stem.clone()]).collect::<Vec<_>>()
        });
        let nearest = |used: String| {
            let ends = used.match_indices('/').map(|(at, _)| at).chain([used.len()]);
            let known = ends.map(|end| &used[..end]).rfind(|path| modules.contains_key(*path));
            known.filter(is_beside).map(str::to_string)
        };
        (path.clone(), used.filter_map(nearest).collect())
    };
    modules.iter().map(of).collect()
}

#[test]
fn no_modules_use_each_other_in_circles() {
    let uses = uses();
    let reached = |from: &str| {
        let mut reached = BTreeSet::new();
        let mut open = vec![from.to_string()];
        while let Some(module) = open.pop() {
            for next in uses.get(&module).into_iter().flatten() {
                if reached.insert(next.clone()) {
                    open.push(next.clone());
                }
            }
        }
        reached
    };
    assert!(uses["simulation/feed/stretch"].contains("simulation/feed/blend"), "imports are seen");
    assert!(reached("simulation/toolpath/trace").contains("simulation/toolpath/trace"), "circles are seen");
    for module in uses.keys().filter(|module| !TANGLED.iter().any(|room| module.starts_with(room))) {
        let reached = reached(module);
        assert!(!reached.contains(module), "{module} is in a circle through some of {reached:?}");
    }
}
