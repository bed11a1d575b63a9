//! The verdict of a diagnosis, by its causes and by the lost time that they leave.
//!
//! | the remaining lost time asks for a cause if it is more than | |
//! |---|---|
//! | `MIN_LOST_TIME_S` s, and the known error of a calibrated machine file | always |
//! | `MAX_SILENT_PART` of the cycle time | always |
//! | [`MAX_REMAINING_PART`] of the lost time without causes | beside causes |
//!
//! Beside causes, more than `MIN_UNEXPLAINED_PART` of the lost time without them is large, however small a part of the
//! cycle time it is.
//!
//! A calibrated machine file is also known to be a little off in form. With any other machine file, a form error beyond
//! noise asks for a cause if none is named: an axis that sticks loses no time.
//!
//! A pace that pulsates asks for a cause too, however little time it loses. Actions of the operator explain runs in
//! spite of the remaining lost time if they are certain and explain more than that. This does not hold for an override
//! on lines that were chosen by the time lost there: it has a single ratio, so the lost time that it leaves speaks
//! against it, and for a place that is slow on parts of these lines.

use crate::identification::comparison::Comparison;
use crate::identification::diagnosis::standing::Standing;
use crate::identification::diagnosis::{Cause, MIN_LOST_TIME_S, Pulsation, Verdict};
use crate::identification::effects::FEED_OVERRIDE;
use crate::machine::Machine;

/// Most lost time that may remain unexplained without a message, as a part of the cycle time.
pub const MAX_SILENT_PART: f64 = 2e-3;
/// Most lost time that may remain beside causes, as a part of the lost time without them: no law matches that of a
/// control to the last per cent, and the error that it leaves is no other cause.
pub const MAX_REMAINING_PART: f64 = 0.05;
/// Least remaining part of the lost time without causes from which on the runs are not explained.
const MIN_UNEXPLAINED_PART: f64 = 0.25;
/// Least confidence of a certain cause.
const MIN_CERTAIN_CONFIDENCE: f64 = 0.9;

/// Lost time that causes leave.
pub struct Left {
    /// Lost time without the causes, s.
    pub before: f64,
    /// Lost time that remains with the causes, s.
    pub after: f64,
    /// Recorded time of all runs together, s.
    whole: f64,
    /// Known error of the machine file, as a part of the cycle time.
    known: f64,
    /// `true` if the machine file was calibrated and is off all the same.
    misses: bool,
    /// Pulsation of the pace; `None` if the pace does not pulsate.
    pulsation: Option<Pulsation>,
    /// `true` if the remaining form error exceeds noise and the known error of the machine file.
    is_off_in_form: bool,
}

impl Left {
    /// Returns the lost time that causes leave, given the lost time without and with them (s), and the comparisons of
    /// the runs with them.
    pub fn of(
        machine: &Machine,
        (before, after): (f64, f64),
        pulsation: Option<Pulsation>,
        compared: &[Comparison],
    ) -> Left {
        let whole = compared.iter().map(|comparison| comparison.whole.recorded).sum();
        let standing = Standing::of(machine);
        let (known, misses) = (standing.known_error(), standing == Standing::Misses);
        Left { before, after, whole, known, misses, pulsation, is_off_in_form: false }
    }

    /// Returns the lost time with a form that `is_off` by more than noise; a machine file that is known to be off
    /// excuses the form.
    pub fn with_form(self, is_off: bool) -> Left {
        Left { is_off_in_form: is_off && self.known == 0.0, ..self }
    }

    fn is_known(&self) -> bool {
        self.after <= self.known * self.whole
    }

    fn is_much_beside(&self, is_beside: bool) -> bool {
        is_beside && MIN_UNEXPLAINED_PART * self.before < self.after
    }

    /// Returns `true` if the lost time asks for a cause, or, if it `is_beside` others, for a further one.
    pub fn asks(&self, is_beside: bool) -> bool {
        let is_seen = MIN_LOST_TIME_S < self.after && !self.is_known();
        let beside = if is_beside { MAX_REMAINING_PART * self.before } else { 0.0 };
        let is_much = self.is_much_beside(is_beside) || beside.max(MAX_SILENT_PART * self.whole) < self.after;
        self.pulsation.is_some() || is_seen && is_much
    }

    /// Returns `true` if nothing but the form of the path asks for a cause.
    pub fn is_of_form(&self, causes: &[Cause]) -> bool {
        causes.is_empty() && self.is_off_in_form && !self.asks(false)
    }

    /// Returns the verdict on lost time for which causes were searched.
    pub fn verdict(&self, causes: &[Cause]) -> Verdict {
        let is_done = |cause: &&Cause| {
            let hypothesis = &cause.candidate.hypothesis;
            let is_placed = hypothesis.effect == FEED_OVERRIDE && !hypothesis.variant.is_empty();
            hypothesis.effect.is_by_operator() && !is_placed
        };
        let sure = causes.iter().filter(is_done).filter(|cause| MIN_CERTAIN_CONFIDENCE <= cause.confidence);
        let by_operator: f64 = sure.map(|cause| cause.seconds.abs()).sum();
        match (causes.is_empty(), self.asks(!causes.is_empty())) {
            (true, true) => Verdict::Unknown,
            (true, false) if self.is_of_form(causes) => Verdict::Unknown,
            (true, false) => Verdict::NothingMissing,
            _ if causes.iter().any(|cause| !cause.alike.is_empty()) => Verdict::Ambiguous,
            (false, true) if self.pulsation.is_some() => Verdict::Unknown,
            (false, true) if by_operator < self.after && self.is_much_beside(true) => Verdict::Unknown,
            _ => Verdict::Explained,
        }
    }

    /// Returns the message on the lost time for the user; `None` if there is nothing to report.
    pub fn message(&self, causes: &[Cause]) -> Option<String> {
        let Left { after, known, .. } = self;
        if self.misses && self.asks(false) {
            Some(
                "the machine file misses the runs that it was calibrated on: it does not describe this machine, so Truefeed \
                 names no cause"
                    .to_string(),
            )
        } else if !causes.is_empty() && self.asks(true) {
            Some(format!("no known cause explains the remaining {after:.2} s of lost time"))
        } else if MAX_SILENT_PART * self.whole < *after && self.is_known() {
            Some(format!(
                "{after:.2} s of lost time remain, within the {:.1} % by which the machine file may be off on this program",
                100.0 * known
            ))
        } else {
            None
        }
    }
}
