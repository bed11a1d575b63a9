//! The comparison of a recording with the simulation as JSON: the summary, the places where time was lost,
//! and the alignment; or the reason why they cannot be compared, with advice.
//!
//! A place is a run of motion of at least [`MIN_PLACE_SHARE`] of the time, and in a polled log of lines of at
//! least [`MIN_PLACE_POLLS`] polls, because the log resolves no shorter place. A line that loses a quarter of
//! that time is a place by itself; consecutive lines that wait are one place.

use serde::Serialize;

use crate::identification::alignment::{Alignment, AlignmentError, Method};
use crate::identification::comparison::{Comparison, Durations, VisitTimes};
use crate::identification::fit::AlignedRunError;
use crate::identification::recording::{Log, OverrideSwitches, RecordingError, RecordingSeverity};
use crate::project::prediction::results::spacing_note;
use crate::simulation::ordered::sort_by_number;
use crate::simulation::profile::FeedCurve;
use crate::simulation::toolpath::{StopCause, Toolpath};
use crate::units::{micrometres, mm_per_min};

/// Least duration of a place, as a part of the whole time.
const MIN_PLACE_SHARE: f64 = 0.01;
/// Least duration of a place, in polls.
const MIN_PLACE_POLLS: f64 = 10.0;
/// Part of the least duration of a place from which on a line is a place by itself.
const SINGLE_LINE_RATIO: f64 = 0.25;
/// Most places that are listed.
const MAX_LISTED_PLACES: usize = 20;

/// The comparison of a recording with the simulation.
#[derive(Clone, Debug, Serialize)]
pub struct ComparisonReport {
    /// Summary, which comes first.
    sentence: String,
    /// Description of the alignment.
    aligned: String,
    /// Differences between the motions, a sentence each.
    measures: Vec<String>,
    /// Assumptions and repairs of reader and alignment.
    remarks: Vec<String>,
    recorded_s: f64,
    simulated_s: f64,
    /// Simulated less recorded time, as a part of the recorded one.
    time_error: f64,
    /// Motion, then waiting, then the parts of waiting.
    parts: Vec<DurationRow>,
    /// Places where most time was lost or gained, the largest first.
    stretches: Vec<PlaceRow>,
    /// Number of places.
    all_stretches: usize,
}

/// A kind of time.
#[derive(Clone, Debug, Serialize)]
struct DurationRow {
    name: String,
    /// `true` for a part of waiting.
    is_detail: bool,
    recorded_s: f64,
    simulated_s: f64,
}

/// A part of the program.
#[derive(Clone, Debug, Serialize)]
struct PlaceRow {
    lines: [u32; 2],
    distance_mm: [f64; 2],
    /// Recorded less simulated time.
    seconds: f64,
    recorded_s: f64,
    simulated_s: f64,
    /// `motion`, or the reason of a wait.
    kind: String,
}

impl ComparisonReport {
    /// Returns the report of a log whose recording was aligned and compared.
    pub fn new(
        log: &Log,
        switches: &OverrideSwitches,
        toolpath: &Toolpath,
        alignment: &Alignment,
        comparison: &Comparison,
    ) -> ComparisonReport {
        let Durations { recorded, simulated } = comparison.whole;
        let stretches = place_rows(toolpath, alignment, comparison);
        ComparisonReport {
            sentence: sentence(comparison),
            aligned: aligned(log, alignment),
            measures: measures(comparison),
            remarks: remarks(log, switches, alignment),
            recorded_s: recorded,
            simulated_s: simulated,
            time_error: simulated / recorded - 1.0,
            parts: duration_rows(toolpath, comparison),
            all_stretches: stretches.len(),
            stretches: stretches.into_iter().take(MAX_LISTED_PLACES).collect(),
        }
    }

    /// Returns the report with a note on the features that a chart of the simulation leaves out.
    pub fn drawn_by(mut self, curve: &FeedCurve) -> ComparisonReport {
        self.remarks.extend(spacing_note(curve.spacing));
        self
    }
}

/// The reason why a recording cannot be compared with a program.
#[derive(Clone, Debug, Serialize)]
pub struct ComparisonRefusal {
    /// Reason.
    reason: String,
    /// Advice.
    pub(in crate::project) advice: &'static str,
    /// `true` if the recording can be read once the time between its rows is stated.
    asks_interval: bool,
}

