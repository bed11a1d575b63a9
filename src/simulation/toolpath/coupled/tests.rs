//! Probing, threading and rigid tapping against the same moves written out.

use crate::machine::Machine;
use crate::simulation::gcode::read;
use crate::simulation::toolpath::{Motion, Segment, StopCause, Toolpath, trace};

fn run(text: &str) -> Toolpath {
    trace(&read(text.as_bytes()), &Machine::default())
}

/// Start, end and feedrate of every move.
fn moves(toolpath: &Toolpath) -> Vec<([f64; 3], [f64; 3], Motion)> {
    let ends = |segment: Segment| (segment.start.into(), segment.end.into(), segment.motion);
    toolpath.segments.iter().map(ends).collect()
}

#[test]
fn probing_goes_to_its_end_and_says_so() {
    for word in ["G31", "G38.2", "G38.3", "G38.4", "G38.5"] {
        let probed = run(&format!("G0 X1 Y1 Z5\nF30\n{word} Z-5\nX2\n"));
        let written = run("G0 X1 Y1 Z5\nF30\nG1 Z-5\nG0 X2\n");
        assert_eq!(moves(&probed), moves(&written), "{word}");
        assert!(probed.diagnostics.iter().any(|told| told.message.contains("probing")), "{word}");
    }
}

#[test]
fn what_was_probed_is_where_it_ended() {
    let text = "%\nO1\nG0 Z5.\nG31 Z-3. F60\nG0 Z5.\nG1 Z[#5063 - 1.]\nM30\n";
    assert_eq!(run(text).segments.last().map(|segment| segment.end.z), Some(-4.0));
}

#[test]
fn a_thread_is_fed_by_its_pitch_and_a_tap_comes_back() {
    for (unit, word, way_back) in [("G21", "G33", ""), ("G20", "G33", ""), ("G21", "G33.1", "Z5\n")] {
        let head = format!("{unit}\nS600 M3\nG0 Z5\n");
        let coupled = run(&format!("{head}{word} Z-5 K.5\n"));
        let written = run(&format!("{head}F300 G1 Z-5\n{way_back}"));
        assert_eq!(moves(&coupled), moves(&written), "{unit} {word}");
    }
    let tap = run("S600 M3\nG0 Z5\nG33.1 Z-5 K.5\n");
    let codes = tap.stops.iter().filter_map(|stop| match stop.cause {
        StopCause::Spindle { code, .. } => Some((stop.after, code?)),
        _ => None,
    });
    assert_eq!(codes.collect::<Vec<_>>(), [(0, 3), (2, 4), (3, 3)]);
    let lame = run("G0 Z5\nF60\nG33 Z-5 K1\n");
    assert!(lame.diagnostics.iter().any(|told| told.message.contains("spindle speed")));
}
