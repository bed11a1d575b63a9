//! Phrases that readers had to read twice, in the pages and in every text of the crate. The list holds the line; it is no
//! substitute for reading.

use std::path::{Path, PathBuf};

use crate::shared::pages::{ROOT, pages, without_code};

/// A phrase, and what says it at once. An asterisk ends a part of a word.
const PHRASES: &[(&str, &str)] = &[
    ("anew", "again"),
    ("begun again", "restarted"),
    ("mended", "fixed, corrected"),
    ("mend*", "fix, correct"),
    ("of its own", "its own"),
    ("of their own", "their own"),
    ("of your own", "your own, yourself"),
    ("is told", "who tells whom?"),
    ("are told", "who tells whom?"),
    ("was told", "who tells whom?"),
    ("told apart", "separate, distinguish"),
    ("is said", "name who says it"),
    ("are said", "name who says it"),
    ("said to be", "reported as"),
    ("stands", "is, is listed, waits"),
    ("stood", "was, was listed, waited"),
    ("stays as it", "does not change"),
    ("stay as they", "do not change"),
    ("laid on", "aligned with"),
    ("laid over", "replaces"),
    ("goes on", "continues"),
    ("go on", "continue"),
    ("so many", "give the number"),
    ("none where", "split the sentence"),
    ("not so", "say what happens instead"),
    ("where it was", "previously"),
    ("as it was before", "unchanged"),
    ("taken back", "undone"),
    ("takes back", "undoes, removes"),
    ("passed over", "ignored"),
    ("nothing is left", "nothing remains"),
    ("in sight", "shown"),
    ("would say", "name the figure"),
    ("put together", "assembled"),
    ("is of one", "name the relation"),
];

/// The phrases found in a text; words are compared without case and punctuation.
fn found(text: &str) -> Vec<&'static str> {
    let lower = text.to_lowercase();
    let words: Vec<&str> =
        lower.split(|c: char| !c.is_alphanumeric() && c != '\'').filter(|word| !word.is_empty()).collect();
    let plain = format!(" {} ", words.join(" "));
    let is_in = |phrase: &str| match phrase.strip_suffix('*') {
        Some(start) => plain.contains(&format!(" {start} ")) || plain.contains(&format!(" {start}s ")),
        None => plain.contains(&format!(" {phrase} ")),
    };
    let mut all: Vec<&str> =
        PHRASES.iter().map(|(phrase, _)| *phrase).filter(|phrase| is_in(phrase)).collect();
    // A clause with `what` for a subject makes the reader wait for the noun.
    if sentences(text).any(|sentence| sentence.starts_with("What ") && !sentence.ends_with('?')) {
        all.push("What … (as a subject)");
    }
    all
}

/// Sentences of a text with the mark that ends them; headings and cells, which have none, are left out.
fn sentences(text: &str) -> impl Iterator<Item = String> + '_ {
    text.split_inclusive(['.', '?', '!'])
        .map(|sentence| sentence.split_whitespace().collect::<Vec<_>>().join(" "))
        .filter(|sentence| sentence.ends_with(['.', '?', '!']) && !sentence.contains('|'))
}

#[test]
fn the_rule_finds_what_it_should() {
    for (planted, phrase) in [
        ("Diagnosed anew.", "anew"),
        ("Mend the line.", "mend*"),
        ("What stands in the file stays.", "stands"),
        ("The rest is fine. What cannot be read is listed.", "What … (as a subject)"),
        ("empty: not so.", "not so"),
    ] {
        assert!(found(planted).contains(&phrase), "{planted}: {:?}", found(planted));
    }
    assert!(found("A standstill. What is a quote? | What it does | The renewed plan is amended.").is_empty());
}

