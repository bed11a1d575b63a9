//! What the runs of a calibration do not tell: it is assumed, said, and no cause of another program.

use truefeed::identification::alignment::{Alignment, align};
use truefeed::identification::calibration::calibrate;
use truefeed::identification::diagnosis::{Diagnosis, ModelError, Verdict, diagnose};
use truefeed::identification::fit::Run;
use truefeed::identification::measured::calibrated_on;
use truefeed::identification::recording;
use truefeed::machine::{Junction, Machine, Planner};
use truefeed::project::{DiagnosisReport, machine_from_toml};
use truefeed::quote::{UnshownFeature, range};
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::profile::Profile;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::Toolpath;

use crate::planners::GENERIC;

/// A planner whose axes differ.
fn truth() -> Machine {
    let mut machine =
        machine_from_toml(include_str!("data/machines/linuxcnc.toml")).expect("the file is right");
    for (axis, acceleration) in machine.axes.iter_mut().zip([500.0, 800.0, 450.0]) {
        axis.acceleration = acceleration;
    }
    machine
}

/// What is known of it before any recording.
pub fn believed() -> Machine {
    machine_from_toml(GENERIC).expect("the file is right")
}

/// 29 rows along one of two axes with a step along Z after each.
fn rows(axis: char) -> String {
    some_rows(axis, 29)
}

fn some_rows(axis: char, count: u32) -> String {
    let row = |at: u32| {
        let (there, feed) = (5 + 7 * (at % 5), 900 + 300 * (at % 4));
        format!("G1 {axis}{there} F{feed}\nZ-{at}\n{axis}0\nZ-{at}.5\n")
    };
    format!(
        "G21 G90\nG0 X0 Y0 Z5\nG0 {axis}90 Z12\nG0 {axis}0 Z0\n{}M30\n",
        (1..=count).map(row).collect::<String>()
    )
}

pub fn traced(program: &str) -> Toolpath {
    trace(&read(program.as_bytes()), &believed())
}

/// The program as a machine runs it, every 4 ms, aligned.
pub fn recorded(toolpath: &Toolpath, machine: &Machine) -> Alignment {
    recorded_by_clock(toolpath, machine, 1.0)
}

/// The same by a clock of a rate, as a ratio to the true time.
fn recorded_by_clock(toolpath: &Toolpath, machine: &Machine, rate: f64) -> Alignment {
    let plan = simulate(toolpath, machine);
    let profile = Profile::new(toolpath, &plan);
    let row = |sample: u32| {
        let time = 0.004 * f64::from(sample);
        let p = profile.at_time(time).position;
        format!("{:.7},{:.4},{:.4},{:.4}\n", rate * time, p.x, p.y, p.z)
    };
    let rows = (0..=(profile.cycle_time() / 0.004) as u32).map(row);
    let csv: String = ["t_s,x_mm,y_mm,z_mm\n".to_string()].into_iter().chain(rows).collect();
    let log = recording::read(csv.as_bytes()).expect("a log");
    align(&log.recordings[0], toolpath, &believed()).expect("it is of this program")
}

pub fn run<'a>(toolpath: &'a Toolpath, alignment: &'a Alignment) -> Run<'a> {
    Run { toolpath, alignment, overrides: (None, None) }
}

/// Calibrated on one program, with all that its machine file keeps.
fn calibrated(program: &str) -> Machine {
    calibrated_on_run(program, &truth())
}

fn calibrated_on_run(program: &str, truth: &Machine) -> Machine {
    let toolpath = traced(program);
    let alignment = recorded(&toolpath, truth);
    let runs = [run(&toolpath, &alignment)];
    let calibration = calibrate(&believed(), &runs, &mut |_| {});
    let error = ModelError::of(&calibration.machine, &runs);
    let mut machine = calibration.machine.clone();
    machine.cycle_time_error = Some(calibration.worst_error(|comparison| comparison.whole));
    machine.calibrated_on = calibrated_on(&calibration.machine, &runs, &calibration.fitted);
    error.keep_in(&mut machine);
    machine
}

fn diagnosed(machine: &Machine, program: &str, truth: &Machine) -> Diagnosis {
    let toolpath = traced(program);
    let alignment = recorded(&toolpath, truth);
    diagnose(machine, &[run(&toolpath, &alignment)], &mut |_| {})
}

