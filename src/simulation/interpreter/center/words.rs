//! The centre of an arc and its turns, by the words of its block.

use crate::simulation::gcode::{Dialect, address, whole_number};
use crate::simulation::interpreter::block::{Block, CENTER_WORDS, POLAR_WORDS};
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::Point;
use crate::simulation::toolpath::plane::Turn;

/// Most turns of one arc.
const MAX_TURNS: u32 = 10_000;

impl Interpreter<'_> {
    /// Returns the centre by R, or by two of I, J and K, mm; a letter that is missing counts as the coordinate of
    /// the start.
    pub(crate) fn center(
        &mut self,
        block: Block,
        ends: (Point, Point),
        turn: Turn,
    ) -> Result<Point, TraceRemark> {
        let [a, b, _] = self.canonical.plane.axes();
        let axes = [(a, self.given.get(b"IJK"[a])), (b, self.given.get(b"IJK"[b]))];
        let has_center = axes.iter().any(|(_, value)| value.is_some());
        if let Some(radius) = self.given.get(b'R').or(self.siemens_radius(ends)) {
            if has_center {
                self.remarks.add(block.place(), TraceRemark::RadiusAndCenter);
            }
            return Ok(self.canonical.plane.center_of_radius(ends, turn, radius * self.modal.unit)?);
        }
        if !has_center {
            return self.pole_as_center(ends.0).ok_or(TraceRemark::NoCenter);
        }
        let mut center = ends.0;
        for (axis, value) in axes {
            let Some(value) = value.map(|value| value * self.modal.unit) else { continue };
            center[axis] = match self.given.is_incremental(b"IJK"[axis], self.modal.has_incremental_center) {
                true => ends.0[axis] + value,
                false if self.frame.turned().is_some() => value,
                false => self.frame.coordinate(axis, value),
            };
        }
        Ok(center)
    }

    /// Returns the number of turns of an arc: P, TURN of Siemens, or L of Fanuc's spirals and Yasnac's helices.
    pub(crate) fn turns(&mut self, block: Block) -> u32 {
        let further = self.given.get(address::TURNS).map(|value| value + 1.0);
        let by_p = self.given.get(b'P').or(further);
        let by_l = self.given.get(b'L').filter(|_| by_p.is_none() && self.dialect == Dialect::Iso);
        let [first, second, normal] = self.canonical.plane.axes().map(|axis| b"IJK"[axis]);
        // An arc without a centre in its plane gets an error, which is enough.
        let has_shape = [first, second, b'R'].into_iter().any(|letter| self.given.get(letter).is_some());
        let is_left_out = |letter: u8| has_shape && self.given.get(letter).is_some_and(|value| value != 0.0);
        for letter in [b'L', normal] {
            if is_left_out(letter) && !(letter == b'L' && by_l.is_some()) && self.is_control_of_letters() {
                let value = self.given.get(letter).unwrap_or_default();
                let value = if letter == b'L' { value } else { value * self.modal.unit };
                let remark = TraceRemark::ArcWordNotRun { letter: letter as char, value };
                self.remarks.add(block.place_of_letter(letter), remark);
            }
        }
        let letter = if by_l.is_some() { b'L' } else { b'P' };
        match by_p.or(by_l) {
            None => 1,
            Some(value) => match whole_number(value).filter(|turns| (1..=MAX_TURNS).contains(turns)) {
                Some(turns) => {
                    if by_l.is_some() && 1 < turns {
                        self.remarks.add(block.place_of_letter(letter), TraceRemark::TurnsByL { turns });
                    }
                    turns
                }
                None => {
                    let remark = TraceRemark::BadTurns { letter: letter as char, value };
                    self.remarks.add(block.place_of_letter(letter), remark);
                    1
                }
            },
        }
    }

    /// Returns `true` if words are single letters, each with a meaning by its block.
    pub(crate) fn is_control_of_letters(&self) -> bool {
        !matches!(self.dialect, Dialect::Siemens | Dialect::Klartext | Dialect::HeidenhainIso)
    }

    /// Returns the pole as the centre of an arc to a polar point, in the coordinates of its ends; `None` if the
    /// end is not polar.
    pub(crate) fn pole_as_center(&self, start: Point) -> Option<Point> {
        if self.dialect != Dialect::Siemens || !self.given.has(POLAR_WORDS) {
            return None;
        }
        let ([a, b, _], pole) = (self.canonical.plane.axes(), self.siemens.pole);
        let mut center = start;
        for axis in [a, b] {
            center[axis] = match self.frame.turned() {
                Some(_) => pole[axis],
                None => self.frame.coordinate(axis, pole[axis]),
            };
        }
        Some(center)
    }

    /// Returns the radius of CR, or the radius by AR and both ends, in the program's unit; negative for the longer
    /// arc.
    pub(crate) fn siemens_radius(&self, (start, end): (Point, Point)) -> Option<f64> {
        let has_center = self.given.has(CENTER_WORDS);
        let opening = self.given.get(address::OPENING_ANGLE);
        let opening = opening.filter(|angle| !has_center && (1e-6..360.0).contains(angle));
        let by_angle = opening.map(|degrees| {
            let [a, b, _] = self.canonical.plane.axes();
            let chord = (end[a] - start[a]).hypot(end[b] - start[b]) / self.modal.unit;
            let radius = 0.5 * chord / (0.5 * degrees.to_radians()).sin();
            if 180.0 < degrees { -radius } else { radius }
        });
        self.given.get(address::CIRCLE_RADIUS).or(by_angle)
    }
}
