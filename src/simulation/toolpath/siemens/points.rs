//! Points and arcs by the words of SINUMERIK programs alone.
//!
//! - AP and RP name a point about the pole of G110, G111 and G112; an arc to it goes around the pole.
//! - ANG with one coordinate of the end: a straight line at this angle to the first axis of the plane.
//! - CR, AR, CIP and CT give an arc by its radius, its opening angle, a point on it, its first direction.
//!
//! Source: SINUMERIK 840D sl, Programming Manual Fundamentals, 2013. Left out: two straight lines by
//! their angles and the end of the second.

use crate::machine::AXES;
use crate::simulation::gcode::{Dialect, address};
use crate::simulation::toolpath::block::{Block, CENTER_WORDS, POLAR_WORDS};
use crate::simulation::toolpath::plane::Turn;
use crate::simulation::toolpath::remark::Untraced;
use crate::simulation::toolpath::trace::Tracer;
use crate::simulation::toolpath::words::Mode;
use crate::simulation::toolpath::{Arc, Point};

impl Tracer<'_> {
    /// G110 to G112.
    pub(super) fn set_pole(&mut self, block: Block, code: u16) {
        let from = match code {
            110 => self.frame.to_program(&self.position),
            111 => Point::origin(),
            _ => self.siemens.pole,
        };
        let mut pole = from;
        for (axis, letter) in AXES.into_iter().enumerate() {
            let value = self.given.get(letter as u8).unwrap_or(0.0) * self.modal.unit;
            pole[axis] += value;
            if !self.is_within_reach(block, letter, pole[axis]) {
                return;
            }
        }
        self.siemens.pole = pole;
    }

    /// The program coordinates in the plane that AP and RP mean, mm.
    pub(in crate::simulation::toolpath) fn siemens_polar(&mut self) -> Option<[(usize, f64); 2]> {
        if self.dialect != Dialect::Siemens {
            return None;
        }
        let (angle, radius) = (self.given.get(address::POLAR_ANGLE), self.given.get(address::POLAR_RADIUS));
        if angle.is_none() && radius.is_none() {
            return None;
        }
        // IC counts from the last angle and radius, G91 does not.
        let from = |address, last| if self.given.is_incremental(address, false) { last } else { 0.0 };
        let last = self.siemens.polar;
        let polar = (
            angle.map_or(last.0, |angle| from(address::POLAR_ANGLE, last.0) + angle.to_radians()),
            radius.map_or(last.1, |radius| from(address::POLAR_RADIUS, last.1) + radius * self.modal.unit),
        );
        self.siemens.polar = polar;
        let ([a, b, _], (angle, radius)) = (self.modal.plane.axes(), polar);
        let pole = self.siemens.pole;
        Some([(a, pole[a] + radius * angle.cos()), (b, pole[b] + radius * angle.sin())])
    }

    /// CIP: the arc through a point of its own, in any plane of the axes.
    pub(super) fn arc_through(&mut self, block: Block) {
        let Some(end) = self.target(block) else { return };
        let mut middle = self.frame.to_program(&self.position);
        for (axis, address) in
            [address::MIDDLE_X, address::MIDDLE_Y, address::MIDDLE_Z].into_iter().enumerate()
        {
            if let Some(value) = self.given.get(address) {
                let value = value * self.modal.unit;
                let is_incremental = self.given.is_incremental(address, self.modal.is_incremental);
                middle[axis] = if is_incremental { middle[axis] + value } else { value };
            }
        }
        let middle = self.frame.to_machine(&middle);
        match Arc::through(self.position, middle, end) {
            Some(arc) => self.feed_along(block, end, arc),
            None => {
                self.remarks.add(block.place(), Untraced::NoArcThrough);
                self.feed_to(block, end);
            }
        }
    }

    /// CT: the arc that goes on in the direction of the last move.
    pub(super) fn tangential_arc(&mut self, block: Block) {
        let Some(end) = self.target(block) else { return };
        let direction = self.toolpath.segments.last().map(|last| last.tangent(last.length));
        let normal = self.modal.plane.axes()[2];
        match direction.and_then(|direction| Arc::along(self.position, direction, end, normal)) {
            Some(arc) => self.feed_along(block, end, arc),
            None => self.feed_to(block, end),
        }
    }

    /// The pole as the centre of an arc to a polar point, as the ends of the arc are given.
    pub(in crate::simulation::toolpath) fn pole_as_center(&self, start: Point) -> Option<Point> {
        if self.dialect != Dialect::Siemens || !self.given.has(POLAR_WORDS) {
            return None;
        }
        let ([a, b, _], pole) = (self.modal.plane.axes(), self.siemens.pole);
        let mut center = start;
        for axis in [a, b] {
            center[axis] = match self.frame.turned() {
                Some(_) => pole[axis],
                None => self.frame.coordinate(axis, pole[axis]),
            };
        }
        Some(center)
    }

    /// The coordinate in the plane that ANG gives to the other one, mm, in the distance mode in force.
    pub(in crate::simulation::toolpath) fn siemens_by_angle(
        &self,
        values: &[Option<f64>; 3],
    ) -> Option<(usize, f64)> {
        let angle = self.given.get(address::LINE_ANGLE)?.to_radians();
        let [a, b, _] = self.modal.plane.axes();
        let at = match self.modal.is_incremental {
            true => Point::origin(),
            false => self.frame.to_program(&self.position),
        };
        let (sine, cosine) = angle.sin_cos();
        match (values[a], values[b]) {
            (Some(value), None) if ALONG < cosine.abs() => Some((b, at[b] + (value - at[a]) * sine / cosine)),
            (None, Some(value)) if ALONG < sine.abs() => Some((a, at[a] + (value - at[b]) * cosine / sine)),
            _ => None,
        }
    }

    /// The end of an arc by its centre and opening angle, as the coordinates of the plane, mm, in the
    /// distance mode in force.
    pub(in crate::simulation::toolpath) fn siemens_by_opening(&self) -> Option<[(usize, f64); 2]> {
        let opening = self.given.get(address::OPENING_ANGLE)?.to_radians();
        let Some(Mode::Arc(turn)) = self.modal.mode else { return None };
        let [a, b, _] = self.modal.plane.axes();
        if !self.given.has(CENTER_WORDS)
            || [a, b].iter().any(|axis| self.given.get(AXES[*axis] as u8).is_some())
        {
            return None;
        }
        let at = self.frame.to_program(&self.position);
        let offset = |axis: usize| {
            let value = self.given.get(b"IJK"[axis])? * self.modal.unit;
            let is_incremental = self.given.is_incremental(b"IJK"[axis], self.modal.has_incremental_center);
            Some(if is_incremental { value } else { value - at[axis] })
        };
        let (u, v) = (offset(a).unwrap_or(0.0), offset(b).unwrap_or(0.0));
        let (sine, cosine) = if turn == Turn::Clockwise { -opening } else { opening }.sin_cos();
        // From the centre the start lies at (-u, -v).
        let end = [(a, u - u * cosine + v * sine), (b, v - u * sine - v * cosine)];
        let from = |axis: usize| if self.modal.is_incremental { 0.0 } else { at[axis] };
        Some(end.map(|(axis, step)| (axis, from(axis) + step)))
    }

    /// Says where ANG stands without an end.
    pub(super) fn check_angle(&mut self, block: Block) {
        let [a, b, _] = self.modal.plane.axes();
        let has_end = [a, b].into_iter().any(|axis| self.given.get(AXES[axis] as u8).is_some());
        if self.given.get(address::LINE_ANGLE).is_some() && !has_end {
            let what = "a line by its angle alone, whose end the next block gives, is not modelled: one straight line is run instead of two";
            self.remarks.add(block.place(), Untraced::Statement { name: "ANG", what });
        }
    }

    /// The radius of CR, or that which AR gives with both ends, in the program's unit; negative for
    /// the longer arc.
    pub(in crate::simulation::toolpath) fn siemens_radius(
        &self,
        (start, end): (Point, Point),
    ) -> Option<f64> {
        let has_center = self.given.has(CENTER_WORDS);
        let opening = self.given.get(address::OPENING_ANGLE);
        let opening = opening.filter(|angle| !has_center && (1e-6..360.0).contains(angle));
        let by_angle = opening.map(|degrees| {
            let [a, b, _] = self.modal.plane.axes();
            let chord = (end[a] - start[a]).hypot(end[b] - start[b]) / self.modal.unit;
            let radius = 0.5 * chord / (0.5 * degrees.to_radians()).sin();
            if 180.0 < degrees { -radius } else { radius }
        });
        self.given.get(address::CIRCLE_RADIUS).or(by_angle)
    }
}

/// A line is this far from square to an axis whose coordinate is to give the other one.
const ALONG: f64 = 1e-9;