impl From<&AlignedRunError> for ComparisonRefusal {
    fn from(error: &AlignedRunError) -> ComparisonRefusal {
        match error {
            AlignedRunError::Recording(error) => ComparisonRefusal::from(error),
            AlignedRunError::Alignment(error) => ComparisonRefusal::from(error),
        }
    }
}

impl ComparisonRefusal {
    /// Returns `true` if the recording can be read once the time between its rows is stated.
    pub fn asks_interval(&self) -> bool {
        self.asks_interval
    }
}

impl std::fmt::Display for ComparisonRefusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.reason, self.advice)
    }
}

impl From<&RecordingError> for ComparisonRefusal {
    fn from(error: &RecordingError) -> ComparisonRefusal {
        let advice = match error {
            RecordingError::Empty => "Record a run of the program and drop the file again.",
            RecordingError::Binary(_) | RecordingError::Archive { .. } | RecordingError::UnknownFormat(_) => {
                "Save the log as text: CSV with a row of names, SHDR or MTConnect, a SINUMERIK trace, TwinCAT Scope \
                 CSV, scope2csv or halsampler."
            }
            RecordingError::NothingKnown { .. } => {
                "Record positions, the feed or the program line, in columns named x_mm, y_mm, z_mm, feed_mm_min or line."
            }
            RecordingError::NoTime { .. } => {
                "Name the time column with its unit, as in t_s or t_ms, or state the sampling interval."
            }
            RecordingError::TimeUnit { .. } => {
                "Name the time column with its unit, as in t_s or t_ms, in the file's first row."
            }
            RecordingError::TimeDisorder { .. } => {
                "Export the log again, sorted by time, with one recording in each file."
            }
            RecordingError::TooFewSamples { .. } => "Record for longer, or more often.",
            RecordingError::NothingMoves { .. } => {
                "Record while the program runs, and include the axes that move."
            }
            _ => "Correct this line, or export the log again.",
        };
        let asks_interval = matches!(error, RecordingError::NoTime { .. });
        ComparisonRefusal { reason: sentence_of(&error.to_string()), advice, asks_interval }
    }
}

impl From<&AlignmentError> for ComparisonRefusal {
    fn from(error: &AlignmentError) -> ComparisonRefusal {
        let advice = match error {
            AlignmentError::NoPath => "In the list beside the recording, choose the program that ran.",
            AlignmentError::NothingToFollow | AlignmentError::TooLittle { .. } => {
                "Record a whole run with positions, feed or program lines."
            }
            AlignmentError::StandsStill => "Start the recording before the program.",
            AlignmentError::Units(_) => {
                "State the right unit in the column's name, as in feed_mm_min or x_inch."
            }
            AlignmentError::TimeUnit { .. } => {
                "State the unit of the time column in its name: t_s if it holds seconds, t_ms if milliseconds."
            }
            AlignmentError::OffPath { hint: Some(_), .. } => {
                "Correct the export as described, and drop the file again."
            }
            AlignmentError::NowhereNear
            | AlignmentError::OffPath { .. }
            | AlignmentError::OtherWay { .. }
            | AlignmentError::LinesDoNotFit { .. }
            | AlignmentError::StopsDoNotFit { .. }
            | AlignmentError::TooFast { .. }
            | AlignmentError::WaysDoNotFit { .. } => {
                "Choose the program that ran, or drop that program together with this recording."
            }
        };
        ComparisonRefusal { reason: sentence_of(&error.to_string()), advice, asks_interval: false }
    }
}

/// Formats seconds with the decimals that suit their size.
pub(in crate::project) fn seconds(value: f64) -> String {
    if value == 0.0 {
        return "0 s".to_string();
    }
    let decimals = if value.abs() < 10.0 { 2 } else { 1 };
    format!("{value:.decimals$} s").replace('-', "−")
}

/// Adds a sign to a number as text; 0 has none.
pub(in crate::project) fn signed(text: String) -> String {
    let is_nothing = text.chars().all(|letter| !('1'..='9').contains(&letter));
    if is_nothing { text.trim_start_matches(['+', '-']).to_string() } else { text.replace('-', "−") }
}

