//! Calibration, and what it predicts of programs that it has not seen. The machine begins as three filters with
//! rough numbers; nothing else of it is known.

use truefeed::identification::calibration::calibrate;
use truefeed::identification::comparison::{Comparison, compare};
use truefeed::identification::diagnosis::{Plateau, plateau};
use truefeed::identification::fit::{AlignedRun, Run};
use truefeed::identification::measured::calibrated_on;
use truefeed::machine::Machine;
use truefeed::project::machine_from_toml;
use truefeed::quote::range;
use truefeed::simulation::simulate;

use crate::hurco::{HURCO, recorded};
use crate::shared::recordings_of_others;

/// Three filters and a rapid rate.
const MACHINE: &str = r#"
name = "mill"
[interpolator]
filters = 3
time_constant_s = 0.021
contour_tolerance_mm = 0.012
[rapid]
feed_mm_min = 42000
[times]
tool_change_s = 4.0
"#;

fn compared(run: &Run, machine: &Machine) -> Comparison {
    compare(run.toolpath, &run.plan(machine), run.alignment)
}

/// Errors of the whole and of the motion, as parts, and of the feedrate as a part of the programmed one.
fn error(comparison: &Comparison) -> (f64, f64, f64) {
    let motion = comparison.motion.simulated / comparison.motion.recorded - 1.0;
    let feed = comparison.feed.expect("feed moves were recorded");
    (comparison.whole.simulated / comparison.whole.recorded - 1.0, motion, feed.rms / feed.programmed)
}

#[test]
#[ignore = "full suite: calibrates on four runs of two mills; a_short_program_predicts_another_one_of_its_machine does on one"]
fn runs_of_two_mills_predict_other_programs_of_theirs() {
    let Some(folder) = recordings_of_others(HURCO) else { return };
    let machine = machine_from_toml(MACHINE).expect("a machine file");
    let fitted = [
        ("box-op1", "box-op1-06"),
        ("box-op1", "box-op1-09"),
        ("box-op3", "box-op3-06"),
        ("plate-12", "plate-12"),
    ]
    .map(|(program, run)| recorded(&folder, program, run, &machine, true));
    let runs: Vec<Run> = fitted.iter().map(AlignedRun::run).collect();
    let found = calibrate(&machine, &runs, &mut |_| {}).machine;
    for (program, run) in [
        ("box-op2", "box-op2-12"),
        ("box-op2", "box-op2-13"),
        ("plate-13", "plate-13"),
        ("box-op1", "box-op1-12"),
        ("box-op3", "box-op3-07"),
        ("box-op3", "box-op3-10"),
    ] {
        let other = recorded(&folder, program, run, &machine, true);
        let mut found = found.clone();
        // The switch of box-op2 was turned before the log begins: it is read off the plateaus, as a diagnosis does.
        if program == "box-op2" {
            let Plateau { ratio, .. } = plateau(&other.run_ignoring_overrides()).expect("it has plateaus");
            found.overrides.feed = ratio;
        }
        let compared = compared(&other.run(), &found);
        let (whole, motion, feed) = error(&compared);
        let programmed = compared.feed.expect("feed moves were recorded");
        eprintln!(
            "{run}: whole {:+.2} %, motion {:+.2} %, feedrate {:.2} %, CAM's {:.2} %",
            1e2 * whole,
            1e2 * motion,
            1e2 * feed,
            1e2 * programmed.programmed_rms / programmed.programmed
        );
        assert!(whole.abs() < 0.02, "{run}: whole {whole}");
        assert!(motion.abs() < 0.005, "{run}: motion {motion}");
        assert!(feed < 0.06, "{run}: feedrate {feed}");
    }
}

#[test]
fn a_short_program_predicts_another_one_of_its_machine() {
    let Some(folder) = recordings_of_others(HURCO) else { return };
    let machine = machine_from_toml(MACHINE).expect("a machine file");
    let fitted = recorded(&folder, "box-op3", "box-op3-06", &machine, true);
    let calibration = calibrate(&machine, &[fitted.run()], &mut |_| {});
    let mut found = calibration.machine;
    found.calibrated_on = calibrated_on(&found, &[fitted.run()], &calibration.fitted);
    // box-op1 has faster feeds, whose ramps box-op3 does not show; a log without positions does not show those of rapids.
    let faster = recorded(&folder, "box-op1", "box-op1-06", &machine, true);
    let (_, motion, _) = error(&compared(&faster.run(), &found));
    let range =
        range(faster.run().toolpath, &found, &simulate(faster.run().toolpath, &found)).expect("a range");
    eprintln!("box-op1-06: motion {:+.2} %, range ±{:.2} %", 1e2 * motion, 1e2 * range.ratio);
    assert!(motion.abs() < range.ratio, "motion {motion}, range {}", range.ratio);
    for (program, run) in [("box-op3", "box-op3-07"), ("box-op3", "box-op3-10"), ("box-op2", "box-op2-12")] {
        let other = recorded(&folder, program, run, &machine, true);
        let [before, after] = [&machine, &found].map(|machine| compared(&other.run(), machine));
        let (was, is) = (error(&before), error(&after));
        eprintln!(
            "{run}: whole {:+.2} → {:+.2} %, motion {:+.2} → {:+.2} %, feedrate {:.2} → {:.2} %",
            1e2 * was.0,
            1e2 * is.0,
            1e2 * was.1,
            1e2 * is.1,
            1e2 * was.2,
            1e2 * is.2
        );
        assert!(is.1.abs() < 0.025, "{run}: motion {}", is.1);
        assert!(is.2 < was.2, "{run}: feedrate {} {}", was.2, is.2);
    }
}
