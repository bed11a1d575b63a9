//! From which segment to which each doubt reaches.

use crate::simulation::gcode::{Cause, Doubt, Effect, Letters, LineNumber, Word};
use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::doubt::letters;
use crate::simulation::interpreter::state::Interpreter;

/// Axes and centres.
const POSITIONS: Letters = Letters::AXES.with(Letters::of(b"UVW")).with(CENTRES);

const CENTRES: Letters = Letters::of(b"IJKR");

const FEED: Letters = Letters::of(b"F");

impl Interpreter<'_> {
    /// Takes over what reading left in doubt before the block that is run next.
    pub(crate) fn doubt_as_read(&mut self, doubts: &[Doubt]) {
        if doubts.is_empty() {
            return;
        }
        self.remarks.look_behind(self.canonical.segment_count());
        for doubt in doubts {
            self.remarks.doubt(doubt.line, doubt.cause, doubt.effect);
        }
    }

    /// A block that is not run, by its words.
    pub(crate) fn doubt_block(&mut self, line: LineNumber, words: &[Word]) {
        self.remarks.look_behind(self.canonical.segment_count());
        self.remarks.doubt(line, Cause::BlocksNotRun, Effect::Words(letters(words)));
    }

    /// Ends the doubts that `block`, which has just been run, resolves, and begins new ones.
    #[inline]
    pub(crate) fn follow_doubts(&mut self, block: Block) {
        if !self.doubts.is_empty() || self.doubts.seen < self.remarks.doubts.len() {
            self.end_and_begin_doubts(block);
        }
    }

    fn end_and_begin_doubts(&mut self, block: Block) {
        let given = letters(block.words);
        let (before, count) = (self.remarks.behind(), self.canonical.segment_count());
        let doubts = &mut self.remarks.doubts;
        self.doubts.open.retain_mut(|(index, letters)| {
            *letters = letters.without(given);
            // An axis moves from a doubtful position here; F and motion words hold from here on.
            let is_position = matches!(doubts[*index].effect, Effect::Words(_));
            doubts[*index].until = if is_position || !letters.is_empty() { count } else { before };
            !letters.is_empty()
        });
        let fresh = doubts.split_off(self.doubts.seen);
        for mut doubt in fresh {
            // What follows from the flow between blocks touches no move of the next block.
            if doubt.effect != Effect::Unbounded {
                doubt.until = count;
            }
            let is_feed_open = self.doubts.open.iter().any(|(_, letters)| letters.meets(FEED));
            let Effect::Words(missing) = doubt.effect else {
                if doubt.effect != Effect::Feed {
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
                    Effect::Words(missing.without(FEED.with(Letters::MOTION).with(Letters::CYCLE))),
                    true,
                ),
                (FEED, Effect::Feed, !is_feed_open && !given.meets(FEED)),
                (
                    Letters::MOTION,
                    Effect::MotionWord,
                    is_motion_modal && !is_motion_open && !given.meets(Letters::MOTION),
                ),
                (Letters::CYCLE, Effect::CycleWord, !is_motion_open),
                (POSITIONS.with(FEED), Effect::Hole, is_hole),
            ];
            for (letters, effect, is_open) in parts {
                if !missing.meets(letters) || !is_open {
                    continue;
                }
                doubts.push(Doubt { effect, ..doubt });
                let ends = match effect {
                    Effect::Words(missing) if self.modal.is_incremental => missing.without(POSITIONS),
                    Effect::Words(missing) => missing.without(CENTRES).without(given),
                    Effect::Hole => Letters::default(),
                    Effect::CycleWord => Letters::MOTION,
                    _ => letters,
                };
                if !ends.is_empty() {
                    self.doubts.open.push((doubts.len() - 1, ends));
                }
            }
        }
        self.doubts.seen = doubts.len();
    }
}
