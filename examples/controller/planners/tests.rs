//! The planners beside recordings of the software that they are written after, and calibrations on their recordings.

use std::path::PathBuf;

use serde_json::Value;
use truefeed::identification::alignment::align;
use truefeed::identification::calibration::calibrate;
use truefeed::identification::fit::{Run, ramp_misfit};
use truefeed::identification::recording;
use truefeed::machine::{Junction, MAX_RAMP_MISFIT, Machine};
use truefeed::project::machine_from_toml;
use truefeed::simulation::gcode;
use truefeed::simulation::interpreter::trace;

use super::replayed;
use crate::geometry::Job;
use crate::kinds;
use crate::machine::{Family, Limits};
use crate::random::Random;
use crate::trace::Scale;
use crate::words::Manner;

use super::settings::Settings;

/// Largest relative error of the time of a run: the recordings have rows every 4 ms, and grbl's overrides came in steps.
const WITHIN: f64 = 0.002;
/// Time between two rows, s.
const STEP_S: f64 = 0.004;

fn folder(control: &str) -> PathBuf {
    PathBuf::from("../shared/recordings").join(control)
}

/// Returns the settings of a run from its answer; `None` if the answer says only on which line something changed.
fn settings(control: &str, answer: &Value) -> Option<Settings> {
    let mut settings = Settings::default();
    let number = |key: &str| answer["parameters"][key].as_f64();
    let axis = answer["parameters"]["axis"].as_str().and_then(|name| "XYZ".find(name));
    match answer["effect"].as_str() {
        None => {}
        Some("junction_rule") if control == "grbl" => settings.junction_deviation = number("value")?,
        Some("junction_rule") => settings.square_corner_velocity = number("value_mm_s")?,
        Some("axis_acceleration_limit") => settings.acceleration[axis?] = number("a_mm_s2")?,
        Some("path_acceleration_limit") => settings.acceleration = [number("a_mm_s2")?; 3],
        Some("look_ahead") => settings.look_ahead = number("blocks")? as usize,
        Some("rapid_override") if control == "grbl" => settings.rapid_override = number("ratio")?,
        Some("rapid_override") => settings.path_velocity = 100.0 * number("ratio")?,
        Some("feed_override") => settings.feed_overrides = vec![(number("from_time_s")?, number("ratio")?)],
        Some("feed_hold") => settings.hold = Some((number("at_time_s")?, number("seconds")?)),
        Some(_) => return None,
    }
    Some(settings)
}

/// From the first change of position to the last, s.
fn recorded(path: &PathBuf) -> f64 {
    let text = std::fs::read_to_string(path).expect("the run is there");
    let rows: Vec<Vec<&str>> = text.lines().skip(1).map(|row| row.split(',').collect()).collect();
    let moves: Vec<usize> = (1..rows.len()).filter(|&row| rows[row][1..4] != rows[row - 1][1..4]).collect();
    let time = |row: usize| rows[row][0].parse::<f64>().expect("a time");
    time(moves[moves.len() - 1]) - time(moves[0])
}

/// Skipped where the recordings are not at hand.
#[test]
fn planners_take_as_long_as_the_software_that_they_are_written_after() {
    for control in ["grbl", "klipper"] {
        let Ok(answers) = std::fs::read_to_string(folder(control).join("answers.json")) else { continue };
        let answers: Value = serde_json::from_str(&answers).expect("they are JSON");
        let mut checked = 0;
        for (run, answer) in answers.as_object().expect("by run") {
            let Some(settings) = settings(control, answer) else { continue };
            let program = folder(control).join(answer["program"].as_str().expect("a name"));
            let text = std::fs::read_to_string(program).expect("the program is there");
            let family = Family::named(control).expect("a control");
            let planned = replayed(family, &text, STEP_S, &settings).expect("it can be read").duration();
            let taken = recorded(&folder(control).join(run));
            println!("{control} {run} {}: {planned:.3} s, recorded {taken:.3} s", answer["effect"]);

            assert!((planned / taken - 1.0).abs() < WITHIN, "{control} {run}: {planned} s, {taken} s");
            checked += 1;
        }
        assert!(checked >= 6, "{control}: {checked} runs");
    }
}

