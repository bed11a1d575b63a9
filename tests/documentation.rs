//! The documentation: links lead somewhere, examples show what the command prints, and the book is complete.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::shared::pages::{ROOT, markdown, pages, without_code};

/// Links of a page with the line they are on, from Markdown and from HTML.
fn links(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (number, line) in without_code(text).lines().enumerate() {
        for (open, close) in [("](", ')'), ("src=\"", '"'), ("srcset=\"", '"'), ("href=\"", '"')] {
            for rest in line.split(open).skip(1) {
                let target = rest.split(close).next().unwrap_or_default();
                found.push((number + 1, target.to_string()));
            }
        }
    }
    found
}

/// The anchors of a page, as GitHub and mdBook make them of headings.
fn anchors(text: &str) -> Vec<String> {
    let headings = without_code(text);
    let headings = headings.lines().filter_map(|line| line.trim_start_matches('#').strip_prefix(' '));
    let slug = |heading: &str| {
        let kept = heading.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.collect::<String>().to_lowercase().replace(' ', "-")
    };
    headings.map(slug).collect()
}

#[test]
fn every_relative_link_leads_to_a_file_and_its_heading() {
    let mut count = 0;
    let mut broken = Vec::new();
    for (path, text) in pages() {
        let folder = path.parent().expect("a page is in a folder");
        for (line, link) in links(&text) {
            if link.starts_with("http") || link.starts_with("mailto:") {
                continue;
            }
            count += 1;
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = if file.is_empty() { path.clone() } else { folder.join(file) };
            let has_anchor = || {
                std::fs::read_to_string(&target).is_ok_and(|page| anchors(&page).iter().any(|a| a == anchor))
            };
            if !target.exists() || (!anchor.is_empty() && !has_anchor()) {
                broken.push(format!("{}:{line}: {link}", path.display()));
            }
        }
    }
    assert!(50 < count, "few links were found: {count}");
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn the_book_holds_every_page_and_leads_nowhere_else() {
    let docs = Path::new(ROOT).join("docs");
    let summary = std::fs::read_to_string(docs.join("SUMMARY.md")).expect("the book has a summary");
    let listed: Vec<PathBuf> = links(&summary).into_iter().map(|(_, link)| docs.join(link)).collect();
    for path in markdown(&docs) {
        assert!(
            path.ends_with("SUMMARY.md") || listed.contains(&path),
            "{} is not in SUMMARY.md",
            path.display()
        );
        // A book has only its own folder, so a link out of it is broken where the book is published.
        let text = std::fs::read_to_string(&path).expect("pages are text");
        let outside: Vec<_> = links(&text).into_iter().filter(|(_, link)| link.starts_with("..")).collect();
        assert!(outside.is_empty(), "{}: {outside:?} leave the book", path.display());
    }
}

#[test]
fn examples_show_what_the_command_prints() {
    let mut count = 0;
    for (path, text) in pages() {
        for block in text.split("```").skip(1).step_by(2) {
            let Some(start) = block.find("$ truefeed ") else { continue };
            let (command, shown) = block[start..].split_once('\n').expect("a block ends with its fence");
            let (command, head) = match command.split_once(" | head -n ") {
                Some((command, lines)) => (command, lines.trim().parse().expect("a number of lines")),
                None => (command, usize::MAX),
            };
            let output = Command::new(env!("CARGO_BIN_EXE_truefeed"))
                .args(command.split_whitespace().skip(2))
                .current_dir(ROOT)
                .output()
                .expect("the command starts");
            assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
            let printed = String::from_utf8(output.stdout).expect("UTF-8");
            let printed: Vec<&str> = printed.lines().take(head).map(str::trim_end).collect();
            let shown: Vec<&str> = shown.trim_end().lines().map(str::trim_end).collect();
            assert_eq!(shown, printed, "{}: {command}", path.display());
            count += 1;
        }
    }
    assert!(0 < count, "no example was found");
}

#[test]
fn the_readme_is_short() {
    let lines = include_str!("../README.md").lines().count();
    assert!(lines <= 120, "{lines} lines: the rest belongs into docs/");
}

#[test]
fn every_key_of_a_prediction_is_described() {
    let output = Command::new(env!("CARGO_BIN_EXE_truefeed"))
        .args(["predict", "www/samples/pocket.nc", "--machine", "examples/machine.toml", "--json"])
        .current_dir(ROOT)
        .output()
        .expect("the command starts");
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let page = include_str!("../docs/json.md");
    let mut keys = Vec::new();
    collect(&result, &mut keys);
    assert!(40 < keys.len(), "few keys: {keys:?}");
    let missing: Vec<_> = keys.iter().filter(|key| !page.contains(&format!("`{key}`"))).collect();
    assert!(missing.is_empty(), "docs/json.md does not describe {missing:?}");
}

/// The keys of all objects in a value, each once.
fn collect(value: &serde_json::Value, keys: &mut Vec<String>) {
    match value {
        serde_json::Value::Object(table) => {
            for (key, value) in table {
                if !keys.contains(key) {
                    keys.push(key.clone());
                }
                collect(value, keys);
            }
        }
        serde_json::Value::Array(list) => list.iter().for_each(|value| collect(value, keys)),
        _ => {}
    }
}

#[test]
fn workflows_call_scripts_that_exist_with_options_that_they_know() {
    let folder = Path::new(ROOT).join(".github/workflows");
    let files: Vec<_> = std::fs::read_dir(folder).expect("there are workflows").collect();
    assert!(4 <= files.len());
    for file in files {
        let path = file.expect("a readable folder").path();
        let text = std::fs::read_to_string(&path).expect("workflows are text");
        for line in text.lines() {
            let mut words = line.split_whitespace();
            let Some(script) = words.find(|word| word.trim_start_matches("./").starts_with("scripts/"))
            else {
                continue;
            };
            let source = std::fs::read_to_string(Path::new(ROOT).join(script));
            let source = source.unwrap_or_else(|_| panic!("{}: {script} is no file", path.display()));
            // Options and names of parts are in the script; paths and what follows are not for it to know.
            for option in words.filter(|word| word.chars().all(|c| c.is_ascii_lowercase() || c == '-')) {
                assert!(source.contains(option), "{}: {script} knows no {option}", path.display());
            }
        }
    }
}