/// With filters, a contour tolerance and a limit of a velocity leave a thousandth of the time of this planner.
#[test]
fn limits_that_leave_time_are_no_causes_on_a_machine_that_was_never_calibrated() {
    let mut truth = truth();
    truth.axes.iter_mut().for_each(|axis| axis.acceleration = 700.0);
    let found = diagnosed(&believed(), &rows('X'), &truth);
    let named: Vec<&str> = found.causes.iter().map(|cause| cause.candidate.hypothesis.effect.id).collect();
    assert_eq!(named, [""; 0], "{} s remain", found.left.0);
    assert!(found.calibrated.is_some());
}

/// A planner that limits the acceleration along the path, and that of Z no lower.
#[test]
fn neither_a_clock_that_is_off_nor_a_limit_of_an_axis_that_holds_nothing_is_an_acceleration() {
    let mut truth = believed();
    truth.become_planner(Planner::SquareCorner, 600.0);
    let square = |at: u32| {
        let (side, feed) = (3 + at % 7, 900 + 700 * (at % 4));
        format!("G1 X{side} F{feed}\nY{side}\nZ-{at}\nX0\nY0\n")
    };
    let program = format!("G21 G90\nG0 Z5\nG0 Z0\n{}M30\n", (1..=24).map(square).collect::<String>());
    let toolpath = traced(&program);
    let alignment = recorded_by_clock(&toolpath, &truth, 1.0006);
    let calibration = calibrate(&believed(), &[run(&toolpath, &alignment)], &mut |_| {});
    let machine = &calibration.machine;
    assert!((machine.path.acceleration / 600.0 - 1.0).abs() < 5e-4, "{} mm/s²", machine.path.acceleration);
    assert!((machine.recorder.clock_ratio - 1.0006).abs() < 5e-5, "{}", machine.recorder.clock_ratio);
    let deviation = |key: &str| {
        calibration.estimates.iter().find(|estimate| estimate.key == key).and_then(|own| own.deviation)
    };
    assert!(deviation("path.acceleration_mm_s2").is_some_and(|own| own < 3.0));
    assert_eq!(deviation("axis.z.acceleration_mm_s2"), None);
}

#[test]
fn an_axis_that_never_ramps_has_the_acceleration_of_the_others_and_the_file_says_so() {
    let machine = calibrated(&rows('Y'));
    let [x, y, z] = [0, 1, 2].map(|axis: usize| machine.axes[axis].acceleration);
    assert!((y / 800.0 - 1.0).abs() < 0.05 && (z / 450.0 - 1.0).abs() < 0.02, "{y}, {z} mm/s²");
    assert!((x / y - 1.0).abs() < 0.01, "{x} mm/s² is not that of Y, {y}");
    assert_eq!(machine.calibrated_on.assumed_accelerations, [true, false, false]);
}

/// Rows along X, each with a rapid back on a diagonal that X holds back.
fn facing() -> String {
    let row = |at: u32| {
        let y = 11.398 * f64::from(at);
        format!("G0 X0 Y{y:.3} Z11\nZ1\nG1 Z-0.5 F800\nX136.237 F5080\nG0 Z11\n")
    };
    let rows: String = (0..10).map(row).collect();
    format!("G21 G90\nG64 P0.007\nG0 Z11\n{rows}G0 X0 Y0\nM30\n")
}

/// That axes are alike tells nothing about an axis that holds nothing back.
#[test]
fn an_axis_that_is_only_taken_to_be_like_another_has_no_deviation() {
    let mut truth = truth();
    (truth.axes[0].acceleration, truth.axes[1].acceleration) = (580.0, 500.0);
    let toolpath = traced(&facing());
    let alignment = recorded(&toolpath, &truth);
    let calibration = calibrate(&believed(), &[run(&toolpath, &alignment)], &mut |_| {});
    let deviation = |axis: &str| {
        let key = format!("axis.{axis}.acceleration_mm_s2");
        let estimate = calibration.estimates.iter().find(|estimate| estimate.key == key);
        estimate.expect("each has one").deviation
    };
    assert!(deviation("x").is_some_and(|deviation| deviation < 10.0), "{:?}", deviation("x"));
    assert_eq!(deviation("y"), None);
    let on = &calibration.machine.calibrated_on;
    assert_eq!(on.assumed_accelerations, [false, true, false]);
    let [x, y, z] = on.acceleration_deviations.expect("X and Z are shown");
    let of_x = x * calibration.machine.axes[0].acceleration;
    assert!(deviation("x").is_some_and(|deviation| (of_x / deviation - 1.0).abs() < 1e-12), "{of_x}");
    assert!(y == 0.0 && 0.0 < z && z < 0.02, "{y}, {z}");
}

