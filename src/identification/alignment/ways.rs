//! Is the way that the machine went while it ran a line as long as the line?
//!
//! The integral of the recorded feed between two line numbers is what the program has between them, to within a
//! poll at either end. On lines that cut, machines go nowhere else, whatever the override.

use crate::identification::alignment::place::{Place, Visit};
use crate::identification::alignment::{AlignmentError, Mark};
use crate::identification::recording::{Channel, Scale};
use crate::simulation::toolpath::{Motion, Toolpath};

/// Ways are compared that are so many times as long as what is run during a poll.
const RESOLVED_POLLS: f64 = 5.0;
/// How far a control's display of the feed may be off, as a part.
const MAX_DISPLAY_ERROR: f64 = 0.02;
/// Of the way that is compared so much must be right.
const MIN_AGREEMENT: f64 = 0.5;

/// Compares ways on lines that cut; `visits` are those of the marks, by index in `all`.
///
/// # Errors
/// [`AlignmentError::WaysDoNotFit`] where most of the recorded way is of another length than its lines.
pub fn check_ways(
    feed: &Channel<f64>,
    poll: f64,
    marks: &[Mark],
    visits: &[usize],
    all: &[Visit],
    toolpath: &Toolpath,
    distance_of: impl Fn(Place) -> f64,
) -> Result<(), AlignmentError> {
    if !matches!(feed.scale, Scale::Stated(_)) {
        return Ok(());
    }
    let cuts = |visit: &Visit| {
        let is_feed = |segment: usize| toolpath.segments.motion(segment) != Motion::Rapid;
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
