//! Beginnings and ends of programs within a recording.
//!
//! ```text
//! status   READY | ACTIVE … FEED_HOLD … ACTIVE … PROGRAM_COMPLETED | ACTIVE …
//!                 └───────────── a run ─────────────────────────┘ └── the next
//! ```
//!
//! Without a status the program's name separates runs; without a name a line number does that comes near its
//! largest value and then returns to the first. Loops and subprograms also return to earlier lines, but not
//! from the end to the beginning. Parts of the recording may belong to no run.

use crate::identification::recording::{Channel, Recording, RecordingRun, RunMark, Status};

/// Part of the largest line number from which on a program may end.
const MIN_END_SHARE: f64 = 0.9;

/// Part of the largest line number up to which a program may begin.
const MAX_BEGINNING_SHARE: f64 = 0.1;

/// Returns the runs of a recording; at least one.
pub(super) fn runs(recording: &Recording) -> Vec<RecordingRun> {
    let mut runs =
        recording.status.as_ref().map(|status| by_status(status, recording.duration)).unwrap_or_default();
    if runs.is_empty() {
        runs =
            recording.program.as_ref().map(|name| by_program(name, recording.duration)).unwrap_or_default();
    }
    if runs.len() < 2 && runs.iter().all(|run| run.found_by == RunMark::Program) {
        let by_line =
            recording.line.as_ref().map(|line| by_line(line, recording.duration)).unwrap_or_default();
        if 1 < by_line.len() {
            runs = by_line;
        }
    }
    if runs.is_empty() {
        runs.push(RecordingRun {
            time: 0.0..recording.duration,
            program: None,
            found_by: RunMark::Whole,
            has_start: false,
            has_end: false,
        });
    }
    if let Some(line) = &recording.line {
        let largest = f64::from(line.values.iter().copied().max().unwrap_or(0));
        for run in runs.iter_mut().filter(|run| !run.has_start) {
            let first = line.time.partition_point(|stamp| *stamp < run.time.start);
            run.has_start =
                line.values.get(first).is_some_and(|line| f64::from(*line) <= MAX_BEGINNING_SHARE * largest);
        }
    }
    if let Some(program) = &recording.program {
        for run in &mut runs {
            // The name often follows the start by a fraction of a second, so that the name at the end is the
            // right one.
            let last = program.time.partition_point(|stamp| *stamp < run.time.end);
            run.program = last.checked_sub(1).and_then(|last| program.values.get(last)).cloned();
        }
    }
    runs
}

fn by_status(status: &Channel<Status>, duration: f64) -> Vec<RecordingRun> {
    let mut runs = Vec::new();
    let mut open: Option<(f64, bool)> = None;
    let mut running_before = None;
    for (stamp, status) in status.time.iter().zip(&status.values) {
        match status {
            Status::Active | Status::Held | Status::Stopped if open.is_none() => {
                // A file that begins in the middle of a run also begins with ACTIVE: a start is known only
                // after an idle or completed state.
                open = Some((*stamp, running_before == Some(false)));
            }
            Status::Ended | Status::Idle => {
                if let Some((from, has_start)) = open.take() {
                    let time = from..*stamp;
                    runs.push(RecordingRun {
                        time,
                        program: None,
                        found_by: RunMark::Status,
                        has_start,
                        has_end: true,
                    });
                }
            }
            _ => {}
        }
        running_before = Some(open.is_some());
    }
    if let Some((from, has_start)) = open {
        let time = from..duration;
        runs.push(RecordingRun { time, program: None, found_by: RunMark::Status, has_start, has_end: false });
    }
    runs.retain(|run| run.time.start < run.time.end);
    runs
}

fn by_program(program: &Channel<String>, duration: f64) -> Vec<RecordingRun> {
    let mut starts: Vec<(f64, &String)> = Vec::new();
    for (stamp, name) in program.time.iter().zip(&program.values) {
        if starts.last().is_none_or(|(_, last)| *last != name) {
            starts.push((*stamp, name));
        }
    }
    let ends = starts.iter().skip(1).map(|(stamp, _)| *stamp).chain([duration]);
    let mut runs: Vec<RecordingRun> = Vec::with_capacity(starts.len());
    for (nth, ((from, name), to)) in starts.iter().zip(ends).enumerate() {
        runs.push(RecordingRun {
            time: *from..to,
            program: Some((*name).clone()),
            found_by: RunMark::Program,
            has_start: 0 < nth,
            has_end: nth + 1 < starts.len(),
        });
    }
    if let Some(first) = runs.first_mut() {
        // The same program is assumed to run before its name first occurs.
        first.time.start = 0.0;
    }
    runs.retain(|run| run.time.start < run.time.end);
    runs
}

fn by_line(line: &Channel<u32>, duration: f64) -> Vec<RecordingRun> {
    let largest = f64::from(line.values.iter().copied().max().unwrap_or(0));
    let mut runs = Vec::new();
    let mut from = 0.0;
    let mut has_start = false;
    let mut reached_end = false;
    for (stamp, line) in line.time.iter().zip(&line.values) {
        let line = f64::from(*line);
        if MIN_END_SHARE * largest <= line {
            reached_end = true;
        } else if reached_end && 0.0 < line && line <= MAX_BEGINNING_SHARE * largest {
            runs.push(RecordingRun {
                time: from..*stamp,
                program: None,
                found_by: RunMark::Line,
                has_start,
                has_end: true,
            });
            (from, has_start, reached_end) = (*stamp, true, false);
        }
    }
    runs.push(RecordingRun {
        time: from..duration,
        program: None,
        found_by: RunMark::Line,
        has_start,
        has_end: reached_end,
    });
    runs
}
