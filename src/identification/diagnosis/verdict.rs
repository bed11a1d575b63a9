//! What a diagnosis comes to, by its causes and by the lost time that they leave.
//!
//! | what is left asks for a cause if it is more than | |
//! |---|---|
//! | `LEAST` s, and what the machine file was off by where it was calibrated | always |
//! | `LEFT` of the cycle time | always |
//! | [`BESIDE`] of what there was | beside causes |
//!
//! More than `MUCH` of what there was is much, beside causes, however little of the cycle time it is.
//!
//! Where a machine file was calibrated, it is also known to be a little off in form. Of another one a form error
//! that noise does not leave asks for a cause where none is named: an axis that sticks loses no time.
//!
//! So does a pace that pulsates, however little time it loses. What the operator did is explained all the same where
//! it is certain and more than what is left. That does not hold for an override on lines that were chosen by what was
//! lost there: it has one ratio, and what it leaves speaks against it, as for a place that is slow on parts of them.

use crate::identification::comparison::Comparison;
use crate::identification::diagnosis::standing::Standing;
use crate::identification::diagnosis::{Cause, LEAST, Pulsation, Verdict};
use crate::identification::effects::FEED_OVERRIDE;
use crate::machine::Machine;

/// What is left unexplained without a word, as a part of the cycle time.
const LEFT: f64 = 2e-3;
/// What may be left beside causes, as a part of what there was: no law is that of a control to the last per cent, and
/// what it leaves of its own is no other cause.
pub const BESIDE: f64 = 0.05;
/// What is left of what there was, from which on it is not explained.
const MUCH: f64 = 0.25;
/// A confidence from which on a cause is certain.
const CERTAIN: f64 = 0.9;

/// Lost time that causes leave.
pub struct Left {
    /// What there was, s.
    pub before: f64,
    /// What is left, s.
    pub after: f64,
    /// How long all runs together took, s.
    whole: f64,
    /// What the machine file is known to be off by, as a part of the cycle time.
    known: f64,
    /// Whether the machine file was calibrated and is off all the same.
    misses: bool,
    /// How its pace pulsates.
    pulsation: Option<Pulsation>,
    /// Whether the form that is left is off by more than noise and what the machine file is known to be off by.
    is_off_in_form: bool,
}

impl Left {
    /// Of the time that there was and is (s), by the comparison with the causes.
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

    /// The same where the form `is_off` by more than noise, unless the machine file is known to be off.
    pub fn with_form(self, is_off: bool) -> Left {
        Left { is_off_in_form: is_off && self.known == 0.0, ..self }
    }

    fn is_known(&self) -> bool {
        self.after <= self.known * self.whole
    }

    fn is_much_beside(&self, is_beside: bool) -> bool {
        is_beside && MUCH * self.before < self.after
    }

    /// Whether it asks for a cause, or, beside others, for a further one.
    pub fn asks(&self, is_beside: bool) -> bool {
        let is_seen = LEAST < self.after && !self.is_known();
        let beside = if is_beside { BESIDE * self.before } else { 0.0 };
        let is_much = self.is_much_beside(is_beside) || beside.max(LEFT * self.whole) < self.after;
        self.pulsation.is_some() || is_seen && is_much
    }

    /// Whether nothing but the form of the path asks for a cause.
    pub fn is_of_form(&self, causes: &[Cause]) -> bool {
        causes.is_empty() && self.is_off_in_form && !self.asks(false)
    }

    /// The verdict, of time that is looked for a cause of.
    pub fn verdict(&self, causes: &[Cause]) -> Verdict {
        let is_done = |cause: &&Cause| {
            let hypothesis = &cause.candidate.hypothesis;
            let is_placed = hypothesis.effect == FEED_OVERRIDE && !hypothesis.variant.is_empty();
            hypothesis.effect.is_by_operator() && !is_placed
        };
        let sure = causes.iter().filter(is_done).filter(|cause| CERTAIN <= cause.confidence);
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

    /// What to know of it, for people.
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
        } else if LEFT * self.whole < *after && self.is_known() {
            Some(format!(
                "{after:.2} s of lost time remain, within the {:.1} % by which the machine file may be off on this program",
                100.0 * known
            ))
        } else {
            None
        }
    }
}