/// Formats a time lost (s) with its sign.
pub fn lost_label(seconds: f64) -> String {
    let decimals = if seconds.abs() < 10.0 { 2 } else { 1 };
    signed(format!("{seconds:+.decimals$} s"))
}

/// Formats a ratio as a percentage with its sign.
pub(in crate::project) fn percent(ratio: f64) -> String {
    if ratio.is_finite() { signed(format!("{:+.1} %", 100.0 * ratio)) } else { "–".to_string() }
}

/// Formats a feedrate (mm/s) in mm/min.
pub(in crate::project) fn feedrate(value: f64) -> String {
    format!("{:.0} mm/min", mm_per_min(value))
}

fn waiting(comparison: &Comparison) -> Durations {
    let (whole, motion) = (comparison.whole, comparison.motion);
    Durations {
        recorded: whole.recorded - motion.recorded,
        simulated: (whole.simulated - motion.simulated).max(0.0),
    }
}

fn sentence(comparison: &Comparison) -> String {
    let Durations { recorded, simulated } = comparison.whole;
    let waits = waiting(comparison).recorded;
    format!(
        "The machine took {}, the simulation {} ({}): {} motion, {} waiting.",
        seconds(recorded),
        seconds(simulated),
        percent(simulated / recorded - 1.0),
        seconds(comparison.motion.recorded),
        seconds(waits.max(0.0)),
    )
}

fn aligned(log: &Log, alignment: &Alignment) -> String {
    let fit = 100.0 * alignment.fit;
    let fit = match alignment.method {
        Method::Positions => {
            let spread = alignment.spread.map_or(String::new(), |spread| {
                format!(", {:.0} µm from it on average", micrometres(spread))
            });
            format!("{fit:.0} % of the recorded path is on the programmed path{spread}")
        }
        Method::Lines => format!("{fit:.0} % of the lines are in order"),
        Method::Feed => format!("{fit:.0} % of the stops were found"),
    };
    let covered = 100.0 * (alignment.covered.end - alignment.covered.start) / alignment.length;
    let covered = if covered < 99.5 {
        format!("; the recording covers {covered:.0} % of the path")
    } else {
        String::new()
    };
    sentence_of(&format!("{}, aligned by {}: {fit}{covered}", log.format, alignment.method.name()))
}

fn measures(comparison: &Comparison) -> Vec<String> {
    let feed = comparison.feed.map(|feed| {
        let of = |rms: f64| format!("{} ({:.1} %)", feedrate(rms), 100.0 * rms / feed.programmed);
        format!(
            "Cutting feedrates differ by {} (root mean square, relative to the programmed {}); CAM's differ by {}.",
            of(feed.rms),
            feedrate(feed.programmed),
            of(feed.programmed_rms)
        )
    });
    let position = comparison.position.map(|position| {
        format!(
            "Positions differ by {:.0} µm on average, {:.0} µm at most.",
            micrometres(position.rms),
            micrometres(position.largest)
        )
    });
    feed.into_iter().chain(position).collect()
}

fn remarks(log: &Log, switches: &OverrideSwitches, alignment: &Alignment) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for (name, ratio) in [("feed", switches.feed), ("rapid", switches.rapid)] {
        if let Some(ratio) = ratio.filter(|ratio| *ratio != 1.0) {
            all.push(format!(
                "The {name} override was at {:.0} %, and the simulation uses it.",
                100.0 * ratio
            ));
        }
    }
    if switches.changed {
        all.push(
            "The operator changed an override during the run; the simulation uses the machine's.".to_string(),
        );
    }
    all.extend(alignment.remarks.iter().map(|remark| sentence_of(remark)));
    // Warnings before notes; each file has few of them.
    for severity in [RecordingSeverity::Warning, RecordingSeverity::Info] {
        for remark in log.remarks.0.iter().filter(|remark| remark.severity == severity) {
            let line = remark.line.map_or(String::new(), |line| format!("line {line}: "));
            let column = remark.column.as_ref().map_or(String::new(), |column| format!("{column}: "));
            all.push(sentence_of(&format!("{line}{column}{}", remark.message)));
        }
    }
    all
}

