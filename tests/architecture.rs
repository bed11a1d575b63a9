//! The shape of the crate: data flows one way, every border has one keeper, every module says
//! what it models.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Stages in the order data flows. A stage uses only those before it.
const FLOW: &[&str] = &[
    "units",
    "side_by_side",
    "machine",
    "simulation/ordered",
    "simulation/packed",
    "simulation/running_sum",
    "simulation/sampled",
    "simulation/gcode",
    "simulation/toolpath",
    "simulation/interpreter",
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
    "identification/measured",
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
    let mut sources = all_sources();
    sources.retain(|(path, _)| path != "main" && !path.starts_with("command/"));
    sources
}

/// All sources, with those of the command line.
fn all_sources() -> Vec<(String, String)> {
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
        ("serde", &["project", "web", "identification/recording/formats/siemens_recorder"]),
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
    for (path, text) in sources().into_iter().filter(|(path, _)| !path.ends_with("tests")) {
        let code = code(&text);
        let code = code.split("#[cfg(test)]").next().expect("split gives a first part");
        for (word, allowed) in keepers {
            let kept =
                allowed.iter().any(|keeper| path == *keeper || path.starts_with(&format!("{keeper}/")));
            assert!(kept || !code.contains(word), "{path}: `{word}` is kept by {allowed:?}");
        }
    }
}

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

/// The modules from which their uses lead back to themselves.
fn in_circles(uses: &BTreeMap<String, BTreeSet<String>>) -> Vec<&str> {
    let is_in_circle = |module: &&String| {
        let mut reached = BTreeSet::new();
        let mut open = vec![*module];
        while let Some(module) = open.pop() {
            open.extend(uses.get(module).into_iter().flatten().filter(|next| reached.insert(*next)));
        }
        reached.contains(module)
    };
    uses.keys().filter(is_in_circle).map(String::as_str).collect()
}

#[test]
fn no_modules_use_each_other_in_circles() {
    let set = |names: &[&str]| names.iter().map(|name| name.to_string()).collect::<BTreeSet<_>>();
    let drawn = [("a", set(&["b"])), ("b", set(&["c"])), ("c", set(&["b", "d"])), ("d", set(&[]))];
    let drawn = drawn.map(|(module, uses)| (module.to_string(), uses)).into();
    assert_eq!(in_circles(&drawn), ["b", "c"]);
    let uses = uses();
    assert!(uses["simulation/feed/rest_to_rest"].contains("simulation/feed/blend"), "imports are seen");
    assert_eq!(in_circles(&uses), [""; 0]);
}

/// For each file of a room, the other files whose methods it calls on the one object that the room is about: no import
/// shows these. `files` are paths and texts.
fn method_calls(files: &[(String, String)], object: &str) -> BTreeMap<String, BTreeSet<String>> {
    let own = |text: &str| code(text).split("#[cfg(test)]").next().unwrap_or_default().to_string();
    let mut homes: BTreeMap<String, BTreeSet<&str>> = BTreeMap::new();
    for (path, text) in files.iter().filter(|(_, text)| text.contains(&format!(" {object}<"))) {
        for line in own(text).lines().filter(|line| line.starts_with("    ") && !line.starts_with("     ")) {
            if let Some((_, name)) = line.split_once("fn ") {
                let name = name.split(['(', '<']).next().unwrap_or_default();
                homes.entry(name.to_string()).or_default().insert(path);
            }
        }
    }
    let called = |(path, text): &(String, String)| {
        let text = own(text);
        let receivers = ["self.", "interpreter."];
        let calls = receivers.iter().flat_map(|receiver| text.split(receiver).skip(1));
        let names = calls.filter_map(|rest| {
            let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_')?;
            rest[end..].starts_with('(').then(|| rest[..end].to_string())
        });
        let others = names.filter_map(|name| homes.get(&name)).flatten().filter(|home| **home != path);
        (path.clone(), others.map(|home| home.to_string()).collect())
    };
    files.iter().map(called).collect()
}

