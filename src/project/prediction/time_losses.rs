//! Time losses as JSON with texts: a part of `predict --json` that the page lists, in inches if the user
//! wants that.

use serde::Serialize;

use crate::machine::tolerance_label_in;
use crate::quote::{self, LossReason, StopReason};
use crate::simulation::toolpath::StopCause;
use crate::units::LengthUnit;

/// The time that one run loses against length over feedrate.
#[derive(Clone, Debug, Serialize)]
pub(in crate::project) struct LostTimesRow {
    /// Total time lost.
    seconds: f64,
    /// Time lost at other places than the listed ones.
    elsewhere_s: f64,
    /// Places that lose most, by their seconds.
    places: Vec<TimeLossRow>,
}

#[derive(Clone, Debug, Serialize)]
struct TimeLossRow {
    /// Kind of place: corner, short_blocks, limit, acceleration, ramp, rapid, tool_change, dwell, rotary,
    /// spindle, m_code, halt or start.
    reason: &'static str,
    text: String,
    lines: [u32; 2],
    distance_mm: [f64; 2],
    seconds: f64,
}

impl From<&quote::LostTimes> for LostTimesRow {
    fn from(lost: &quote::LostTimes) -> LostTimesRow {
        let places: Vec<TimeLossRow> = lost.places.iter().map(TimeLossRow::from).collect();
        let told: f64 = places.iter().map(|place| place.seconds).sum();
        LostTimesRow { seconds: lost.total, elsewhere_s: lost.total - told, places }
    }
}

impl From<&quote::TimeLoss> for TimeLossRow {
    fn from(place: &quote::TimeLoss) -> TimeLossRow {
        TimeLossRow {
            reason: word(&place.reason),
            text: text(&place.reason, LengthUnit::Millimetre),
            lines: [place.lines.0.0, place.lines.1.0],
            distance_mm: [place.distance.0, place.distance.1],
            seconds: place.seconds,
        }
    }
}

/// Returns the texts of the places that lose most, with lengths in a unit.
pub fn time_loss_texts(lost: &quote::LostTimes, unit: LengthUnit) -> Vec<String> {
    lost.places.iter().map(|place| text(&place.reason, unit)).collect()
}

fn word(reason: &LossReason) -> &'static str {
    match reason {
        LossReason::Corner { .. } => "corner",
        LossReason::ShortBlocks { .. } => "short_blocks",
        LossReason::Limit { .. } => "limit",
        LossReason::Acceleration => "acceleration",
        LossReason::Ramp(_) => "ramp",
        LossReason::Rapid { .. } => "rapid",
        LossReason::Wait(StopCause::Dwell { .. }) => "dwell",
        LossReason::Wait(StopCause::Rotary { .. }) => "rotary",
        LossReason::Wait(StopCause::ToolChange { .. } | StopCause::SameTool { .. }) => "tool_change",
        LossReason::Wait(StopCause::Spindle { .. }) => "spindle",
        LossReason::Wait(StopCause::MCode { .. }) => "m_code",
        LossReason::Halt => "halt",
        LossReason::Start => "start",
    }
}

fn text(reason: &LossReason, unit: LengthUnit) -> String {
    let count = |number: usize, one: &str, many: &str| match number {
        1 => one.to_string(),
        _ => format!("{number} {many}"),
    };
    match reason {
        LossReason::Corner { turn, tolerance } => {
            format!("{:.0}° corner at {}", turn.to_degrees(), tolerance_label_in(unit, *tolerance))
        }
        LossReason::ShortBlocks { blocks } => count(*blocks, "short block", "short blocks"),
        LossReason::Limit { feedrate, programmed, is_arc } => {
            let what = if *is_arc { "arc" } else { "feedrate" };
            let (decimals, symbol) = (unit.feed_decimals(), unit.feed_symbol());
            let [slowed, asked] = [*feedrate, *programmed].map(|feedrate| unit.feedrate(feedrate));
            format!("{what} slowed to {slowed:.decimals$} of {asked:.decimals$} {symbol}")
        }
        LossReason::Acceleration => "acceleration limit".to_string(),
        LossReason::Ramp(StopReason::Begin) => "ramp at the beginning".to_string(),
        LossReason::Ramp(StopReason::End) => "ramp at the end".to_string(),
        LossReason::Ramp(StopReason::Exact) => "ramps at a full stop".to_string(),
        LossReason::Ramp(StopReason::For(cause)) => format!("ramps at {}", of_cause(cause)),
        LossReason::Rapid { blocks } => count(*blocks, "rapid", "rapids"),
        LossReason::Wait(cause) => of_cause(cause),
        LossReason::Halt => "feed hold or wait".to_string(),
        LossReason::Start => "start of the program".to_string(),
    }
}

/// Returns the name of the function for which the machine waits.
fn of_cause(cause: &StopCause) -> String {
    match cause {
        StopCause::Dwell { seconds } => format!("dwell of {seconds} s"),
        StopCause::Rotary { .. } => "turn of rotary axes".to_string(),
        StopCause::ToolChange { tool: Some(tool) } | StopCause::SameTool { tool } => {
            format!("tool change to T{tool}")
        }
        StopCause::ToolChange { tool: None } => "tool change".to_string(),
        StopCause::Spindle { code: Some(code), .. } => format!("spindle, M{code}"),
        StopCause::Spindle { code: None, .. } => "spindle speed".to_string(),
        StopCause::MCode { code } => format!("M{code}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_told_in_the_unit_shown() {
        // 2540 of 5080 mm/min.
        let reason = LossReason::Limit { feedrate: 127.0 / 3.0, programmed: 254.0 / 3.0, is_arc: true };
        assert_eq!(text(&reason, LengthUnit::Millimetre), "arc slowed to 2540 of 5080 mm/min");
        assert_eq!(text(&reason, LengthUnit::Inch), "arc slowed to 100.0 of 200.0 in/min");
    }
}
