//! What holds whatever is read: no panic, and these laws. The fuzz targets and the tests share it.

use truefeed::machine::{Machine, Tool};
use truefeed::project::{machine_from_toml, toml_from_machine};
use truefeed::simulation::gcode::{Dialect, Options, read_with};
use truefeed::simulation::interpreter::{trace_plain, trace_streaming, trace_within};
use truefeed::simulation::toolpath::{Curve, Motion, Toolpath};

/// Blocks that loops may run here: the bound of a program as it is quoted takes a second to reach, and nothing that
/// is read depends on it; tests/siege reaches it.
const MOST_REPEATED: usize = 10_000;

/// More moves than any bound on loops and repeats lets through.
const MOST_SEGMENTS: usize = 10_000_000;

/// More remarks than there are kinds of them times how many of a kind are listed.
const MOST_DIAGNOSTICS: usize = 40_000;

/// Bytes → program → toolpath, in the dialect that they show or, half of the time, in another one.
#[allow(dead_code)]
pub fn program(bytes: &[u8]) {
    let other = Dialect::WORDS[bytes.len() / 2 % Dialect::WORDS.len()].1;
    let dialect = (bytes.len() % 2 == 1).then_some(other);
    program_in(bytes, dialect);
}

/// The same in a dialect that is chosen.
#[allow(dead_code)]
pub fn program_in(bytes: &[u8], dialect: Option<Dialect>) {
    let (options, machine) = (Options { dialect, ..Options::default() }, machine());
    let toolpath = trace_within(&read_with(bytes, &options), &machine, MOST_REPEATED);
    check(bytes, &toolpath);
    // Part by part it is the same, wherever the parts end, and where nothing but plain words is read.
    let lines = 1 + bytes.len() as u32 % 7;
    for part_by_part in [trace_streaming, trace_plain].map(|trace| trace(bytes, &options, &machine, lines)) {
        assert!(part_by_part.is_none_or(|one| one == toolpath), "in parts of {lines} lines");
    }
}

/// A machine that knows tools and reference points, so that compensation and G28 move.
fn machine() -> Machine {
    let tools = (1..10).map(|number| (number, Tool { diameter: f64::from(number) })).collect();
    let mut machine = Machine { tools, ..Machine::default() };
    for axis in &mut machine.axes {
        axis.home = Some(0.0);
    }
    machine
}

fn check(bytes: &[u8], toolpath: &Toolpath) {
    assert!(toolpath.segments.len() <= MOST_SEGMENTS, "{} segments", toolpath.segments.len());
    assert!(toolpath.stops.len() <= MOST_SEGMENTS, "{} stops", toolpath.stops.len());
    for segment in &toolpath.segments {
        let line = segment.line.0;
        assert!(0.0 < segment.length && segment.length.is_finite(), "length in line {line}");
        if let Motion::Feed { feedrate } = segment.motion {
            assert!(0.0 < feedrate && feedrate.is_finite(), "feedrate {feedrate} in line {line}");
        }
        if let Curve::Arc(arc) = &segment.curve {
            assert!(0.0 < arc.sweep && arc.sweep.is_finite(), "sweep in line {line}");
        }
        assert!(segment.end.coords.iter().all(|coordinate| coordinate.is_finite()), "end of line {line}");
    }
    assert!(toolpath.stops.is_sorted_by_key(|stop| stop.after), "stops out of order");
    assert!(toolpath.stops.iter().all(|stop| stop.after <= toolpath.segments.len()), "a stop after the end");
    check_diagnostics(bytes, toolpath);
}

fn check_diagnostics(bytes: &[u8], toolpath: &Toolpath) {
    let diagnostics = &toolpath.diagnostics;
    assert!(diagnostics.len() <= MOST_DIAGNOSTICS, "{} diagnostics", diagnostics.len());
    assert!(diagnostics.is_sorted_by_key(|diagnostic| diagnostic.line), "diagnostics out of order");
    // The lines of a file that is read as UTF-16 are not those of its bytes.
    let is_utf16 = diagnostics.iter().any(|diagnostic| diagnostic.message.contains("UTF-16"));
    let widths = widths(bytes);
    for diagnostic in diagnostics {
        let (line, (first, past)) = (diagnostic.line.0 as usize, diagnostic.columns);
        assert!(1 <= first && first <= past, "columns: {diagnostic:?}");
        if !is_utf16 {
            assert!((1..=widths.len()).contains(&line), "line {line} of {}: {diagnostic:?}", widths.len());
            // The end of the line is a column too: something may be missing there.
            assert!(past as usize <= widths[line - 1] + 2, "columns beyond the line: {diagnostic:?}");
        }
        let text = &diagnostic.message;
        assert!(!text.is_empty() && !text.contains(char::is_control), "message: {diagnostic:?}");
    }
}

/// Bytes of each line, of which each character is at least one; a lone CR ends a line too.
fn widths(bytes: &[u8]) -> Vec<usize> {
    let mut widths = vec![0];
    let mut rest = bytes.iter().peekable();
    while let Some(byte) = rest.next() {
        match byte {
            b'\r' if rest.peek() == Some(&&b'\n') => {}
            b'\r' | b'\n' => widths.push(0),
            _ => *widths.last_mut().expect("there is one line at least") += 1,
        }
    }
    widths
}

/// Text → machine, which its own file gives again, or what is wrong and where.
#[allow(dead_code)]
pub fn machine_file(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    match machine_from_toml(&text) {
        Ok(machine) => {
            let written = toml_from_machine(&machine);
            let again = machine_from_toml(&written);
            let again = again.unwrap_or_else(|fault| panic!("{}\n{written}", fault.message));
            assert_eq!(toml_from_machine(&again), written, "another machine comes back");
        }
        Err(fault) => {
            assert!(!fault.message.is_empty());
            if let Some((line, column)) = fault.place {
                let lines: Vec<&str> = text.split('\n').collect();
                assert!((1..=lines.len()).contains(&line), "line {line}: {}", fault.message);
                let width = lines[line - 1].chars().count();
                assert!((1..=width + 2).contains(&column), "column {column}: {}", fault.message);
            }
        }
    }
}