/// A slot cut in circles, far below the velocities of the axes, but LinuxCNC plans its corners by these.
fn slot() -> String {
    let turn = |at: u32| {
        let x = 0.393 * f64::from(at);
        format!("X{x:.3} F2590\nG3 Y11.238 I0 J11.238\nG1 Y-11.238 F2720\n")
    };
    let turns: String = (1..15).map(turn).collect();
    format!("G21 G90 G64 P0.016\nG0 X0 Y0 Z8\nG0 Y-11.238\nZ1\nG1 Z-2.8 F400\n{turns}G0 Z8\nM30\n")
}

/// Rows of lines that turn by a tenth of a degree, in exact path mode.
fn rows_in_exact_path_mode() -> String {
    let line = |at: u32| {
        let (x, y) = (2.0 * f64::from(at), 0.0022 * f64::from(at * (at - 1)));
        format!("X{x:.4} Y{y:.4}\n")
    };
    let lines: String = (1..21).map(line).collect();
    let row = format!("G0 X0 Y0\nG1\n{lines}");
    format!("G21 G90 G61\nG0 X0 Y0 Z8\nG0 Z1\nG1 Z-1 F400\nF2400\n{}G0 Z8\nM30\n", row.repeat(6))
}

#[test]
fn the_override_that_exact_path_mode_is_planned_for_is_no_cause() {
    let mut truth = truth();
    for axis in &mut truth.axes {
        (axis.acceleration, axis.velocity, axis.rapid) = (1400.0, 67.0, 67.0);
    }
    let mut machine = calibrated_on_run(&slot(), &truth);
    let [low, high] = [1.2, 2.0].map(|planned| {
        machine.interpolator.max_override = planned;
        simulate(&traced(&rows_in_exact_path_mode()), &machine).cycle_time()
    });
    assert!(0.1 < (low - high).abs(), "{low} s, {high} s: the program shows nothing of it");
    (machine.interpolator.max_override, truth.interpolator.max_override) = (1.2, 2.0);
    let diagnosis = diagnosed(&machine, &rows_in_exact_path_mode(), &truth);
    assert!(diagnosis.causes.is_empty(), "{:?}", diagnosis.causes);
    assert_eq!(diagnosis.verdict, Verdict::NothingMissing);
}

#[test]
fn corners_that_are_planned_by_the_velocity_of_rapids_show_the_planner() {
    let mut truth = truth();
    for (axis, (acceleration, velocity)) in
        truth.axes.iter_mut().zip([(2010.0, 60.0), (1420.0, 67.0), (2070.0, 68.0)])
    {
        (axis.acceleration, axis.velocity, axis.rapid) = (acceleration, velocity, velocity);
    }
    let machine = calibrated_on_run(&slot(), &truth);
    assert!(!machine.has_filters(), "{:?}", machine.interpolator);
    for (axis, letter) in [(0, 'X'), (1, 'Y'), (2, 'Z')] {
        let ratio = machine.axes[axis].acceleration / truth.axes[axis].acceleration;
        assert!((ratio - 1.0).abs() < 0.06, "{letter}: {ratio} of the true acceleration");
    }
}

#[test]
fn what_was_assumed_is_no_cause_of_another_program() {
    let machine = calibrated(&rows('Y'));
    let diagnosis = diagnosed(&machine, &rows('X'), &truth());
    assert!(diagnosis.causes.is_empty(), "{:?}", diagnosis.causes);
    assert!(diagnosis.elsewhere.is_some_and(|off| 0.01 < off), "{:?}", diagnosis.elsewhere);
}

