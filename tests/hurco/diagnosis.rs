//! Diagnosis: what the operator did is found, and what nobody did is not. The logs are taken without the
//! channels that say what the operator did.

use truefeed::identification::diagnosis::{Diagnosis, Plateau, diagnose, plateau};
use truefeed::machine::Machine;
use truefeed::project::machine_from_toml;

use crate::{recorded, recordings};

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
    diagnosis.causes.iter().map(|cause| cause.candidate.hypothesis.id).collect()
}

#[test]
fn plateaus_tell_the_feed_override_without_a_model_of_the_motion() {
    let Some(folder) = recordings() else { return };
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
        let Plateau { ratio: found, deviation } = plateau(&recorded.unswitched()).expect("it has plateaus");
        eprintln!("{run}: {found:.4} ± {deviation:.4}, switch at {ratio}");
        assert!((found - ratio).abs() < 0.003, "{run}: {found}");
    }
}

#[test]
fn an_override_of_one_part_in_a_hundred_is_found_in_half_an_hour() {
    let Some(folder) = recordings() else { return };
    let machine = machine();
    let recorded = recorded(&folder, "box-op1", "box-op1-07", &machine, false);
    let diagnosis = diagnose(&machine, &[recorded.unswitched()], &mut |_| {});
    let overrides = diagnosis.causes.iter().filter(|cause| cause.candidate.hypothesis.id == "feed_override");
    let ratios: Vec<f64> = overrides.map(|cause| cause.candidate.values[0]).collect();
    eprintln!("{:?} {ratios:?}", ids(&diagnosis));
    assert!(ratios.len() == 1 && (0.985..=0.995).contains(&ratios[0]), "{ratios:?}");
    assert!(!ids(&diagnosis).contains(&"feed_hold"), "{:?}", ids(&diagnosis));
}

#[test]
fn nothing_is_laid_to_an_operator_who_did_nothing() {
    let Some(folder) = recordings() else { return };
    let machine = machine();
    let recorded = recorded(&folder, "box-op3", "box-op3-07", &machine, false);
    let diagnosis = diagnose(&machine, &[recorded.unswitched()], &mut |_| {});
    eprintln!("{:?}", ids(&diagnosis));
    for id in ["feed_override", "rapid_override", "feed_hold"] {
        assert!(!ids(&diagnosis).contains(&id), "{:?}", ids(&diagnosis));
    }
}
