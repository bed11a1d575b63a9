//! Bytes → toolpath at once, for a program whose blocks are run one after another.
//!
//! Nearly every long program is one: it has no jumps, subprograms or parameters. Its words are then needed only
//! while their block is run, and so it is read part by part, each part run before the next is read in its
//! place. What comes out is what [`trace`] makes of the whole; a test compares the two.
//!
//! Where something turns up that touches what was run before, the whole program is read: whatever leads elsewhere or
//! is to be worked out; behind the first part, a sign of a tape, which makes the time of a dwell milliseconds; a
//! diameter told by a comment after one was looked for. Heidenhain programs nearly always have some of it, and
//! subprograms at their end.

use crate::machine::Machine;
use crate::simulation::gcode::{Dialect, Options, Parts, Program, read_with};
use crate::simulation::toolpath::Toolpath;
use crate::simulation::toolpath::block::Block;
use crate::simulation::toolpath::center::Centers;
use crate::simulation::toolpath::trace::{Tracer, trace};

/// Lines of a part: what is read of them stays near the processor until it is run.
pub const LINES_OF_A_PART: u32 = 1_000;

/// Reads a program and runs it on the geometry of `machine`; the text is given back before a path takes room beside
/// all its words.
pub fn trace_text(text: Vec<u8>, options: &Options, machine: &Machine) -> Toolpath {
    trace_straight(&text, options, machine, LINES_OF_A_PART).unwrap_or_else(|| {
        let program = read_with(&text, options);
        drop(text);
        trace(&program, machine)
    })
}

/// The toolpath of a program that goes straight on, read in parts of so many lines; none of others.
pub fn trace_straight(text: &[u8], options: &Options, machine: &Machine, lines: u32) -> Option<Toolpath> {
    let mut run = run_straight(text, options, machine, lines, None)?;
    if run.0.centers.show_absolute() {
        run = run_straight(text, options, machine, lines, Some(Centers::shown()))?;
    }
    let (tracer, program) = run;
    Some(tracer.finish(&program))
}

/// Reads and runs all blocks; without `centers` those of the dialect.
fn run_straight<'a>(
    text: &[u8],
    options: &Options,
    machine: &'a Machine,
    lines: u32,
    centers: Option<Centers>,
) -> Option<(Tracer<'a>, Program)> {
    let mut parts = Parts::new(text, options)?;
    let dialect = parts.part().dialect;
    if goes_back_at_its_end(text, dialect) {
        return None;
    }
    parts.next_part(lines);
    let is_tape = parts.part().is_tape;
    let centers = centers.unwrap_or_else(|| Centers::new(dialect, options.arc_centers));
    let mut tracer = Tracer::new(machine, parts.part(), centers);
    // Most blocks of a long program are one move each.
    tracer.toolpath.segments.try_reserve_exact(parts.expected_blocks()).ok();
    let (mut heard, mut rest) = (0, None);
    let (mut index, mut doubted) = (0, 0);
    loop {
        let part = parts.part();
        if !parts.goes_straight_on() || part.is_tape != is_tape {
            return None;
        }
        if !tracer.compensation.known.hear(&part.comments[heard..]) {
            return None;
        }
        heard = part.comments.len();
        tracer.look_for_points(part);
        for block in &part.blocks {
            if tracer.ended.is_some() {
                rest.get_or_insert((block.line, 0)).1 += 1;
                continue;
            }
            let doubts = &parts.doubts()[doubted..];
            let before = doubts.iter().take_while(|doubt| doubt.after <= index).count();
            tracer.doubt_as_read(&doubts[..before]);
            (doubted, index) = (doubted + before, index + 1);
            let words = part.words(block);
            let scaled = tracer.by_increments(words, words);
            tracer.block(Block { words: scaled.as_deref().unwrap_or(words), line: block.line });
        }
        if !parts.next_part(lines) {
            break;
        }
    }
    tracer.tell_rest(rest);
    let program = parts.finish();
    if tracer.ended.is_none() {
        tracer.doubt_as_read(&program.doubts[doubted..]);
    }
    Some((tracer, program))
}

/// So many bytes at the end of a text are looked at first.
const END: usize = 1_000;

/// Whether the last lines lead elsewhere: a long pass is often a subprogram, whose last block goes back, and would
/// otherwise be run in vain.
fn goes_back_at_its_end(text: &[u8], dialect: Dialect) -> bool {
    let end = &text[text.len().saturating_sub(END)..];
    let whole_lines = end.iter().position(|byte| *byte == b'\n').map_or(end, |at| &end[at..]);
    let options = Options { dialect: Some(dialect), ..Options::default() };
    let read = Parts::new(whole_lines, &options).map(|mut parts| {
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
        let straight = trace_straight(text.as_bytes(), &options, &machine, lines);
        let whole = trace(&read_with(text.as_bytes(), &options), &machine);
        if let Some(straight) = &straight {
            assert_eq!(*straight, whole, "{text:?} in parts of {lines}");
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
        assert!(trace_straight(text, &options, &Machine::default(), 1).is_none());
        assert!(trace_straight(text, &options, &Machine::default(), 9).is_some());
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
            assert_eq!(goes_back_at_its_end(text.as_bytes(), dialect), goes_back, "{dialect:?}, {end:?}");
        }
        assert!(!goes_back_at_its_end(b"", Dialect::Iso));
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