#[test]
fn no_files_of_the_interpreter_call_each_other_in_circles() {
    let file = |path: &str, text: &str| (path.to_string(), text.to_string());
    let planted = [
        file("a", "impl Interpreter<'_> {\n    fn one(&mut self) {\n        self.two();\n    }\n}\n"),
        file(
            "b",
            "impl Interpreter<'_> {\n    pub(crate) fn two(&mut self) {\n        self.three();\n    }\n}\n",
        ),
        file(
            "c",
            "impl Interpreter<'_> {\n    fn three(&self) {}\n    fn four(&mut self) {\n        self.two();\n    }\n}\n",
        ),
    ];
    assert_eq!(in_circles(&method_calls(&planted, "Interpreter")), ["b", "c"]);
    let mut files = sources();
    files.retain(|(path, _)| path.starts_with("simulation/interpreter/") && !path.ends_with("tests"));
    let calls = method_calls(&files, "Interpreter");
    let motion = &calls["simulation/interpreter/motion"];
    assert!(motion.contains("simulation/interpreter/feed_mode/feedrate"), "calls are seen: {motion:?}");
    assert_eq!(in_circles(&calls), [""; 0]);
}

/// The most lines of a function, from its `fn` to its closing brace.
const MAX_FUNCTION_LINES: usize = 80;

/// What a comment above a longer function begins with.
const REASON: &str = "// Long because ";

/// The functions beyond `MAX_FUNCTION_LINES` of a formatted source that do not say why: line, name and lines.
fn long_functions(text: &str) -> Vec<(usize, &str, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let mut found = Vec::new();
    for (at, line) in lines.iter().enumerate() {
        let code = line.trim_start();
        let indent = &line[..line.len() - code.len()];
        let Some((before, after)) = code.split_once("fn ") else { continue };
        let is_qualifier = |word: &str| {
            ["const", "async", "unsafe"].contains(&word) || word.starts_with("pub") || word.ends_with(')')
        };
        if !before.split_whitespace().all(is_qualifier) {
            continue;
        }
        let name = after.split(['(', '<']).next().unwrap_or(after);
        // rustfmt puts the closing brace below the first letter, and nothing before it; a declaration has none.
        let is_end = |(nth, line): (usize, &&str)| {
            let is_whole = nth == 0 && line.ends_with(['}', ';']);
            let closes = |rest: &str| rest == "}" || rest.starts_with(')') && rest.ends_with(';');
            is_whole || line.strip_prefix(indent).is_some_and(closes)
        };
        let Some(end) = lines[at..].iter().enumerate().position(is_end) else { continue };
        let above = lines[..at].iter().rev().map(|line| line.trim_start());
        let mut above = above.take_while(|line| line.starts_with("//") || line.starts_with("#["));
        if MAX_FUNCTION_LINES < end + 1 && !above.any(|line| line.starts_with(REASON)) {
            found.push((at + 1, name, end + 1));
        }
    }
    found
}

#[test]
fn long_functions_say_why() {
    let long = |above: &str, head: &str, lines: usize| {
        format!("impl A {{\n{above}    {head} {{\n{}    }}\n}}\n", "        a();\n".repeat(lines - 2))
    };
    for head in
        ["fn f()", "pub fn f<T>(\n    )", "pub(in crate::a::b) const fn f()", "pub(super) async fn f() -> A"]
    {
        let extra = head.lines().count() - 1;
        assert_eq!(long_functions(&long("", head, 80 - extra)), []);
        assert_eq!(long_functions(&long("", head, 81 - extra)), [(2, "f", 81)], "{head}");
    }
    let reason = "    // Long because it is a table.\n    #[inline]\n";
    assert_eq!(long_functions(&long(reason, "fn f()", 200)), []);
    assert_eq!(long_functions(&long("    // Long ago.\n", "fn f()", 81)), [(3, "f", 81)]);
    let short = format!(
        "trait A {{\n    fn a();\n    fn b(\n    ) -> u8;\n    fn c() {{}}\n}}\n{}",
        "const C: u8 = 1;\n".repeat(200)
    );
    assert_eq!(long_functions(&short), []);

    for (path, text) in all_sources() {
        let long = long_functions(&text);
        assert!(
            long.is_empty(),
            "{path}: functions of more than {MAX_FUNCTION_LINES} lines; split them or say above `{REASON}…`: {long:?}"
        );
    }
}

