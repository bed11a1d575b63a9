//! Where time is lost, as JSON with texts: what `predict --json` adds to a run, and the page lists.

use serde::Serialize;

use crate::machine::tolerance_label;
use crate::quote::{self, Reason, Standing};
use crate::simulation::toolpath::StopCause;
use crate::units::mm_per_min;

/// The time one run loses against length over feedrate.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Lost {
    /// All of it.
    seconds: f64,
    /// What is not lost at the places.
    elsewhere_s: f64,
    /// Those that cost most, in order of their seconds.
    places: Vec<LostAt>,
}

#[derive(Clone, Debug, Serialize)]
struct LostAt {
    /// Kind of place: corner, short_blocks, limit, acceleration, ramp, rapid, tool_change, dwell, rotary,
    /// spindle, m_code, halt or start.
    reason: &'static str,
    text: String,
    lines: [u32; 2],
    distance_mm: [f64; 2],
    seconds: f64,
}

impl From<&quote::Lost> for Lost {
    fn from(lost: &quote::Lost) -> Lost {
        let places: Vec<LostAt> = lost.places.iter().map(LostAt::from).collect();
        let told: f64 = places.iter().map(|place| place.seconds).sum();
        Lost { seconds: lost.total, elsewhere_s: lost.total - told, places }
    }
}

impl From<&quote::LostAt> for LostAt {
    fn from(place: &quote::LostAt) -> LostAt {
        LostAt {
            reason: word(&place.reason),
            text: text(&place.reason),
            lines: [place.lines.0.0, place.lines.1.0],
            distance_mm: [place.distance.0, place.distance.1],
            seconds: place.seconds,
        }
    }
}

fn word(reason: &Reason) -> &'static str {
    match reason {
        Reason::Corner { .. } => "corner",
        Reason::ShortBlocks { .. } => "short_blocks",
        Reason::Limit { .. } => "limit",
        Reason::Acceleration => "acceleration",
        Reason::Ramp(_) => "ramp",
        Reason::Rapid { .. } => "rapid",
        Reason::Wait(StopCause::Dwell { .. }) => "dwell",
        Reason::Wait(StopCause::Rotary { .. }) => "rotary",
        Reason::Wait(StopCause::ToolChange { .. } | StopCause::SameTool { .. }) => "tool_change",
        Reason::Wait(StopCause::Spindle { .. }) => "spindle",
        Reason::Wait(StopCause::MCode { .. }) => "m_code",
        Reason::Halt => "halt",
        Reason::Start => "start",
    }
}

fn text(reason: &Reason) -> String {
    let count = |number: usize, one: &str, many: &str| match number {
        1 => one.to_string(),
        _ => format!("{number} {many}"),
    };
    match reason {
        Reason::Corner { turn, tolerance } => {
            format!("{:.0}° corner at {}", turn.to_degrees(), tolerance_label(*tolerance))
        }
        Reason::ShortBlocks { blocks } => count(*blocks, "short block", "short blocks"),
        Reason::Limit { feedrate, programmed, is_arc } => {
            let what = if *is_arc { "arc" } else { "feedrate" };
            format!("{what} held to {:.0} of {:.0} mm/min", mm_per_min(*feedrate), mm_per_min(*programmed))
        }
        Reason::Acceleration => "acceleration limit".to_string(),
        Reason::Ramp(Standing::Begin) => "ramp at the beginning".to_string(),
        Reason::Ramp(Standing::End) => "ramp at the end".to_string(),
        Reason::Ramp(Standing::Exact) => "ramps at a full stop".to_string(),
        Reason::Ramp(Standing::For(cause)) => format!("ramps at {}", of_cause(cause)),
        Reason::Rapid { blocks } => count(*blocks, "rapid", "rapids"),
        Reason::Wait(cause) => of_cause(cause),
        Reason::Halt => "feed hold or wait".to_string(),
        Reason::Start => "start of the program".to_string(),
    }
}

/// What is waited for.
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
