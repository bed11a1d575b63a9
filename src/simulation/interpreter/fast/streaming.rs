//! Bytes → toolpath in one pass, for a program whose blocks run one after another.
//!
//! Nearly every long program is such a one: it has no jumps, subprograms or parameters. Its words are then needed
//! only while their block is run, so Truefeed reads a part, runs it, and reads the next part in its place. The
//! result equals that of [`trace`] on the whole program; a test compares the two.
//!
//! If the program has an item that affects earlier blocks, it is read as a whole. Such items are flow and
//! formulas; behind the first part, a sign that dwells are in milliseconds; and a comment with the diameter of a
//! tool after a diameter was searched. Heidenhain programs nearly always have flow or formulas, and programs with
//! subprograms have them at their end.

use crate::machine::Machine;
use crate::simulation::gcode::{Dialect, Options, Parts, Program, Scope, read_with};
use crate::simulation::interpreter::block::{Block, BlockStatements};
use crate::simulation::interpreter::center::Centers;
use crate::simulation::interpreter::fast::rare;
use crate::simulation::interpreter::state::{Interpreter, Rare};
use crate::simulation::interpreter::trace::trace;
use crate::simulation::toolpath::Toolpath;

/// Lines of a part, few enough that the words of a part remain in the cache of the processor.
pub const LINES_PER_PART: u32 = 1_000;

/// Reads a program and runs it on the geometry of `machine`. The text is freed before the toolpath is allocated, which
/// bounds the peak of memory.
pub fn trace_text(text: Vec<u8>, options: &Options, machine: &Machine) -> Toolpath {
    trace_streaming(&text, options, machine, LINES_PER_PART).unwrap_or_else(|| {
        let program = read_with(&text, options);
        drop(text);
        trace(&program, machine)
    })
}

/// Returns the toolpath of a program without jumps, calls and parameters, read in parts of `lines` lines, or `None` for other
/// programs.
pub fn trace_streaming(text: &[u8], options: &Options, machine: &Machine, lines: u32) -> Option<Toolpath> {
    trace_within(text, options, machine, lines, (Scope::STRAIGHT, rare::ALL))
}

/// Does the work of [`trace_streaming`] for ISO programs of words and comments alone, without splines. A
/// WebAssembly module that calls nothing else includes no code for other programs.
pub fn trace_plain(text: &[u8], options: &Options, machine: &Machine, lines: u32) -> Option<Toolpath> {
    trace_within(text, options, machine, lines, (Scope::PLAIN, rare::NONE))
}

/// Runs a program within a scope, and once more if its arcs show absolute centres.
fn trace_within(
    text: &[u8],
    options: &Options,
    machine: &Machine,
    lines: u32,
    extent: (Scope, Rare),
) -> Option<Toolpath> {
    let mut run = run_straight(text, options, machine, lines, extent, None)?;
    if run.0.centers.show_absolute() {
        run = run_straight(text, options, machine, lines, extent, Some(Centers::absolute_by_arcs()))?;
    }
    let (interpreter, program) = run;
    Some(interpreter.finish(&program))
}

