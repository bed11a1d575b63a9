//! What F means.
//!
//! | mode | F                                   | feedrate of a move of length L, mm/s          |
//! |------|-------------------------------------|-----------------------------------------------|
//! | G93  | 1/min, for its own block alone      | L F / 60: the block lasts 1/F min             |
//! | G94  | mm/min, inch/min; deg/min of a turn | F / 60                                        |
//! | G95  | mm or inch per revolution           | F S / 60, S in rev/min                        |
//!
//! Each mode remembers its own F, but what chooses another mode than G93 forgets it: controls refuse a feed move
//! until there is a new F, LinuxCNC even where the mode was in force already. Such a move is told, and run at the
//! former feedrate. Under G96 S is a surface speed, which needs the diameter that the
//! tool cuts at; it is left out, and G95 goes on with the last S in rev/min.
//!
//! Source: NIST RS274/NGC, Sect. 3.5.19; LinuxCNC, G93, G94, G95.

use crate::simulation::gcode::Dialect;
use crate::simulation::toolpath::block::{Block, bits};
use crate::simulation::toolpath::motion::{ASSUMED_FEEDRATE, SHORTEST};
use crate::simulation::toolpath::remark::{Code, Untraced};
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
    /// The G word after which there was no F yet, where it forgets the one before.
    pub(super) forgotten_by: Option<Code>,
}

impl Default for Feed {
    fn default() -> Feed {
        let mode = FeedMode::PerMinute;
        Feed { mode, inverse_time: None, per_minute: None, per_revolution: None, forgotten_by: None }
    }
}

impl Tracer<'_> {
    /// Millimetres in the unit of length that feeds are given in.
    pub(super) fn unit_of_feeds(&self) -> f64 {
        if self.siemens.leaves_feeds { 1.0 } else { self.modal.unit }
    }

    /// G93, G94 and G95.
    pub(super) fn choose_feed_mode(&mut self, code: Code, mode: FeedMode) {
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

    /// Tells that a move is run at the feedrate `former`, mm/s, which the mode in force forgot.
    fn tell_forgotten_feed(&mut self, block: Block, former: f64) -> f64 {
        if let Some(code) = self.modal.feed.forgotten_by.take() {
            self.remarks.add(block.place(), Untraced::ForgottenFeed { code, former: mm_per_min(former) });
        }
        former
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
            let feedrate = self.feedrate_by_spindle(block);
            return self.tell_forgotten_feed(block, feedrate);
        }
        match self.modal.feedrate {
            Some(feedrate) => self.tell_forgotten_feed(block, feedrate),
            None => self.assumed_feedrate(block),
        }
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
        if let Some(former) = degrees_per_minute {
            self.tell_forgotten_feed(block, mm_per_s(former * self.unit_of_feeds()));
        }
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