/// Returns the machine calibrated, from a file that knows nothing of it, on a job of a kind that a planner has run.
fn calibrated(control: &str, kind: &str, settings: &Settings) -> Machine {
    calibrated_with_misfit(control, kind, settings).0
}

/// Returns the machine as [`calibrated`] does, and the misfit of its ramps.
fn calibrated_with_misfit(control: &str, kind: &str, settings: &Settings) -> (Machine, f64) {
    let family = Family::named(control).expect("a control");
    let mut random = Random::new(1, 0);
    let limits =
        Limits { acceleration: settings.acceleration, velocity: settings.velocity, settings: Vec::new() };
    let manner = Manner { inch: false, ..Manner::draw(&mut random).on(family, &limits) };
    let mut job = Job::new(30.0, 5.0);
    let fill = kinds::KINDS.iter().find(|(name, _)| *name == kind).expect("a kind").1;
    fill(&mut random, &mut job);
    let program = manner.write(kind, 5.0, &job.moves);
    let run = replayed(family, &program, STEP_S, settings).expect("it can be read");
    let file = std::env::temp_dir().join(format!("truefeed-{}-{control}-{kind}.csv.gz", std::process::id()));
    run.write(&file, Scale::Command).expect("it can be written");
    let bytes = std::fs::read(&file).expect("it is there");
    std::fs::remove_file(&file).expect("it can be removed");
    let generic = machine_from_toml(include_str!("../../../tests/data/machines/generic.toml"));
    let generic = generic.expect("a machine file");
    let toolpath = trace(&gcode::read(program.as_bytes()), &generic);
    let log = recording::read(&bytes).expect("a log").recordings.remove(0);
    let alignment = align(&log, &toolpath, &generic).expect("it is of that program");
    let runs = [Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }];
    let machine = calibrate(&generic, &runs, &mut |_| {}).machine;
    let misfit = ramp_misfit(&machine, &runs).of_path.expect("positions were recorded");
    (machine, misfit)
}

/// A control of which every value is another than those from which a calibration begins: corners that are much slower, and
/// short ramps that hardly cruise.
#[test]
fn slow_corners_of_klipper_are_not_taken_for_gentle_ramps() {
    let truth = Settings {
        acceleration: [1700.0; 3],
        velocity: [300.0; 3],
        square_corner_velocity: 3.0,
        cruise_ratio: 0.25,
        ..Settings::default()
    };
    let found = calibrated("klipper", "finishing", &truth);
    let Junction::SquareCorner(velocity) = found.interpolator.junction else {
        panic!("{:?}", found.interpolator.junction)
    };
    assert!((velocity / 3.0 - 1.0).abs() < 0.05, "{velocity} mm/s");
    assert!((found.path.acceleration / 1700.0 - 1.0).abs() < 0.05, "{} mm/s²", found.path.acceleration);
}

/// Klipper limits Z separately. Other rapids hold their F, which is 100 mm/s here, so that no rate along the path shows.
#[test]
fn rapids_of_klipper_are_slower_along_z() {
    let truth = Settings {
        acceleration: [900.0, 900.0, 500.0],
        velocity: [100.0, 100.0, 30.0],
        ..Settings::default()
    };
    let found = calibrated("klipper", "drilling", &truth);
    assert!(
        matches!(found.interpolator.junction, Junction::SquareCorner(_)),
        "{:?}",
        found.interpolator.junction
    );
    assert!(found.rapid.at_feedrate && 100.0 <= found.rapid.feedrate, "{:?}", found.rapid);
    for (value, expected) in
        [(found.axes[2].rapid, 30.0), (found.axes[2].acceleration, 500.0), (found.path.acceleration, 900.0)]
    {
        assert!((value / expected - 1.0).abs() < 0.02, "{value}, {expected}");
    }
}

/// A program that asks for more than an axis of grbl can do, as it has one velocity for feed moves and rapids.
#[test]
fn an_axis_of_grbl_holds_back_feed_moves_too() {
    let truth = Settings {
        acceleration: [440.0, 300.0, 430.0],
        velocity: [25.0, 20.0, 25.0],
        junction_deviation: 0.026,
        ..Settings::default()
    };
    let found = calibrated("grbl", "facing", &truth);
    assert!(
        matches!(found.interpolator.junction, Junction::Deviation(_)),
        "{:?}",
        found.interpolator.junction
    );
    let held = found.axes.iter().map(|axis| axis.velocity).fold(f64::INFINITY, f64::min);
    assert!((held / 20.0 - 1.0).abs() < 0.01 || (held / 25.0 - 1.0).abs() < 0.01, "{held} mm/s");
}

