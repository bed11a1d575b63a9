//! Ramps that are not those of filters: they grow with the speed step.
//!
//! A machine file that was fitted without them has them in its other values: its filters are as long as the mean
//! ramp, its rapids as slow. These hypotheses therefore free, beside the jerk, what makes up for its absence.

use std::sync::Arc;

use crate::identification::fit::{Freed, Run, Scale};
use crate::identification::hypotheses::{Hypothesis, Report, Reported, Trace};
use crate::machine::{Junction, Machine, TimeConstants};

/// Jerks along the path tried first, mm/s³.
const JERKS: [f64; 5] = [5e3, 1e4, 2e4, 4e4, 1e5];
/// Time constants tried with them, as parts of what it is; the corners stay as fast.
const SHORTER: [f64; 2] = [1.0, 0.6];
/// Jerks of positioning tried first, mm/s³.
const POSITIONING: [f64; 4] = [2e4, 5e4, 1e5, 3e5];
/// Rapid feedrates tried with them, as parts of what it is.
const RATES: [f64; 2] = [1.0, 2.0];

pub fn hypotheses(machine: &Machine, runs: &[Run]) -> Vec<Hypothesis> {
    if machine.interpolator.junction == Junction::AccelerationBlend {
        return Vec::new();
    }
    ramps(machine).into_iter().chain(positioning(machine, runs)).collect()
}

/// Along the path: the jerk, with the filters and the tolerance fitted again.
fn ramps(machine: &Machine) -> Option<Hypothesis> {
    let TimeConstants::Equal(constant) = machine.interpolator.time_constants else { return None };
    let tolerance = machine.interpolator.contour_tolerance;
    let freed = [
        Freed::number("path.jerk_mm_s3", JERKS[2], (1e3, 1e6), Scale::Ratio),
        Freed::number("interpolator.time_constant_s", constant, (2e-4, 0.5), Scale::Ratio),
        Freed::number("interpolator.contour_tolerance_mm", tolerance, (1e-5, 5.0), Scale::Ratio),
    ];
    let trials = SHORTER
        .iter()
        .flat_map(|part| JERKS.map(|jerk| vec![jerk, part * constant, part * tolerance]))
        .collect();
    let report: Report = Arc::new(|values| {
        vec![
            ("j_mm_s3", Reported::Number(values[0])),
            ("time_constant_s", Reported::Number(values[1])),
            ("contour_tolerance_mm", Reported::Number(values[2])),
        ]
    });
    hypothesis("along the path", freed, trials, report)
}

/// Of rapids from stand to stand: the jerk, with the rapid feedrate fitted again.
fn positioning(machine: &Machine, runs: &[Run]) -> Option<Hypothesis> {
    if !runs.iter().any(Run::has_rapid) {
        return None;
    }
    let rate = machine.rapid.feedrate;
    let freed = [
        Freed::number("rapid.positioning_jerk_mm_s3", POSITIONING[1], (5e3, 5e6), Scale::Ratio),
        Freed::number("rapid.feed_mm_min", rate, (0.02 * rate, 10.0 * rate), Scale::Ratio),
    ];
    let trials = RATES.iter().flat_map(|part| POSITIONING.map(|jerk| vec![jerk, part * rate])).collect();
    let report: Report = Arc::new(|values| {
        vec![
            ("j_mm_s3", Reported::Number(values[0])),
            ("at", Reported::Word("rapid".to_string())),
            ("rapid_mm_min", Reported::Number(crate::units::mm_per_min(values[1]))),
        ]
    });
    hypothesis("rapid", freed, trials, report)
}

/// None where a key is unknown.
fn hypothesis<const COUNT: usize>(
    variant: &str,
    freed: [Option<Freed>; COUNT],
    trials: Vec<Vec<f64>>,
    report: Report,
) -> Option<Hypothesis> {
    Some(Hypothesis {
        id: "jerk_limit",
        variant: variant.to_string(),
        trace: Trace::Time,
        freed: freed.into_iter().collect::<Option<Vec<Freed>>>()?,
        trials,
        is_continuous: true,
        report,
    })
}
