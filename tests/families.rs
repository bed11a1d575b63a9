//! Families of planners that a calibration recognises: steps of axis velocities at corners and at rests, and short blocks that are
//! chords of an arc, as Marlin, ramps of constant jerk, as TinyG, and square corners, as Klipper.

use truefeed::identification::calibration::calibrate;
use truefeed::machine::{ArcChords, Junction, Machine, Planner};
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::simulate;

use crate::untold::{believed, recorded, run, traced};

/// Steps of 5.5 mm/s, in X more acceleration than in Y and Z.
fn truth() -> Machine {
    let mut machine = believed();
    machine.become_planner(Planner::AxisStep, 1340.0);
    machine.interpolator.junction = Junction::AxisStep(5.5);
    machine.axes[1].acceleration = 1080.0;
    machine.axes[2].acceleration = 1210.0;
    machine
}

/// Rows along X with half circles between them: hardly a ramp that holds its acceleration for long.
fn rows() -> String {
    let pair = |at: u32| {
        let (up, down) = (12 * at + 6, 12 * at + 12);
        format!("G1 X60\nG3 Y{up} I0 J3\nG1 X0\nG2 Y{down} I0 J3\n")
    };
    format!(
        "G21 G90\nG0 Z9 F4980\nG0 X0 Y0\nG0 Z1\nG1 Z-0.5 F800\nF3160\n{}G0 Z9\nM30\n",
        (0..4).map(pair).collect::<String>()
    )
}

/// Corners of many angles with a stop after each turn.
fn star() -> String {
    let turn = |at: u32| {
        let (sin, cos) = (0.7 * f64::from(at)).sin_cos();
        format!(
            "G1 X{:.3} Y{:.3} F2400\nX{:.3} Y{:.3} Z-1\nZ0\nG0 X0 Y0 F5400\nG4 P0.2\n",
            20.0 * cos,
            20.0 * sin,
            24.0 * cos,
            15.0 * sin
        )
    };
    format!("G21 G90\nG0 X0 Y0 Z0 F5400\n{}M30\n", (0..12).map(turn).collect::<String>())
}

/// Waves of short lines with long ones between them.
fn waves() -> String {
    let point =
        |at: u32| format!("X{:.3} Y{:.3}\n", 0.25 * f64::from(at), 6.0 * (0.12 * f64::from(at)).sin());
    let wave = |at: u32| {
        format!(
            "G1 X0 Y0 F{}\n{}G0 Z2\nX0 Y0\nZ0\n",
            2400 + 300 * at,
            (1..=160).map(point).collect::<String>()
        )
    };
    format!("G21 G90\nG0 X0 Y0 Z0 F5400\n{}M30\n", (0..4).map(wave).collect::<String>())
}

/// Circles that are too tight for the programmed feedrate, with a corner before and after each short line.
fn trochoid() -> String {
    let circle = |at: u32| format!("G1 X{:.3}\nG3 Y7 J3.5\nG3 Y0 J-3.5\n", 0.542 * f64::from(at));
    format!(
        "G21 G90\nG0 X0 Y0 Z1 F7080\nG1 Z-2 F300\nF4150\n{}G0 Z6 F7080\nM30\n",
        (1..=30).map(circle).collect::<String>()
    )
}

/// Calibrates the machine of which only the least is known on a program that `truth` runs.
fn calibrated(program: &str, truth: &Machine) -> Machine {
    let toolpath = traced(program);
    let alignment = recorded(&toolpath, truth);
    calibrate(&believed(), &[run(&toolpath, &alignment)], &mut |_| {}).machine
}

fn time(program: &str, machine: &Machine) -> f64 {
    simulate(&trace(&read(program.as_bytes()), machine), machine).cycle_time()
}

