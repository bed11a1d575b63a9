//! The table of effects: ids, sentences, and hypotheses that programs excite.

use truefeed::identification::alignment::align;
use truefeed::identification::diagnosis::{Diagnosis, diagnose};
use truefeed::identification::effects::{ALL, Finding, library, with_id};
use truefeed::identification::fit::Run;
use truefeed::identification::recording::read;
use truefeed::machine::Machine;
use truefeed::project::profile_csv;
use truefeed::simulation::drive::actual_motion;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::profile::{Profile, Resolution, Samples};
use truefeed::simulation::toolpath::Toolpath;
use truefeed::simulation::{gcode, simulate};

#[test]
fn an_effect_is_known_by_its_id() {
    for (at, effect) in ALL.iter().enumerate() {
        assert_eq!(with_id(effect.id), Some(*effect));
        assert!(ALL[..at].iter().all(|other| other != effect), "{effect:?} is there twice");
    }
    assert_eq!(with_id("gremlins"), None);
}

#[test]
fn every_effect_has_a_sentence_whatever_is_reported() {
    for effect in ALL {
        let sentence = (effect.sentence)(&Finding { values: &[], lines: &[(2, 3)], seconds: 1.0 });
        assert!(sentence.ends_with('.') && sentence.starts_with(char::is_uppercase), "{sentence}");
    }
}

/// A program with all that effects act on is offered each that a program brings out, with trials that reach the
/// machine and values that are reported.
#[test]
fn a_program_that_has_everything_is_offered_everything() {
    let program =
        "G0 X5 Y5 Z5\nM6 T1\nG61\nG1 X20 F3000\nG64\nY6\nX30 Y6.2\nX40\nG2 X50 Y16.2 I0 J10\nG1 X0 Y0 Z0\n";
    let machine = Machine::default();
    let toolpath = trace(&gcode::read(program.as_bytes()), &machine);
    let plan = simulate(&toolpath, &machine);
    let recorded = profile_csv(&Profile::new(&toolpath, &plan).samples(Resolution::FINE));
    let log = read(recorded.as_bytes()).expect("a log");
    let alignment = align(&log.recordings[0], &toolpath, &machine).expect("it is of this program");
    let runs = [Run { toolpath: &toolpath, alignment: &alignment, overrides: (None, None) }];
    let library = library(&machine, &runs);
    for effect in ALL.iter().filter(|effect| effect.unprovoked.is_none()) {
        assert!(library.iter().any(|hypothesis| hypothesis.effect == *effect), "{effect:?} is not offered");
    }
    for hypothesis in &library {
        for values in &hypothesis.trials {
            assert_eq!(values.len(), hypothesis.freed.len(), "{hypothesis:?}");
            assert!(!hypothesis.reported(values, &[]).is_empty(), "{hypothesis:?}");
        }
        assert!(
            hypothesis.trials.iter().any(|values| hypothesis.machine(&machine, values) != machine),
            "{hypothesis:?}"
        );
    }
}

/// Diagnoses a recording of these samples of a run of the program.
fn diagnosed(toolpath: &Toolpath, believed: &Machine, samples: &Samples) -> Diagnosis {
    let log = read(profile_csv(samples).as_bytes()).expect("a log");
    let alignment = align(&log.recordings[0], toolpath, believed).expect("it is of this program");
    diagnose(believed, &[Run { toolpath, alignment: &alignment, overrides: (None, None) }], &mut |_| {})
}

/// The ids and variants of the causes named.
fn names(diagnosis: &Diagnosis) -> Vec<(&str, &str)> {
    let hypotheses = diagnosis.causes.iter().map(|cause| &cause.candidate.hypothesis);
    hypotheses.map(|hypothesis| (hypothesis.effect.id, hypothesis.variant.as_str())).collect()
}

/// A meander in which the spindle changes its speed in blocks of motion.
fn with_speeds() -> String {
    let rows = (0..12).map(|row| {
        let (y, speed) =
            (3 * row, if row % 3 == 2 { format!(" S{}", 4000 + 500 * row) } else { String::new() });
        format!("G1 X40 Y{y} F1800{speed}\nX40 Y{}\nX0 F1500\n", y + 1)
    });
    // The rapid move shows that the cut began without a wait.
    format!("G21 G90\nM3 S4000\nG0 X20\nX0\n{}M30\n", rows.collect::<String>())
}