/// Names of numbers without a quantity or a role.
const BARE_NAMES: &[&str] = &[
    "ACTS",
    "ALIKE",
    "ALONE",
    "APART",
    "AROUND",
    "BACK",
    "BEFORE",
    "BEGINNING",
    "BELIEVED",
    "BELOW",
    "BESIDE",
    "BETWEEN",
    "BIG",
    "BROAD",
    "CERTAIN",
    "CLEARLY_LESS",
    "CLIMBS",
    "CLOSE",
    "CLOSE_ENOUGH",
    "CONTRADICTED",
    "DEEPEST",
    "DEPENDENT",
    "DOT",
    "DOUBTFUL",
    "ELSEWHERE",
    "END",
    "ENOUGH",
    "EVERY",
    "EXACT",
    "FAR",
    "FARTHER",
    "FARTHEST",
    "FASTER",
    "FASTEST",
    "FEW",
    "FEWEST",
    "FINEST",
    "FIRST",
    "GAIN",
    "GOOD",
    "HALF",
    "HARDLY",
    "HELD_BACK",
    "HIDDEN",
    "HIGHEST",
    "IN_PLACE",
    "KNOWN",
    "LARGE",
    "LARGEST",
    "LATE",
    "LEAST",
    "LEFT",
    "LINES",
    "LISTED",
    "LITTLE",
    "LONG",
    "LONGER",
    "LONGEST",
    "LOW",
    "LOWEST",
    "MANY",
    "MOST",
    "MOVED",
    "MUCH",
    "NAMED",
    "NEAR",
    "NEAREST",
    "OPPOSITE",
    "OTHERS",
    "OUT",
    "PALE",
    "PART",
    "PARTS",
    "POINTS",
    "POLLS",
    "REACHED",
    "READ",
    "RECONSIDERED",
    "ROUGHLY",
    "ROUNDING",
    "ROUNDS",
    "SAID",
    "SAME",
    "SEEN",
    "SEPARATED",
    "SHORT",
    "SHORTEST",
    "SHOWN",
    "SLIGHT",
    "SMALL",
    "SMALLEST",
    "STANDING",
    "STANDS",
    "STAYS",
    "STEADY",
    "STEEP",
    "STEP",
    "STEPS",
    "STILL",
    "STRAIGHT",
    "TELLS",
    "THERE",
    "TIMES",
    "TOLD",
    "UNKNOWN",
    "USUAL",
    "WELL",
    "WIDEST",
    "WITHIN",
];

/// Returns name and type of the constant that a line declares.
fn declared_constant(line: &str) -> Option<(&str, &str)> {
    let (before, declared) = line.split_once("const ")?;
    let is_visibility = |word: &str| word.starts_with("pub") || word.ends_with(')');
    let (name, rest) = declared.split_once(": ")?;
    let (kind, _) = rest.split_once(" =")?;
    before.split_whitespace().all(is_visibility).then_some((name, kind))
}

/// Returns the faults of the numeric constants of a source: bare names, and tuples other than bounds of one quantity.
fn faults_of_constants(text: &str) -> Vec<String> {
    let is_number =
        |kind: &str| ["f32", "f64", "usize", "u8", "u16", "u32", "u64", "i32", "i64"].contains(&kind);
    let mut faults = Vec::new();
    for (name, kind) in text.lines().filter_map(declared_constant) {
        if is_number(kind) && BARE_NAMES.contains(&name) {
            faults.push(format!("{name}: name quantity, role and unit, such as `MIN_STANDSTILL_S`"));
        }
        let items = kind.strip_prefix('(').and_then(|kind| kind.strip_suffix(')'));
        let is_tuple = items.is_some_and(|items| items.split(", ").all(is_number));
        if is_tuple && !name.contains("BOUNDS") {
            faults.push(format!(
                "{name}: two constants, or a struct; `…_BOUNDS…` of one quantity may be a tuple"
            ));
        }
    }
    faults
}

