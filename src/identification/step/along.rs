//! A log of one move → the positions along its line, or its feedrates if no position was recorded.

use crate::identification::recording;
use crate::identification::step::{Outcome, RecordedQuantity, Recording, identify};
use crate::simulation::sampled::rows_around;
use crate::simulation::toolpath::Vector;

/// A move as columns.
struct Along {
    times: Vec<f64>,
    values: Vec<f64>,
    quantity: RecordedQuantity,
}

/// Identifies the filters from the move in a log; `None` if the log has neither positions nor feedrates.
pub fn identify_move(log: &recording::Recording) -> Option<Outcome> {
    let Along { times, values, quantity } = along_line(log).or_else(|| by_feedrate(log))?;
    Some(identify(&Recording { times: &times, values: &values, quantity }))
}

/// Returns positions along the line from the first position of the tool towards the last.
fn along_line(log: &recording::Recording) -> Option<Along> {
    let axes = log.positions();
    let longest = axes.iter().flatten().max_by_key(|channel| channel.time.len())?;
    let times = longest.time.to_vec();
    let columns = axes.each_ref().map(|axis| {
        let mut row = 0;
        let mut at = |time: &f64| {
            let channel = axis.as_ref()?;
            rows_around(&channel.time, *time, &mut row).map(|rows| rows.between(&channel.values))
        };
        times.iter().map(|time| at(time).unwrap_or(0.0)).collect::<Vec<f64>>()
    });
    let position = |at: usize| Vector::new(columns[0][at], columns[1][at], columns[2][at]);
    let (first, last) = (position(0), position(times.len().checked_sub(1)?));
    let direction = (last - first).try_normalize(f64::MIN_POSITIVE)?;
    let values = (0..times.len()).map(|at| (position(at) - first).dot(&direction)).collect();
    Some(Along { times, values, quantity: RecordedQuantity::Position })
}

fn by_feedrate(log: &recording::Recording) -> Option<Along> {
    let feed = log.feed.as_ref().or(log.commanded_feed.as_ref())?;
    Some(Along {
        times: feed.time.to_vec(),
        values: feed.values.clone(),
        quantity: RecordedQuantity::Feedrate,
    })
}
