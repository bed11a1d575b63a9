//! Stamps → one ascending time axis, or several if a file contains several recordings.
//!
//! Stamps are ISO 8601 with any number of decimals (`2017-02-06T17:40:26.9218750Z`, blank for `T`, comma for
//! the point, zone `Z`, `±hh:mm` or none), times of day, or numbers with a unit. Faults of stamps, and their
//! repairs:
//!
//! ```text
//! one sample early or late, the rest in order    the sample is dropped
//! time starts again and then ascends             a new recording begins
//! time jumps ahead by more than a day            a new recording begins
//! the same stamp, the same values                the copy is dropped
//! the same stamp, other values                   spread evenly up to the next stamp: the stamp was rounded
//! anything beyond one sample in a hundred        refused
//! ```

use crate::identification::recording::diagnostic::is_tolerable;
use crate::identification::recording::{RecordingError, RecordingRemarks};

const NANOSECONDS_PER_SECOND: f64 = 1e9;

/// Least number of values of a recording, all fields together.
pub(super) const MIN_SAMPLES: usize = 8;

/// Returns the nanoseconds since 1970 of an ISO 8601 stamp, or since midnight of a time of day; `None` for
/// any other text.
pub(super) fn iso(text: &str) -> Option<i64> {
    let text = text.trim().trim_matches('"');
    let (date, rest) = match text.split_once(['T', 't', ' ']) {
        Some((date, rest)) => (Some(date), rest),
        None => (None, text),
    };
    let days = match date {
        Some(date) => days_since_1970(date)?,
        None => 0,
    };
    let (time, zone) = match rest.find(['Z', 'z', '+', '-']) {
        Some(at) => (&rest[..at], zone(&rest[at..])?),
        None => (rest, 0),
    };
    let mut parts = time.splitn(3, ':');
    let hours = digits(parts.next()?, 24)?;
    let minutes = digits(parts.next()?, 60)?;
    let (seconds, nanoseconds) = match parts.next() {
        Some(text) => match text.split_once(['.', ',']) {
            Some((whole, decimals)) => (digits(whole, 61)?, nanoseconds(decimals)?),
            None => (digits(text, 61)?, 0),
        },
        None => (0, 0),
    };
    let seconds = days.checked_mul(86_400)?.checked_add(hours * 3600 + minutes * 60 + seconds - zone)?;
    seconds.checked_mul(1_000_000_000)?.checked_add(nanoseconds)
}

fn digits(text: &str, below: i64) -> Option<i64> {
    let plain = (1..=4).contains(&text.len()) && text.bytes().all(|b| b.is_ascii_digit());
    text.parse().ok().filter(|value| plain && *value < below)
}

/// Reads the decimals of a second; digits beyond nine are dropped.
fn nanoseconds(decimals: &str) -> Option<i64> {
    if !decimals.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    let kept = &decimals[..decimals.len().min(9)];
    let value: i64 = if kept.is_empty() { 0 } else { kept.parse().ok()? };
    Some(value * 10_i64.pow(9 - kept.len() as u32))
}

/// Reads a time zone, seconds east of Greenwich.
fn zone(text: &str) -> Option<i64> {
    let sign = match text.as_bytes().first()? {
        b'Z' | b'z' => return (text.len() == 1).then_some(0),
        b'-' => -1,
        _ => 1,
    };
    let text = text.get(1..)?;
    let (hours, minutes) = text.split_once(':').or_else(|| Some((text.get(..2)?, text.get(2..)?)))?;
    let minutes = if minutes.is_empty() { 0 } else { digits(minutes, 60)? };
    Some(sign * (digits(hours, 24)? * 3600 + minutes * 60))
}

/// Returns the days from 1970-01-01 to `yyyy-mm-dd` in the Gregorian calendar (Hinnant's algorithm).
fn days_since_1970(date: &str) -> Option<i64> {
    let mut parts = date.split('-');
    let (year, month, day) = (parts.next()?, parts.next()?, parts.next()?);
    let (year, month, day) = (digits(year, 10_000)?, digits(month, 13)?, digits(day, 32)?);
    if parts.next().is_some() || month == 0 || day == 0 {
        return None;
    }
    let year = if month <= 2 { year - 1 } else { year };
    let era = year.div_euclid(400);
    let year_of_era = year.rem_euclid(400);
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    let day_of_era = year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year;
    Some(era * 146_097 + day_of_era - 719_468)
}

/// Returns the seconds from stamp `from` to stamp `to`, both in ns; exact before rounding.
pub(super) fn seconds(from: i64, to: i64) -> f64 {
    to.saturating_sub(from) as f64 / NANOSECONDS_PER_SECOND
}

