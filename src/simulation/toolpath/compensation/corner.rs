//! The joint of two offset curves at a corner of the contour.
//!
//! With β the angle by which the contour turns away from the tool, −π/2 to 3π/2:
//!
//! ```text
//! |β| ≤ 0.05                 none: the next curve begins where this one ends
//! 0.05 < β ≤ π + 0.05        outer: an arc of the tool radius around the corner, or both
//!                            curves are prolonged until they meet
//! else                       inner: both curves are cut off where they meet
//! ```
//!
//! Around an outer corner rapid moves run straight, since there are no rapid arcs. A corner where an arc turns
//! back into its tangent, as on top of an `h`, counts as an inner one.
//!
//! Source: LinuxCNC, cutter radius compensation (user manual, and the output of `rs274`).

use crate::simulation::toolpath::compensation::geometry::{PlanarCurve, PlanarShape, Point2, angle};
use std::f64::consts::{PI, TAU};

/// Smaller turns are no corner, rad.
const STRAIGHT_TURN_RAD: f64 = 0.05;

/// The way of the tool around an outer corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum OuterCorner {
    /// An arc of the tool radius, as on LinuxCNC and by G450 of Siemens.
    Arc,
    /// Straight curves are prolonged until they meet, as on Fanuc and by G451 of Siemens. The tool takes an arc
    /// where they would meet further from the corner than `reach` tool radii, and where an arc is part of the
    /// corner.
    Intersection {
        /// Distance of corner and meeting point over the tool radius, at least 1.
        reach: f64,
    },
}

/// The connection of an offset curve with the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Joint {
    /// The next curve begins where this one ends.
    Smooth,
    /// An arc around the outside of the corner, from the end of this curve to the start of the next.
    Around,
    /// Both curves end and begin at this point.
    Meet(Point2),
    /// The curves do not meet.
    Apart,
}

/// Returns the joint of two offset curves at the distance `radius` (mm) from a `corner` of the contour. `side` is
/// 1 with the tool on the left and −1 with the tool on the right; `outer` holds the way around an outer corner and
/// the tool radius, mm.
pub(super) fn joint(
    one: &PlanarCurve,
    two: &PlanarCurve,
    corner: Point2,
    side: f64,
    outer: (OuterCorner, f64),
) -> Joint {
    let (out, arrival) = (one.end_direction(), two.start_direction());
    let turn = -side * angle(out, arrival);
    let away = if turn < -0.5 * PI { turn + TAU } else { turn };
    let is_outside =
        |curve: &PlanarCurve| matches!(curve.shape, PlanarShape::Circle { turn, .. } if turn * side < 0.0);
    let turns_back =
        (away - PI).abs() < STRAIGHT_TURN_RAD && is_outside(if two.is_line() { one } else { two });
    if turns_back {
        return meet(one.shape.meeting_ahead(&two.shape, arrival - out));
    }
    if !(-STRAIGHT_TURN_RAD..=PI + STRAIGHT_TURN_RAD).contains(&away) {
        return inner_joint(one, two, corner);
    }
    if away <= STRAIGHT_TURN_RAD {
        return Joint::Smooth;
    }
    match outer {
        (OuterCorner::Intersection { reach }, radius) if one.is_line() && two.is_line() => {
            match one.shape.meeting(&two.shape, corner) {
                Some(meeting) if (meeting - corner).norm() <= reach * radius => Joint::Meet(meeting),
                _ => Joint::Around,
            }
        }
        _ => Joint::Around,
    }
}

/// Returns the joint of two offset curves that cross near `corner`.
pub(super) fn inner_joint(one: &PlanarCurve, two: &PlanarCurve, corner: Point2) -> Joint {
    meet(one.shape.meeting(&two.shape, corner))
}

fn meet(meeting: Option<Point2>) -> Joint {
    meeting.map_or(Joint::Apart, Joint::Meet)
}
