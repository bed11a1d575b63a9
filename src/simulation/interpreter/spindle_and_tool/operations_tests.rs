//! Where operations begin and what they are called.

use crate::machine::{Machine, SpindleDirection, SpindleState};
use crate::simulation::gcode::{Comment, LineNumber, read};
use crate::simulation::interpreter::trace;
use crate::simulation::toolpath::operations::operations;
use crate::simulation::toolpath::{
    MAX_OPERATIONS, Motion, Operation, Segment, Segments, Stop, StopCause, Toolpath,
};

fn cut(text: &str) -> (Toolpath, Vec<Operation>) {
    let toolpath = trace(&read(text.as_bytes()), &Machine::default());
    let operations = toolpath.operations.clone();
    (toolpath, operations)
}

/// First line, tool and name of each.
fn outline(text: &str) -> Vec<(u32, Option<u32>, String)> {
    let name = |operation: &Operation| operation.name.clone().unwrap_or_default();
    cut(text).1.iter().map(|found| (found.line.0, found.tool, name(found))).collect()
}

fn row(line: u32, tool: Option<u32>, name: &str) -> (u32, Option<u32>, String) {
    (line, tool, name.to_string())
}

#[test]
fn a_tool_change_begins_an_operation() {
    let text = "G0 X1\nG1 F9 X0\nT1 M6\nG0 X2\nG1 F100 X3\nM5\nT2 M6\nG0 X4";
    assert_eq!(outline(text), [row(1, None, ""), row(3, Some(1), ""), row(7, Some(2), "")]);
    let (toolpath, found) = cut(text);
    let places: Vec<_> = found.iter().map(|found| (found.first_segment, found.first_stop)).collect();
    assert_eq!(places, [(0, 0), (2, 0), (4, 2)]);
    assert_eq!(toolpath.stops[2].cause, StopCause::ToolChange { tool: Some(2) });
    // What comes before the first move belongs to the first operation.
    assert_eq!(outline("M9\nT1 M6\nG0 X1"), [row(2, Some(1), "")]);
    assert_eq!(outline("M9\nG0 Z9\nT1 M6\nG0 X1"), [row(3, Some(1), "")]);
    assert_eq!(outline("T1 M6\nT2 M6\nG0 X1"), [row(1, Some(1), ""), row(2, Some(2), "")]);
    assert_eq!(outline("T1 M6\nG0 X1\nT1 M6\nG0 X2"), [row(1, Some(1), ""), row(3, Some(1), "")]);
}

#[test]
fn a_heading_begins_an_operation_where_the_tool_is_free() {
    let between = |comment: &str| format!("T1 M6\nG0 X1\nG1 F9 Z-1\n{comment}\nX9\nG1 X8");
    assert_eq!(outline(&between("G0 Z5\n(POCKET)\nG0")).last(), Some(&row(5, Some(1), "POCKET")));
    assert_eq!(outline(&between("M9\n(POCKET)\nG0")).last(), Some(&row(5, Some(1), "POCKET")));
    for heading in ["(HOME)\nG0 Z50\nM9", "(HOME)\nG0 Z50\n(AND)\nG0 X0", "(HOME)\nG0 Z50\nM30"] {
        let text = format!("{}\nF9 G1 X3\nM9\n{heading}", between("G0 Z5\n(POCKET)\nG0"));
        assert_eq!(outline(&text).last(), Some(&row(5, Some(1), "POCKET")), "{heading}");
    }
    // Before a rapid out of the cut, before a feed move, or inside the cut it is a note.
    for comment in ["(RETRACT)\nG0 Z5", "(LEAD OUT)", "G0 Z5\n(PLUNGE)\nG1", "G4 P1\n(WAIT)\nG0"] {
        assert_eq!(outline(&between(comment)).len(), 1, "{comment}");
    }
}

