//! Straight moves that a probe ends or the spindle drives.
//!
//! ```text
//! G31, G38.2 … G38.5 X Y Z   until the probe touches, at F     run to the end, as without contact
//! G33 X Y Z K                thread: K per revolution          feedrate K S
//! G33.1 X Y Z K              rigid tapping: as G33, then the spindle reverses and the tool
//!                            returns to the start
//! ```
//!
//! K is in the unit of length in force, S in rev/min. These words act in their own block alone. The point of
//! contact of a probe is unknown, so the time of probing is an upper bound, and the moves after it begin where the
//! tool is without contact. Not modelled: the wait of a thread for the spindle's index, and the overrun of the tap
//! while the spindle reverses.
//!
//! Source: LinuxCNC 2.9, G-code reference, G33, G33.1 and G38; Fanuc B-63944EN, G31.

use crate::simulation::interpreter::block::{AXIS_WORDS, Block};
use crate::simulation::interpreter::bounds::FEEDRATES_MM_S;
use crate::simulation::interpreter::code::Code;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::{Curve, Motion, Point};
use crate::units::mm_per_s;

impl Interpreter<'_> {
    /// Runs G31 and G38: a move to the end at the feedrate in force, with a full stop.
    pub(super) fn probe(&mut self, block: Block, code: Code) {
        self.remarks.add(block.place(), TraceRemark::Probing { code });
        let Some(target) = self.target(block) else { return };
        self.canonical.exact_stop = true;
        self.feed_to(block, target);
        self.probed = Some(self.canonical.position);
    }

    /// Runs G33 and, with the way back, G33.1.
    pub(super) fn thread(&mut self, block: Block, code: Code, is_tapping: bool) {
        if !self.given.has(AXIS_WORDS) {
            return;
        }
        let (Some(end), begin) = (self.target(block), self.canonical.position) else { return };
        let speed = self.functions.speed;
        let by_spindle = self.given.get(b'K').zip(speed).map(|(pitch, speed)| {
            let per_revolution = pitch.abs() * self.modal.unit;
            mm_per_s(per_revolution * speed)
        });
        let feedrate = by_spindle.filter(|feedrate| FEEDRATES_MM_S.contains(feedrate));
        if feedrate.is_none() {
            self.remarks.add(block.place(), TraceRemark::NoThreadFeed { code });
        }
        let feedrate = feedrate.unwrap_or_else(|| self.feedrate(block));
        self.canonical.exact_stop |= is_tapping;
        self.stroke(block, end, feedrate);
        if is_tapping {
            let turn = self.cycle.turn;
            self.turn_spindle(block, turn.reversed().code());
            self.stroke(block, begin, feedrate);
            self.turn_spindle(block, turn.code());
        }
    }

    /// Moves straight to `end` at a feedrate (mm/s).
    fn stroke(&mut self, block: Block, end: Point, feedrate: f64) {
        let length = (end - self.canonical.position).norm();
        self.push(block, end, Curve::Line, length, Motion::Feed { feedrate });
    }
}

#[cfg(test)]
mod tests {
    use crate::machine::Machine;
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;
    use crate::simulation::toolpath::{Motion, Segment, StopCause, Toolpath};

    fn run(text: &str) -> Toolpath {
        trace(&read(text.as_bytes()), &Machine::default())
    }

    /// Start, end and feedrate of every move.
    fn moves(toolpath: &Toolpath) -> Vec<([f64; 3], [f64; 3], Motion)> {
        let ends = |segment: Segment| (segment.start.into(), segment.end.into(), segment.motion);
        toolpath.segments.iter().map(ends).collect()
    }

    #[test]
    fn probing_goes_to_its_end_and_says_so() {
        for word in ["G31", "G38.2", "G38.3", "G38.4", "G38.5"] {
            let probed = run(&format!("G0 X1 Y1 Z5\nF30\n{word} Z-5\nX2\n"));
            let written = run("G0 X1 Y1 Z5\nF30\nG1 Z-5\nG0 X2\n");
            assert_eq!(moves(&probed), moves(&written), "{word}");
            assert!(probed.diagnostics.iter().any(|told| told.message.contains("probing")), "{word}");
        }
    }

    #[test]
    fn what_was_probed_is_where_it_ended() {
        let text = "%\nO1\nG0 Z5.\nG31 Z-3. F60\nG0 Z5.\nG1 Z[#5063 - 1.]\nM30\n";
        assert_eq!(run(text).segments.last().map(|segment| segment.end.z), Some(-4.0));
    }

    #[test]
    fn a_thread_is_fed_by_its_pitch_and_a_tap_comes_back() {
        for (unit, word, way_back) in [("G21", "G33", ""), ("G20", "G33", ""), ("G21", "G33.1", "Z5\n")] {
            let head = format!("{unit}\nS600 M3\nG0 Z5\n");
            let coupled = run(&format!("{head}{word} Z-5 K.5\n"));
            let written = run(&format!("{head}F300 G1 Z-5\n{way_back}"));
            assert_eq!(moves(&coupled), moves(&written), "{unit} {word}");
        }
        let tap = run("S600 M3\nG0 Z5\nG33.1 Z-5 K.5\n");
        let codes = tap.stops.iter().filter_map(|stop| match stop.cause {
            StopCause::Spindle { code, .. } => Some((stop.after, code?)),
            _ => None,
        });
        assert_eq!(codes.collect::<Vec<_>>(), [(0, 3), (2, 4), (3, 3)]);
        let lame = run("G0 Z5\nF60\nG33 Z-5 K1\n");
        assert!(lame.diagnostics.iter().any(|told| told.message.contains("spindle speed")));
    }
}
