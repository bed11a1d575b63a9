//! What lies between two strokes beside the contour: the treatment of its corners.
//!
//! With β the angle by which the contour turns away from the tool, −π/2 to 3π/2:
//!
//! ```text
//! |β| ≤ 0.05                 none: the next stroke begins where this one ends
//! 0.05 < β ≤ π + 0.05        outer: an arc of the tool radius around the corner, or the
//!                            strokes are prolonged until they meet
//! else                       inner: both strokes are cut off where they meet
//! ```
//!
//! Around an outer corner rapid moves run straight, since there are no rapid arcs. A corner where
//! an arc turns back into its tangent, as on top of an `h`, is an inner one.
//!
//! Source: LinuxCNC, cutter radius compensation (user manual, and what `rs274` prints).

use crate::simulation::toolpath::compensation::geometry::{PlanarCurve, Point2, Shape, angle};
use std::f64::consts::{PI, TAU};

/// Turns below this are none, rad.
const STRAIGHT_TURN_RAD: f64 = 0.05;

/// How the tool goes around an outer corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum OuterCorner {
    /// On an arc of the tool radius, as on LinuxCNC and by G450 of Siemens.
    Arc,
    /// Straight strokes are prolonged until they meet, as on Fanuc and by G451 of Siemens; on an
    /// arc where they would meet further from the corner than `reach` tool radii, and where an
    /// arc is part of the corner.
    Intersection {
        /// Distance of corner and meeting point over the tool radius, at least 1.
        reach: f64,
    },
}

/// How one stroke goes over into the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Joint {
    /// The next begins where this one ends.
    Smooth,
    /// Around the outside of the corner, from the end of this one to the start of the next.
    Around,
    /// Both meet here.
    Meet(Point2),
    /// They do not meet.
    Apart,
}

/// The joint of two strokes at the distance `radius` from a `corner` of the contour; `side` is 1
/// where the tool is on the left and −1 on the right.
pub(super) fn joint(
    one: &PlanarCurve,
    two: &PlanarCurve,
    corner: Point2,
    side: f64,
    outer: (OuterCorner, f64),
) -> Joint {
    let (out, in_) = (one.way_out(), two.way_in());
    let turn = -side * angle(out, in_);
    let away = if turn < -0.5 * PI { turn + TAU } else { turn };
    let is_outside =
        |stroke: &PlanarCurve| matches!(stroke.shape, Shape::Circle { turn, .. } if turn * side < 0.0);
    let turns_back =
        (away - PI).abs() < STRAIGHT_TURN_RAD && is_outside(if two.is_line() { one } else { two });
    if turns_back {
        return meet(one.shape.meeting_ahead(&two.shape, in_ - out));
    }
    if !(-STRAIGHT_TURN_RAD..=PI + STRAIGHT_TURN_RAD).contains(&away) {
        return inner(one, two, corner);
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

/// The joint of two strokes that cross near `corner`.
pub(super) fn inner(one: &PlanarCurve, two: &PlanarCurve, corner: Point2) -> Joint {
    meet(one.shape.meeting(&two.shape, corner))
}

fn meet(meeting: Option<Point2>) -> Joint {
    meeting.map_or(Joint::Apart, Joint::Meet)
}