#[test]
fn a_heading_beside_a_tool_change_is_its_name() {
    assert_eq!(outline("(PART 12)\n\n(FACE)\nT1 M6\nG0 X1"), [row(3, Some(1), "FACE")]);
    assert_eq!(outline("T1 M6\n(FACE)\nS9 M3\nG0 X1"), [row(1, Some(1), "FACE")]);
    assert_eq!(outline("(FACE)\nT1 M6\n(note)\nS9 M3\nG0 X1"), [row(1, Some(1), "FACE")]);
    assert_eq!(outline("(---)\n(OP 10)\n(rough)\n(---)\nG0 X1"), [row(2, None, "OP 10")]);
    assert_eq!(
        outline("(ONE)\nT1 M6\nG0 X1\nG1 F9 X2\nG0 Z9\n(TWO)\nM5\nT2 M6\nG0 X3"),
        [row(1, Some(1), "ONE"), row(6, Some(2), "TWO")]
    );
}

#[test]
fn comments_name_tools() {
    let names = |text: &str| -> Vec<Option<String>> {
        cut(text).1.into_iter().map(|operation| operation.tool_name).collect()
    };
    let end_mill = [Some("10MM ENDMILL".to_string())];
    assert_eq!(names("T5 M6 (10MM ENDMILL)\nG0 X1"), end_mill);
    assert_eq!(names("T5 (10MM ENDMILL)\nM6\nG0 X1"), end_mill);
    assert_eq!(names("G1 F1 X1 T5 (READY)\nG0 X2\nM6\nG0 X1"), [None, None]);
    for comment in
        ["T5 | 10MM ENDMILL |", " T5 - 10MM ENDMILL", "tool 5: 10MM ENDMILL", "TOOL #5 10MM ENDMILL"]
    {
        assert_eq!(names(&format!("({comment})\n(FACE)\nT5 M6\nG0 X1")), end_mill, "{comment}");
    }
    assert_eq!(names("(T5 10MM ENDMILL, T6 DRILL)\nT5 M6\nG0 X1"), end_mill);
    assert_eq!(names("(T4 SAW, 2 MM; T5 10MM ENDMILL)\nT5 M6\nG0 X1"), end_mill);
    assert_eq!(names("(T-SLOT)\n(TOOLPATH 5)\n(T5X)\nT5 M6\nG0 X1"), [None]);
}

#[test]
fn a_program_that_jumps_is_cut_where_it_runs() {
    // A loop over lines 4 to 6, under a heading in line 3.
    let lines = [
        (1, true),
        (4, true),
        (5, false),
        (6, true),
        (4, true),
        (5, false),
        (6, true),
        (8, true),
        (9, false),
    ];
    let moves = trace(&read("G91 G0 X1\n".repeat(lines.len()).as_bytes()), &Machine::default());
    let segments = moves.segments.iter().zip(lines).map(|(segment, (line, is_rapid))| {
        let motion = if is_rapid { Motion::RAPID } else { Motion::Feed { feedrate: 1.0 } };
        Segment { line: LineNumber(line), motion, ..segment }
    });
    let headings = [(3, "LOOP"), (7, "END")].map(|(line, text)| Comment {
        line: LineNumber(line),
        text: text.to_string(),
        is_alone: true,
    });
    let (found, _) = operations(&segments.collect(), &[], &headings);
    let places: Vec<_> = found.iter().map(|found| (found.first_segment, found.line.0)).collect();
    assert_eq!(places, [(0, 3), (7, 7)]);
}

#[test]
fn the_rest_beyond_the_most_is_taken_together() {
    let change = |index: usize| Stop {
        after: 0,
        cause: StopCause::ToolChange { tool: Some(index as u32) },
        line: LineNumber(index as u32 + 1),
    };
    let stops: Vec<Stop> = (0..MAX_OPERATIONS + 20).map(change).collect();
    let (found, beyond) = operations(&Segments::default(), &stops, &[]);
    assert_eq!((found.len(), beyond), (MAX_OPERATIONS, 20));
    assert_eq!(found.last().map(|last| (last.first_stop, last.tool)), Some((499, None)));
    assert_eq!(operations(&Segments::default(), &[], &[]), (Vec::new(), 0));
}

#[test]
fn a_spindle_that_changes_its_speed_begins_nothing() {
    let to = SpindleState { direction: SpindleDirection::Clockwise, speed: 100.0 };
    let cause = StopCause::Spindle { from: SpindleState::AT_REST, to, code: None };
    let stops = [Stop { after: 0, cause, line: LineNumber(3) }];
    let (found, _) = operations(&Segments::default(), &stops, &[]);
    assert_eq!(found, [Operation { line: LineNumber(3), ..Operation::default() }]);
}
