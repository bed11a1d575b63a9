//! Points by radius r and angle φ in the plane: pole + r (cos φ, sin φ) along its two axes.
//!
//! - G16 … G15 (Fanuc, Haas): the word of the plane's first axis is r (in units of length), the word of the second
//!   φ (degrees). The pole is the origin of program coordinates; a radius under G91 makes the position its pole. An
//!   angle under G91 adds to the angle before. A missing word keeps its value.
//! - `@` and `^` (LinuxCNC): r and φ about the origin, under G91 added to those of the position.

use crate::machine::AXES;
use crate::simulation::gcode::address;
use crate::simulation::interpreter::block::bits;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::Point;

/// A direction of polar coordinates: its pole in the plane, mm, and its angle, rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Ray {
    pole: [f64; 2],
    angle: f64,
}

/// Polar coordinates in force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Polar {
    last: Ray,
    /// The ray of the last computed point, and that point in program coordinates: the ray becomes `last` once the
    /// tool is at the point.
    ahead: Option<(Ray, [f64; 2])>,
}

/// Largest distance of the tool from a point at which it is there, mm.
const MAX_ARRIVAL_DISTANCE_MM: f64 = 1e-6;

/// Words of a point by an angle or a radius.
const BY_ANGLE: u64 =
    bits(&[address::POLAR_RADIUS, address::POLAR_ANGLE, address::LINE_ANGLE, address::OPENING_ANGLE]);

impl Interpreter<'_> {
    /// Returns the words for X, Y and Z in mm, as increments under G91. For a point by radius and angle they are
    /// computed.
    pub(crate) fn axis_values(&mut self) -> [Option<f64>; 3] {
        let mut values = AXES.map(|axis| self.given.get(axis as u8).map(|value| value * self.modal.unit));
        self.refer_to_mode(&mut values);
        if !self.given.has(BY_ANGLE) && self.frame.polar.is_none() {
            return values;
        }
        let [a, b, _] = self.canonical.plane.axes();
        if let Some((axis, value)) = self.siemens_by_angle(&values) {
            values[axis] = Some(value);
        }
        for (axis, value) in self.siemens_by_opening().into_iter().flatten() {
            values[axis] = Some(value);
        }
        if let Some(point) = self.siemens_polar().or_else(|| self.klartext_polar()) {
            let at = self.frame.to_program(&self.canonical.position);
            for (axis, value) in point {
                values[axis] = Some(if self.modal.is_incremental { value - at[axis] } else { value });
            }
            return values;
        }
        let has_polar_words = self.given.has(bits(&[address::POLAR_RADIUS, address::POLAR_ANGLE]));
        if !has_polar_words && self.frame.polar.is_none() {
            return values;
        }
        let at = self.frame.to_program(&self.canonical.position);
        let point = if has_polar_words {
            let radius = self.given.get(address::POLAR_RADIUS).map(|value| value * self.modal.unit);
            let angle = self.given.get(address::POLAR_ANGLE).map(f64::to_radians);
            about_origin([at[a], at[b]], radius, angle, self.modal.is_incremental)
        } else if values[a].is_some() || values[b].is_some() {
            let angle = self.given.get(AXES[b] as u8).map(f64::to_radians);
            self.modal_polar(&at, values[a], angle)
        } else {
            return values;
        };
        for (axis, value) in [a, b].into_iter().zip(point) {
            values[axis] = Some(if self.modal.is_incremental { value - at[axis] } else { value });
        }
        values
    }

    /// Converts words that state their reference point to the distance mode in force.
    fn refer_to_mode(&mut self, values: &mut [Option<f64>; 3]) {
        if !self.given.refers() {
            return;
        }
        let is_incremental = self.modal.is_incremental;
        let others = AXES.map(|axis| self.given.is_incremental(axis as u8, is_incremental) != is_incremental);
        if others == [false; 3] {
            return;
        }
        let at = self.frame.to_program(&self.canonical.position);
        for axis in (0..3).filter(|axis| others[*axis]) {
            values[axis] =
                values[axis].map(|value| if is_incremental { value - at[axis] } else { at[axis] + value });
        }
    }

    /// Returns the point of G16 in the plane, in program coordinates, mm.
    fn modal_polar(&mut self, at: &Point, radius: Option<f64>, angle: Option<f64>) -> [f64; 2] {
        let is_incremental = self.modal.is_incremental;
        let [a, b, _] = self.canonical.plane.axes();
        let at = [at[a], at[b]];
        let polar = self.frame.polar.get_or_insert_default();
        if let Some((ray, there)) = polar.ahead
            && (at[0] - there[0]).hypot(at[1] - there[1]) < MAX_ARRIVAL_DISTANCE_MM
        {
            polar.last = ray;
        }
        let pole = match radius {
            Some(_) if is_incremental => at,
            Some(_) => [0.0; 2],
            None => polar.last.pole,
        };
        let angle = match angle {
            Some(angle) if is_incremental => polar.last.angle + angle,
            Some(angle) => angle,
            None => polar.last.angle,
        };
        let radius = radius.unwrap_or((at[0] - pole[0]).hypot(at[1] - pole[1]));
        let point = [pole[0] + radius * angle.cos(), pole[1] + radius * angle.sin()];
        polar.ahead = Some((Ray { pole, angle }, point));
        point
    }
}

/// Returns the point of `@` and `^` about the origin of the plane, mm.
fn about_origin(at: [f64; 2], radius: Option<f64>, angle: Option<f64>, is_incremental: bool) -> [f64; 2] {
    let (now, heading) = (at[0].hypot(at[1]), at[1].atan2(at[0]));
    let (radius, angle) = if is_incremental {
        (now + radius.unwrap_or_default(), heading + angle.unwrap_or_default())
    } else {
        (radius.unwrap_or(now), angle.unwrap_or(heading))
    };
    [radius * angle.cos(), radius * angle.sin()]
}
