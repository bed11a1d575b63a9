//! Comparison of travelled lengths with the lengths of lines.
//!
//! The integral of the recorded feed between two line numbers is the length of the program between them, to
//! within the length of a poll at either end. On lines that cut, a machine runs the programmed path and
//! nothing else, whatever the override.

use crate::identification::alignment::place::{ProgramPlace, Visit};
use crate::identification::alignment::{AlignmentError, Mark};
use crate::identification::recording::{Channel, ChannelUnit};
use crate::simulation::toolpath::Toolpath;

/// Least length that is compared, in multiples of the length run in one poll.
const RESOLVED_POLLS: f64 = 5.0;
/// Largest relative error of a control's display of the feed.
const MAX_DISPLAY_ERROR: f64 = 0.02;
/// Least part of the compared length that must be right.
const MIN_AGREEMENT: f64 = 0.5;

/// Compares lengths on lines that cut; `visits` holds the visit of each mark, as an index of `all`.
///
/// # Errors
///
/// Returns [`AlignmentError::WaysDoNotFit`] if most of the recorded length differs from that of its lines.
pub fn check_lengths(
    feed: &Channel<f64>,
    poll: f64,
    marks: &[Mark],
    visits: &[usize],
    all: &[Visit],
    toolpath: &Toolpath,
    distance_of: impl Fn(ProgramPlace) -> f64,
) -> Result<(), AlignmentError> {
    if !matches!(feed.unit, ChannelUnit::Stated(_)) {
        return Ok(());
    }
    let cuts = |visit: &Visit| {
        let is_feed = |segment: usize| !toolpath.segments.motion(segment).is_rapid();
        visit.stops.is_empty() && visit.segments.clone().all(is_feed)
    };
    let (mut compared, mut agreed) = (0.0, 0.0);
    for (pair, ends) in marks.windows(2).zip(visits.windows(2)) {
        if !all[ends[0]..ends[1]].iter().all(cuts) {
            continue;
        }
        let programmed = distance_of(pair[1].place) - distance_of(pair[0].place);
        let recorded = feed.during(&(pair[0].time..pair[1].time)).integral(pair[1].time);
        let around = feed.during(&(pair[0].time - poll..pair[1].time + poll));
        let per_poll = poll * around.extent().map_or(0.0, |(_, fastest)| fastest);
        let longer = programmed.max(recorded);
        if longer <= RESOLVED_POLLS * per_poll {
            continue;
        }
        compared += longer;
        if (recorded - programmed).abs() <= 2.0 * per_poll + MAX_DISPLAY_ERROR * programmed {
            agreed += longer;
        }
    }
    match agreed < MIN_AGREEMENT * compared {
        true => Err(AlignmentError::WaysDoNotFit { part: 1.0 - agreed / compared }),
        false => Ok(()),
    }
}
