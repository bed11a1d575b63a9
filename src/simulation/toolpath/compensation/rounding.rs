//! Roundings and chamfers between two programmed moves.
//!
//! A rounding of radius ρ is the arc that touches both moves inside their corner. Its centre is the point where
//! the parallels of both moves meet, at the distance ρ on the inside; its ends are the feet of the perpendiculars
//! from that centre. A chamfer joins two straight moves by a straight line, from the length c before the corner to
//! c behind it; a chamfer of width w has c = w / (2 cos(τ/2)), with τ the angle by which the contour turns. Both
//! moves must keep some length. Over the corner the height changes evenly.
//!
//! A corner that does not turn remains unchanged.
//!
//! Source: elementary; the words are those of Siemens (RND, RNDM, CHR, CHF, FRC) and Klartext
//! (RND, CHF), and of `,R` and `,C` on Fanuc.

use crate::simulation::toolpath::compensation::geometry::{
    PlanarCurve, PlanarShape, Point2, ROUNDING_MM, angle,
};
use crate::simulation::toolpath::compensation::planar::{draw, height, planar_curve};
use crate::simulation::toolpath::compensation::remark::CompensationRemark;
use crate::simulation::toolpath::plane::Plane;
use crate::simulation::toolpath::{Motion, Segment};
use std::f64::consts::{PI, TAU};

/// Smaller turns are no corner; a turn this close to a reversal leaves no room, rad.
const SLIGHT_TURN_RAD: f64 = 1e-4;

/// The shape that replaces a corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum CornerShape {
    /// An arc that touches both moves: RND, `,R`.
    Rounding {
        /// Radius, mm.
        radius: f64,
    },
    /// A straight line that shortens both moves by this length: CHR, `,C`, CHF of Klartext.
    Chamfer {
        /// Length taken from each move, mm.
        leg: f64,
    },
    /// A straight line of this length: CHF of Siemens.
    ChamferWidth {
        /// Length of the chamfer, mm.
        width: f64,
    },
}

/// A shape that replaces a corner, with its feedrate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CornerTreatment {
    pub(crate) shape: CornerShape,
    /// Feedrate of the new move alone, mm/s; `None` for the feedrate of the move before it.
    pub(crate) feedrate: Option<f64>,
}

impl CornerTreatment {
    pub(crate) fn name(&self) -> &'static str {
        match self.shape {
            CornerShape::Rounding { .. } => "rounding",
            _ => "chamfer",
        }
    }

    /// Returns the radius, the leg or the width, mm.
    pub(crate) fn size(&self) -> f64 {
        let (CornerShape::Rounding { radius: size }
        | CornerShape::Chamfer { leg: size }
        | CornerShape::ChamferWidth { width: size }) = self.shape;
        size
    }
}

/// Two moves and the new one between them; each is `None` if it has no length.
#[derive(Debug)]
pub(super) struct Treated {
    pub(super) before: Option<Segment>,
    pub(super) corner: Option<Segment>,
    pub(super) after: Option<Segment>,
}

