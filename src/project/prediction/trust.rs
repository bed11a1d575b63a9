//! The trust in a cycle time as text: JSON and sentences.

use serde::Serialize;

use crate::quote::{self, CauseInDoubt};
use crate::simulation::gcode::DoubtCause;

/// The doubts about a cycle time.
#[derive(Clone, Debug, Serialize)]
pub struct TrustRow {
    /// Largest error of the cycle time by the doubts that have a bound.
    seconds_in_doubt: f64,
    /// `true` if every doubt has a bound.
    bounded: bool,
    /// Reasons, one sentence each.
    reasons: Vec<String>,
    /// The reasons as data.
    causes: Vec<DoubtRow>,
}

#[derive(Clone, Debug, Serialize)]
struct DoubtRow {
    id: &'static str,
    count: usize,
    /// First and last line.
    lines: [u32; 2],
    seconds: Option<f64>,
}

impl From<&quote::Trust> for TrustRow {
    fn from(trust: &quote::Trust) -> TrustRow {
        let reason = |doubt: &CauseInDoubt| DoubtRow {
            id: words(doubt.cause)[0],
            count: doubt.count,
            lines: [doubt.lines.0.0, doubt.lines.1.0],
            seconds: doubt.seconds,
        };
        TrustRow {
            seconds_in_doubt: trust.seconds_in_doubt(),
            bounded: trust.is_bounded(),
            reasons: trust.doubts.iter().map(reason_sentence).collect(),
            causes: trust.doubts.iter().map(reason).collect(),
        }
    }
}

/// Returns all doubts in one line; `None` if there are none.
pub fn doubt_sentence(trust: &quote::Trust) -> Option<String> {
    if trust.doubts.is_empty() {
        return None;
    }
    let seconds = trust.seconds_in_doubt();
    let unbounded: Vec<String> =
        trust.doubts.iter().filter(|doubt| doubt.seconds.is_none()).map(reason_sentence).collect();
    let bounded = trust.doubts.iter().filter(|doubt| doubt.seconds.is_some());
    let bounded: Vec<String> = bounded.map(counted_words).collect();
    let mut parts = Vec::new();
    if !bounded.is_empty() {
        parts.push(format!("{seconds:.1} s ({})", bounded.join("; ")));
    }
    parts.extend(unbounded);
    Some(format!("In doubt: {}", parts.join("; ")))
}

/// Returns one reason with its seconds.
fn reason_sentence(doubt: &CauseInDoubt) -> String {
    match doubt.seconds {
        Some(seconds) => format!("{}: up to {seconds:.1} s", counted_words(doubt)),
        None => format!("{}: by an unknown time", counted_words(doubt)),
    }
}

/// Returns the number of occurrences of a reason and the first line, in words.
fn counted_words(doubt: &CauseInDoubt) -> String {
    let [_, one, several] = words(doubt.cause);
    let line = doubt.lines.0.0;
    match doubt.count {
        1 => format!("1 {one}, at line {line}"),
        count => format!("{count} {several}, first at line {line}"),
    }
}

/// Returns the id of a cause, and its description for one and for several.
fn words(cause: DoubtCause) -> [&'static str; 3] {
    match cause {
        DoubtCause::UnreadWords => ["unread_words", "word cannot be read", "words cannot be read"],
        DoubtCause::BlocksNotRun => ["blocks_not_run", "block is not run", "blocks are not run"],
        DoubtCause::UnknownWords => ["unknown_words", "word is not understood", "words are not understood"],
        DoubtCause::OpenArcs => ["open_arcs", "arc does not close", "arcs do not close"],
        DoubtCause::UnclearTurns => {
            ["unclear_turns", "arc may have more or fewer turns", "arcs may have more or fewer turns"]
        }
        DoubtCause::MissingArcs => ["missing_arcs", "arc has no circle", "arcs have no circle"],
        DoubtCause::MissingFeeds => ["missing_feeds", "feedrate is missing", "feedrates are missing"],
        DoubtCause::FeedsBeyondRapid => {
            ["feeds_beyond_rapid", "feedrate is beyond the rapids", "feedrates are beyond the rapids"]
        }
        DoubtCause::MissingPoints => {
            ["missing_points", "length has no decimal point", "lengths have no decimal point"]
        }
        DoubtCause::UnclearDwells => {
            ["unclear_dwells", "waiting time is unclear", "waiting times are unclear"]
        }
        DoubtCause::UnknownHome => [
            "unknown_home",
            "move goes to an unknown reference position (travel up to 1 m)",
            "moves go to an unknown reference position (travel up to 1 m)",
        ],
        DoubtCause::UnknownOffsets => [
            "unknown_offsets",
            "work offset is unknown (travel up to 1 m)",
            "work offsets are unknown (travel up to 1 m)",
        ],
        DoubtCause::UnmadeHoles => {
            ["unmade_holes", "hole is not made as written", "holes are not made as written"]
        }
        DoubtCause::UnmodelledCycles => ["unmodelled_cycles", "cycle has no moves", "cycles have no moves"],
        DoubtCause::UnmodelledFunctions => {
            ["unmodelled_functions", "function is not modelled", "functions are not modelled"]
        }
        DoubtCause::UnmodelledCurves => {
            ["unmodelled_curves", "spline is run as straight lines", "splines are run as straight lines"]
        }
        DoubtCause::UnmodelledThreads => ["unmodelled_threads", "thread has no feed", "threads have no feed"],
        DoubtCause::PerhapsLathe => ["perhaps_lathe", "sign of a lathe program", "signs of a lathe program"],
        DoubtCause::Probing => ["probing", "probing move may end early", "probing moves may end early"],
        DoubtCause::MissingSubprograms => {
            ["missing_subprograms", "subprogram is missing", "subprograms are missing"]
        }
        DoubtCause::BrokenFlow => [
            "broken_flow",
            "jump, loop or condition cannot be followed",
            "jumps, loops or conditions cannot be followed",
        ],
        DoubtCause::UnknownParameters => {
            ["unknown_parameters", "parameter has no value", "parameters have no value"]
        }
        DoubtCause::Compensation => [
            "compensation",
            "place cannot be compensated for the tool",
            "places cannot be compensated for the tool",
        ],
    }
}
