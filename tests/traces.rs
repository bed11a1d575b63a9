//! What each program of the corpus and of `tests/data/programs` becomes, held by a table, and the ways from bytes to a
//! toolpath against each other.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use truefeed::machine::Machine;
use truefeed::quote::programmed_time;
use truefeed::simulation::gcode::{Options, read_with};
use truefeed::simulation::interpreter::{
    trace, trace_by_reference, trace_plain, trace_streaming, trace_text,
};
use truefeed::simulation::toolpath::{Curve, Motion, StopCause, Toolpath};

use crate::shared::kept::{assert_kept, digest};
use crate::shared::samples::samples;

/// A program with its name in the table.
struct Program {
    name: String,
    bytes: Vec<u8>,
    options: Options,
}

/// Returns the programs of the repository, in order: those of the corpus by the dialect in their names.
fn programs() -> Vec<Program> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut programs = Vec::new();
    for sample in samples() {
        let name = format!("corpus/{}", sample.name());
        programs.push(Program { name, bytes: sample.bytes, options: sample.options });
    }
    let own = root.join("tests/data/programs");
    for path in files(&own).into_iter().filter(|path| path.extension().is_some_and(|end| end != "expected")) {
        let name = path.strip_prefix(&own).expect("below the folder").to_string_lossy().replace('\\', "/");
        programs.push(Program {
            name,
            bytes: std::fs::read(&path).expect("a readable file"),
            options: Options::default(),
        });
    }
    assert!(150 < programs.len(), "the programs were found: {}", programs.len());
    programs
}

/// Returns the files below a folder, in order.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder of programs");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("a readable folder").path()).collect();
    paths.sort();
    paths.into_iter().flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

fn hash(text: &str) -> u64 {
    digest(text.bytes())
}

/// Returns the moves and stops of a toolpath, lengths to the micrometre: the last digits of sines differ from one
/// system to another.
fn moves(toolpath: &Toolpath) -> String {
    let mut text = String::new();
    let rounded = |value: f64| (value * 1e3).round() as i64;
    for segment in &toolpath.segments {
        let [x, y, z] = [segment.end.x, segment.end.y, segment.end.z].map(rounded);
        let [a, b, c] = [segment.rotation.x, segment.rotation.y, segment.rotation.z].map(rounded);
        let feedrate = match segment.motion {
            Motion::Rapid { .. } => -1,
            Motion::Feed { feedrate } => rounded(feedrate),
        };
        let is_arc = matches!(segment.curve, Curve::Arc(_));
        let (length, line) = (rounded(segment.length), segment.line.0);
        let stops = (segment.exact_stop, segment.exact_path);
        let _ = writeln!(text, "{line} {x} {y} {z} {a} {b} {c} {length} {feedrate} {is_arc} {stops:?}");
    }
    for stop in &toolpath.stops {
        let cause = match stop.cause {
            StopCause::Dwell { seconds } => format!("dwell {}", rounded(seconds)),
            StopCause::Rotary { rotation, rate } => {
                format!("turn {:?} {:?}", rotation.map(rounded), rate.map(rounded))
            }
            other => format!("{other:?}"),
        };
        let _ = writeln!(text, "{} {} {cause}", stop.line.0, stop.after);
    }
    let Toolpath { operations, path_modes, spins, .. } = toolpath;
    let _ = writeln!(text, "{operations:?}\n{path_modes:?}\n{spins:?}");
    text
}

/// Returns the remarks of a toolpath by place, severity and text, and the doubts they leave.
fn remarks(toolpath: &Toolpath) -> String {
    format!("{:#?}\n{:#?}\n{:?}", toolpath.diagnostics, toolpath.doubts, toolpath.declined)
}

#[test]
fn traces_are_those_kept() {
    let mut table =
        String::from("program,segments,stops,operations,remarks,doubts,programmed_s,moves,said\n");
    let machine = Machine::default();
    for Program { name, bytes, options } in programs() {
        let toolpath = trace(&read_with(&bytes, &options), &machine);
        let counts = [
            toolpath.segments.len(),
            toolpath.stops.len(),
            toolpath.operations.len(),
            toolpath.diagnostics.len(),
            toolpath.doubts.len(),
        ];
        let counts = counts.map(|count| count.to_string()).join(",");
        let (time, moves) = (programmed_time(&toolpath, &machine), hash(&moves(&toolpath)));
        let _ = writeln!(table, "{name},{counts},{time:.6},{moves:016x},{:016x}", hash(&remarks(&toolpath)));
    }
    assert_kept("traces.csv", &table);
}

/// The fast path for plain blocks, and reading part by part, against the reference path block by block.
#[test]
fn every_way_to_a_toolpath_gives_the_same() {
    let machine = Machine::default();
    let (mut straight, mut plain) = (0, 0);
    for Program { name, bytes, options } in programs() {
        let program = read_with(&bytes, &options);
        let reference = trace_by_reference(&program, &machine);
        assert_eq!(trace(&program, &machine), reference, "{name}");
        assert_eq!(trace_text(bytes.clone(), &options, &machine), reference, "{name}");
        for lines in [1, 7, 1000] {
            if let Some(toolpath) = trace_streaming(&bytes, &options, &machine, lines) {
                assert_eq!(toolpath, reference, "{name} in parts of {lines} lines");
                straight += 1;
            }
            if let Some(toolpath) = trace_plain(&bytes, &options, &machine, lines) {
                assert_eq!(toolpath, reference, "{name} in parts of {lines} lines");
                plain += 1;
            }
        }
    }
    assert!(100 < straight && 100 < plain, "{straight} and {plain} programs go straight on");
}