/// Pockets of arcs on which the slowest axis of the plane is the limit.
const ARCS: &str = "G21 G90\nG0 X20 Y0 Z2\nG1 Z0 F600\nG3 X20 Y0 I-20 J0 F6000\nG3 X20 Y0 I-14 J0\nG3 X20 Y0 I-9 J0\n\
    G3 X20 Y0 I-5 J0\nG1 X50\nY40\nX0\nY0\nZ-1\nG3 X0 Y0 I12 J0\nG3 X0 Y0 I7 J0\nG0 Z5\nM30\n";

#[test]
fn a_limit_is_found_where_a_looser_one_would_cost_more_than_all() {
    let machine = calibrated(ARCS);
    let mut changed = truth();
    changed.axes[0].acceleration = 440.0;
    let diagnosis = diagnosed(&machine, ARCS, &changed);
    let named: Vec<_> = diagnosis.causes.iter().map(|cause| cause.candidate.hypothesis.name()).collect();
    assert_eq!(named, ["axis acceleration limit (X)"]);
    assert!((diagnosis.causes[0].candidate.values[0] / 440.0 - 1.0).abs() < 0.02);
}

/// A calibration that took another reason to be slow for velocity limits, as on arcs at their centripetal acceleration.
#[test]
fn a_limit_that_the_recording_exceeds_is_no_cause_of_another_program() {
    let mut wrong = calibrated(ARCS);
    let own = diagnosed(&wrong, &rows('X'), &truth());
    assert!(own.causes.is_empty(), "{:?}", own.causes);
    for axis in &mut wrong.axes {
        (axis.velocity, axis.rapid) = (30.0, 30.0);
    }
    wrong.calibrated_on.assumed_rapids = [false; 3];
    let program =
        rows('X').replace("G0 X90 Z12\nG0 X0 Z0\n", &"G0 X90 Z12\nG1 X86 F900\nG0 X0 Z0\nG1 X4\n".repeat(4));
    let diagnosis = diagnosed(&wrong, &program, &truth());
    assert!(diagnosis.causes.is_empty(), "{:?}", diagnosis.causes);
    let raised = diagnosis.calibrated.expect("the limits are raised");
    assert!(60.0 < raised.axes[0].velocity, "{} mm/s", raised.axes[0].velocity);
}

#[test]
fn a_rapid_that_no_run_showed_is_taken_from_the_recording_and_is_no_cause() {
    let mut slow = truth();
    slow.axes.iter_mut().for_each(|axis| axis.rapid = 50.0);
    let short: String =
        (1..40).map(|at| format!("G1 X{} F900\nG0 Z1\nX0\nZ0\nG1 Y{}\n", 3 + at % 2, at % 3)).collect();
    let long: String = ["X90 Y60", "X0", "Y0", "X80"].map(|to| format!("G0 {to}\nG1 Z3\nZ4 F900\n")).concat();
    let long = format!("G21 G90 F900\n{long}{short}M30\n");
    let machine = calibrated_on_run(&format!("G21 G90\nG0 Z1\n{short}M30\n"), &slow);
    assert_eq!(machine.calibrated_on.assumed_rapids, [true; 3]);
    let diagnosis = diagnosed(&machine, &long, &slow);
    assert!(diagnosis.causes.is_empty(), "{:?}", diagnosis.causes);
    let found = diagnosis.calibrated.expect("the rapids are taken from the recording");
    let rapids = found.axes.each_ref().map(|axis| axis.rapid);
    assert!(rapids[..2].iter().all(|rapid| (rapid / 50.0 - 1.0).abs() < 0.01), "{rapids:?} mm/s");
}

/// Moves from stop to stop, most of whose time is ramps.
fn stops(count: u32) -> String {
    let stop = |at: u32| format!("X{} F3000\nY{}\nZ-{}\n", 2 + 3 * (at % 2), 4 * (at % 2), 1 + at % 2);
    format!("G21 G90\nG61.1\nG0 Z5\nG1\n{}M30\n", (1..=count).map(stop).collect::<String>())
}