#[test]
fn a_wait_at_s_words_is_found_and_predicts_the_run() {
    let believed = Machine::default();
    let mut truth = believed.clone();
    truth.times.spindle_change = 0.8;
    let toolpath = trace(&gcode::read(with_speeds().as_bytes()), &believed);
    assert_eq!(toolpath.speed_changes().count(), 4);
    let plan = simulate(&toolpath, &truth);
    let samples = Profile::new(&toolpath, &plan).samples(Resolution::FINE);
    let diagnosis = diagnosed(&toolpath, &believed, &samples);
    let ids: Vec<&str> = diagnosis.causes.iter().map(|cause| cause.candidate.hypothesis.effect.id).collect();
    assert_eq!(ids, ["spindle_wait"]);
    let seconds = diagnosis.causes[0].candidate.values[0];
    assert!((seconds - 0.8).abs() < 0.01, "{seconds} s");
    let (found, recorded) = (simulate(&toolpath, &diagnosis.machine).cycle_time(), plan.cycle_time());
    assert!((found - recorded).abs() < 0.05, "{found} s is not {recorded} s");
}

/// A control that starts the spindle without standing still, and has the first feed move wait for it.
#[test]
fn a_wait_of_the_first_feed_move_for_the_spindle_is_found_where_it_is() {
    let believed = Machine::default();
    let mut truth = believed.clone();
    truth.times.spindle_at_feed = 1.7;
    let part = |x: i32, speed: i32| {
        format!(
            "G0 Z20\nS{speed}\nX{x} Y0\nZ2\nG1 Z-1 F600\nX{} F1800\nY20\nG0 Z5\nX{x} Y10\nZ1\nG1 Z-1 F600\n",
            x + 20
        )
    };
    let text = format!("G21 G90\nG0 X0 Y0 Z10\nM3 S4000\n{}{}M30\n", part(10, 4000), part(60, 9000));
    let toolpath = trace(&gcode::read(text.as_bytes()), &believed);
    assert_eq!(toolpath.feeds_at_new_speed().count(), 2);
    let plan = simulate(&toolpath, &truth);
    assert!((plan.cycle_time() - simulate(&toolpath, &believed).cycle_time() - 3.4).abs() < 0.1);
    let samples = Profile::new(&toolpath, &plan).samples(Resolution::FINE);
    let diagnosis = diagnosed(&toolpath, &believed, &samples);
    assert_eq!(names(&diagnosis), [("spindle_wait", "first feed moves")]);
    assert!((diagnosis.causes[0].candidate.values[0] - 1.7).abs() < 0.02);
}

/// Rapid moves and dwells overlap the ramp of the spindle, and the first feed move waits for the rest of it.
#[test]
fn what_is_left_of_the_spindles_ramp_at_a_feed_move_is_found() {
    let believed = Machine::default();
    let mut truth = believed.clone();
    truth.times.spindle_ramp_at_feed = 0.8e-3;
    let part = |x: u32, speed: u32, more: &str| {
        format!("G0 Z20\nS{speed} M3\n{more}G0 X{x} Y0\nZ2\nG1 Z-1 F600\nX{} F1800\nY20\n", x + 20)
    };
    let parts = [part(10, 4000, ""), part(60, 9000, "G4 P1.5\n"), part(10, 8500, "")].concat();
    let text = format!("G21 G90\nG0 X0 Y0 Z10\n{parts}G0 Z20\nM30\n");
    let toolpath = trace(&gcode::read(text.as_bytes()), &believed);
    let found = simulate(&toolpath, &truth);
    let samples = Profile::new(&toolpath, &found).samples(Resolution::FINE);
    let diagnosis = diagnosed(&toolpath, &believed, &samples);
    assert_eq!(names(&diagnosis), [("spindle_wait", "ramp at first feed moves")]);
    assert!((diagnosis.causes[0].candidate.values[0] / 0.8e-3 - 1.0).abs() < 0.02);
}

