//! The range of a program by what its calibration showed.

use super::*;
use crate::machine::{MAX_RAMP_MISFIT, Planner};
use crate::simulation::gcode::read;
use crate::simulation::interpreter::trace;

fn planner(family: Planner, acceleration: f64) -> Machine {
    let mut machine = Machine::default();
    machine.become_planner(family, acceleration);
    machine
}

fn path(program: &str) -> Toolpath {
    trace(&read(program.as_bytes()), &Machine::default())
}

/// Returns the range of a program that a calibrated machine runs.
fn range_of(toolpath: &Toolpath, machine: &Machine) -> TimeRange {
    range(toolpath, machine, &simulate(toolpath, machine)).expect("calibrated")
}

#[test]
fn the_range_reaches_to_corners_that_are_planned_for_the_largest_override_that_runs_allow() {
    let mut machine = planner(Planner::AccelerationBlend, 400.0);
    machine.interpolator.max_override = 1.2;
    let corners = path("G21 G90\nG1 X40 F1500\nY40\nX80\nY80\n");
    let known = CalibratedOn { range: Some(0.02), ..features_of([&corners]) };
    let unknown = CalibratedOn { largest_override: Some(2.0), ..known.clone() };
    let [known, unknown] = [known, unknown]
        .map(|calibrated_on| range_of(&corners, &Machine { calibrated_on, ..machine.clone() }));
    assert_eq!(known.ratio, 0.02);
    assert_eq!(unknown.unshown[0].0, UnshownFeature::Overrides);
    let time = |machine: &Machine| simulate(&corners, machine).cycle_time();
    let usual = time(&machine);
    machine.interpolator.max_override = 2.0;
    assert!((0.02 + (usual - time(&machine)) / usual - unknown.ratio).abs() < 1e-9, "{unknown:?}");
    assert!(0.03 < unknown.ratio, "{unknown:?}");
}

/// Klipper limits the path, so its axes have no acceleration of their own.
#[test]
fn an_axis_at_rest_makes_no_rapid_uncertain() {
    let mut machine = planner(Planner::SquareCorner, 500.0);
    let rapids = path("G21 G90\nG0 X50\nG1 X60 F1000\nG0 X0\n");
    machine.calibrated_on = CalibratedOn {
        range: Some(0.01),
        velocities: Some([machine.rapid.feedrate, 1.0, 1.0]),
        assumed_rapids: [true; 3],
        ..features_of([&rapids])
    };
    let found = range_of(&rapids, &machine);
    assert_eq!(found, TimeRange { ratio: 0.01, unshown: Vec::new() });
}

/// A diagonal that is almost along X: Y would be faster if X were, and no faster by itself.
#[test]
fn an_axis_that_another_one_holds_back_makes_no_rapid_uncertain() {
    let mut machine = planner(Planner::AccelerationBlend, 1460.0);
    machine.axes.iter_mut().for_each(|axis| axis.rapid = 90.0);
    let rapids = path("G21 G90\nG1 X80 F1000\nG0 X0 Y4.85\n");
    let of_rates = |shown: [f64; 3], rate_of_y: f64| {
        let mut machine = machine.clone();
        machine.axes[1].rapid = rate_of_y;
        machine.calibrated_on = CalibratedOn {
            range: Some(0.01),
            velocities: Some(shown),
            assumed_rapids: [false, true, false],
            ..features_of([&rapids])
        };
        range_of(&rapids, &machine).ratio
    };
    assert_eq!(of_rates([90.0, 5.4, 60.0], 90.0), 0.01);
    // Y may be faster than 5 mm/s where it is as slow, and slower than 90 mm/s if no axis is known to reach 45.
    assert!(0.1 < of_rates([90.0, 5.4, 60.0], 5.0));
    assert!(0.1 < of_rates([5.0, 1.0, 5.0], 90.0));
}

#[test]
fn an_arc_may_take_twice_as_long_if_the_runs_show_neither_corner_nor_arc() {
    // The rapid shows the velocity of the feed.
    let lines = path("G21 G90\nG1 X20 F1000\nG0 X0\n");
    let arcs = path("G21 G90\nG1 X20 F3000\nG2 X20 Y0 I0 J-5\n");
    let shares = |turns: Extent| {
        let on =
            CalibratedOn { range: Some(0.01), velocities: Some([200.0; 3]), turns, ..features_of([&lines]) };
        range_of(&arcs, &Machine { calibrated_on: on, ..Machine::default() })
    };
    let of_arc = 10.0 * std::f64::consts::PI / (20.0 + 10.0 * std::f64::consts::PI);
    let unknown = shares(Extent(None));
    assert_eq!(unknown.unshown[0].0, UnshownFeature::Arcs);
    assert!((unknown.ratio - 0.01 - of_arc).abs() < 1e-6, "{unknown:?}");
    assert!(shares(Extent(Some((0.1, 3.0)))).ratio < 0.04);
}