#[test]
fn an_acceleration_that_is_a_little_off_is_no_cause_of_another_program() {
    let mut machine = calibrated(&stops(30));
    assert_eq!(machine.calibrated_on.assumed_accelerations, [false; 3]);
    machine.axes.iter_mut().for_each(|axis| axis.acceleration *= 1.045);
    let diagnosis = diagnosed(&machine, &stops(43), &truth());
    assert!(diagnosis.causes.is_empty(), "{:?}", diagnosis.causes);
    let found = diagnosis.calibrated.expect("the accelerations are taken from the recording");
    for (found, truth) in found.axes.iter().zip(&truth().axes) {
        let ratio = found.acceleration / truth.acceleration;
        assert!((ratio - 1.0).abs() < 0.01, "{ratio} of the true acceleration");
    }
}

/// Plunges with a rapid of 7 mm back, which reaches no rate.
fn plunges() -> String {
    let plunge = |at: u32| format!("G1 Z-2 F300\nX{} F{}\nG0 Z5\n", 9 * (at % 2), 900 + 300 * (at % 4));
    format!("G21 G90\nG64 P0.01\nG0 Z5\n{}M30\n", (1..12).map(plunge).collect::<String>())
}

#[test]
fn a_slower_axis_and_an_override_of_rapids_are_alike_where_no_rapid_rate_is_known() {
    let mut fast = truth();
    fast.axes.iter_mut().for_each(|axis| axis.rapid = 70.0);
    let machine = calibrated_on_run(&plunges(), &fast);
    assert_eq!(machine.calibrated_on.assumed_rapids, [true; 3]);
    let mut changed = fast.clone();
    changed.overrides.rapid = 0.4;
    let diagnosis = diagnosed(&machine, &plunges(), &changed);
    let [cause] = &diagnosis.causes[..] else { panic!("{:?}", diagnosis.causes) };
    let ids = [&[cause.candidate.hypothesis.effect.id_on(None)], &cause.alike[..]].concat();
    for id in ["axis_velocity_limit", "rapid_override"] {
        assert!(ids.iter().any(|own| own.starts_with(id)), "{id} is not among {ids:?}");
    }
}

/// Retracts too short for a plateau of 60 ms, from two depths.
fn letters() -> String {
    let letter = |at: u32| {
        let (x, depth) = (6 * at, if at.is_multiple_of(3) { "0.3" } else { "0.963" });
        format!("G0 X{x}\nZ1\nG1 Z-{depth} F250\nG2 X{}.5 Y2 I1.5 J0.5 F970\nG0 Z7.5\nY0\n", 6 * at + 1)
    };
    let letters: String = (0..8).map(letter).collect();
    format!("G21 G90 G64\nG0 Z7.5\nX0 Y0\n{letters}M30\n")
}

/// A machine whose Z is the slowest axis in rapids.
fn slow_in_z() -> Machine {
    let mut slow = truth();
    (slow.axes[2].acceleration, slow.axes[2].velocity, slow.axes[2].rapid) = (730.0, 62.0, 62.0);
    slow
}

#[test]
fn rapids_of_two_lengths_show_the_rate_that_holds_them_back() {
    let machine = calibrated_on_run(&letters(), &slow_in_z());
    assert!((machine.axes[2].rapid / 62.0 - 1.0).abs() < 1e-3, "{} mm/s", machine.axes[2].rapid);
    assert_eq!(machine.calibrated_on.assumed_rapids, [true, true, false]);
}

#[test]
fn a_rate_is_read_off_a_run_with_its_recorded_rapid_override() {
    let mut halved = slow_in_z();
    halved.overrides.rapid = 0.5;
    let toolpath = traced(&letters());
    let alignment = recorded(&toolpath, &halved);
    let runs = [Run { overrides: (None, Some(0.5)), ..run(&toolpath, &alignment) }];
    let machine = calibrate(&believed(), &runs, &mut |_| {}).machine;
    assert!((machine.axes[2].rapid / 62.0 - 1.0).abs() < 1e-3, "{} mm/s", machine.axes[2].rapid);
}

/// Moves of rest to rest, each with a dwell after it, as the probe has them.
#[test]
fn dwells_that_last_longer_are_no_slower_axes() {
    let mut late = truth();
    late.times.dwell_excess = 0.006;
    let program = rows('Y').replace("Z-", "G4 P0.1\nG1 Z-");
    let machine = calibrated_on_run(&program, &late);
    assert!((machine.times.dwell_excess - 0.006).abs() < 5e-4, "{} s", machine.times.dwell_excess);
    let accelerations = [machine.axes[1].acceleration / 800.0, machine.axes[2].acceleration / 450.0];
    assert!(
        accelerations.iter().all(|ratio| (ratio - 1.0).abs() < 0.02),
        "{accelerations:?} of the true ones"
    );
}