/// Returns a clause as a sentence.
pub(in crate::project) fn sentence_of(clause: &str) -> String {
    let mut letters = clause.chars();
    let first = letters.next().map(|letter| letter.to_uppercase().to_string()).unwrap_or_default();
    let end = if clause.ends_with(['.', '?', '!']) { "" } else { "." };
    format!("{first}{}{end}", letters.as_str())
}

fn duration_rows(toolpath: &Toolpath, comparison: &Comparison) -> Vec<DurationRow> {
    let part = |name: &str, of: Durations| DurationRow {
        name: name.to_string(),
        is_detail: false,
        recorded_s: of.recorded,
        simulated_s: of.simulated,
    };
    let mut details: Vec<(String, usize, Durations)> = Vec::new();
    for visit in comparison.lost.iter().filter(|visit| visit.waits()) {
        let name = causes(toolpath, visit);
        let at = details.iter().position(|(known, ..)| *known == name).unwrap_or_else(|| {
            details.push((name, 0, Durations::default()));
            details.len() - 1
        });
        let (_, count, durations) = &mut details[at];
        *count += 1;
        durations.recorded += visit.recorded.end - visit.recorded.start;
        durations.simulated += visit.simulated.end - visit.simulated.start;
    }
    let mut all = vec![part("Motion", comparison.motion), part("Waiting", waiting(comparison))];
    all.extend(details.into_iter().map(|(name, count, of)| {
        let times = if 1 < count { format!(" ({count}×)") } else { String::new() };
        DurationRow { is_detail: true, ..part(&format!("{name}{times}"), of) }
    }));
    all
}