#[test]
fn the_range_reaches_to_other_chords_if_the_runs_show_no_arc() {
    let mut machine = planner(Planner::JunctionDeviation, 900.0);
    machine.path.jerk = 15e3;
    let arc = path("G21 G90\nG1 X20 F3000\nG2 X20 Y0 I0 J-10\nG1 X40\n");
    let shares = |radii: Extent| {
        let on = CalibratedOn { range: Some(0.01), radii, ..features_of([&arc]) };
        range_of(&arc, &Machine { calibrated_on: on, ..machine.clone() }).ratio
    };
    assert_eq!(shares(Extent(Some((5.0, 20.0)))), 0.01);
    let time = |ratio: f64| simulate(&arc, &machine.with_scaled_chords(ratio)).cycle_time();
    let other = (time(0.2) - time(1.0)).max(time(1.0) - time(5.0));
    assert!(0.01 + other / time(1.0) < shares(Extent(None)), "{other} s");
    // Runs whose arcs longer chords would slow allow shorter ones only.
    let on = CalibratedOn { range: Some(0.01), other_chord_ratios: vec![0.2], ..features_of([&arc]) };
    let found = range_of(&arc, &Machine { calibrated_on: on, ..machine.clone() });
    assert!((found.ratio - 0.01 - (time(0.2) / time(1.0) - 1.0).abs()).abs() < 1e-9, "{found:?}");
}

#[test]
fn the_range_is_wide_if_the_recorded_ramps_have_another_shape() {
    let legs = path("G21 G90\nG1 X40 F3000\nX0\n");
    let ratio_with = |ramp_misfit: Option<f64>| {
        let calibrated_on = CalibratedOn { range: Some(0.01), ramp_misfit, ..features_of([&legs]) };
        range_of(&legs, &Machine { calibrated_on, ..Machine::default() })
    };
    assert_eq!(ratio_with(None).ratio, 0.01);
    assert_eq!(ratio_with(Some(0.9 * MAX_RAMP_MISFIT)).ratio, 0.01);
    let other = ratio_with(Some(1.1 * MAX_RAMP_MISFIT));
    assert!((other.ratio - 0.01 - UNKNOWN_LAW_ERROR_RATIO).abs() < 1e-12, "{other:?}");
    assert_eq!(other.unshown, [(UnshownFeature::Ramps, 1.0)]);
}

#[test]
fn the_range_reaches_to_other_accelerations_if_one_was_assumed() {
    let machine = planner(Planner::JunctionDeviation, 400.0);
    let legs = path("G21 G90\nG1 X40 F3000\nX0\nX40\nX0\n");
    let ratio_with = |assumed: [bool; 3], least: [f64; 3]| {
        let calibrated_on = CalibratedOn {
            range: Some(0.01),
            assumed_accelerations: assumed,
            least_accelerations: Some(least),
            ..features_of([&legs])
        };
        range_of(&legs, &Machine { calibrated_on, ..machine.clone() }).ratio
    };
    // Four legs from rest to rest last v/A longer than at their feedrate.
    let of_ramps = 4.0 * 50.0 / 400.0;
    let slower = of_ramps * (ASSUMED_ACCELERATION_RATIO - 1.0);
    let found = ratio_with([true, false, false], [0.0; 3]);
    assert!((found - 0.01 - slower / (160.0 / 50.0 + of_ramps)).abs() < 1e-3, "{found}");
    assert_eq!(ratio_with([false, true, true], [0.0; 3]), 0.01);
    // The runs allow no lower one, and a higher one saves less.
    assert!(ratio_with([true, false, false], [400.0, 0.0, 0.0]) < found - 0.005);
}

/// Each ramp of jerk J takes 2 √(Δv/J), and both ramps of a leg cost half of that.
#[test]
fn the_range_reaches_to_other_jerks_if_one_was_assumed() {
    let mut machine = planner(Planner::JunctionDeviation, 1e4);
    machine.axes.iter_mut().for_each(|axis| axis.jerk = 5000.0);
    let legs = path("G21 G90\nG1 X40 F3000\nX0\nX40\nX0\n");
    let ratio_with = |least: Option<[f64; 3]>| {
        let calibrated_on = CalibratedOn { range: Some(0.01), least_jerks: least, ..features_of([&legs]) };
        range_of(&legs, &Machine { calibrated_on, ..machine.clone() }).ratio
    };
    let of_ramps = 4.0 * 2.0 * (50.0f64 / 5000.0).sqrt();
    let slower = of_ramps * (ASSUMED_ACCELERATION_RATIO.sqrt() - 1.0);
    let found = ratio_with(Some([100.0, 0.0, 0.0]));
    assert!((found - 0.01 - slower / (160.0 / 50.0 + of_ramps)).abs() < 1e-3, "{found}");
    assert_eq!([ratio_with(None), ratio_with(Some([0.0, 100.0, 0.0]))], [0.01; 2]);
    // The runs allow no lower one, and a higher one saves less.
    assert!(ratio_with(Some([5000.0, 0.0, 0.0])) < found - 0.002);
}

