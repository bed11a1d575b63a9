//! The feedrate of a move by the F words in force.

use crate::simulation::gcode::{Dialect, address};
use crate::simulation::interpreter::block::{Block, bits};
use crate::simulation::interpreter::bounds::{ASSUMED_FEEDRATE, FEEDRATES_MM_S};
use crate::simulation::interpreter::code::Code;
use crate::simulation::interpreter::feed_mode::FeedMode;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::MIN_MOVE_MM;
use crate::units::{SECONDS_PER_MINUTE, mm_per_min, mm_per_s};

/// The inverse times that count as meant, 1/min.
const INVERSE_TIMES_PER_MIN: std::ops::RangeInclusive<f64> = 1e-6..=1e7;

impl Interpreter<'_> {
    /// Returns the millimetres in the unit of length of feeds.
    pub(crate) fn unit_of_feeds(&self) -> f64 {
        if self.siemens.leaves_feeds { 1.0 } else { self.modal.unit }
    }

    /// Runs G93, G94 and G95.
    pub(crate) fn choose_feed_mode(&mut self, code: Code, mode: FeedMode) {
        let feed = &mut self.modal.feed;
        let forgets = feed.mode != mode || self.dialect == Dialect::LinuxCnc;
        let former = match mode {
            FeedMode::InverseTime => None,
            FeedMode::PerMinute => feed.per_minute,
            FeedMode::PerRevolution => feed.per_revolution,
        };
        feed.mode = mode;
        feed.forgotten_by = former.filter(|_| forgets).map(|_| code);
    }

    /// Remarks on a move at the feedrate `former`, mm/s, which the mode in force forgot, and returns it.
    fn remark_on_forgotten_feed(&mut self, block: Block, former: f64) -> f64 {
        if let Some(code) = self.modal.feed.forgotten_by.take() {
            self.remarks.add(block.place(), TraceRemark::ForgottenFeed { code, former: mm_per_min(former) });
        }
        former
    }

    /// Sets the feed of the mode in force by F of a block, if it has one.
    pub(crate) fn set_feed(&mut self, block: Block, value: Option<f64>) {
        let Some(value) = value else { return };
        let length = value * self.unit_of_feeds();
        let is_possible = match self.modal.feed.mode {
            FeedMode::InverseTime => INVERSE_TIMES_PER_MIN.contains(&value),
            FeedMode::PerMinute => FEEDRATES_MM_S.contains(&mm_per_s(length)),
            FeedMode::PerRevolution => FEEDRATES_MM_S.contains(&length),
        };
        if !is_possible {
            self.remarks.add(block.place_of_letter(b'F'), TraceRemark::BadFeed { value });
            return;
        }
        self.modal.feed.forgotten_by = None;
        match self.modal.feed.mode {
            FeedMode::InverseTime => self.modal.feed.inverse_time = Some(value),
            FeedMode::PerRevolution => self.modal.feed.per_revolution = Some(length),
            FeedMode::PerMinute => {
                let feedrate = mm_per_s(length);
                self.modal.feedrate = Some(feedrate);
                self.modal.feed.per_minute = Some(value);
                let rapid = self.machine.fastest_rapid();
                if rapid < feedrate {
                    let (feedrate, rapid) = (mm_per_min(feedrate), mm_per_min(rapid));
                    let remark = TraceRemark::FasterThanRapid { feedrate, rapid };
                    self.remarks.add(block.place_of_letter(b'F'), remark);
                }
            }
        }
    }

    /// Returns the feedrate in force for a move of `length` (mm), mm/s.
    pub(crate) fn feedrate_along(&mut self, block: Block, length: f64) -> f64 {
        if let Some(feedrate) = self.siemens_block_feedrate() {
            return feedrate;
        }
        match self.modal.feed.mode {
            // Beside the contour a move without length may get one; it has no time of its own.
            FeedMode::InverseTime if length < MIN_MOVE_MM => self.feedrate(block),
            FeedMode::InverseTime => {
                let per_minute = self.per_minute_in_block(block);
                per_minute.map_or(ASSUMED_FEEDRATE, |rate| length * rate / SECONDS_PER_MINUTE)
            }
            FeedMode::PerMinute | FeedMode::PerRevolution => self.feedrate(block),
        }
    }

    /// Returns the feedrate in force, mm/s. Under G93 a move without F takes the feedrate of G94.
    pub(crate) fn feedrate(&mut self, block: Block) -> f64 {
        if self.modal.feed.mode == FeedMode::PerRevolution {
            let feedrate = self.feedrate_by_spindle(block);
            return self.remark_on_forgotten_feed(block, feedrate);
        }
        match self.modal.feedrate {
            Some(feedrate) => self.remark_on_forgotten_feed(block, feedrate),
            None => self.assumed_feedrate(block),
        }
    }

    /// Returns the rate of rotary axes alone, rad/s, given the length of their turn in rad.
    pub(crate) fn rotary_feedrate(&mut self, block: Block, turn: f64) -> f64 {
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
        if let Some(former) = degrees_per_minute {
            self.remark_on_forgotten_feed(block, mm_per_s(former * self.unit_of_feeds()));
        }
        let degrees_per_minute = degrees_per_minute.unwrap_or_else(|| {
            self.remarks.add(block.place(), TraceRemark::NoFeed { assumed });
            assumed
        });
        degrees_per_minute.to_radians() / SECONDS_PER_MINUTE
    }

    /// Returns F of a block under G93, 1/min; without F the one of an earlier block.
    fn per_minute_in_block(&mut self, block: Block) -> Option<f64> {
        let own = self.given.get(b'F').filter(|value| INVERSE_TIMES_PER_MIN.contains(value));
        if !self.given.has(bits(b"F")) {
            let assumed = self.modal.feed.inverse_time.is_none().then_some(mm_per_min(ASSUMED_FEEDRATE));
            self.remarks.add(block.place(), TraceRemark::NoInverseTime { assumed });
        }
        own.or(self.modal.feed.inverse_time)
    }

    /// Returns the feedrate of G95 at the speed of the spindle, mm/s.
    fn feedrate_by_spindle(&mut self, block: Block) -> f64 {
        let Some(per_revolution) = self.modal.feed.per_revolution else {
            return self.assumed_feedrate(block);
        };
        let Some(speed) = self.functions.speed.filter(|speed| 0.0 < *speed) else {
            let assumed = mm_per_min(ASSUMED_FEEDRATE);
            self.remarks.add(block.place(), TraceRemark::NoSpindleSpeed { assumed });
            return ASSUMED_FEEDRATE;
        };
        mm_per_s(per_revolution * speed).clamp(*FEEDRATES_MM_S.start(), *FEEDRATES_MM_S.end())
    }

    /// Returns the feedrate of a move without F, mm/s, and remarks on it.
    fn assumed_feedrate(&mut self, block: Block) -> f64 {
        let assumed = mm_per_min(ASSUMED_FEEDRATE);
        self.remarks.add(block.place(), TraceRemark::NoFeed { assumed });
        ASSUMED_FEEDRATE
    }

    /// Returns the feedrate of FB, mm/s.
    pub(crate) fn siemens_block_feedrate(&self) -> Option<f64> {
        let feed = self.given.get(address::BLOCK_FEED)? * self.unit_of_feeds();
        let feedrate = match self.modal.feed.mode {
            FeedMode::PerMinute => mm_per_s(feed),
            FeedMode::PerRevolution => mm_per_s(feed * self.functions.speed?),
            FeedMode::InverseTime => return None,
        };
        FEEDRATES_MM_S.contains(&feedrate).then_some(feedrate)
    }
}
