//! First and last segment of each doubt.

use crate::simulation::gcode::{Doubt, DoubtCause, DoubtEffect, Letters, LineNumber, Word};
use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::doubt::letters;
use crate::simulation::interpreter::state::Interpreter;

/// Letters of axes and centres.
const POSITIONS: Letters = Letters::AXES.with(Letters::of(b"UVW")).with(CENTRES);

/// Letters of centres.
const CENTRES: Letters = Letters::of(b"IJKR");

/// The letter of feedrates.
const FEED: Letters = Letters::of(b"F");

impl Interpreter<'_> {
    /// Adds the doubts of reading before the block that is run next.
    pub(crate) fn add_doubts_of_reading(&mut self, doubts: &[Doubt]) {
        if doubts.is_empty() {
            return;
        }
        self.remarks.set_place(self.canonical.segment_count());
        for doubt in doubts {
            self.remarks.doubt(doubt.line, doubt.cause, doubt.effect);
        }
    }

    /// Adds the doubt about a block that is not run, by its words.
    pub(crate) fn doubt_block(&mut self, line: LineNumber, words: &[Word]) {
        self.remarks.set_place(self.canonical.segment_count());
        self.remarks.doubt(line, DoubtCause::BlocksNotRun, DoubtEffect::Words(letters(words)));
    }

    /// Ends the doubts that `block`, which has just been run, resolves, and starts new ones.
    #[inline]
    pub(crate) fn follow_doubts(&mut self, block: Block) {
        if !self.doubts.is_empty() || self.doubts.read < self.remarks.doubts.len() {
            self.end_and_begin_doubts(block);
        }
    }

    /// Ends resolved doubts and splits new ones by the letters that end them.
    fn end_and_begin_doubts(&mut self, block: Block) {
        let given = letters(block.words);
        let (before, count) = (self.remarks.place(), self.canonical.segment_count());
        let doubts = &mut self.remarks.doubts;
        self.doubts.open.retain_mut(|(index, letters)| {
            *letters = letters.without(given);
            // An axis moves from a doubtful position here; F and motion words are in force from here on.
            let is_position = matches!(doubts[*index].effect, DoubtEffect::Words(_));
            doubts[*index].until = if is_position || !letters.is_empty() { count } else { before };
            !letters.is_empty()
        });
        let fresh = doubts.split_off(self.doubts.read);
        for mut doubt in fresh {
            // A fault in the flow between blocks affects no move of the next block.
            if doubt.effect != DoubtEffect::Unbounded {
                doubt.until = count;
            }
            let is_feed_open = self.doubts.open.iter().any(|(_, letters)| letters.meets(FEED));
            let DoubtEffect::Words(missing) = doubt.effect else {
                if doubt.effect != DoubtEffect::Feed {
                    doubts.push(doubt);
                } else if !is_feed_open {
                    doubts.push(doubt);
                    self.doubts.open.push((doubts.len() - 1, FEED));
                }
                continue;
            };
            let is_motion_open = self.doubts.open.iter().any(|(_, letters)| letters.meets(Letters::MOTION));
            let is_hole = self.cycle.is_active() || self.siemens.modal.is_some();
            let is_motion_modal = !self.dialect.names_each_motion();
            let parts = [
                (
                    POSITIONS,
                    DoubtEffect::Words(missing.without(FEED.with(Letters::MOTION).with(Letters::CYCLE))),
                    true,
                ),
                (FEED, DoubtEffect::Feed, !is_feed_open && !given.meets(FEED)),
                (
                    Letters::MOTION,
                    DoubtEffect::MotionWord,
                    is_motion_modal && !is_motion_open && !given.meets(Letters::MOTION),
                ),
                (Letters::CYCLE, DoubtEffect::CycleWord, !is_motion_open),
                (POSITIONS.with(FEED), DoubtEffect::Hole, is_hole),
            ];
            for (letters, effect, is_open) in parts {
                if !missing.meets(letters) || !is_open {
                    continue;
                }
                doubts.push(Doubt { effect, ..doubt });
                let ends = match effect {
                    DoubtEffect::Words(missing) if self.modal.is_incremental => missing.without(POSITIONS),
                    DoubtEffect::Words(missing) => missing.without(CENTRES).without(given),
                    DoubtEffect::Hole => Letters::default(),
                    DoubtEffect::CycleWord => Letters::MOTION,
                    _ => letters,
                };
                if !ends.is_empty() {
                    self.doubts.open.push((doubts.len() - 1, ends));
                }
            }
        }
        self.doubts.read = doubts.len();
    }
}
