//! Planners of hobby controls: cycle times of recorded runs, clean and with one setting changed, with the true settings in
//! the machine file.

use std::path::{Path, PathBuf};

use truefeed::identification::alignment::align;
use truefeed::identification::calibration::calibrate;
use truefeed::identification::diagnosis::{ModelError, Verdict, diagnose};
use truefeed::identification::fit::Run;
use truefeed::identification::recording::{self, Recording};
use truefeed::machine::{Junction, Machine, Planner};
use truefeed::project::machine_from_toml;
use truefeed::simulation::feed::Tolerances;
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::Toolpath;

use crate::figures::{agree, row};
use crate::shared::corpus;

/// How far off a cycle time may be, as a part of it.
const WITHIN: f64 = 0.003;

/// A control whose planner was recorded.
struct Control {
    folder: &'static str,
    machine: &'static str,
    /// What docs/diagnosis.md calls it, and says is found.
    name: &'static str,
    found: &'static str,
}

const CONTROLS: [Control; 3] = [
    Control {
        folder: "grbl",
        machine: include_str!("data/machines/grbl.toml"),
        name: "grbl",
        found: "junction deviation 0.0101 mm (0.010)",
    },
    Control {
        folder: "klipper",
        machine: include_str!("data/machines/klipper.toml"),
        name: "Klipper",
        found: "square-corner velocity 300 mm/min (300), path acceleration 500 mm/s² (500)",
    },
    Control {
        folder: "linuxcnc",
        machine: include_str!("data/machines/linuxcnc.toml"),
        name: "LinuxCNC",
        found: "blends at the acceleration of the axes",
    },
];

/// The machine of a run; `None` where what was changed is not in the machine, or its place is known by time alone.
fn machine(control: &Control, effect: Option<&str>, parameters: &serde_json::Value) -> Option<Machine> {
    let mut machine = machine_from_toml(control.machine).expect("the file is right");
    let number = |key: &str| parameters[key].as_f64();
    let line = |key: &str| number(key).map(|line| line as u32);
    let axis = parameters["axis"].as_str().and_then(|name| "XYZ".find(name));
    let set = |key: &str, value: f64| {
        let text = control.machine.lines().map(|row| match row.split_once(" = ") {
            Some((known, _)) if known == key => format!("{key} = {value}\n"),
            _ => format!("{row}\n"),
        });
        machine_from_toml(&text.collect::<String>()).expect("the setting is one of a machine")
    };
    match effect {
        None => {}
        Some("junction_rule") => {
            let key = match parameters["rule"].as_str()? {
                "junction_deviation" => "junction_deviation_mm",
                _ => "square_corner_velocity_mm_min",
            };
            machine = set(key, number("value")?);
        }
        Some("axis_acceleration_limit") => machine.axes[axis?].acceleration = number("a_mm_s2")?,
        Some("axis_velocity_limit") => machine.axes[axis?].velocity = number("v_mm_min")? / 60.0,
        Some("path_acceleration_limit") => machine = set("acceleration_mm_s2", number("a_mm_s2")?),
        Some("corner_tolerance") => {
            machine.path_modes.tolerance_override = number("contour_tolerance_mm");
        }
        Some("look_ahead") => machine.interpolator.look_ahead = number("blocks")?,
        Some("rapid_override") => machine.overrides.rapid = number("ratio")?,
        Some("feed_override") => {
            machine.overrides.feed_by_line.insert(line("from_line")?, number("ratio")?);
        }
        Some("feed_hold") => {
            machine.halts.feed_holds.insert(line("line")?, number("seconds")?);
        }
        Some(_) => return None,
    }
    Some(machine)
}

/// From the first change of position to the last, s.
fn motion_time(recording: &Path) -> f64 {
    let text = std::fs::read_to_string(recording).expect("the recording is there");
    let mut rows = text.lines();
    let header: Vec<&str> = rows.next().expect("it has a header").split(',').collect();
    let columns =
        ["x_mm", "y_mm", "z_mm"].map(|name| header.iter().position(|known| *known == name).unwrap());
    let rows: Vec<(f64, [&str; 3])> = rows
        .map(|row| {
            let cells: Vec<&str> = row.split(',').collect();
            (cells[0].parse().expect("a time"), columns.map(|column| cells[column]))
        })
        .collect();
    let moves: Vec<usize> = (1..rows.len()).filter(|&i| rows[i].1 != rows[i - 1].1).collect();
    rows[moves[moves.len() - 1]].0 - rows[moves[0] - 1].0
}

