//! Diagnosis: what the operator did is found, and what nobody did is not. The logs are taken without the
//! channels that say what the operator did.

use std::collections::BTreeMap;

use truefeed::identification::diagnosis::{Diagnosis, Plateau, diagnose, feed_holds, plateau};
use truefeed::machine::Machine;
use truefeed::project::machine_from_toml;

use crate::hurco::{HURCO, recorded};
use crate::shared::recordings_of_others;

/// What a calibration on other runs of the mill finds.
const MACHINE: &str = r#"
name = "mill"
[interpolator]
filters = 3
time_constant_s = 0.0133
contour_tolerance_mm = 0.00886
[path]
jerk_mm_s3 = 41758
[rapid]
feed_mm_min = 77505
positioning_jerk_mm_s3 = 82527
[times]
tool_change_s = 5.88
spindle_start_s = 0.632
spindle_stop_s = 0.069
m_codes = { M1 = 6.95, M8 = 6.57, M9 = 0.97 }
"#;

fn machine() -> Machine {
    machine_from_toml(MACHINE).expect("a machine file")
}

fn ids(diagnosis: &Diagnosis) -> Vec<&str> {
    diagnosis.causes.iter().map(|cause| cause.candidate.hypothesis.effect.id).collect()
}

#[test]
fn plateaus_tell_the_feed_override_without_a_model_of_the_motion() {
    let Some(folder) = recordings_of_others(HURCO) else { return };
    let rough = Machine::default();
    for (program, run, ratio) in [
        ("box-op1", "box-op1-03", 1.01),
        ("box-op1", "box-op1-07", 0.99),
        ("box-op1", "box-op1-09", 1.0),
        ("box-op2", "box-op2-13", 1.01),
        ("box-op3", "box-op3-06", 1.0),
        ("box-op3", "box-op3-10", 1.0),
        ("plate-12", "plate-12", 1.0),
    ] {
        let recorded = recorded(&folder, program, run, &rough, false);
        let Plateau { ratio: found, deviation } =
            plateau(&recorded.run_ignoring_overrides()).expect("it has plateaus");
        eprintln!("{run}: {found:.4} ± {deviation:.4}, switch at {ratio}");
        assert!((found - ratio).abs() < 0.003, "{run}: {found}");
    }
}

#[test]
#[ignore = "full suite: diagnoses half an hour of a real mill"]
fn an_override_of_one_part_in_a_hundred_is_found_in_half_an_hour() {
    let Some(folder) = recordings_of_others(HURCO) else { return };
    let machine = machine();
    let recorded = recorded(&folder, "box-op1", "box-op1-07", &machine, false);
    let diagnosis = diagnose(&machine, &[recorded.run_ignoring_overrides()], &mut |_| {});
    let overrides =
        diagnosis.causes.iter().filter(|cause| cause.candidate.hypothesis.effect.id == "feed_override");
    let ratios: Vec<f64> = overrides.map(|cause| cause.candidate.values[0]).collect();
    eprintln!("{:?} {ratios:?}", ids(&diagnosis));
    assert!(ratios.len() == 1 && (0.985..=0.995).contains(&ratios[0]), "{ratios:?}");
    assert!(!ids(&diagnosis).contains(&"feed_hold"), "{:?}", ids(&diagnosis));
}

#[test]
#[ignore = "full suite: diagnoses half an hour of a real mill"]
fn nothing_is_laid_to_an_operator_who_did_nothing() {
    let Some(folder) = recordings_of_others(HURCO) else { return };
    let machine = machine();
    let recorded = recorded(&folder, "box-op3", "box-op3-07", &machine, false);
    let diagnosis = diagnose(&machine, &[recorded.run_ignoring_overrides()], &mut |_| {});
    eprintln!("{:?}", ids(&diagnosis));
    for id in ["feed_override", "rapid_override", "feed_hold"] {
        assert!(!ids(&diagnosis).contains(&id), "{:?}", ids(&diagnosis));
    }
}

/// What the cost must fall by for each hold, as in a diagnosis of one run.
const PRICE: f64 = 14.0;

#[test]
fn feed_holds_are_located_where_the_status_has_them() {
    let Some(folder) = recordings_of_others(HURCO) else { return };
    let machine = machine();
    let recorded = recorded(&folder, "plate-1", "plate-01", &machine, false);
    let holds = feed_holds(&machine, &[recorded.run_ignoring_overrides()], PRICE);
    let seconds: BTreeMap<u32, f64> = (holds.iter())
        .map(|(hold, _)| {
            let line = hold.hypothesis.variant.trim_start_matches("line ").parse().expect("a line");
            (line, hold.values[0])
        })
        .collect();
    eprintln!("{seconds:?}");
    // The channel of the status, which is not told here, has a hold on each of these lines.
    let held = [15, 28, 253, 533, 2648, 2964, 2976];
    for line in held {
        assert!(
            seconds.get(&line).is_some_and(|seconds| (5.0..30.0).contains(seconds)),
            "{line}: {seconds:?}"
        );
    }
    // The override stood at 0 on the line before some of them, which is another switch for the same.
    let is_near = |line: &u32| held.iter().any(|held| *line <= *held && held - line <= 2);
    assert!(seconds.keys().all(is_near), "{seconds:?}");
}

#[test]
fn standing_for_a_poll_or_two_is_no_hold() {
    let Some(folder) = recordings_of_others(HURCO) else { return };
    let machine = machine();
    for (program, run) in [
        ("box-op1", "box-op1-03"),
        ("box-op1", "box-op1-06"),
        ("box-op1", "box-op1-07"),
        ("box-op3", "box-op3-06"),
        ("plate-12", "plate-12"),
    ] {
        let recorded = recorded(&folder, program, run, &machine, false);
        let holds = feed_holds(&machine, &[recorded.run_ignoring_overrides()], PRICE);
        let named: Vec<&str> = holds.iter().map(|(hold, _)| hold.hypothesis.variant.as_str()).collect();
        assert!(named.is_empty(), "{run}: {named:?}");
    }
}
