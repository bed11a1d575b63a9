//! Moves of Klartext: straight lines, arcs about a pole, polar coordinates, corners.
//!
//! A polar word gives the point at the radius PR and the angle PA about the pole CC, both counted from the last
//! ones if they are incremental. `CP IPA…` makes the turns of its angle; C without an end is a full circle.

use crate::machine::AXES;
use crate::simulation::gcode::{KlartextStatement, Reference, address};
use crate::simulation::interpreter::block::{Block, POLAR_WORDS};
use crate::simulation::interpreter::bounds::FEEDRATES_MM_S;
use crate::simulation::interpreter::compensation::Side;
use crate::simulation::interpreter::klartext::KlartextRemark;
use crate::simulation::interpreter::rotary::ROTARY_AXES;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::interpreter::words::Mode;
use crate::simulation::toolpath::compensation::{CornerShape, CornerTreatment};
use crate::simulation::toolpath::plane::Turn;
use crate::simulation::toolpath::{Arc, Motion, Point};
use std::f64::consts::TAU;

/// Smaller parts of a turn are rounding errors.
const ROUNDING_TURNS: f64 = 1e-9;

impl Interpreter<'_> {
    /// Runs L, LN and LP.
    pub(super) fn straight(&mut self, block: Block) {
        let mode = self.mode_of();
        self.modal.mode = Some(mode);
        if self.has_m(block, &[91.0, 92.0]) {
            self.settle_approach();
            self.uncompensated(|interpreter| interpreter.machine_coordinates(block));
            return;
        }
        self.absolute_angles();
        let Some(target) = self.target(block) else { return };
        self.read_rotary_words(block);
        let moves = self.moves_axes();
        match self.changed_side() {
            Some(Some(side)) if moves && self.klartext.beside.is_none() => {
                let motion = self.motion_of(block, mode, (target - self.canonical.position).norm());
                self.lead_in(block, side, target, motion);
                self.turn_remaining(block);
                return;
            }
            Some(side) => self.change_side(block, side),
            None => {}
        }
        if moves {
            match mode {
                Mode::Rapid => self.rapid_to(block, target),
                _ => self.feed_to(block, target),
            }
        }
        self.turn_remaining(block);
        self.retract(block);
    }

    /// Returns the motion of a move of `length` (mm).
    pub(super) fn motion_of(&mut self, block: Block, mode: Mode, length: f64) -> Motion {
        match mode {
            Mode::Rapid => Motion::RAPID,
            _ => Motion::Feed { feedrate: self.feedrate_along(block, length) },
        }
    }

    /// Returns the side by the word of the block, if it differs from the side in force.
    fn changed_side(&self) -> Option<Option<Side>> {
        let side_by_word = match self.given.get(address::SIDE)? {
            0.0 => None,
            side if 0.0 < side => Some(Side::Left),
            _ => Some(Side::Right),
        };
        (side_by_word != self.klartext.side).then_some(side_by_word)
    }

    /// Runs R0, or another side within a contour.
    fn change_side(&mut self, block: Block, side: Option<Side>) {
        self.settle_approach();
        self.klartext.side = side;
        match side {
            None => {
                self.klartext.beside = None;
                self.end_compensation_in_place();
            }
            Some(side) => {
                let diameter = self.tool_diameter();
                self.klartext.beside = Some(self.beside(block, side, diameter));
                self.compensate(block, Some((side, diameter)));
            }
        }
    }

    /// Runs M140: retracts along the tool axis, away from the part.
    fn retract(&mut self, block: Block) {
        if !self.has_m(block, &[140.0]) {
            return;
        }
        let axis = self.canonical.plane.axes()[2];
        let mut target = self.canonical.position;
        match self.given.get(address::RETRACTION) {
            Some(distance) if 0.0 <= distance => target[axis] += distance * self.modal.unit,
            _ => match self.machine.axes[axis].home {
                Some(home) => target[axis] = target[axis].max(home),
                None => {
                    let what =
                        "the end of travel is unknown: the retraction is not timed; set axis.z.home_mm";
                    self.remark(block.place(), KlartextRemark::Statement { name: "M140 MB MAX", what });
                }
            },
        }
        if self.is_within_reach(block, AXES[axis], target[axis]) {
            self.rapid_to(block, target);
        }
    }

    /// Converts incremental rotary words to absolute ones.
    fn absolute_angles(&mut self) {
        for (axis, letter) in ROTARY_AXES.into_iter().enumerate() {
            let letter = letter as u8;
            if let (Some(value), true) = (self.given.get(letter), self.given.is_incremental(letter, false)) {
                let at = self.rotary.position[axis] - self.frame.rotary_coordinate(axis, 0.0);
                self.given.set(letter, at.to_degrees() + value);
            }
        }
    }

    /// Runs CC; without words the pole is the position of the tool.
    pub(super) fn set_pole_here(&mut self, block: Block) {
        let at = self.frame.to_program(&self.canonical.position);
        let mut pole = if self.moves_axes() { self.klartext.pole.unwrap_or(at) } else { at };
        for (axis, letter) in AXES.into_iter().enumerate() {
            let Some(value) = self.given.get(letter as u8) else { continue };
            let value = value * self.modal.unit;
            let coordinate =
                if self.given.is_incremental(letter as u8, false) { at[axis] + value } else { value };
            if !self.is_within_reach(block, letter, coordinate) {
                return;
            }
            pole[axis] = coordinate;
        }
        if let (true, Some(point)) = (self.given.has(POLAR_WORDS), self.klartext_polar()) {
            for (axis, value) in point {
                pole[axis] = value;
            }
        }
        (self.klartext.pole, self.klartext.polar) = (Some(pole), None);
    }

    /// Returns the pole, program coordinates, mm; remarks on a missing one.
    fn pole(&mut self, block: Block) -> Point {
        if self.klartext.pole.is_none() {
            self.remark(block.place(), KlartextRemark::NoPole);
        }
        *self.klartext.pole.get_or_insert(Point::origin())
    }

    /// Runs C, CP, CR, CT and CTP.
    pub(super) fn klartext_arc(&mut self, block: Block, statement: KlartextStatement) {
        use KlartextStatement::{Circle, CircleByRadius, PolarCircle, PolarTangentialArc, TangentialArc};
        let sense = self.given.get(address::SENSE);
        if let Some(side) = self.changed_side() {
            self.change_side(block, side);
        }
        if let Some(sense) = sense {
            self.klartext.sense = sense;
        }
        let turn = if self.klartext.sense < 0.0 { Turn::Clockwise } else { Turn::Counterclockwise };
        let is_about_pole = matches!(statement, Circle | PolarCircle);
        if is_about_pole || statement == PolarTangentialArc {
            self.pole(block);
        }
        let Some(end) = self.target(block) else { return };
        self.absolute_angles();
        self.read_rotary_words(block);
        self.modal.mode = Some(Mode::Straight);
        match statement {
            CircleByRadius if self.given.get(address::CIRCLE_RADIUS).is_none() => {
                let (name, what, instead) = (statement.name(), "radius R", "taken as a straight line");
                self.remark(block.place(), KlartextRemark::Missing { name, what, instead });
                self.feed_to(block, end);
            }
            CircleByRadius => self.arc_to(block, end, turn),
            TangentialArc | PolarTangentialArc => self.tangential(block, end),
            _ => {
                let pole = self.pole(block);
                let [a, b, _] = self.canonical.plane.axes();
                for axis in [a, b] {
                    self.given.set(b"IJK"[axis], pole[axis] / self.modal.unit);
                    self.given.refer(b"IJK"[axis], Reference::Absolute);
                }
                let through = self.given.get(address::POLAR_ANGLE).map(f64::to_radians);
                let is_further = self.given.is_incremental(address::POLAR_ANGLE, false);
                if let Some(angle) = through.filter(|_| is_further) {
                    let turns = (angle.abs() / TAU - ROUNDING_TURNS).ceil() - 1.0;
                    self.given.set(address::TURNS, turns.max(0.0));
                }
                self.arc_to(block, end, turn);
            }
        }
        self.turn_remaining(block);
    }

    /// Runs an arc that begins in the direction of the last move.
    fn tangential(&mut self, block: Block, end: Point) {
        let normal = self.canonical.plane.axes()[2];
        let direction = self.klartext.direction;
        if direction.is_none() {
            let (name, what, instead) = ("CT", "move before it", "taken as a straight line");
            self.remark(block.place(), KlartextRemark::Missing { name, what, instead });
        }
        match direction.and_then(|direction| Arc::along(self.canonical.position, direction, end, normal)) {
            Some(arc) => self.feed_along(block, end, arc),
            None => self.feed_to(block, end),
        }
    }

    /// Runs RND and CHF, which treat the corner between the move before and the next one.
    pub(super) fn klartext_corner(&mut self, block: Block, statement: KlartextStatement) {
        let is_rounding = statement == KlartextStatement::Rounding;
        let unit = self.modal.unit;
        let per_minute = if unit == 1.0 { 1.0 } else { 0.1 * unit };
        let feedrate = self.given.get(b'F').map(|feed| feed * per_minute / 60.0);
        let feedrate = feedrate.filter(|feedrate| FEEDRATES_MM_S.contains(feedrate));
        let shape = if is_rounding {
            self.given
                .get(address::CIRCLE_RADIUS)
                .map(|radius| CornerShape::Rounding { radius: radius * unit })
        } else {
            self.given.get(address::CHAMFER_LEG).map(|leg| CornerShape::Chamfer { leg: leg * unit })
        };
        match shape {
            Some(shape) => self.treat_next_corner(block, CornerTreatment { shape, feedrate }),
            None => {
                let what = if is_rounding { "radius R" } else { "length" };
                let (name, instead) = (statement.name(), "the corner is not changed");
                self.remark(block.place(), KlartextRemark::Missing { name, what, instead });
            }
        }
    }
}