#[test]
fn a_tool_change_that_no_run_had_is_taken_from_the_recording_and_widens_the_range() {
    let machine = calibrated(&rows('Y'));
    let mut quick = truth();
    quick.times.tool_change = 0.4;
    assert!(1.0 < machine.times.tool_change, "{} s from the file before", machine.times.tool_change);
    let program = rows('X').replace("G0 X0 Z0\n", "G0 X0 Z0\nT2 M6\n");
    let [with, without] = [program.as_str(), &rows('X')].map(|program| {
        let toolpath = traced(program);
        range(&toolpath, &machine, &simulate(&toolpath, &machine)).expect("the machine was calibrated")
    });
    assert!(with.unshown.iter().any(|(feature, _)| *feature == UnshownFeature::MWords), "{with:?}");
    let lasts = simulate(&traced(&program), &machine).cycle_time();
    assert!(machine.times.tool_change - 0.4 < with.ratio * lasts, "{with:?}");
    assert!(without.unshown.iter().all(|(feature, _)| *feature != UnshownFeature::MWords), "{without:?}");

    let diagnosis = diagnosed(&machine, &program, &quick);
    assert!(diagnosis.causes.is_empty(), "{:?}", diagnosis.causes);
    assert_eq!(diagnosis.verdict, Verdict::NothingMissing);
    let found = diagnosis.calibrated.expect("the time is taken from the recording").times.tool_change;
    assert!((found - 0.4).abs() < 0.01, "{found} s");
}

/// On arcs of one radius the acceleration keeps both axes below one velocity, √(√3/2 A r), again and again.
#[test]
fn a_velocity_that_the_acceleration_allows_on_arcs_is_no_limit_of_an_axis() {
    let turn = |at: u32| format!("G1 X{}.5\nG3 Y8 I0 J4\nG3 Y0 I0 J-4\n", at);
    let turns: String = (1..12).map(turn).collect();
    let program = format!("G21 G90 G64\nG0 X0 Y0 Z2\nG1 Z0 F600\nF6000\n{turns}G0 Z5\nM30\n");
    let toolpath = traced(&program);
    let alignment = recorded(&toolpath, &truth());
    let runs = [run(&toolpath, &alignment)];
    let on_arcs = (0.866_f64 * 500.0 * 4.0).sqrt();
    let of = |file: &Machine| calibrate(file, &runs, &mut |_| {}).machine.axes.map(|axis| axis.velocity);
    let found = of(&believed());
    assert!(found[..2].iter().all(|velocity| 1.2 * on_arcs < *velocity), "{found:?} mm/s, {on_arcs} on arcs");
    // A limit of the file stays even if the runs do not show it.
    let mut known = believed();
    known.axes[0].velocity = 150.0;
    assert!(of(&known)[0].is_finite());
}

/// Moves along which X is always a little faster than Y, so that a limit of either slows them alike.
#[test]
fn two_axes_that_always_move_together_are_not_told_apart() {
    let diagonals: String = (1..12)
        .map(|at| format!("G1 X{0} Y{1} F900\nZ-{at}\nG0 X0 Y0\nZ0\n", 26 * (1 + at % 3), 25 * (1 + at % 3)))
        .collect();
    let program = format!("G21 G90\nG0 Z1\n{diagonals}M30\n");
    let machine = calibrated(&program);
    let mut changed = truth();
    let limit = 0.8 * machine.axes[1].rapid.min(machine.axes[0].rapid * 25.0 / 26.0);
    (changed.axes[1].velocity, changed.axes[1].rapid) = (limit, limit);
    let diagnosis = diagnosed(&machine, &program, &changed);
    let [cause] = &diagnosis.causes[..] else { panic!("{:?}", diagnosis.causes) };
    assert_eq!(cause.candidate.hypothesis.effect.id, "axis_velocity_limit");
    let other = if cause.candidate.hypothesis.axes().as_deref() == Some("X") { "Y" } else { "X" };
    assert!(cause.alike.contains(&format!("axis_velocity_limit ({other})")), "{:?}", cause.alike);
    assert!(cause.confidence <= 0.5, "{}", cause.confidence);
    assert_eq!(diagnosis.verdict, Verdict::Ambiguous);
    let said = DiagnosisReport::new(&diagnosis, &["run".to_string()]).to_text();
    assert!(
        said.contains("or, as likely,") && said.contains(&format!("axis velocity limit ({other})")),
        "{said}"
    );
    assert!(said.contains("truefeed probe --between \"axis_velocity_limit ("), "{said}");
}