/// Programs of ramps alone: their time is proportional to 1/√a.
#[test]
fn the_range_contains_the_deviations_of_accelerations() {
    let machine = planner(Planner::JunctionDeviation, 400.0);
    let legs = path("G21 G90\nG1 X1 F30000\nX0\nX1\nX0\n");
    let of = |deviations: [f64; 3]| {
        let calibrated_on = CalibratedOn {
            range: Some(0.01),
            acceleration_deviations: Some(deviations),
            ..features_of([&legs])
        };
        range_of(&legs, &Machine { calibrated_on, ..machine.clone() })
    };
    let wide = of([0.02, 0.0, 0.0]);
    let of_ramps = (1.0 + NORMAL_QUANTILE_95 * 0.02).sqrt() - 1.0;
    assert!((wide.ratio - of_ramps.hypot(0.01)).abs() < 1e-5, "{wide:?}");
    assert_eq!(wide.unshown[0].0, UnshownFeature::RoughAccelerations);
    // Of axes that do not move, and of hardly any deviation.
    for deviations in [[0.0, 0.02, 0.02], [0.0015, 0.0, 0.0]] {
        let own = of(deviations);
        assert!((own.ratio - 0.01).abs() < 1e-9 && own.unshown.is_empty(), "{own:?}");
    }
}

#[test]
fn the_range_reaches_to_full_stops_if_the_runs_show_no_corner() {
    let mut machine = Machine::default();
    machine.axes.iter_mut().for_each(|axis| axis.acceleration = 500.0);
    let corners = path("G21 G90\nG1 X20 F3000\nY20\nX40\nY40\nX60\n");
    let of = |runs: &Toolpath, machine: &Machine| {
        let on = CalibratedOn { range: Some(0.02), ..features_of([runs]) };
        range_of(&corners, &Machine { calibrated_on: on, ..machine.clone() }).ratio
    };
    let straight = path("G21 G90\nG1 X20 F3000\nG0 Z5\nG1 X50\n");
    let [unknown, known] = [&straight, &corners].map(|runs| of(runs, &machine));
    assert_eq!(known, 0.02);

    let feedrate = 50.0;
    let uniform = 100.0 / feedrate;
    machine.interpolator.exact_stop_angle = 0.0;
    let of_ends = feedrate / 500.0 + 3.0 * 0.0255;
    let of_stops = simulate(&corners, &machine).cycle_time() - uniform - of_ends;
    assert!(0.1 * uniform < of_stops, "{of_stops} s");
    assert!(of_stops <= unknown * uniform, "{of_stops} s beyond ±{} %", 100.0 * unknown);
}

/// All rapids of the runs held F3000. No run shows a rapid at another F.
#[test]
fn the_range_reaches_to_rapids_at_the_only_feedrate_that_runs_show() {
    let mut machine = planner(Planner::JunctionDeviation, 400.0);
    machine.rapid.at_feedrate = true;
    let program = path("G21 G90\nG1 X40 F1500\nG0 X0 F1000\nG1 X20 F1500\n");
    let known = CalibratedOn { range: Some(0.02), ..features_of([&program]) };
    let only_one = CalibratedOn { only_rapid_feedrate: Some(50.0), ..known.clone() };
    let [known, only_one] = [known, only_one]
        .map(|calibrated_on| range_of(&program, &Machine { calibrated_on, ..machine.clone() }));
    assert_eq!(known.ratio, 0.02);
    let [(feature, ratio)] = only_one.unshown[..] else { panic!("{only_one:?}") };
    assert_eq!(feature, UnshownFeature::RapidFeedrates);
    let time = |machine: &Machine| simulate(&program, machine).cycle_time();
    let usual = time(&machine);
    machine.rapid.at_feedrate = false;
    machine.rapid.feedrate = 50.0;
    let longer = (usual - time(&machine)) / usual;
    assert!((longer - ratio).abs() < 1e-9 && (0.02 + longer - only_one.ratio).abs() < 1e-9, "{only_one:?}");
    assert!(0.2 < longer, "{longer}");
}
