//! The feedrate at which a control runs rapids: the programmed one, F, as in feed moves, or separate rates.
//!
//! Klipper and Marlin have no rapid: their G0 is G1. A rapid that holds F times the feed override, to the part
//! [`MAX_VELOCITY_DIFFERENCE_RATIO`], may be at its rate by coincidence, if a post-processor writes the rate of the machine as F.
//! Rapids at two different F that hold theirs do not, and a rapid that is faster than its F contradicts. A rapid that is slower
//! says nothing: a limit or its ramps held it back. Programs for a control with separate rates mostly leave F out of rapids,
//! and the F of the cut before is lower. If rapids hold one F, they therefore more likely run at it; the range of other
//! programs has room for both.
//!
//! Limits: a feed override that the recording does not state counts as 1.

use crate::identification::calibration::rapid_moves::{MAX_VELOCITY_DIFFERENCE_RATIO, RapidVelocity};

/// Least ratio of two feedrates that are different, many times that tolerance.
const MIN_FEEDRATE_RATIO: f64 = 1.1;

/// Evidence of the feedrate of rapids.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum RapidFeedrates {
    /// They run at the programmed one.
    Programmed,
    /// They run at separate rates.
    Separate,
    /// All hold this one (mm/s), which may be their rate by coincidence.
    OnlyOne(f64),
    /// Nothing shows it.
    #[default]
    Untold,
}

impl RapidFeedrates {
    /// Returns the evidence of rapids.
    pub fn of(rapids: &[RapidVelocity]) -> RapidFeedrates {
        let is_faster =
            |rapid: &RapidVelocity| (1.0 + MAX_VELOCITY_DIFFERENCE_RATIO) * rapid.feedrate < rapid.along();
        if rapids.iter().any(is_faster) {
            return RapidFeedrates::Separate;
        }
        let held = rapids.iter().filter(|rapid| !rapid.held.is_empty() && is_at_feedrate(rapid));
        let feedrates = held.map(|rapid| rapid.feedrate);
        let [least, largest] =
            feedrates.fold([f64::INFINITY, 0.0], |[least, largest], own| [least.min(own), largest.max(own)]);
        if MIN_FEEDRATE_RATIO * least < largest {
            RapidFeedrates::Programmed
        } else if 0.0 < largest {
            RapidFeedrates::OnlyOne(largest)
        } else {
            RapidFeedrates::Untold
        }
    }

    /// Returns the only feedrate that the rapids hold, mm/s; `None` if they hold several or none.
    pub fn only_one(self) -> Option<f64> {
        match self {
            RapidFeedrates::OnlyOne(feedrate) => Some(feedrate),
            _ => None,
        }
    }

    /// Returns `true` if rapids run at the programmed feedrate; `untold` if they do not say so.
    pub fn are_programmed(self, untold: bool) -> bool {
        match self {
            RapidFeedrates::Programmed | RapidFeedrates::OnlyOne(_) => true,
            RapidFeedrates::Separate => false,
            RapidFeedrates::Untold => untold,
        }
    }
}

/// Returns `true` if a rapid reaches its programmed feedrate and is no faster.
pub fn is_at_feedrate(rapid: &RapidVelocity) -> bool {
    (rapid.along() / rapid.feedrate - 1.0).abs() <= MAX_VELOCITY_DIFFERENCE_RATIO
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::toolpath::Vector;

    /// Returns the evidence of rapids, each of a feedrate and the velocity that it holds, mm/s.
    fn of(rapids: &[(f64, f64)]) -> RapidFeedrates {
        let held = |&(feedrate, along): &(f64, f64)| RapidVelocity {
            held: vec![along * Vector::new(0.6, 0.8, 0.0)],
            feedrate,
            ..RapidVelocity::default()
        };
        RapidFeedrates::of(&rapids.iter().map(held).collect::<Vec<RapidVelocity>>())
    }

    #[test]
    fn two_feedrates_that_rapids_hold_are_no_coincidence() {
        assert_eq!(of(&[(20.0, 20.02), (50.0, 49.9)]), RapidFeedrates::Programmed);
        // An axis may hold back the faster one.
        assert_eq!(of(&[(20.0, 20.0), (50.0, 50.0), (90.0, 60.0)]), RapidFeedrates::Programmed);
        assert_eq!(of(&[(20.0, 20.0), (50.0, 40.0)]), RapidFeedrates::OnlyOne(20.0));
        assert_eq!(of(&[(50.0, 50.0), (50.0, 50.0)]).only_one(), Some(50.0));
        assert_eq!(of(&[(f64::INFINITY, 50.0)]), RapidFeedrates::Untold);
        assert_eq!(of(&[]), RapidFeedrates::Untold);
    }

    #[test]
    fn a_rapid_faster_than_its_feedrate_has_a_separate_rate() {
        assert_eq!(of(&[(20.0, 20.0), (50.0, 50.0), (15.0, 60.0)]), RapidFeedrates::Separate);
    }
}