#[test]
#[ignore = "full suite: calibrates and diagnoses a long run"]
fn a_change_of_the_program_that_was_calibrated_on_is_found_all_the_same() {
    let machine = calibrated(&rows('Y'));
    let mut changed = truth();
    changed.axes[1].acceleration = 350.0;
    let diagnosis = diagnosed(&machine, &rows('Y'), &changed);
    assert_eq!(diagnosis.elsewhere, None);
    let named: Vec<_> = diagnosis.causes.iter().map(|cause| cause.candidate.hypothesis.name()).collect();
    assert_eq!(named, ["axis acceleration limit (Y)"]);
    assert!((diagnosis.causes[0].candidate.values[0] / 350.0 - 1.0).abs() < 0.03);
}

/// A finishing program in G64 without P, and so without merged lines.
fn finishing() -> String {
    let point = |row: u32, at: u32| {
        let (x, y) =
            (0.35 * f64::from(if row.is_multiple_of(2) { at } else { 80 - at }), 1.2 * f64::from(row));
        format!("X{x:.3} Y{y:.3} Z{:.3}\n", -1.5 * (x / 2.5).sin() * (0.4 * y).cos())
    };
    let points: String = (0..6).flat_map(|row| (0..81).map(move |at| point(row, at))).collect();
    format!("G21 G90 G64\nG0 X0 Y0 Z8\nG1 Z0 F900\nF3000\n{points}G0 Z8\nM30\n")
}

/// LinuxCNC's `G64 P` without Q sets the tolerance of corners, and merges lines within it.
#[test]
fn a_tolerance_that_also_merges_lines_is_one_cause() {
    let mut machine = truth();
    machine.interpolator.max_override = 1.0;
    let mut changed = machine.clone();
    (changed.interpolator.contour_tolerance, changed.interpolator.path_smoothing) = (0.012, Some(0.012));
    let diagnosis = diagnosed(&machine, &finishing(), &changed);
    let [cause] = &diagnosis.causes[..] else { panic!("{:?}", diagnosis.causes) };
    assert_eq!(cause.candidate.hypothesis.effect.id, "corner_tolerance");
    assert!((cause.candidate.values[0] / 0.012 - 1.0).abs() < 0.1, "{:?}", cause.candidate.values);
    let found = &diagnosis.machine.interpolator;
    assert_eq!(found.path_smoothing, Some(found.contour_tolerance));
}

/// The error of an unknown law and the change of a limit look alike, so only the second control has a limit to name. An
/// override is the operator's, whatever the law.
#[test]
fn a_control_of_an_unknown_law_has_no_limits_to_name() {
    let program = some_rows('X', 8);
    let toolpath = traced(&program);
    let alignment = recorded(&toolpath, &truth());
    let runs = [run(&toolpath, &alignment)];
    let mut known = truth();
    known.cycle_time_error = Some(1e-4);
    ModelError::of(&truth(), &runs).keep_in(&mut known);
    known.calibrated_on = calibrated_on(&truth(), &runs, &[]);
    assert_eq!(known.calibrated_on.misfit_of_unknown_law(), None);
    let mut unknown = known.clone();
    unknown.calibrated_on.ramp_misfit = Some(0.15);
    let (mut slower, mut overridden) = (truth(), truth());
    slower.axes[0].acceleration *= 0.7;
    overridden.overrides.feed = 0.8;
    let ids = |machine: &Machine, truth: &Machine| {
        let diagnosis = diagnosed(machine, &program, truth);
        let ids: Vec<&str> =
            diagnosis.causes.iter().map(|cause| cause.candidate.hypothesis.effect.id).collect();
        (diagnosis.verdict, ids, diagnosis.messages)
    };
    assert_eq!(ids(&known, &slower).1, ["axis_acceleration_limit"]);
    let (verdict, causes, messages) = ids(&unknown, &slower);
    assert_eq!((verdict, causes.len()), (Verdict::Unknown, 0), "{causes:?}");
    assert!(messages.iter().any(|message| message.contains("names no limit or setting")), "{messages:?}");
    for machine in [&known, &unknown] {
        assert_eq!(ids(machine, &overridden).1, ["feed_override"]);
    }
}