/// Returns a source without its unit tests.
fn without_tests(text: &str) -> &str {
    text.split("#[cfg(test)]\nmod ").next().expect("split gives a first part")
}

#[test]
fn constants_say_what_they_measure() {
    let text = "const MOST: usize = 3;\npub(super) const STEP: f64 = 0.5;\nconst STEP_MM: f64 = 1.0;\n\
                const LOW: View = VIEW;\nconst REACH_AND_ORDER: (f64, usize) = (0.1, 2);\n\
                const TAX_BOUNDS: (f64, f64) = (0.0, 1.0);\n";
    let faults = faults_of_constants(text);
    let names: Vec<&str> = faults.iter().filter_map(|fault| fault.split(':').next()).collect();
    assert_eq!(names, ["MOST", "STEP", "REACH_AND_ORDER"]);
    for (path, text) in all_sources() {
        if path.ends_with("tests") {
            continue;
        }
        let faults = faults_of_constants(without_tests(&text));
        assert!(faults.is_empty(), "{path}: {}", faults.join("; "));
    }
}

/// Returns the types that a source declares.
fn declared_types(text: &str) -> impl Iterator<Item = &str> {
    let is_visibility = |word: &str| word.starts_with("pub") || word == "in" || word.ends_with(')');
    without_tests(text).lines().filter_map(move |line| {
        // A type of a trait is indented.
        let (before, after) =
            ["struct ", "enum ", "trait ", "type "].iter().find_map(|word| line.split_once(word))?;
        let is_declaration = !line.starts_with(' ') && before.split_whitespace().all(is_visibility);
        is_declaration
            .then(|| after.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default())
    })
}

#[test]
fn a_type_name_belongs_to_one_stage() {
    let declared: Vec<&str> =
        declared_types("pub(in crate::a) struct A<T>(T);\n    type Item = A;\nenum B {\nfn c() {}\n")
            .collect();
    assert_eq!(declared, ["A", "B"]);
    let glossary = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/glossary.md"));
    let glossary = glossary.expect("the glossary can be read");
    let mut stages: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (path, text) in all_sources().into_iter().filter(|(path, _)| !path.ends_with("tests")) {
        let is_command = path == "main" || path.starts_with("command/");
        let stage = if is_command {
            "command"
        } else if path == "lib" {
            "lib"
        } else {
            FLOW[stage_of(&path)]
        };
        for name in declared_types(&text) {
            stages.entry(name.to_string()).or_default().insert(stage.to_string());
        }
    }
    // A word that several stages share has its entry, with the type in the field's letters.
    stages.retain(|name, stages| 1 < stages.len() && !glossary.contains(&format!("`{name}`")));
    assert!(stages.is_empty(), "types of one name in several stages; qualify them: {stages:#?}");
}

/// Returns the position in `FLOW` of the stage of a source, of the front of stages that of their first.
fn stage_of(path: &str) -> usize {
    if CONTENTS.contains(&path) { 0 } else { stage(path) }
}

#[test]
fn no_folder_holds_only_tests_and_every_layout_is_the_same() {
    let sources: Vec<String> = all_sources().into_iter().map(|(path, _)| path).collect();
    let folders: BTreeSet<&str> = sources.iter().filter_map(|path| Some(path.rsplit_once('/')?.0)).collect();
    for folder in folders {
        let below: Vec<&str> =
            sources.iter().filter_map(|path| path.strip_prefix(folder)?.strip_prefix('/')).collect();
        assert!(
            below.iter().any(|path| !path.ends_with("tests")),
            "{folder}: holds only tests; put them into its file"
        );
        assert!(below.contains(&"mod"), "{folder}: a module with parts is `{folder}/mod.rs`");
    }
}