/// Rows of a hundred blocks with a right turn after each, a stop at every one: N (L/F + F/a), and a tenth less of a in exact
/// path mode, as LinuxCNC was recorded at.
#[test]
fn exact_path_takes_a_tenth_of_the_acceleration_and_exact_stop_none() {
    let machine = machine_from_toml(include_str!("data/machines/linuxcnc.toml")).expect("the file is right");
    let blocks: String = (0..50).map(|_| "G91 X2\nY2\n").collect();
    let time = |word: &str| {
        let program = format!("G21\n{word}\nG1 F900\n{blocks}");
        simulate(&trace(&read(program.as_bytes()), &machine), &machine).cycle_time()
    };
    let stops = |acceleration: f64| 100.0 * (2.0 / 15.0 + 15.0 / acceleration);
    for (word, acceleration) in [("G61.1", 500.0), ("G61", 450.0)] {
        let off = time(word) / stops(acceleration) - 1.0;
        assert!((0.0..4e-3).contains(&off), "{word}: {} s, {} s", time(word), stops(acceleration));
    }
}

#[test]
fn true_settings_give_the_recorded_cycle_times() {
    let mut checked = 0;
    for control in &CONTROLS {
        let folder = corpus::recordings().join(control.folder);
        let answers = std::fs::read_to_string(folder.join("answers.json")).expect("it has answers");
        let answers: serde_json::Value = serde_json::from_str(&answers).expect("they are JSON");
        for (run, answer) in answers.as_object().expect("by run") {
            let effect = answer["effect"].as_str();
            // Behind the drives nothing changes the time; a place known by time alone is not one of the program.
            let Some(machine) = machine(control, effect, &answer["parameters"]) else { continue };
            // A junction deviation of less than the arcs' chords makes their corners count, whose angles the whole
            // steps of the axes blur: 0.5 % here.
            let within = if effect == Some("junction_rule") { 2.0 * WITHIN } else { WITHIN };
            let program = std::fs::read(folder.join(answer["program"].as_str().expect("a name")));
            let toolpath = trace(&read(&program.expect("the program is there")), &machine);
            let predicted =
                simulate::with_policy(&toolpath, &machine, Tolerances::Programmed.into()).cycle_time();
            let recorded = motion_time(&folder.join(run));
            let error = predicted / recorded - 1.0;
            println!(
                "{} {run} {}: recorded {recorded:.3} s, predicted {predicted:.3} s, {:+.2} %",
                control.folder,
                effect.unwrap_or("clean"),
                100.0 * error
            );
            assert!(error.abs() < within, "{} {run}: {error}", control.folder);
            checked += 1;
        }
        assert!(0 < checked);
    }
}

/// What an estimator knows of a machine before its first recording.
pub const GENERIC: &str = include_str!("data/machines/generic.toml");

/// How far off motion may be on programs that the calibration did not see, as a part.
const ELSEWHERE: f64 = 0.015;

/// The clean runs of a control: program and recording.
fn clean_runs(control: &Control) -> Vec<(Toolpath, Recording, PathBuf)> {
    let folder = corpus::recordings().join(control.folder);
    let answers = std::fs::read_to_string(folder.join("answers.json")).expect("it has answers");
    let answers: serde_json::Value = serde_json::from_str(&answers).expect("they are JSON");
    let clean = answers.as_object().expect("by run").iter().filter(|(_, answer)| answer["effect"].is_null());
    let read_run = |(run, answer): (&String, &serde_json::Value)| {
        let program = std::fs::read(folder.join(answer["program"].as_str().expect("a name")));
        let toolpath = trace(&read(&program.expect("the program is there")), &Machine::default());
        let log =
            recording::read(&std::fs::read(folder.join(run)).expect("the run is there")).expect("a log");
        (toolpath, log.recordings.into_iter().next().expect("a recording"), folder.join(run))
    };
    clean.map(read_run).collect()
}

