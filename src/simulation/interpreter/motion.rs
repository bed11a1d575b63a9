//! Moves: arcs and straight lines in rapid and in feed.

use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::feed_mode::FeedMode;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::plane::{Turn, tolerated_difference};
use crate::simulation::toolpath::{Arc, Curve, MIN_MOVE_MM, Motion, Point, Rotation};

impl Interpreter<'_> {
    /// Runs an arc in feed to `end`; without a circle, a straight line.
    pub(super) fn arc_to(&mut self, block: Block, end: Point, turn: Turn) {
        for letter in *b"IJKR" {
            let value = self.given.get(letter).unwrap_or_default() * self.modal.unit;
            if !self.is_within_reach(block, letter as char, value) {
                return;
            }
        }
        let (ends, turns) = ((self.canonical.position, end), self.turns(block));
        self.count_center_evidence(block, ends);
        let arc = match self.frame.turned().copied() {
            Some(chain) => self.turned_arc(block, chain, ends, turn, turns),
            None => {
                let center = self.center(block, ends, turn);
                center.and_then(|center| Ok(self.canonical.plane.arc(ends, center, turn, turns)?))
            }
        };
        match arc {
            Ok(arc) => {
                let (start, end_radius) = (arc.start_radius, arc.end_radius);
                if tolerated_difference(start) < (start - end_radius).abs() {
                    self.remarks.add(block.place(), TraceRemark::UnequalRadii { start, end: end_radius });
                }
                self.feed_along(block, end, arc);
            }
            Err(no_circle) => {
                self.remarks.add(block.place(), no_circle);
                self.feed_to(block, end);
            }
        }
    }

    /// Moves along an arc in feed.
    pub(super) fn feed_along(&mut self, block: Block, end: Point, arc: Arc) {
        let length = arc.length();
        let feedrate = self.feedrate_along(block, length);
        let feedrate = self.linear_share(block, length, feedrate);
        self.push(block, end, Curve::Arc(arc.into()), length, Motion::Feed { feedrate });
    }

    /// Moves straight to `end` in rapid.
    pub(super) fn rapid_to(&mut self, block: Block, end: Point) {
        let length = (end - self.canonical.position).norm();
        self.push(block, end, Curve::Line, length, self.rapid());
    }

    /// Returns the motion of a rapid, with the feedrate of G94 that is in force.
    pub(crate) fn rapid(&self) -> Motion {
        let per_minute = self.modal.feedrate.filter(|_| self.modal.feed.mode == FeedMode::PerMinute);
        Motion::Rapid { modal_feedrate: per_minute.unwrap_or(f64::INFINITY) }
    }

    /// Moves straight to `end` in feed.
    pub(super) fn feed_to(&mut self, block: Block, end: Point) {
        let length = (end - self.canonical.position).norm();
        if MIN_MOVE_MM <= length || self.canonical.is_beside() {
            let feedrate = self.feedrate_along(block, length);
            let feedrate = self.linear_share(block, length, feedrate);
            self.push(block, end, Curve::Line, length, Motion::Feed { feedrate });
        }
    }

    /// Adds a move, with the rotary axes that turn during it.
    pub(super) fn push(&mut self, block: Block, end: Point, curve: Curve, length: f64, motion: Motion) {
        if length < MIN_MOVE_MM && !self.canonical.is_beside() {
            self.turn_alone(block, motion.is_rapid());
            return;
        }
        if let Some(before_move) = self.heidenhain.as_ref().map(|own| own.before_move) {
            before_move(self, end, &curve, length);
        }
        let rotation = self.turned_along().map_or(Rotation::NONE, Rotation::from);
        let line = block.line;
        match (motion, curve) {
            (Motion::Rapid { modal_feedrate }, _) => {
                self.canonical.straight_traverse(line, (end, length), modal_feedrate, rotation);
            }
            (Motion::Feed { feedrate }, Curve::Line) => {
                self.canonical.straight_feed(line, (end, length), feedrate, rotation);
            }
            (Motion::Feed { feedrate }, Curve::Arc(arc)) => {
                self.canonical.arc_feed(line, (end, arc, length), feedrate, rotation);
            }
        }
        self.add_compensation_remarks();
    }
}
