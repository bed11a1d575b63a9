//! Execution of a plain block.

use crate::simulation::gcode::{Reference, Word};
use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::bounds::MAX_COORDINATE_MM;
use crate::simulation::interpreter::fast::plain::PlainBlockState;
use crate::simulation::interpreter::feed_mode::FeedMode;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::interpreter::words::Mode;
use crate::simulation::toolpath::MIN_MOVE_MM;
use crate::simulation::toolpath::Motion;
use crate::units::mm_per_s;

impl Interpreter<'_> {
    /// Runs a plain block. Returns `false`, without any effect, for all other blocks.
    pub(crate) fn plain_block(&mut self, block: Block) -> bool {
        self.plain = self.plain.or_else(|| self.plain_block_state());
        let Some(PlainBlockState { code, mut feedrate, same_feed }) = self.plain else { return false };
        if !block.statements.list.is_empty() {
            return false;
        }
        let (mut end, mut feed, mut has_axis) = (self.canonical.position, None, [false; 3]);
        for &Word { letter, value, reference, .. } in block.words {
            match letter {
                _ if reference != Reference::Modal => return false,
                b'X'..=b'Z' => {
                    let axis = usize::from(letter - b'X');
                    end[axis] = self.frame.coordinate(axis, value * self.modal.unit);
                    let is_first = !std::mem::replace(&mut has_axis[axis], true);
                    if !(is_first && end[axis].abs() <= MAX_COORDINATE_MM) {
                        return false;
                    }
                }
                b'F' if feed.is_none() => feed = Some(value),
                b'G' if value == code => {}
                _ => return false,
            }
        }
        let length = (end - self.canonical.position).norm();
        if length < MIN_MOVE_MM {
            return false;
        }
        if feed.is_some() && feed != same_feed {
            self.set_feed(block, feed);
            self.plain = None;
            feedrate = feedrate.and(self.modal.feedrate);
        }
        self.turning.names_y |= has_axis[1];
        let motion = feedrate.map_or_else(|| self.rapid(), |feedrate| Motion::Feed { feedrate });
        self.canonical.straight_plain(block.line, (end, length), motion);
        true
    }

    /// Returns the state for plain blocks, or `None` if anything in force affects a line.
    fn plain_block_state(&self) -> Option<PlainBlockState> {
        let touches_lines = self.modal.is_incremental
            || self.modal.feed.mode != FeedMode::PerMinute
            || self.modal.feed.forgotten_by.is_some()
            || self.frame.turned().is_some()
            || self.frame.polar.is_some()
            || self.cycle.is_active()
            || self.siemens.modal.is_some()
            || self.rotary.turn_along()
            || self.path_mode.has_exact_stop()
            || !self.canonical.is_idle();
        let (code, feedrate) = match self.modal.mode.filter(|_| !touches_lines)? {
            Mode::Rapid => (0.0, None),
            Mode::Straight => (1.0, Some(self.modal.feedrate?)),
            Mode::Arc(_) | Mode::Spline(_) => return None,
        };
        let is_same = |value: &f64| {
            let feedrate = mm_per_s(value * self.unit_of_feeds());
            self.modal.feedrate == Some(feedrate) && feedrate <= self.machine.fastest_rapid()
        };
        Some(PlainBlockState { code, feedrate, same_feed: self.modal.feed.per_minute.filter(is_same) })
    }
}