/// Returns the reasons of the stops of a visit.
fn causes(toolpath: &Toolpath, visit: &VisitTimes) -> String {
    let mut names: Vec<String> = Vec::new();
    for stop in &toolpath.stops[visit.stops.clone()] {
        let name = match stop.cause {
            StopCause::Dwell { .. } => "dwell".to_string(),
            StopCause::Rotary { .. } => "rotary axes".to_string(),
            StopCause::ToolChange { .. } => "tool change".to_string(),
            StopCause::SameTool { .. } => "same tool again".to_string(),
            StopCause::Spindle { code: Some(code), .. } => format!("spindle M{code}"),
            StopCause::Spindle { code: None, .. } => "spindle speed".to_string(),
            StopCause::MCode { code } => format!("M{code}"),
        };
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names.join(" and ")
}

/// Returns all places, the one with the largest loss or gain first.
fn place_rows(toolpath: &Toolpath, alignment: &Alignment, comparison: &Comparison) -> Vec<PlaceRow> {
    let poll = match alignment.method {
        Method::Positions => 0.0,
        Method::Lines | Method::Feed => {
            alignment.marks.first().map_or(0.0, |mark| mark.deviation * 12.0f64.sqrt())
        }
    };
    let least = (MIN_PLACE_SHARE * comparison.whole.recorded).max(MIN_PLACE_POLLS * poll);
    let time = |visit: &VisitTimes| visit.recorded.end - visit.recorded.start;
    let mut groups: Vec<&[VisitTimes]> = Vec::new();
    let mut rest = &comparison.lost[..];
    while let Some(first) = rest.first() {
        let is_alone = |visit: &VisitTimes| SINGLE_LINE_RATIO * least <= visit.seconds().abs();
        let count = if first.waits() {
            rest.iter().take_while(|visit| visit.waits()).count()
        } else if is_alone(first) {
            1
        } else {
            let mut length = 0.0;
            let more = rest.iter().take_while(|visit| {
                let takes = length < least && !visit.waits() && !is_alone(visit);
                length += time(visit);
                takes
            });
            more.count()
        };
        let (group, others) = rest.split_at(count);
        groups.push(group);
        rest = others;
    }
    let mut all: Vec<PlaceRow> = groups.into_iter().map(|group| place_row(toolpath, group)).collect();
    sort_by_number(&mut all, |one| -one.seconds.abs());
    all
}

/// Returns the place of consecutive visits, at least one.
fn place_row(toolpath: &Toolpath, visits: &[VisitTimes]) -> PlaceRow {
    let (first, last) = (&visits[0], &visits[visits.len() - 1]);
    let lines = visits.iter().map(|visit| visit.line.0);
    let mut kinds: Vec<String> = Vec::new();
    for kind in visits.iter().filter(|visit| visit.waits()).map(|visit| causes(toolpath, visit)) {
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    let sum = |of: fn(&VisitTimes) -> f64| visits.iter().map(of).sum::<f64>();
    PlaceRow {
        lines: [lines.clone().min().unwrap_or(0), lines.max().unwrap_or(0)],
        distance_mm: [first.distance.start, last.distance.end],
        seconds: sum(VisitTimes::seconds),
        recorded_s: sum(|visit| visit.recorded.end - visit.recorded.start),
        simulated_s: sum(|visit| visit.simulated.end - visit.simulated.start),
        kind: if kinds.is_empty() { "motion".to_string() } else { format!("waiting: {}", kinds.join(", ")) },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::alignment::align_log;
    use crate::identification::comparison::compare;
    use crate::identification::recording::read;
    use crate::machine::{Machine, TimeConstants};
    use crate::project::profile_csv;
    use crate::simulation::gcode;
    use crate::simulation::interpreter::trace;
    use crate::simulation::profile::{Profile, Resolution};
    use crate::simulation::simulate;

    const PROGRAM: &[u8] = b"G21 G90\nG0 X0 Y0\nG1 X40 F3000\nG1 Y30\nM8\nG1 X0\nG1 Y0\nG0 X50\nM30\n";

    fn machine(time_constant: f64) -> Machine {
        let mut machine = Machine::default();
        machine.interpolator.time_constants = TimeConstants::Equal(time_constant);
        machine
    }

    fn recorded(machine: &Machine) -> Log {
        let toolpath = trace(&gcode::read(PROGRAM), machine);
        let plan = simulate(&toolpath, machine);
        read(profile_csv(&Profile::new(&toolpath, &plan).samples(Resolution::FINE)).as_bytes())
            .expect("a log")
    }

    #[test]
    fn stretches_and_parts_add_up_to_the_difference() {
        let mut slower = machine(0.08);
        slower.times.m_codes.insert(8, 3.0);
        let log = recorded(&slower);
        let nominal = machine(0.03);
        let toolpath = trace(&gcode::read(PROGRAM), &nominal);
        let (_, alignment) = align_log(&log, &toolpath, &nominal).expect("it is of this program");
        let comparison = compare(&toolpath, &simulate(&toolpath, &nominal), &alignment);
        let report =
            ComparisonReport::new(&log, &OverrideSwitches::default(), &toolpath, &alignment, &comparison);
        let whole = report.recorded_s - report.simulated_s;
        assert!(3.0 < whole, "{whole} s");
        let lost: f64 = report.stretches.iter().map(|stretch| stretch.seconds).sum();
        assert!((lost - whole).abs() < 1e-6, "{lost} of {whole}");
        let parts: f64 =
            report.parts.iter().filter(|part| !part.is_detail).map(|p| p.recorded_s - p.simulated_s).sum();
        assert!((parts - whole).abs() < 1e-6, "{parts} of {whole}");
        assert_eq!(report.stretches[0].kind, "waiting: M8");
        assert_eq!(report.stretches[0].lines, [5, 5]);
        assert!(report.stretches.is_sorted_by(|a, b| b.seconds.abs() <= a.seconds.abs()));
        assert!(report.sentence.starts_with("The machine took "), "{}", report.sentence);
        assert!(report.aligned.contains("aligned by axis positions"), "{}", report.aligned);
    }

    #[test]
    fn sentences_have_units_and_signs() {
        let comparison = Comparison {
            residuals: vec![],
            simulated: vec![],
            lost: vec![],
            whole: Durations { recorded: 391.8, simulated: 395.9 },
            motion: Durations { recorded: 326.3, simulated: 330.0 },
            feed: None,
            position: None,
        };
        assert_eq!(
            sentence(&comparison),
            "The machine took 391.8 s, the simulation 395.9 s (+1.0 %): 326.3 s motion, 65.5 s waiting."
        );
        assert_eq!(percent(-0.0123), "−1.2 %");
        assert_eq!(percent(-0.0001), "0.0 %");
        assert_eq!((&*lost_label(-0.126), &*lost_label(12.34)), ("−0.13 s", "+12.3 s"));
        assert_eq!(seconds(0.0), "0 s");
    }
}
