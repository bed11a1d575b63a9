//! The reference pages: every key of the machine file, from the parameter table, and every command, from its help.
//!
//! `cargo run --example reference` writes `docs/machine-file.md` and `docs/cli.md`.

use std::fmt::Write;
use std::path::Path;

use serde_json::Value;

#[path = "../src/command/help.rs"]
mod help;

const MACHINE_FILE: &str = "# Machine file

A machine file describes one machine in [TOML](https://toml.io). This is the least it must contain; every other key is optional
and has no effect when left out:

```toml
";

const KEYS: &str = "```

[Which numbers of my machine?](machine.md) says where controls show them. The form on the page has the same keys, and saves and
loads this file. Truefeed refuses an unknown key and names the nearest known one.

Below, *left out* is the value a key has when the file does not contain it. A key such as `axis.x.rapid_mm_min` is the key
`rapid_mm_min` in the table `[axis.x]`. `cargo run --example reference` writes this page from the table of parameters.
";

const COMMANDS: &str = "# Command line

`cargo install --path .` installs the command `truefeed` from a clone. This page contains what `--help` prints;
`cargo run --example reference` writes it.

";

fn main() -> std::io::Result<()> {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    std::fs::write(docs.join("machine-file.md"), machine_file())?;
    std::fs::write(docs.join("cli.md"), commands())
}

/// The page of the machine file's keys, a table for each group of the form.
pub fn machine_file() -> String {
    let form: Value = serde_json::from_str(&truefeed::project::form()).expect("the form is JSON");
    let fields = form["fields"].as_array().expect("a form has fields");
    let mut groups: Vec<&str> = Vec::new();
    for field in fields {
        let group = text(field, "group");
        if !groups.contains(&group) {
            groups.push(group);
        }
    }
    let mut page = MACHINE_FILE.to_string() + include_str!("machine.toml") + KEYS;
    for group in groups {
        write!(page, "\n## {group}\n\n| key | values | left out | meaning |\n|---|---|---|---|\n")
            .expect(STRING);
        for field in fields.iter().filter(|field| text(field, "group") == group) {
            let (key, doc) = (text(field, "key"), text(field, "doc"));
            writeln!(page, "| `{key}` | {} | {} | {doc} |", values(field), neutral(field)).expect(STRING);
        }
    }
    page
}

const STRING: &str = "a string takes any text";

fn text<'a>(field: &'a Value, name: &str) -> &'a str {
    field[name].as_str().unwrap_or_default()
}

/// The values that a key takes, with their unit and bounds.
fn values(field: &Value) -> String {
    let whole = if field["whole"] == true { "whole number" } else { "number" };
    let unit = match text(field, "unit") {
        "" => String::new(),
        unit => format!(" {unit}"),
    };
    let bounds = match (field["min"].as_f64(), field["max"].as_f64()) {
        (Some(min), Some(max)) => format!(", {min} to {max}{unit}"),
        _ => String::new(),
    };
    match text(field, "kind") {
        "number" => format!("{whole}{bounds}"),
        "list" => format!("list of {whole}s{bounds}"),
        "choice" => {
            let words = field["words"].as_array().into_iter().flatten().filter_map(Value::as_str);
            words.map(|word| format!("`\"{word}\"`")).collect::<Vec<_>>().join(", ")
        }
        "flag" => "`true`, `false`".to_string(),
        "text" => "text".to_string(),
        "codes" => format!("table of numbers{bounds}"),
        _ => "table of diameters in mm".to_string(),
    }
}

/// The value of a key that is left out.
fn neutral(field: &Value) -> String {
    match &field["neutral"] {
        Value::Null => "–".to_string(),
        Value::String(text) if text.is_empty() => "–".to_string(),
        Value::Array(list) if list.is_empty() => "–".to_string(),
        Value::Object(table) if table.is_empty() => "–".to_string(),
        Value::String(text) => format!("`\"{text}\"`"),
        Value::Number(number) => number.as_f64().unwrap_or_default().to_string(),
        Value::Array(list) => {
            let numbers: Vec<String> =
                list.iter().filter_map(Value::as_f64).map(|number| number.to_string()).collect();
            format!("[{}]", numbers.join(", "))
        }
        other => other.to_string(),
    }
}

/// The page of the commands.
pub fn commands() -> String {
    let mut page = COMMANDS.to_string() + "```text\n" + help::OVERVIEW + "\n```\n";
    for (name, help) in [
        ("predict", help::PREDICT),
        ("calibrate", help::CALIBRATE),
        ("diagnose", help::DIAGNOSE),
        ("probe", help::PROBE),
        ("job", help::JOB),
    ] {
        write!(page, "\n## truefeed {name}\n\n```text\n{help}\n```\n").expect(STRING);
    }
    page
}
