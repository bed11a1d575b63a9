//! Override switches in a recording.

use std::ops::Range;

use crate::identification::recording::{Channel, Recording};

/// Override switches during a run, as ratios.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OverrideSwitches {
    /// Of the feed; `None` if it was not recorded or was changed.
    pub feed: Option<f64>,
    /// Of the rapid feed; `None` if it was not recorded or was changed.
    pub rapid: Option<f64>,
    /// `true` if one of them was changed during the run.
    pub changed: bool,
}

impl Recording {
    /// Returns the switches that had one value throughout `range` (s).
    pub fn switches(&self, range: &Range<f64>) -> OverrideSwitches {
        let feed = steady(&self.feed_override, range);
        let rapid = steady(&self.rapid_override, range);
        let changed = feed == SwitchCourse::Changed || rapid == SwitchCourse::Changed;
        OverrideSwitches { feed: feed.ratio(), rapid: rapid.ratio(), changed }
    }
}

/// The course of one switch.
#[derive(Clone, Copy, PartialEq)]
enum SwitchCourse {
    NotRecorded,
    At(f64),
    Changed,
}

impl SwitchCourse {
    fn ratio(self) -> Option<f64> {
        match self {
            SwitchCourse::At(ratio) => Some(ratio),
            SwitchCourse::NotRecorded | SwitchCourse::Changed => None,
        }
    }
}

fn steady(channel: &Option<Channel<f64>>, range: &Range<f64>) -> SwitchCourse {
    let Some(own) = channel.as_ref().map(|channel| channel.during(range)) else {
        return SwitchCourse::NotRecorded;
    };
    match own.values.split_first() {
        // At 0 the machine is at rest, which is a feed hold instead of a ratio.
        None => SwitchCourse::NotRecorded,
        Some((first, rest)) if 0.0 < *first && rest.iter().all(|value| value == first) => {
            SwitchCourse::At(*first)
        }
        Some(_) => SwitchCourse::Changed,
    }
}