/// Returns the two moves, shortened, with the new one between them, or `None` if there is no corner.
///
/// # Errors
///
/// If the moves leave no room for the treatment, or are not in the plane.
pub(super) fn treat(
    plane: Plane,
    (one, two): (&Segment, &Segment),
    treatment: &CornerTreatment,
) -> Result<Option<Treated>, CompensationRemark> {
    let name = treatment.name();
    let (Some(before), Some(after)) = (planar_curve(plane, one), planar_curve(plane, two)) else {
        return Err(CompensationRemark::NotInPlane { name });
    };
    let turn = angle(before.end_direction(), after.start_direction());
    let bridge = match treatment.shape {
        _ if turn.abs() < SLIGHT_TURN_RAD || treatment.size() < ROUNDING_MM => return Ok(None),
        _ if PI - SLIGHT_TURN_RAD < turn.abs() => None,
        CornerShape::Rounding { radius } => touching_arc(&before, &after, radius, turn),
        _ if !before.is_line() || !after.is_line() => return Err(CompensationRemark::NotInPlane { name }),
        CornerShape::Chamfer { leg } => chamfer(&before, &after, leg),
        CornerShape::ChamferWidth { width } => chamfer(&before, &after, 0.5 * width / (0.5 * turn).cos()),
    };
    let Some(PlanarCurve { start: from, end: to, shape, sweep }) = bridge else {
        return Err(CompensationRemark::NoRoom { name });
    };
    let (Some(kept_before), Some(kept_after)) =
        (kept_part(&before, before.start, from), kept_part(&after, to, after.end))
    else {
        return Err(CompensationRemark::NoRoom { name });
    };
    let (low, corner, high) = (height(plane, one.start), height(plane, one.end), height(plane, two.end));
    let motion = treatment.feedrate.map_or(one.motion, |feedrate| Motion::Feed { feedrate });
    let between = Segment {
        motion,
        exact_stop: false,
        rotation: crate::simulation::toolpath::Rotation::NONE,
        ..one.clone()
    };
    let (from, from_height) = match kept_before.is_nothing() {
        true => (before.start, low),
        false => (from, low + (corner - low) * kept_before.share),
    };
    let (to, to_height) = match kept_after.is_nothing() {
        true => (after.end, high),
        false => (to, high + (corner - high) * kept_after.share),
    };
    let before = draw(plane, one, one.start, (&before.shape, kept_before.length), (from, from_height));
    let at = before.as_ref().map_or(one.start, |segment| segment.end);
    let corner = draw(plane, &between, at, (&shape, sweep), (to, to_height));
    let at = corner.as_ref().map_or(at, |segment| segment.end);
    let after = draw(plane, two, at, (&after.shape, kept_after.length), (after.end, high));
    if after.as_ref().map_or(at, |segment| segment.end) != two.end {
        return Err(CompensationRemark::NoRoom { name });
    }
    Ok(Some(Treated { before, corner, after }))
}

/// The part of a curve that a corner leaves.
struct KeptPart {
    /// Length, mm of a line, rad of an arc.
    length: f64,
    /// Fraction of the whole.
    share: f64,
}

impl KeptPart {
    fn is_nothing(&self) -> bool {
        self.length < 1e3 * ROUNDING_MM
    }
}

/// Returns the part of a curve between two of its points, or `None` if they are not on it in this order.
fn kept_part(curve: &PlanarCurve, start: Point2, end: Point2) -> Option<KeptPart> {
    let whole = if curve.is_line() { (curve.end - curve.start).norm() } else { curve.sweep };
    let length = curve.remaining_between(start, end);
    let share = length / whole;
    (-1e-9..=1.0 + 1e-9).contains(&share).then_some(KeptPart { length, share })
}

/// Returns the arc of this radius (mm) that touches both curves on the inside of their corner.
fn touching_arc(before: &PlanarCurve, after: &PlanarCurve, radius: f64, turn: f64) -> Option<PlanarCurve> {
    let inside = turn.signum() * radius;
    let center = before.parallel(inside)?.shape.meeting(&after.parallel(inside)?.shape, before.end)?;
    let (start, end) = (before.shape.foot(center)?, after.shape.foot(center)?);
    let turn = turn.signum();
    let once = turn * angle(start - center, end - center);
    let sweep = if once < 0.0 { once + TAU } else { once };
    Some(PlanarCurve { start, end, shape: PlanarShape::Circle { center, radius, turn }, sweep })
}

/// Returns the straight line from `leg` (mm) before the corner to `leg` behind it.
fn chamfer(before: &PlanarCurve, after: &PlanarCurve, leg: f64) -> Option<PlanarCurve> {
    PlanarCurve::line(before.end - before.end_direction() * leg, after.start + after.start_direction() * leg)
}
