//! Predictions against recordings of LinuxCNC's own trajectory planner.
//!
//! The machine has the settings the recordings were made with, none was fitted; for a run with a change it has the change.

use truefeed::identification::alignment::align;
use truefeed::identification::calibration::calibrate;
use truefeed::identification::comparison::compare;
use truefeed::identification::fit::Run;
use truefeed::identification::recording;
use truefeed::machine::{AXES, Machine};
use truefeed::project::machine_from_toml;
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;

use crate::shared::corpus;

/// The planner has no filters: 0.5 ms is half its period.
pub const MACHINE: &str = r#"
name = "LinuxCNC"
[interpolator]
filters = 1
time_constant_s = 0.0005
contour_tolerance_mm = 0.02
junction_rule = "acceleration_blend"
max_override_percent = 200
look_ahead_blocks = 50
[rapid]
feed_mm_min = 10392.3
time_constant_s = 0.0005
[times]
tool_change_s = 0.0
[axis]
x = { velocity_mm_min = 6000, acceleration_mm_s2 = 500 }
y = { velocity_mm_min = 6000, acceleration_mm_s2 = 500 }
z = { velocity_mm_min = 6000, acceleration_mm_s2 = 500 }
"#;

/// A run and what was changed for it.
struct Change {
    run: &'static str,
    program: &'static str,
    /// Words of the program, and what stood there.
    words: (&'static str, &'static str),
    machine: fn(&mut Machine),
}

const AS_WRITTEN: (&str, &str) = ("", "");

const RUNS: [Change; 7] = [
    Change { run: "01", program: "1", words: AS_WRITTEN, machine: |_| {} },
    Change { run: "02", program: "1", words: AS_WRITTEN, machine: |m| m.axes[1].acceleration = 134.0 },
    Change { run: "05", program: "1", words: ("G64 P0.02", "G64 P0.001"), machine: |_| {} },
    Change { run: "06", program: "2", words: AS_WRITTEN, machine: |_| {} },
    Change { run: "07", program: "2", words: AS_WRITTEN, machine: |m| m.axes[0].velocity = 516.0 / 60.0 },
    Change { run: "08", program: "2", words: ("G64 P0.02", "G61.1"), machine: |_| {} },
    Change { run: "10", program: "2", words: AS_WRITTEN, machine: |m| m.overrides.rapid = 0.6 },
];

#[test]
fn runs_take_the_time_and_have_the_feedrate_that_is_predicted() {
    let folder = corpus::recordings().join("linuxcnc");
    for Change { run, program, words, machine: change } in RUNS {
        let file = |name: String| std::fs::read(folder.join(name)).expect("each run has its files");
        let mut machine = machine_from_toml(MACHINE).expect("a machine file");
        change(&mut machine);
        let text = String::from_utf8(file(format!("program-{program}.ngc"))).expect("text");
        let changed = if words == AS_WRITTEN { text.clone() } else { text.replace(words.0, words.1) };
        assert_eq!(changed != text, words != AS_WRITTEN, "run {run} has the words that are changed");
        let toolpath = trace(&read(changed.as_bytes()), &machine);
        let log = recording::read(&file(format!("run-{run}.csv"))).expect("a recording");
        let alignment = align(&log.recordings[0], &toolpath, &machine).expect("it is of that program");
        let plan = Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }.plan(&machine);
        let comparison = compare(&toolpath, &plan, &alignment);
        let feed = comparison.feed.expect("feed moves were recorded");
        let time = comparison.whole.simulated / comparison.whole.recorded - 1.0;
        let rms = feed.rms / feed.programmed;
        let apart = 1e3 * comparison.position.expect("positions were recorded").rms;
        eprintln!(
            "run {run}: time {:+.3} %, feedrate {:.2} %, position {apart:.2} µm",
            1e2 * time,
            1e2 * rms
        );
        assert!(time.abs() < 2e-3, "run {run}: {time}");
        assert!(rms < 1.5e-3, "run {run}: {rms}");
        assert!(apart < 4.0, "run {run}: {apart} µm");
    }
}

#[test]
fn accelerations_are_found_from_one_run() {
    let folder = corpus::recordings().join("linuxcnc");
    let file = |name: &str| std::fs::read(folder.join(name)).expect("each run has its files");
    let mut machine = machine_from_toml(MACHINE).expect("a machine file");
    machine.axes.iter_mut().for_each(|axis| axis.acceleration = 400.0);
    let toolpath = trace(&read(&file("program-1.ngc")), &machine);
    let log = recording::read(&file("run-01.csv")).expect("a recording");
    let alignment = align(&log.recordings[0], &toolpath, &machine).expect("it is of that program");
    let run = Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) };
    let found = calibrate(&machine, &[run], &mut |_| {}).machine;
    for (axis, letter) in found.axes.iter().zip(AXES) {
        assert!((axis.acceleration / 500.0 - 1.0).abs() < 0.01, "{letter}: {} mm/s²", axis.acceleration);
    }
}