/// TinyG ramps with a jerk, and limits no acceleration.
#[test]
fn ramps_of_constant_jerk_are_found() {
    let truth = Settings {
        acceleration: [900.0; 3],
        velocity: [80.0; 3],
        junction_deviation: 0.03,
        jerk_time: Some(0.06),
        ..Settings::default()
    };
    let (found, misfit) = calibrated_with_misfit("tinyg", "drilling", &truth);
    for jerk in found.axes.map(|axis| axis.jerk) {
        assert!((jerk / 15e3 - 1.0).abs() < 0.02, "{jerk} mm/s³");
    }
    assert!(misfit < MAX_RAMP_MISFIT, "{misfit}");
}

/// Marlin's curves last as long as trapezoids.
#[test]
fn steps_of_axis_velocities_and_quintic_ramps_are_found() {
    let truth = Settings {
        acceleration: [400.0; 3],
        velocity: [80.0; 3],
        corner_step: Some(5.0),
        is_curved: true,
        ..Settings::default()
    };
    let (found, misfit) = calibrated_with_misfit("marlin", "pocket", &truth);
    let Junction::AxisStep(step) = found.interpolator.junction else { panic!("{:?}", found.interpolator) };
    assert!((step / 5.0 - 1.0).abs() < 0.01, "{step} mm/s");
    assert!(found.interpolator.quintic_ramps && misfit < MAX_RAMP_MISFIT, "{misfit}");
}

/// In a trochoid, most places are within ramps: with the accelerations that trapezoids end at, curves have no better shape.
#[test]
fn quintic_ramps_are_found_where_trapezoids_end_far_from_them() {
    let truth = Settings {
        acceleration: [950.0, 710.0, 1090.0],
        velocity: [77.0, 69.0, 96.0],
        corner_step: Some(2.0),
        is_curved: true,
        ..Settings::default()
    };
    let (found, misfit) = calibrated_with_misfit("marlin", "corpus-trochoid", &truth);
    assert!(found.interpolator.quintic_ramps && misfit < MAX_RAMP_MISFIT, "{misfit}");
    for (axis, expected) in found.axes.iter().zip([950.0, 710.0]) {
        assert!((axis.acceleration / expected - 1.0).abs() < 0.02, "{} mm/s²", axis.acceleration);
    }
}

/// Marlin's default corners, with curves.
#[test]
fn a_junction_deviation_of_marlin_is_found() {
    let truth = Settings {
        acceleration: [400.0; 3],
        velocity: [80.0; 3],
        junction_deviation: 0.03,
        has_short_blocks_as_chords: true,
        is_curved: true,
        ..Settings::default()
    };
    let (found, misfit) = calibrated_with_misfit("marlin-deviation", "pocket", &truth);
    let Junction::Deviation(deviation) = found.interpolator.junction else {
        panic!("{:?}", found.interpolator)
    };
    assert!((deviation / 0.03 - 1.0).abs() < 0.02, "{deviation} mm");
    assert!(found.interpolator.short_blocks_are_chords);
    assert!(found.interpolator.quintic_ramps && misfit < MAX_RAMP_MISFIT, "{misfit}");
}

/// Marlin's curves with grbl's corners, which are no family: the nearest one has all of its ramps.
#[test]
fn curves_with_corners_of_grbl_are_taken_for_marlin() {
    let truth =
        Settings { acceleration: [400.0; 3], velocity: [80.0; 3], is_curved: true, ..Settings::default() };
    let (found, misfit) = calibrated_with_misfit("marlin", "pocket", &truth);
    let Junction::Deviation(deviation) = found.interpolator.junction else {
        panic!("{:?}", found.interpolator)
    };
    assert!((deviation / 0.01 - 1.0).abs() < 0.05, "{deviation} mm");
    assert!(found.interpolator.quintic_ramps && misfit < MAX_RAMP_MISFIT, "{misfit}");
}