fn assert_is_truth(found: &Machine, truth: &Machine, other: &str) {
    let Junction::AxisStep(step) = found.interpolator.junction else {
        panic!("{:?}", found.interpolator.junction)
    };
    assert!((step / 5.5 - 1.0).abs() < 0.01, "{step} mm/s");
    assert_eq!(found.interpolator.quintic_ramps, truth.interpolator.quintic_ramps);
    assert!(found.rapid.at_feedrate);
    let off = time(other, found) / time(other, truth) - 1.0;
    assert!(off.abs() < 2e-3, "another program is {off} off");
}

#[test]
fn steps_of_axis_velocities_are_found_where_ramps_hold_no_acceleration() {
    let truth = truth();
    assert_is_truth(&calibrated(&rows(), &truth), &truth, &star());
}

#[test]
fn quintic_ramps_are_known_by_their_shape() {
    let mut truth = truth();
    truth.interpolator.quintic_ramps = true;
    assert_is_truth(&calibrated(&star(), &truth), &truth, &rows());
    truth.interpolator.quintic_ramps = false;
    assert_is_truth(&calibrated(&star(), &truth), &truth, &rows());
}

/// Small circles with a corner before each: the motion turns in all ramps, so that these hold no jerk.
fn circles() -> String {
    let circle = |at: u32| format!("G1 X{} F{}\nG3 I0 J3.8\n", 3 * at, 1500 + 400 * (at % 4));
    format!("G21 G90\nG0 X0 Y0 Z2\nG1 Z-1 F300\n{}G0 Z2\nM30\n", (1..=14).map(circle).collect::<String>())
}

#[test]
fn a_jerk_that_no_straight_ramp_shows_is_found_by_the_shape_of_ramps() {
    let mut truth = believed();
    truth.become_planner(Planner::JunctionDeviation, 1050.0);
    truth.interpolator.step_segment = 0.0;
    truth.interpolator.junction = Junction::Deviation(0.058);
    truth.interpolator.arc_chords = ArcChords::Within(0.01);
    truth.axes.iter_mut().for_each(|axis| (axis.jerk, axis.rapid) = (6560.0, 200.0));
    truth.rapid.feedrate = f64::INFINITY;
    let found = calibrated(&circles(), &truth);
    for jerk in found.axes[..2].iter().map(|axis| axis.jerk) {
        assert!((jerk / 6560.0 - 1.0).abs() < 0.01, "{jerk} mm/s³");
    }
    assert!(matches!(found.interpolator.junction, Junction::Deviation(_)));
}

/// A planner with steps of 10 mm/s and 400 mm/s².
fn planner() -> Machine {
    let mut machine = Machine::default();
    machine.become_planner(Planner::AxisStep, 400.0);
    machine
}

#[test]
fn motions_begin_and_end_with_the_step_of_an_axis() {
    // From 10 to 50 mm/s in 0.1 s and 3 mm; along a diagonal from 12.5 mm/s with 500 mm/s²; slower than the step without ramps.
    let diagonal = 2.0 * 37.5 / 500.0 + (20.0 - 37.5 * 62.5 / 500.0) / 50.0;
    let programs =
        [("G1 X20 F3000", 0.2 + 14.0 / 50.0), ("G1 X12 Y16 F3000", diagonal), ("G1 X20 F300", 4.0)];
    for (program, expected) in programs {
        let found = time(program, &planner());
        assert!((found - expected).abs() < 1e-4, "{program}: {found} s, {expected} s");
    }
}

#[test]
fn filters_begin_at_rest() {
    let mut machine = Machine::default();
    let without = time("G1 X20 F3000", &machine);
    machine.interpolator.junction = planner().interpolator.junction;
    assert!((time("G1 X20 F3000", &machine) - without).abs() < 1e-9);
}