/// A calibration from a generic file on one clean run finds the family of each control. It predicts the motion of the other
/// programs and explains the run completely. A diagnosis from the generic file finds the same family.
#[test]
fn a_calibration_finds_the_planner_and_predicts_other_programs() {
    let generic = machine_from_toml(GENERIC).expect("a machine file");
    for control in &CONTROLS {
        let runs = clean_runs(control);
        let (toolpath, recording, _) = &runs[0];
        let alignment = align(recording, toolpath, &generic).expect("it is of that program");
        let run = [Run { toolpath, alignment: &alignment, overrides: (None, None) }];
        let mut machine = calibrate(&generic, &run, &mut |_| {}).machine;
        match (control.folder, machine.interpolator.junction) {
            ("grbl", Junction::Deviation(value)) => assert!((value / 0.01 - 1.0).abs() < 0.1, "{value} mm"),
            ("klipper", Junction::SquareCorner(value)) => {
                assert!((value / 5.0 - 1.0).abs() < 0.05, "{value} mm/s")
            }
            ("linuxcnc", Junction::AccelerationBlend) => {}
            (folder, junction) => panic!("{folder}: {junction:?}"),
        }
        let mut errors = Vec::new();
        for (other, _, file) in &runs {
            let error = simulate(other, &machine).cycle_time() / motion_time(file) - 1.0;
            println!("{} {}: {:+.2} %", control.folder, file.display(), 100.0 * error);
            assert!(error.abs() < ELSEWHERE, "{}: {error}", file.display());
            errors.push(100.0 * error);
        }
        let stated = row("docs/diagnosis.md", &format!("| {} | {} |", control.name, control.found)).concat();
        agree(&stated, &errors, control.name);
        let error = ModelError::of(&machine, &run);
        machine.cycle_time_error = Some(error.unexplained_time);
        error.keep_in(&mut machine);
        let diagnosis = diagnose(&machine, &run, &mut |_| {});
        assert_eq!(diagnosis.verdict, Verdict::NothingMissing, "{}: {:?}", control.folder, diagnosis.causes);
        // No cause makes a planner of filters.
        let first = diagnose(&generic, &run, &mut |_| {});
        let calibrated = first.calibrated.as_ref().expect("the preset describes another machine");
        assert_eq!(calibrated.interpolator.junction, machine.interpolator.junction, "{}", control.folder);
        assert_eq!(first.verdict, Verdict::NothingMissing, "{}: {:?}", control.folder, first.causes);
    }
}

/// Klipper holds a velocity in each rapid for the part of it that the minimum cruise ratio asks for, so a held velocity is
/// not the rapid rate in the one program whose rapids are all short.
#[test]
fn rapids_that_a_minimum_cruise_ratio_holds_back_do_not_show_their_rate() {
    let generic = machine_from_toml(GENERIC).expect("a machine file");
    let runs = clean_runs(&CONTROLS[1]);
    let (toolpath, recording, file) = &runs[1];
    assert!(file.ends_with("run-04.csv"));
    let alignment = align(recording, toolpath, &generic).expect("it is of that program");
    let run = [Run { toolpath, alignment: &alignment, overrides: (None, None) }];
    let machine = calibrate(&generic, &run, &mut |_| {}).machine;
    assert_eq!(machine.calibrated_on.assumed_rapids, [true; 3]);
    for (other, _, file) in &runs {
        let error = simulate(other, &machine).cycle_time() / motion_time(file) - 1.0;
        assert!(error.abs() < ELSEWHERE, "{}: {error}", file.display());
    }
}

/// A move from rest to rest takes its ramps and no filter.
#[test]
fn a_stop_of_a_stepper_lasts_no_longer_than_its_ramps() {
    for planner in [Planner::JunctionDeviation, Planner::SquareCorner] {
        let mut machine = Machine::default();
        machine.become_planner(planner, 500.0);
        let toolpath = trace(&read(b"G1 X10 F3000\nG4 P0\nX0\n"), &machine);
        // 50 mm/s at 500 mm/s² over 10 mm takes 0.3 s.
        let seconds = simulate(&toolpath, &machine).cycle_time();
        assert!((seconds - 0.6).abs() < 1e-4, "{planner:?}: {seconds} s");
    }
}