#[test]
fn the_pages_are_plain() {
    let mut faults = Vec::new();
    for (path, text) in pages() {
        // A paragraph at a time, so that a fault has a place.
        for paragraph in without_code(&text).split("\n\n") {
            for phrase in found(paragraph) {
                let start: String = paragraph.trim().chars().take(70).collect();
                faults.push(format!("{}: “{phrase}” in: {start}", path.display()));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn the_texts_of_the_crate_are_plain() {
    let mut files = Vec::new();
    sources(&Path::new(ROOT).join("src"), &mut files);
    let mut count = 0;
    let mut faults = Vec::new();
    for path in files {
        let source = std::fs::read_to_string(&path).expect("sources are text");
        for literal in literals(&source).into_iter().filter(|literal| literal.contains(' ')) {
            count += 1;
            for phrase in found(&literal) {
                faults.push(format!("{}: “{phrase}” in: {literal}", path.display()));
            }
        }
    }
    assert!(1000 < count, "few texts were found: {count}");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Beginnings of doc comments without a noun for the thing, and what says it.
const DOC_BEGINNINGS: &[(&str, &str)] = &[
    ("What ", "the noun: `The result of …`"),
    ("Whether ", "Returns `true` if …"),
    ("The same", "the noun"),
    ("None of ", "the noun"),
    ("So many ", "`Number of …`, `Most …`"),
    ("How ", "the noun: `Number of …`, `Duration of …`"),
    ("Those ", "the noun"),
    ("That of ", "the noun"),
    ("It ", "the noun"),
    ("Why ", "`The reason why …`"),
];

/// Phrases that docs must not use, beyond those of every text.
const DOC_PHRASES: &[&str] = &["as it is", "asked for", "are asked", "is asked", "nobody", "what is"];

/// The doc comments of a source before its unit tests, each as one text.
fn docs(source: &str) -> Vec<String> {
    let source = source.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
    let mut docs = Vec::new();
    let mut is_open = false;
    let mut is_code = false;
    for line in source.lines().map(str::trim_start) {
        let Some(text) = line.strip_prefix("///").or_else(|| line.strip_prefix("//!")) else {
            (is_open, is_code) = (false, false);
            continue;
        };
        if text.trim_start().starts_with("```") {
            is_code = !is_code;
        } else if !is_code && !is_open {
            docs.push(text.trim().to_string());
        } else if !is_code {
            let last: &mut String = docs.last_mut().expect("a doc comment is open");
            *last += &format!("\n{}", text.trim());
        }
        is_open = true;
    }
    docs
}

/// The faults of a doc comment: phrases without a subject, and beginnings without a noun.
fn faults_of_doc(doc: &str) -> Vec<&'static str> {
    let beginnings =
        DOC_BEGINNINGS.iter().map(|(beginning, _)| *beginning).filter(|beginning| doc.starts_with(beginning));
    let plain = format!(" {} ", doc.to_lowercase().split_whitespace().collect::<Vec<_>>().join(" "));
    let phrases = DOC_PHRASES.iter().copied().filter(|phrase| plain.contains(&format!(" {phrase} ")));
    // A table or a formula has its own language.
    let sentences: Vec<&str> = doc.split("\n\n").filter(|paragraph| !paragraph.contains('|')).collect();
    beginnings.chain(phrases).chain(found(&sentences.join("\n\n"))).collect()
}

#[test]
fn docs_say_what_they_document() {
    let planted = "//! What a thing is.\n//!\n//! ```\n//! What::new();\n//! ```\n\n/// Whether it\n/// stands.\nfn a() {}\n\
                   /// Returns `true`.\nfn b() {}\n#[cfg(test)]\nmod tests {\n/// What it tests.\n}\n";
    assert_eq!(docs(planted), ["What a thing is.\n", "Whether it\nstands.", "Returns `true`."]);
    assert_eq!(faults_of_doc("Whether it\nstands."), ["Whether ", "stands"]);
    let mut files = Vec::new();
    let src = Path::new(ROOT).join("src");
    sources(&src, &mut files);
    let mut faults = Vec::new();
    let mut count = 0;
    for path in files {
        let room = path.strip_prefix(&src).expect("below src").to_string_lossy().replace('\\', "/");
        for doc in docs(&std::fs::read_to_string(&path).expect("sources are text")) {
            count += 1;
            for fault in faults_of_doc(&doc) {
                faults.push(format!("{}: “{fault}” in: {}", room, doc.lines().next().unwrap_or_default()));
            }
        }
    }
    assert!(2000 < count, "few docs were found: {count}");
    assert!(faults.is_empty(), "{} faults\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn the_texts_of_the_page_are_plain() {
    let mut count = 0;
    let mut faults = Vec::new();
    for name in ["www/texts.js", "www/texts_later.js"] {
        let source = std::fs::read_to_string(Path::new(ROOT).join(name)).expect("the texts can be read");
        for literal in texts_of_script(&source) {
            count += 1;
            for phrase in found(&literal) {
                faults.push(format!("{name}: “{phrase}” in: {literal}"));
            }
        }
    }
    assert!(300 < count, "few texts were found: {count}");
    assert!(faults.is_empty(), "{} faults\n{}", faults.len(), faults.join("\n"));
}

/// The string and template literals of a script that hold a blank.
fn texts_of_script(source: &str) -> Vec<String> {
    let mut texts = Vec::new();
    let mut rest = source;
    while let Some(at) = rest.find(['"', '\'', '`', '/']) {
        let after = &rest[at + 1..];
        let mark = rest.as_bytes()[at];
        rest = match mark {
            b'/' if after.starts_with('/') => after.split_once('\n').map_or("", |(_, next)| next),
            b'/' if after.starts_with('*') => after.split_once("*/").map_or("", |(_, next)| next),
            b'/' => after,
            _ => {
                let mut end = 0;
                let bytes = after.as_bytes();
                while end < bytes.len() && bytes[end] != mark {
                    end += if bytes[end] == b'\\' { 2 } else { 1 };
                }
                let text = &after[..end.min(bytes.len())];
                if text.contains(' ') {
                    texts.push(text.to_string());
                }
                after.get(end + 1..).unwrap_or_default()
            }
        };
    }
    texts
}

/// Sources that speak to people; tests speak to developers.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder of sources").flatten() {
        let path = entry.path();
        match path.is_dir() {
            true if !path.ends_with("tests") => sources(&path, found),
            false if !path.to_string_lossy().ends_with("tests.rs") => found.push(path),
            _ => {}
        }
    }
}

/// The string literals of a source before its tests, but for those that `expect` and its like show to developers.
fn literals(source: &str) -> Vec<String> {
    let source = source.split("#[cfg(test)]").next().unwrap_or_default();
    let mut found = Vec::new();
    let mut rest = source;
    while let Some(at) = rest.find(['"', '\'', '/']) {
        let (before, mark) = rest.split_at(at);
        let after = &mark[1..];
        rest = match mark.as_bytes()[0] {
            b'/' if after.starts_with('/') => after.split_once('\n').map_or("", |(_, next)| next),
            b'/' => after,
            // A character, or a lifetime, which has no second mark.
            b'\'' => match after.strip_prefix('\\') {
                Some(escaped) => &escaped[1..],
                None => after.strip_prefix("\"'").unwrap_or(after),
            },
            _ => {
                let mut end = 0;
                while !after[end..].starts_with('"') {
                    end += if after[end..].starts_with('\\') {
                        2
                    } else {
                        after[end..].chars().next().map_or(1, char::len_utf8)
                    };
                }
                let is_ours = ["expect(", "panic!(", "unreachable!(", "debug_assert!("]
                    .iter()
                    .any(|call| before.ends_with(call));
                if !is_ours {
                    found.push(continued(&after[..end]));
                }
                &after[end + 1..]
            }
        };
    }
    found
}

/// A literal with the lines joined that a backslash continues.
fn continued(literal: &str) -> String {
    let mut parts = literal.split("\\\n");
    let first = parts.next().unwrap_or_default().to_string();
    parts.fold(first, |text, part| text + part.trim_start())
}