/// The path turns back at 5 mm/s, from where the step is not reached within a micrometre.
#[test]
fn a_short_block_beside_a_rest_keeps_its_length() {
    for program in ["G1 X10 F3000\nX9.999", "G1 X0.001 F3000\nX-9.999"] {
        let toolpath = trace(&read(program.as_bytes()), &planner());
        let plan = simulate(&toolpath, &planner());
        for (index, segment) in toolpath.segments.iter().enumerate() {
            let own = plan.pulses.iter().filter(|pulse| pulse.segment as usize == index);
            let length: f64 =
                own.map(|pulse| 0.5 * pulse.duration * (pulse.feedrate[0] + pulse.feedrate[1])).sum();
            assert!((length - segment.length).abs() < 1e-9, "{program}: {length} mm");
        }
    }
}

/// The joints of chords are corners too, and could limit arcs if the acceleration were higher.
#[test]
fn arcs_do_not_hide_the_acceleration_and_corners_of_a_planner_with_square_corners() {
    let mut truth = believed();
    truth.become_planner(Planner::SquareCorner, 670.0);
    truth.interpolator.junction = Junction::SquareCorner(3.849);
    let found = calibrated(&trochoid(), &truth);
    let Junction::SquareCorner(velocity) = found.interpolator.junction else {
        panic!("{:?}", found.interpolator.junction)
    };
    assert!((velocity / 3.849 - 1.0).abs() < 0.02, "{velocity} mm/s");
    assert!((found.path.acceleration / 670.0 - 1.0).abs() < 0.01, "{} mm/s²", found.path.acceleration);
}

/// By the law of grbl, the tool would pass the corners between short lines at full speed.
#[test]
fn short_blocks_are_passed_as_chords_of_an_arc() {
    let mut truth = believed();
    truth.become_planner(Planner::ChordDeviation, 1340.0);
    truth.interpolator.junction = Junction::Deviation(0.03);
    for is_quintic in [false, true] {
        truth.interpolator.quintic_ramps = is_quintic;
        let found = calibrated(&star(), &truth);
        assert!(found.interpolator.short_blocks_are_chords, "{:?}", found.interpolator);
        assert_eq!(found.interpolator.quintic_ramps, is_quintic);
        let off = time(&waves(), &found) / time(&waves(), &truth) - 1.0;
        assert!(off.abs() < 3e-3, "another program is {off} off");
    }
}

/// With trapezoids in the place of these ramps, all else would be fitted wrong, and filters would be nearer.
#[test]
fn small_circles_show_quintic_ramps() {
    let mut truth = believed();
    truth.become_planner(Planner::ChordDeviation, 1080.0);
    truth.interpolator.junction = Junction::Deviation(0.05);
    truth.interpolator.quintic_ramps = true;
    let found = calibrated(&trochoid(), &truth);
    assert!(found.interpolator.quintic_ramps, "{:?}", found.interpolator);
    let acceleration = found.axes[0].acceleration;
    assert!((acceleration / 1080.0 - 1.0).abs() < 0.01, "{acceleration} mm/s²");
}

/// The look-ahead limits the feedrate along short lines. The ring of 16 blocks keeps one free.
#[test]
fn a_run_that_the_look_ahead_limits_shows_steps_of_axis_velocities() {
    let mut truth = believed();
    truth.become_planner(Planner::AxisStep, 300.0);
    truth.interpolator.junction = Junction::AxisStep(2.5);
    truth.interpolator.look_ahead = 15.0;
    let found = calibrated(&waves(), &truth);
    let Junction::AxisStep(step) = found.interpolator.junction else {
        panic!("{:?}", found.interpolator.junction)
    };
    assert!((step / 2.5 - 1.0).abs() < 0.01, "{step} mm/s");
    assert_eq!(found.interpolator.look_ahead, 15.0);
}

/// Klipper's corners with Marlin's curves are no family.
#[test]
fn ramps_of_an_unknown_law_are_told() {
    let mut truth = believed();
    truth.become_planner(Planner::SquareCorner, 670.0);
    truth.interpolator.quintic_ramps = true;
    let found = calibrated(&rows(), &truth);
    assert!(found.calibrated_on.misfit_of_unknown_law().is_some(), "{:?}", found.calibrated_on.ramp_misfit);
}
