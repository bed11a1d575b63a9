//! What the spindle and the tool changer are told to do.

use crate::machine::{Machine, SpindleDirection, SpindleState};
use crate::simulation::gcode::read;
use crate::simulation::interpreter::trace;
use crate::simulation::toolpath::{StopCause, Toolpath};

fn run(text: &str, ramp: f64) -> Toolpath {
    let mut machine = Machine::default();
    machine.times.spindle.ramp = ramp;
    trace(&read(text.as_bytes()), &machine)
}

/// Signed speeds that the spindle goes through, rpm, on a machine that has to wait for them.
fn speeds(text: &str) -> Vec<(f64, f64)> {
    let steps = run(text, 1e-3).stops.into_iter().filter_map(|stop| match stop.cause {
        StopCause::Spindle { from, to, .. } => Some((from.signed_speed(), to.signed_speed())),
        _ => None,
    });
    steps.collect()
}

/// On Mazak the first T of a block comes in, and the second is got ready.
#[test]
fn two_tools_in_a_block_are_a_change_and_the_next_one() {
    let path = run("O1\nT1 T2 M6\nG0 X1.\nT2 T1 M6\nG0 X2.\n", 0.0);
    let causes: Vec<_> = path.stops.iter().map(|stop| stop.cause).collect();
    let change = |tool| StopCause::ToolChange { tool: Some(tool) };
    assert_eq!(causes, [change(1), change(2)]);
    assert!(path.diagnostics.is_empty(), "{:?}", path.diagnostics);
    assert_eq!(run("T1 T2", 0.0).diagnostics.len(), 1);
}

#[test]
fn the_spindle_goes_where_its_words_say() {
    assert_eq!(speeds("S500 M3\nM5\nM4\nM19"), [(0.0, 500.0), (500.0, 0.0), (0.0, -500.0), (-500.0, 0.0)]);
    assert_eq!(speeds("M3 S500\nS600\nS600\nM4 S700"), [(0.0, 500.0), (500.0, 600.0), (600.0, -700.0)]);
    assert_eq!(speeds("S500\nS600\nM3"), [(0.0, 600.0)]);
    // A tool change stops it, but not one that changes nothing.
    assert_eq!(speeds("T1 M6\nS500 M3\nT2 M6\nM3"), [(0.0, 500.0), (0.0, 500.0)]);
    assert_eq!(speeds("T1 M6\nS500 M3\nT1 M6\nM5"), [(0.0, 500.0), (500.0, 0.0)]);
}

#[test]
fn not_every_s_is_a_speed_of_the_spindle() {
    let steady = [(0.0, 500.0), (500.0, 0.0)];
    for other in ["G4 P1 S2", "G96 S120", "G92 S3000", "G50 S3000", "S-1", "S2000000"] {
        assert_eq!(speeds(&format!("G0 Y1\nS500 M3\n{other}\nM5")), steady, "{other}");
    }
    assert_eq!(speeds("G0 Y1\nG96 S120 M3\nG97 S500\nM5"), [(0.0, 0.0), (0.0, 500.0), (500.0, 0.0)]);
    let said = run("S-1", 0.0).diagnostics;
    assert!(said.iter().any(|found| found.message.contains("S-1 is not a speed")), "{said:?}");
}

#[test]
fn a_change_of_speed_stops_the_motion_only_where_it_takes_time() {
    let text = "S500 M3\nF100 G1 X1\nS800 X2\nX3\nM5";
    let waits = |ramp: f64| run(text, ramp).stops.iter().map(|stop| stop.after).collect::<Vec<_>>();
    assert_eq!(waits(0.0), [0, 3]);
    assert_eq!(waits(1e-3), [0, 1, 3]);
    // What it runs at is known all the same.
    let last = run(text, 0.0).stops.last().map(|stop| stop.cause);
    let from = SpindleState { direction: SpindleDirection::Clockwise, speed: 800.0 };
    assert_eq!(last, Some(StopCause::Spindle { from, to: SpindleState::AT_REST, code: Some(5) }));
}

#[test]
fn a_start_without_a_speed_is_said_where_it_matters() {
    let says =
        |ramp: f64| run("M3", ramp).diagnostics.iter().any(|found| found.message.contains("no S before M3"));
    assert!(says(1e-3) && !says(0.0));
}

#[test]
fn a_tool_that_is_there_is_not_changed() {
    let causes = |text: &str| run(text, 0.0).stops.iter().map(|stop| stop.cause).collect::<Vec<_>>();
    let (change, same) =
        (|tool| StopCause::ToolChange { tool: Some(tool) }, |tool| StopCause::SameTool { tool });
    assert_eq!(causes("T1 M6\nT2\nM6\nT2 M6\nT1 M6"), [change(1), change(2), same(2), change(1)]);
    assert_eq!(causes("M6\nM6"), [StopCause::ToolChange { tool: None }; 2]);
    let said = run("T7 M6\nT7 M6", 0.0).diagnostics;
    assert_eq!(said.len(), 1);
    assert_eq!((said[0].line.0, said[0].message.contains("tool 7 is already in the spindle")), (2, true));
}
