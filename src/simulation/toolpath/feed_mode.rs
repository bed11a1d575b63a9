//! What F means.
//!
//! | mode | F                                   | feedrate of a move of length L, mm/s          |
//! |------|-------------------------------------|-----------------------------------------------|
//! | G93  | 1/min, for its own block alone      | L F / 60: the block lasts 1/F min             |
//! | G94  | mm/min, inch/min; deg/min of a turn | F / 60                                        |
//! | G95  | mm or inch per revolution           | F S / 60, S in rev/min                        |
//!
//! Each mode remembers its own F. Under G96 S is a surface speed, which needs the diameter that the
//! tool cuts at; it is left out, and G95 goes on with the last S in rev/min.
//!
//! Source: NIST RS274/NGC, Sect. 3.5.19; LinuxCNC, G93, G94, G95.

use crate::simulation::toolpath::block::{Block, bits};
use crate::simulation::toolpath::motion::{ASSUMED_FEEDRATE, SHORTEST};
use crate::simulation::toolpath::remark::Untraced;
use crate::simulation::toolpath::trace::Tracer;
use crate::units::{SECONDS_PER_MINUTE, mm_per_min, mm_per_s};

/// The feedrates that are taken at their word, mm/s.
pub(super) const FEEDRATES: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

/// The inverse times that are taken at their word, 1/min.
const INVERSE_TIMES: std::ops::RangeInclusive<f64> = 1e-6..=1e7;

/// What F counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FeedMode {
    /// G93.
    InverseTime,
    /// G94.
    PerMinute,
    /// G95.
    PerRevolution,
}

/// F in each mode, and what it counts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Feed {
    pub(super) mode: FeedMode,
    /// G93, 1/min.
    inverse_time: Option<f64>,
    /// G94 as written, in units of length or degrees per minute.
    pub(super) per_minute: Option<f64>,
    /// G95, mm.
    per_revolution: Option<f64>,
}

impl Default for Feed {
    fn default() -> Feed {
        let mode = FeedMode::PerMinute;
        Feed { mode, inverse_time: None, per_minute: None, per_revolution: None }
    }
}

impl Tracer<'_> {
    /// Millimetres in the unit of length that feeds are given in.
    pub(super) fn unit_of_feeds(&self) -> f64 {
        if self.siemens.leaves_feeds { 1.0 } else { self.modal.unit }
    }

    /// The value of F in a block that has one, by the mode in force.
    pub(super) fn take_feed(&mut self, block: Block, value: Option<f64>) {
        let Some(value) = value else { return };
        let length = value * self.unit_of_feeds();
        let is_possible = match self.modal.feed.mode {
            FeedMode::InverseTime => INVERSE_TIMES.contains(&value),
            FeedMode::PerMinute => FEEDRATES.contains(&mm_per_s(length)),
            FeedMode::PerRevolution => FEEDRATES.contains(&length),
        };
        if !is_possible {
            self.remarks.add(block.place_of_letter(b'F'), Untraced::BadFeed { value });
            return;
        }
        match self.modal.feed.mode {
            FeedMode::InverseTime => self.modal.feed.inverse_time = Some(value),
            FeedMode::PerRevolution => self.modal.feed.per_revolution = Some(length),
            FeedMode::PerMinute => {
                let feedrate = mm_per_s(length);
                self.modal.feedrate = Some(feedrate);
                self.modal.feed.per_minute = Some(value);
                if self.machine.rapid.feedrate < feedrate {
                    let (feedrate, rapid) = (mm_per_min(feedrate), mm_per_min(self.machine.rapid.feedrate));
                    let remark = Untraced::FasterThanRapid { feedrate, rapid };
                    self.remarks.add(block.place_of_letter(b'F'), remark);
                }
            }
        }
    }

    /// The feedrate in force of a move of `length` (mm), mm/s.
    pub(super) fn feedrate_along(&mut self, block: Block, length: f64) -> f64 {
        if let Some(feedrate) = self.siemens_block_feedrate() {
            return feedrate;
        }
        match self.modal.feed.mode {
            // Beside the contour a move without length may get one, for which no time is told.
            FeedMode::InverseTime if length < SHORTEST => self.feedrate(block),
            FeedMode::InverseTime => {
                let per_minute = self.per_minute_in_block(block);
                per_minute.map_or(ASSUMED_FEEDRATE, |rate| length * rate / SECONDS_PER_MINUTE)
            }
            FeedMode::PerMinute | FeedMode::PerRevolution => self.feedrate(block),
        }
    }

    /// The feedrate in force, mm/s. Under G93, where a move has none of its own, it is that of G94.
    pub(super) fn feedrate(&mut self, block: Block) -> f64 {
        if self.modal.feed.mode == FeedMode::PerRevolution {
            return self.feedrate_by_spindle(block);
        }
        self.modal.feedrate.unwrap_or_else(|| self.assumed_feedrate(block))
    }

    /// How fast rotary axes turn on their own, rad/s, given the length of their turn in rad.
    pub(super) fn rotary_feedrate(&mut self, block: Block, turn: f64) -> f64 {
        let degrees_per_minute = match self.modal.feed.mode {
            FeedMode::InverseTime => {
                let rate = self.per_minute_in_block(block);
                return turn * rate.unwrap_or(mm_per_min(ASSUMED_FEEDRATE)) / SECONDS_PER_MINUTE;
            }
            FeedMode::PerMinute => self.modal.feed.per_minute,
            FeedMode::PerRevolution => {
                Some(mm_per_min(self.feedrate_by_spindle(block)) / self.unit_of_feeds())
            }
        };
        let assumed = mm_per_min(ASSUMED_FEEDRATE);
        let degrees_per_minute = degrees_per_minute.unwrap_or_else(|| {
            self.remarks.add(block.place(), Untraced::NoFeed { assumed });
            assumed
        });
        degrees_per_minute.to_radians() / SECONDS_PER_MINUTE
    }

    /// F of a block under G93, 1/min; that of a block before where it has none.
    fn per_minute_in_block(&mut self, block: Block) -> Option<f64> {
        let own = self.given.get(b'F').filter(|value| INVERSE_TIMES.contains(value));
        if !self.given.has(bits(b"F")) {
            let assumed = self.modal.feed.inverse_time.is_none().then_some(mm_per_min(ASSUMED_FEEDRATE));
            self.remarks.add(block.place(), Untraced::NoInverseTime { assumed });
        }
        own.or(self.modal.feed.inverse_time)
    }

    fn feedrate_by_spindle(&mut self, block: Block) -> f64 {
        let Some(per_revolution) = self.modal.feed.per_revolution else {
            return self.assumed_feedrate(block);
        };
        let Some(speed) = self.functions.speed.filter(|speed| 0.0 < *speed) else {
            let assumed = mm_per_min(ASSUMED_FEEDRATE);
            self.remarks.add(block.place(), Untraced::NoSpindleSpeed { assumed });
            return ASSUMED_FEEDRATE;
        };
        mm_per_s(per_revolution * speed).clamp(*FEEDRATES.start(), *FEEDRATES.end())
    }

    fn assumed_feedrate(&mut self, block: Block) -> f64 {
        let assumed = mm_per_min(ASSUMED_FEEDRATE);
        self.remarks.add(block.place(), Untraced::NoFeed { assumed });
        ASSUMED_FEEDRATE
    }
}
