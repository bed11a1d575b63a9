//! Points by an angle or a radius in the words of SINUMERIK and TNC controls: AP, RP, ANG and AR, PA and PR.

use crate::machine::AXES;
use crate::simulation::gcode::{Dialect, address};
use crate::simulation::interpreter::block::{CENTER_WORDS, POLAR_WORDS};
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::interpreter::words::Mode;
use crate::simulation::toolpath::Point;
use crate::simulation::toolpath::plane::Turn;

impl Interpreter<'_> {
    /// Returns the program coordinates in the plane by AP and RP, mm.
    pub(crate) fn siemens_polar(&mut self) -> Option<[(usize, f64); 2]> {
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
        let ([a, b, _], (angle, radius)) = (self.canonical.plane.axes(), polar);
        let pole = self.siemens.pole;
        Some([(a, pole[a] + radius * angle.cos()), (b, pole[b] + radius * angle.sin())])
    }

    /// Returns the coordinate in the plane that follows from ANG and the other one, mm, in the distance mode in
    /// force.
    pub(crate) fn siemens_by_angle(&self, values: &[Option<f64>; 3]) -> Option<(usize, f64)> {
        let angle = self.given.get(address::LINE_ANGLE)?.to_radians();
        let [a, b, _] = self.canonical.plane.axes();
        let at = match self.modal.is_incremental {
            true => Point::origin(),
            false => self.frame.to_program(&self.canonical.position),
        };
        let (sine, cosine) = angle.sin_cos();
        match (values[a], values[b]) {
            (Some(value), None) if MIN_COSINE < cosine.abs() => {
                Some((b, at[b] + (value - at[a]) * sine / cosine))
            }
            (None, Some(value)) if MIN_COSINE < sine.abs() => {
                Some((a, at[a] + (value - at[b]) * cosine / sine))
            }
            _ => None,
        }
    }

    /// Returns the end of an arc by its centre and opening angle, as the coordinates of the plane, mm, in the
    /// distance mode in force.
    pub(crate) fn siemens_by_opening(&self) -> Option<[(usize, f64); 2]> {
        let opening = self.given.get(address::OPENING_ANGLE)?.to_radians();
        let Some(Mode::Arc(turn)) = self.modal.mode else { return None };
        let [a, b, _] = self.canonical.plane.axes();
        if !self.given.has(CENTER_WORDS)
            || [a, b].iter().any(|axis| self.given.get(AXES[*axis] as u8).is_some())
        {
            return None;
        }
        let at = self.frame.to_program(&self.canonical.position);
        let offset = |axis: usize| {
            let value = self.given.get(b"IJK"[axis])? * self.modal.unit;
            let is_incremental = self.given.is_incremental(b"IJK"[axis], self.modal.has_incremental_center);
            Some(if is_incremental { value } else { value - at[axis] })
        };
        let (u, v) = (offset(a).unwrap_or(0.0), offset(b).unwrap_or(0.0));
        let (sine, cosine) = if turn == Turn::Clockwise { -opening } else { opening }.sin_cos();
        // Relative to the centre the start is at (-u, -v).
        let end = [(a, u - u * cosine + v * sine), (b, v - u * sine - v * cosine)];
        let from = |axis: usize| if self.modal.is_incremental { 0.0 } else { at[axis] };
        Some(end.map(|(axis, step)| (axis, from(axis) + step)))
    }

    /// Returns the program coordinates in the plane by PR and PA, mm.
    pub(crate) fn klartext_polar(&mut self) -> Option<[(usize, f64); 2]> {
        if !self.is_heidenhain() || !self.given.has(POLAR_WORDS) {
            return None;
        }
        let pole = self.klartext.pole.unwrap_or(Point::origin());
        let at = self.frame.to_program(&self.canonical.position);
        let [a, b, _] = self.canonical.plane.axes();
        let (from_a, from_b) = (at[a] - pole[a], at[b] - pole[b]);
        let (mut angle, mut radius) =
            self.klartext.polar.unwrap_or((from_b.atan2(from_a), from_a.hypot(from_b)));
        if let Some(given) = self.given.get(address::POLAR_ANGLE).map(f64::to_radians) {
            let is_further = self.given.is_incremental(address::POLAR_ANGLE, false);
            angle = if is_further { angle + given } else { given };
        }
        if let Some(given) = self.given.get(address::POLAR_RADIUS).map(|radius| radius * self.modal.unit) {
            let is_further = self.given.is_incremental(address::POLAR_RADIUS, false);
            radius = if is_further { radius + given } else { given };
        }
        self.klartext.polar = Some((angle, radius));
        Some([(a, pole[a] + radius * angle.cos()), (b, pole[b] + radius * angle.sin())])
    }
}

/// Least cosine of the angle between a line and an axis from whose coordinate the other one follows.
const MIN_COSINE: f64 = 1e-9;