/// Reads and runs all blocks; `centers` is `None` for the rule of the dialect. Returns `None` for programs that do
/// not run straight.
fn run_straight<'a>(
    text: &[u8],
    options: &Options,
    machine: &'a Machine,
    lines: u32,
    (scope, rare): (Scope, Rare),
    centers: Option<Centers>,
) -> Option<(Interpreter<'a>, Program)> {
    let mut parts = Parts::new(text, options, scope)?;
    let dialect = parts.part().dialect;
    if ends_with_flow(text, dialect, scope) {
        return None;
    }
    parts.next_part(lines);
    let is_tape = parts.part().is_tape;
    let centers = centers.unwrap_or_else(|| Centers::new(dialect, options.arc_centers));
    let mut interpreter = Interpreter::new(machine, parts.part(), centers, rare);
    // Most blocks of a long program are one move each.
    interpreter.canonical.reserve(parts.expected_blocks());
    let (mut comments_read, mut rest) = (0, None);
    let (mut index, mut doubts_read) = (0, 0);
    loop {
        let part = parts.part();
        if !parts.runs_straight() || part.is_tape != is_tape {
            return None;
        }
        if !interpreter.compensation.known.add_comments(&part.comments[comments_read..]) {
            return None;
        }
        comments_read = part.comments.len();
        interpreter.look_for_points(part);
        let mut next_statement = 0;
        for block in &part.blocks {
            let statements = part.statements(index, &mut next_statement);
            if interpreter.ended.is_some() {
                rest.get_or_insert((block.line, 0)).1 += 1;
                continue;
            }
            let doubts = &parts.doubts()[doubts_read..];
            let before = doubts.iter().take_while(|doubt| doubt.after <= index as usize).count();
            interpreter.add_doubts_of_reading(&doubts[..before]);
            doubts_read += before;
            index += 1;
            let words = part.words(block);
            let scaled = interpreter.by_increments(words, words);
            let words = scaled.as_deref().unwrap_or(words);
            let statements = BlockStatements { list: statements, arguments: part.arguments(statements) };
            interpreter.block(Block { words, statements: &statements, line: block.line });
        }
        if interpreter.needs_rare_functions {
            return None;
        }
        if !parts.next_part(lines) {
            break;
        }
    }
    interpreter.remark_on_rest(rest);
    let program = parts.finish();
    if interpreter.ended.is_none() {
        interpreter.add_doubts_of_reading(&program.doubts[doubts_read..]);
    }
    Some((interpreter, program))
}

/// Number of bytes at the end of a text that are read first.
const END_BYTES: usize = 1_000;

