//! The range of a cycle time on a calibrated machine, as data and as a sentence.

use serde::{Deserialize, Serialize};

use crate::quote::{TimeRange, UnshownFeature};
use crate::units::PERCENT;

/// The range of a cycle time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(in crate::project) struct RangeRow {
    /// Half of the range, percent of the cycle time.
    pub(in crate::project) percent: f64,
    pub(in crate::project) cycle_time_s: [f64; 2],
    /// Features of the programmed time that the calibration did not show, the largest first.
    unshown: Vec<UnshownRow>,
    /// Sentence for people.
    pub(in crate::project) sentence: String,
}

/// A feature that the calibration did not show, with its part of the time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct UnshownRow {
    what: String,
    percent: f64,
}

impl RangeRow {
    /// Returns the row of a cycle time, s.
    pub(in crate::project) fn new(range: &TimeRange, cycle_time: f64) -> RangeRow {
        let row = |(what, share): &(UnshownFeature, f64)| UnshownRow {
            what: what.words().to_string(),
            percent: PERCENT * share,
        };
        RangeRow {
            percent: PERCENT * range.ratio,
            cycle_time_s: [1.0 - range.ratio, 1.0 + range.ratio].map(|of_time| of_time * cycle_time),
            unshown: range.unshown.iter().map(row).collect(),
            sentence: range_sentence(range),
        }
    }
}

/// Returns the range and its reason as a sentence that continues the name of the cycle time.
pub fn range_sentence(range: &TimeRange) -> String {
    let told = range.unshown.iter().map(|(what, share)| (what.words(), PERCENT * share));
    let told = told.filter(|(_, percent)| MIN_SHARE_PERCENT <= *percent);
    let told: Vec<String> =
        told.map(|(what, percent)| format!("{what} ({percent:.0} % of the time)")).collect();
    let wider = match told.as_slice() {
        [] => String::new(),
        _ => format!("; wider for what the calibration did not show: {}", told.join(", ")),
    };
    format!("±{:.1} %, which nine in ten programs on this machine are within{wider}.", PERCENT * range.ratio)
}

/// Least share that is reported, percent.
const MIN_SHARE_PERCENT: f64 = 0.5;
