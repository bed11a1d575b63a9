//! Rows of numbers without names, as LinuxCNC's `halsampler` writes them:
//!
//! ```text
//! [sample number] x y z [more pins]        halsampler -t puts the number first
//! 4711  12.5  0.0  -3.0  8.333  17
//! ```
//!
//! The columns are the pins that the user linked to the sampler. They are identified by their values, and a
//! remark lists them; names can be given instead ([`crate::identification::recording::ReadingOptions`]). In
//! order: a first column of whole numbers rising by one is the sample number (a jump: samples were lost
//! because the FIFO was full), a first column that rises by nearly equal fractions is time in s, the next
//! three columns are X, Y and Z, and further ones are the line if whole and never negative, else the feed.
//! One row is a servo period, [`LINUXCNC_SERVO_PERIOD_S`], unless an interval is given. The unit of the
//! machine, mm or inch, is not stated.
//!
//! Source: halsampler(1), sampler(9). Not read: bit pins as words, several samplers in one file.

use crate::identification::recording::field::{ChannelField, ChannelLabel, LoopSide};
use crate::identification::recording::formats::columns::{TableColumn, TableRows};
use crate::identification::recording::unit::SECOND;
use crate::identification::recording::{ReadingOptions, RecordingError, RecordingRemarks};
use crate::simulation::feed::LINUXCNC_SERVO_PERIOD_S;

/// Identifies the columns of `rows`, and adds a time column if there is none.
pub(in crate::identification::recording) fn named(
    mut rows: TableRows,
    options: &ReadingOptions,
    remarks: &mut RecordingRemarks,
) -> Result<TableRows, RecordingError> {
    let mut at = 0;
    let numbers = |rows: &TableRows, at: usize| match rows.columns.get(at) {
        Some(TableColumn::Numbers(values)) => values.clone(),
        _ => Vec::new(),
    };
    let first = numbers(&rows, 0);
    let label = |name: &str, field: ChannelField| ChannelLabel {
        name: name.to_owned(),
        field: Some(field),
        unit: None,
    };
    let mut has_time = false;
    if rises_by_one(&first) {
        rows.labels[0] = label("sample number", ChannelField::SampleNumber);
        at = 1;
    } else if rises_evenly(&first) {
        rows.labels[0] = ChannelLabel { unit: Some(SECOND), ..label("time", ChannelField::Time) };
        has_time = true;
        at = 1;
    }
    if rows.columns.len() < at + 3 {
        let found = (1..=rows.columns.len()).map(|n| format!("column {n}")).collect();
        return Err(RecordingError::NothingKnown { found });
    }
    for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
        rows.labels[at + axis] = label(name, ChannelField::Position(LoopSide::Unstated, axis));
    }
    let (mut line, mut feed) = (false, false);
    for column in at + 3..rows.columns.len() {
        let values = numbers(&rows, column);
        let known = || values.iter().filter(|value| value.is_finite());
        if !line && known().all(|value| value.fract() == 0.0 && 0.0 <= *value) {
            rows.labels[column] = label("line", ChannelField::Line);
            line = true;
        } else if !feed && known().all(|value| value.is_finite()) && known().any(|value| value.fract() != 0.0)
        {
            rows.labels[column] = label("feed", ChannelField::Feed(LoopSide::Unstated));
            feed = true;
        } else {
            rows.columns[column] = TableColumn::Skipped;
        }
    }
    let read: Vec<&str> = rows.labels.iter().filter(|l| l.field.is_some()).map(|l| l.name.as_str()).collect();
    remarks.warn(None, None, format!("no names: the columns are assumed to be {}", read.join(", ")));
    if !has_time {
        let interval = options.interval.filter(|interval| interval.is_finite() && 0.0 < *interval);
        let period = interval.unwrap_or(LINUXCNC_SERVO_PERIOD_S);
        if interval.is_none() {
            let message = format!(
                "no time column: the interval between rows is assumed to be a servo period of {} ms",
                period * 1e3
            );
            remarks.warn(None, None, message);
        }
        let counts: Vec<f64> =
            if at == 1 { first } else { (0..rows.lines.len()).map(|row| row as f64).collect() };
        let lost: f64 =
            counts.windows(2).map(|pair| pair[1] - pair[0] - 1.0).filter(|lost| 0.0 < *lost).sum();
        if 0.0 < lost {
            remarks.warn(
                None,
                None,
                format!("{lost} samples were lost by the recorder: gaps in the sample numbers"),
            );
        }
        let origin = counts.first().copied().unwrap_or(0.0);
        rows.labels.push(ChannelLabel { unit: Some(SECOND), ..label("time", ChannelField::Time) });
        rows.columns
            .push(TableColumn::Numbers(counts.iter().map(|count| (count - origin) * period).collect()));
    }
    Ok(rows)
}

/// Returns `true` for whole numbers of which nearly all rise by one.
fn rises_by_one(values: &[f64]) -> bool {
    let ones = values.windows(2).filter(|pair| pair[1] - pair[0] == 1.0).count();
    8 <= values.len() && values.iter().all(|value| value.fract() == 0.0) && 9 * (values.len() - 1) < 10 * ones
}

/// Returns `true` for numbers that rise by nearly equal steps.
fn rises_evenly(values: &[f64]) -> bool {
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mean = steps.iter().sum::<f64>() / steps.len().max(1) as f64;
    let even = steps.iter().filter(|step| (*step - mean).abs() < 0.5 * mean).count();
    8 <= values.len() && 0.0 < mean && mean < 0.5 && 9 * steps.len() < 10 * even
}