/// A contour with few corners between feed moves, twice at other depths.
fn contour() -> String {
    let pass = |z: f64| {
        format!(
            "G0 X15.723 Y-12.56 Z1\nG1 Z{z} F300\nG3 X14.529 Y-8.488 I1.439 J2.633 F1480\nG1 X17.713 Y-2.662\n\
             G3 X17.84 Y-1.231 I-1.576 J0.861\nG1 X14.117 Y9.89\nG3 X13.338 Y10.86 I-1.704 J-0.57\nG1 X-1.05 Y19.494\n\
             G3 X-2.813 Y19.542 I-0.924 J-1.54\nG1 X-14.555 Y13.341\nG3 X-15.503 Y11.935 I0.839 J-1.589\n\
             G1 X-16.362 Y3.541\nG1 X14.529 Y-8.488\nG0 Z12\n"
        )
    };
    format!("G21 G90\nG0 Z12\n{}{}M30\n", pass(-0.821), pass(-1.642))
}

#[test]
fn a_planner_whose_ramps_have_the_recorded_shape_is_taken() {
    let mut truth = machine_from_toml(include_str!("data/machines/grbl.toml")).expect("the file is right");
    for (axis, acceleration) in truth.axes.iter_mut().zip([2020.0, 2520.0, 1340.0]) {
        (axis.acceleration, axis.velocity, axis.rapid) = (acceleration, 150.0, 150.0);
    }
    let machine = calibrated_on_run(&contour(), &truth);
    assert!(matches!(machine.interpolator.junction, Junction::Deviation(_)), "{:?}", machine.interpolator);
    assert_eq!(machine.calibrated_on.misfit_of_unknown_law(), None);
    for (axis, acceleration) in machine.axes.iter().zip([2020.0, 2520.0, 1340.0]) {
        assert!((axis.acceleration / acceleration - 1.0).abs() < 0.1, "{} mm/s²", axis.acceleration);
    }
}

/// Squares, each cut at one of some feedrates; a rapid at that feedrate goes to the next.
fn squares(count: u32, feedrates: [u32; 3]) -> String {
    let square = |at: u32| {
        let (side, feed) = (4 + at % 5, feedrates[at as usize % 3]);
        format!("G1 Z-1 F{feed}\nX{side}\nY{side}\nX0\nY0\nG0 Z5\nX40 Y25\nX0 Y0\n")
    };
    let squares: String = (1..=count).map(square).collect();
    format!("G21 G90\nG0 X0 Y0 Z5 F9000\n{squares}M30\n")
}

/// Klipper's G0 is G1, and CAM writes no F into it.
#[test]
fn rapids_at_the_programmed_feedrate_are_found() {
    let mut truth = believed();
    truth.become_planner(Planner::SquareCorner, 980.0);
    truth.interpolator.junction = Junction::SquareCorner(1.1);
    (truth.rapid.feedrate, truth.rapid.at_feedrate) = (150.0, true);
    let machine = calibrated_on_run(&squares(9, [1400, 2600, 400]), &truth);
    assert!(machine.rapid.at_feedrate);
    let other = squares(9, [3100, 600, 1900]);
    let toolpath = traced(&other);
    let [own, expected] = [&machine, &truth].map(|machine| simulate(&toolpath, machine).cycle_time());
    assert!((own / expected - 1.0).abs() < 1e-3, "{own} for {expected} s");
    assert_eq!(diagnosed(&machine, &other, &truth).verdict, Verdict::NothingMissing);
    // The same squares with rapids that are faster than F.
    truth.rapid.at_feedrate = false;
    assert!(!calibrated_on_run(&squares(9, [1400, 2600, 400]), &truth).rapid.at_feedrate);
}
