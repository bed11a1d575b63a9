//! The override switches that a recording shows itself.

use std::ops::Range;

use crate::identification::recording::{Channel, Recording};

/// Override switches during a run, as ratios.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Switches {
    /// Of the feed; none where it was not recorded or was changed.
    pub feed: Option<f64>,
    /// Of the rapid feed; likewise.
    pub rapid: Option<f64>,
    /// Whether one of them was changed during the run.
    pub changed: bool,
}

impl Recording {
    /// The switches in `range` (s): those that stood at one value all along.
    pub fn switches(&self, range: &Range<f64>) -> Switches {
        let feed = steady(&self.feed_override, range);
        let rapid = steady(&self.rapid_override, range);
        let changed = feed == Switch::Changed || rapid == Switch::Changed;
        Switches { feed: feed.ratio(), rapid: rapid.ratio(), changed }
    }
}

/// What one switch did.
#[derive(Clone, Copy, PartialEq)]
enum Switch {
    NotRecorded,
    At(f64),
    Changed,
}

impl Switch {
    fn ratio(self) -> Option<f64> {
        match self {
            Switch::At(ratio) => Some(ratio),
            Switch::NotRecorded | Switch::Changed => None,
        }
    }
}

fn steady(channel: &Option<Channel<f64>>, range: &Range<f64>) -> Switch {
    let Some(own) = channel.as_ref().map(|channel| channel.during(range)) else { return Switch::NotRecorded };
    match own.values.split_first() {
        // At nothing the machine stands; that is a hold and no ratio.
        None => Switch::NotRecorded,
        Some((first, rest)) if 0.0 < *first && rest.iter().all(|value| value == first) => Switch::At(*first),
        Some(_) => Switch::Changed,
    }
}