/// Dwells and rapid moves run beside the ramp, and the feed begins when the last of all is done.
#[test]
fn a_feed_move_begins_when_ramp_dwell_and_rapids_are_done() {
    let mut machine = Machine::default();
    let time = |program: &str, machine: &Machine| {
        simulate(&trace(&gcode::read(program.as_bytes()), machine), machine).cycle_time()
    };
    let [rapid, feed] = ["G21 G90 G0 X100", "G21 G91 G1 X100 F3000"].map(|program| time(program, &machine));
    machine.times.spindle_ramp_at_feed = 0.8e-3;
    for dwell in [0.0, 1.0, 3.0, 10.0] {
        let program = format!("G21 G90\nS4000 M3\nG4 P{dwell}\nG0 X100\nG1 X200 F3000");
        let expected = f64::max(3.2, dwell + rapid) + feed;
        let found = time(&program, &machine);
        assert!((found - expected).abs() < 1e-9, "{found} s, {expected} s");
    }
}

/// Each wait costs its time and a full stop, and none where the machine has no such wait.
#[test]
fn a_wait_at_s_words_is_a_full_stop_and_its_time() {
    let mut machine = Machine::default();
    let toolpath = trace(&gcode::read(with_speeds().as_bytes()), &machine);
    let times = [0.0, 0.5, 1.5].map(|seconds| {
        machine.times.spindle_change = seconds;
        simulate(&toolpath, &machine).cycle_time()
    });
    assert!(times[0] + 4.0 * 0.5 < times[1], "{times:?}");
    assert!((times[2] - times[1] - 4.0).abs() < 1e-9, "{times:?}");
}

/// A limit along the path, which cuts off feeds and rapids alike.
#[test]
fn a_velocity_limit_along_the_path_is_no_override() {
    let believed = Machine::default();
    let mut truth = believed.clone();
    truth.path.velocity = 40.0;
    let rows = (0..8).map(|row| {
        let y = 6 * row;
        format!("G0 X60 Y{y}\nG1 Z-1 F600\nX0 F3600\nY{} F1200\nX60\nG0 Z2\n", y + 3)
    });
    let text = format!("G21 G90\nG0 Z2\n{}M30\n", rows.collect::<String>());
    let toolpath = trace(&gcode::read(text.as_bytes()), &believed);
    let samples = Profile::new(&toolpath, &simulate(&toolpath, &truth)).samples(Resolution::FINE);
    let fastest = samples.feedrate.iter().copied().fold(0.0, f64::max);
    assert!((fastest - 40.0).abs() < 1e-9, "{fastest} mm/s");
    let diagnosis = diagnosed(&toolpath, &believed, &samples);
    assert_eq!(names(&diagnosis), [("axis_velocity_limit", "XYZ")]);
    assert!((diagnosis.machine.path.velocity - 40.0).abs() < 0.1, "{:?}", diagnosis.machine.path);
}

/// A scale at the table is behind after each reversal, an encoder at a motor that is compensated ahead.
#[test]
fn backlash_and_its_compensation_are_told_apart() {
    let believed = Machine::default();
    let rows = (0..6).map(|row| {
        let y = 8 * row;
        format!("G1 X40 Y{y} F1500\nG3 X40 Y{} I0 J4\nG1 X0\n", y + 8)
    });
    let text = format!("G21 G90\nG0 X0 Y0\n{}M30\n", rows.collect::<String>());
    let toolpath = trace(&gcode::read(text.as_bytes()), &believed);
    let plan = simulate(&toolpath, &believed);
    let commanded = Profile::new(&toolpath, &plan).samples(Resolution::FINE);
    for (backlash, compensation, variant) in [(0.06, 0.0, "X"), (0.0, 0.06, "X, compensated")] {
        let mut truth = believed.clone();
        (truth.axes[0].backlash, truth.axes[0].backlash_compensation) = (backlash, compensation);
        let diagnosis = diagnosed(&toolpath, &believed, &actual_motion(&commanded, &truth));
        assert_eq!(names(&diagnosis), [("backlash", variant)]);
        let width = diagnosis.causes[0].candidate.values[0];
        assert!((width - 0.06).abs() < 2e-3, "{width} mm");
    }
}