/// The rows of one recording with their stamps.
#[derive(Debug)]
pub(super) struct RecordingRows {
    /// Indices of the rows.
    pub(super) rows: Vec<usize>,
    /// Stamps, strictly ascending.
    pub(super) time: Vec<f64>,
}

impl RecordingRows {
    fn push(&mut self, row: usize, time: f64) {
        self.rows.push(row);
        self.time.push(time);
    }
}

/// Returns the median of time steps; 0 if there are none.
pub(super) fn median_step(mut steps: Vec<f64>) -> f64 {
    let middle = steps.len() / 2;
    if steps.is_empty() { 0.0 } else { *steps.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// Number of ascending rows after which time has started again.
const RESTART_ROWS: usize = 4;

/// Longest time without a row within one recording, s.
const MAX_GAP_S: f64 = 86_400.0;
/// Longest time without a row within one recording, in usual steps: with a wrong unit of time, [`MAX_GAP_S`]
/// alone would divide the file into one recording per row.
const MAX_GAP_STEPS: f64 = 1e6;

/// Sorts a table's `stamps` (NaN if missing) into recordings; `line(row)` is the line of a row, and `same(a,
/// b)` is `true` if two rows have the same values.
pub(super) fn split_recordings(
    stamps: &[f64],
    line: impl Fn(usize) -> usize,
    same: impl Fn(usize, usize) -> bool,
    remarks: &mut RecordingRemarks,
) -> Result<Vec<RecordingRows>, RecordingError> {
    let mut stretches = vec![RecordingRows { rows: Vec::with_capacity(stamps.len()), time: Vec::new() }];
    let mut dropped = FaultCount::default();
    let mut copies = FaultCount::default();
    let mut restarts = FaultCount::default();
    let known: Vec<usize> = (0..stamps.len()).filter(|row| stamps[*row].is_finite()).collect();
    if known.is_empty() {
        return Err(RecordingError::TooFewSamples { found: 0, needed: MIN_SAMPLES });
    }
    let steps = known.windows(2).map(|pair| stamps[pair[1]] - stamps[pair[0]]);
    let max_gap = MAX_GAP_S.max(MAX_GAP_STEPS * median_step(steps.collect()));
    for (at, row) in known.iter().copied().enumerate() {
        let time = stamps[row];
        let current = stretches.last_mut().expect("there is always a stretch");
        let Some(last) = current.time.last().copied() else {
            current.push(row, time);
            continue;
        };
        let before_last = current.time.len().checked_sub(2).map(|at| current.time[at]);
        if max_gap < time - last {
            let message =
                format!("nothing for {:.0} s before this row: another recording begins here", time - last);
            remarks.warn(Some(line(row)), None, message);
            stretches.push(RecordingRows { rows: vec![row], time: vec![time] });
        } else if last < time {
            current.push(row, time);
        } else if last == time {
            let copy = current.rows.last().is_some_and(|last| same(*last, row));
            if copy {
                copies.add(line(row));
            } else {
                current.push(row, time);
            }
        } else if before_last.is_some_and(|before| before < time) {
            // The previous sample jumped ahead.
            dropped.add(line(*current.rows.last().expect("two were kept")));
            *current.rows.last_mut().expect("two were kept") = row;
            *current.time.last_mut().expect("two were kept") = time;
        } else if known.get(at..at + RESTART_ROWS).is_some_and(|rows| starts_again(stamps, rows, last)) {
            remarks.warn(
                Some(line(row)),
                None,
                "time starts again: another recording begins here".to_owned(),
            );
            restarts.add(line(row));
            stretches.push(RecordingRows { rows: vec![row], time: vec![time] });
        } else {
            dropped.add(line(row));
        }
    }
    let count = dropped.count + restarts.count;
    if !is_tolerable(count, stamps.len()) {
        let firsts = [&dropped, &restarts].into_iter().filter(|faults| 0 < faults.count);
        let line = firsts.map(|faults| faults.first).min().unwrap_or(0);
        return Err(RecordingError::TimeDisorder { line, count, of: stamps.len() });
    }
    dropped.report(remarks, "out of order in time, dropped");
    copies.report(remarks, "copies of the sample before, dropped");
    let spread: usize = stretches.iter_mut().map(|stretch| spread_equal(&mut stretch.time)).sum();
    if stretches.iter().all(|stretch| stretch.time.first() == stretch.time.last()) && 1 < known.len() {
        return Err(RecordingError::TimeDisorder {
            line: line(known[1]),
            count: known.len() - 1,
            of: stamps.len(),
        });
    }
    if 0 < spread {
        let message =
            format!("{spread} samples share their time stamp with another: spread evenly up to the next one");
        remarks.warn(None, None, message);
    }
    Ok(stretches)
}

/// Returns `true` if time ascends along these `rows`, all of them up to the stamp `last`.
fn starts_again(stamps: &[f64], rows: &[usize], last: f64) -> bool {
    let (first, end) = (stamps[rows[0]], stamps[rows[rows.len() - 1]]);
    rows.windows(2).all(|pair| stamps[pair[0]] <= stamps[pair[1]]) && first < end && end <= last
}

/// Spreads equal stamps evenly up to the next stamp, and the last group at the pace before it.
fn spread_equal(time: &mut [f64]) -> usize {
    let mut moved = 0;
    let mut step = 0.0;
    let mut from = 0;
    while from < time.len() {
        let mut to = from + 1;
        while to < time.len() && time[to] == time[from] {
            to += 1;
        }
        let group = (to - from) as f64;
        if to < time.len() {
            step = (time[to] - time[from]) / group;
        }
        let start = time[from];
        for (nth, stamp) in time[from..to].iter_mut().enumerate().skip(1) {
            *stamp = start + step * nth as f64;
            moved += 1;
        }
        from = to;
    }
    moved
}

/// Largest delay of a late event against the latest one, s.
const MAX_LATENESS_S: f64 = 2.0;

/// Splits the `stamps` of lines of events where time restarts. Late lines keep their place, as channels sort
/// their stamps; a stray old stamp is dropped.
pub(super) fn split_event_recordings(
    stamps: &[f64],
    line: impl Fn(usize) -> usize,
    remarks: &mut RecordingRemarks,
) -> Result<Vec<Vec<usize>>, RecordingError> {
    let mut stretches = vec![Vec::with_capacity(stamps.len())];
    let mut stray = FaultCount::default();
    let mut late = FaultCount::default();
    let mut latest = f64::NEG_INFINITY;
    // The row of `latest`, and its earlier value.
    let mut latest_at = (0, f64::NEG_INFINITY);
    let mut before = f64::NEG_INFINITY;
    for (row, time) in stamps.iter().copied().enumerate() {
        if time < before {
            late.add(line(row));
        }
        before = time;
        if latest - MAX_LATENESS_S <= time {
            if latest < time {
                latest_at = (row, latest);
                latest = time;
            }
        } else if latest_at.0 + 1 == row && latest_at.1 - MAX_LATENESS_S <= time && latest_at.1.is_finite() {
            // The line before jumped ahead.
            stray.add(line(row - 1));
            stretches.last_mut().expect("there is always a stretch").pop();
            latest = latest_at.1.max(time);
        } else if stamps[row..].len() >= RESTART_ROWS
            && stamps[row..row + RESTART_ROWS].iter().all(|stamp| *stamp < latest - MAX_LATENESS_S)
            && time <= stamps[row + RESTART_ROWS - 1]
        {
            remarks.warn(
                Some(line(row)),
                None,
                "time starts again: another recording begins here".to_owned(),
            );
            stretches.push(Vec::new());
            latest_at = (row, f64::NEG_INFINITY);
            latest = time;
        } else {
            stray.add(line(row));
            continue;
        }
        stretches.last_mut().expect("there is always a stretch").push(row);
    }
    if stamps.is_empty() {
        return Err(RecordingError::TooFewSamples { found: 0, needed: MIN_SAMPLES });
    }
    let disorder = stray.count + stretches.len() - 1;
    if !is_tolerable(disorder, stamps.len()) || stamps.len() < 5 * late.count.saturating_sub(3) {
        return Err(RecordingError::TimeDisorder {
            line: if 0 < late.count { late.first } else { stray.first },
            count: late.count.max(disorder),
            of: stamps.len(),
        });
    }
    stray.report(remarks, "stamped long before their neighbours, dropped");
    if late.count + 1 != stretches.len() + stray.count {
        late.report(remarks, "later in the file than in time, sorted");
    }
    Ok(stretches)
}

/// The number of faults of one kind, and the line of the first fault.
#[derive(Default)]
struct FaultCount {
    count: usize,
    first: usize,
}

impl FaultCount {
    fn add(&mut self, line: usize) {
        if self.count == 0 {
            self.first = line;
        }
        self.count += 1;
    }

    fn report(&self, remarks: &mut RecordingRemarks, what: &str) {
        if 0 < self.count {
            remarks.warn(Some(self.first), None, format!("{} samples {what}; this is the first", self.count));
        }
    }
}