/// Returns `true` if the last lines have flow: a long text is often a subprogram, whose last block returns, and
/// its straight run would be in vain.
fn ends_with_flow(text: &[u8], dialect: Dialect, scope: Scope) -> bool {
    let end = &text[text.len().saturating_sub(END_BYTES)..];
    let whole_lines = end.iter().position(|byte| *byte == b'\n').map_or(end, |at| &end[at..]);
    let options = Options { dialect: Some(dialect), ..Options::default() };
    let read = Parts::new(whole_lines, &options, scope).map(|mut parts| {
        parts.next_part(u32::MAX);
        parts.finish()
    });
    read.is_some_and(|end| !end.flow.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the parts of a few lines give, after a comparison with the whole.
    fn in_parts(text: &str, lines: u32) -> Option<Toolpath> {
        let (options, machine) = (Options::default(), Machine::default());
        let straight = trace_streaming(text.as_bytes(), &options, &machine, lines);
        let whole = trace(&read_with(text.as_bytes(), &options), &machine);
        let plain = trace_plain(text.as_bytes(), &options, &machine, lines);
        for part_by_part in straight.iter().chain(&plain) {
            assert_eq!(*part_by_part, whole, "{text:?} in parts of {lines}");
        }
        assert_eq!(trace_text(text.as_bytes().to_vec(), &options, &machine), whole, "{text:?}");
        straight
    }

    #[test]
    fn programs_without_flow_go_straight_on() {
        for text in [
            "",
            "\n\n\n",
            "G1 X1 F500\nX2\nX3\nX4\n",
            "%\nO1234 (PART)\n(T1 D=10. END MILL)\nT1 M6\nG4 P500\nG41 D1 G1 X10. F500\nY20.\nG40 X0.\nM30\n%\n",
            "O7\nG1 X5. F100\nG4 P200\nM30\n%\n",
            "G1 X5. F100\nX20000\nM30\nG0 X3\n\nX7 (never run)\n(T2 D=4. DRILL)\n",
            "G20\r\nG1 X1 F10\rG2 X2 I.5\r\nG81 Z-1 R1\nX3\nG80\nbad line!\nG1 X1 X2\n",
        ] {
            for lines in [1, 2, 3, 1000] {
                assert!(in_parts(text, lines).is_some(), "{text:?} in parts of {lines}");
            }
        }
    }

    /// Comments before the `%` line are none of the program; LinuxCNC's are no tape.
    #[test]
    fn a_leader_without_blocks_is_given_up() {
        let text = b"(T1 D=10. LEADER)\n%\nG1 X1 F500\nM2\n%\n";
        let options = Options { dialect: Some(Dialect::LinuxCnc), ..Options::default() };
        assert!(trace_streaming(text, &options, &Machine::default(), 1).is_none());
        assert!(trace_streaming(text, &options, &Machine::default(), 9).is_some());
    }

    /// What a first visit does without is left to the whole module, and not run wrongly.
    #[test]
    fn what_is_rare_is_not_plain() {
        let machine = Machine::default();
        for (dialect, text, is_plain) in [
            (Dialect::LinuxCnc, "G1 X1 F500\nG5 X5 Y5 I1 J1 P-1 Q-1\nM2\n", false),
            (Dialect::LinuxCnc, "G1 X1 F500\nG5.2 P1 L3\nX1 Y2 P1\nX3 Y4 P1\nG5.3\nM2\n", false),
            (Dialect::LinuxCnc, "G1 X1 F500\nG2 X5 Y5 I1 J1\nM2\n", true),
            (Dialect::Siemens, "G1 X1 F500\nX2\nM30\n", false),
            (Dialect::Iso, "G1 X[1+2] F500\nM30\n", false),
            (Dialect::Iso, "G1 X1 F500\nY1 ,R2\nX0\nM30\n", false),
            (Dialect::Iso, "G1 X1 F500\nX\nM30\n", false),
            (Dialect::Iso, "(T1 D=10. END MILL)\nT1 M6\nG41 D1 G1 X10. F500\nY20.\nG40 X0.\nM30\n", true),
        ] {
            let options = Options { dialect: Some(dialect), ..Options::default() };
            let plain = trace_plain(text.as_bytes(), &options, &machine, 9);
            assert_eq!(plain.is_some(), is_plain, "{dialect:?}, {text:?}");
            let straight = trace_streaming(text.as_bytes(), &options, &machine, 9);
            assert!(plain.is_none() || plain == straight, "{dialect:?}, {text:?}");
        }
    }

    #[test]
    fn a_subprogram_is_told_by_its_end() {
        let pass = "G1 X1 F500\nX2\n".repeat(1000);
        for (dialect, end, goes_back) in [
            (Dialect::Iso, "M99\n%\n", true),
            (Dialect::Iso, "M30\n%\n", false),
            (Dialect::Iso, "", false),
            (Dialect::Siemens, "RET\n", true),
            (Dialect::Siemens, "M17\n", true),
            (Dialect::Siemens, "M30\n", false),
        ] {
            let text = format!("{pass}{end}");
            assert_eq!(
                ends_with_flow(text.as_bytes(), dialect, Scope::STRAIGHT),
                goes_back,
                "{dialect:?}, {end:?}"
            );
        }
        assert!(!ends_with_flow(b"", Dialect::Iso, Scope::STRAIGHT));
    }

    #[test]
    fn what_touches_the_blocks_before_is_read_whole() {
        for text in [
            "G1 X1 F500\nM98 P7\nM30\nO7\nX2\nM99\n",
            "G1 X1 F500\n#1=5\nX#1\n",
            "G1 X1 F500\nG4 P500\nX2\n%\n",
            "G1 X1 F500\nX2\n%\nX3\nM30\n%\n",
            "O7\nG1 X1 F500\nX2\n%\nX3\nM30\n%\n",
            "T1 M6\nG41 D1 G1 X10 F500\nY20\n(T1 D=10. END MILL)\n",
            "G1 X1 F500\nX2\nM99\n",
            "%\nO1\nG1 X1 F500\nM98 P7\nM30\n%\nO7\nX2\nM99\n%\n",
        ] {
            assert!(in_parts(text, 1).is_none(), "{text:?}");
        }
    }
}
