//! Approach to a contour and departure from it, for the tool centre.
//!
//! ```text
//! APPR LT   straight, along the first element          DEP LT   straight, along the last element
//! APPR LN   straight, square to it                     DEP LN   straight, square to it
//! APPR CT   arc of CCA and R that touches it           DEP CT   arc of CCA and R that touches it
//! APPR LCT  straight, then an arc of R that touches    DEP LCT  an arc of R, then straight
//!           both that line and the element
//! ```
//!
//! With t the direction of the first element at its start A, n the normal towards the tool and r its radius, the
//! tool arrives at A' = A + r n. LT begins LEN before A' along t, LN at A' + LEN n. R is the radius of the
//! contour's own arc; the tool moves inside it, so that its centre moves on the radius R − r about A + R n. The
//! first element is known only with the next move: until then the tool waits at P_S. A block L with RL or RR leads
//! in by the same rule, straight to A'.
//!
//! Source: TNC 640, Klartext Programming, 2018, ch. 6. Limits: the way to the auxiliary point is straight in all
//! axes; if the next move is along the tool axis, the tool goes straight to A.

use crate::simulation::gcode::{ContourWay, KlartextStatement, LineNumber, address};
use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::compensation::{Beside, Side};
use crate::simulation::interpreter::klartext::KlartextRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::interpreter::words::Mode;
use crate::simulation::toolpath::plane::{Plane, Turn};
use crate::simulation::toolpath::{Arc, Curve, MIN_MOVE_MM, Motion, Point, Rotation, Segment, Vector};

/// The shape of an approach or departure, with its sizes.
#[derive(Clone, Copy, Debug)]
enum Way {
    /// Straight to the start.
    Direct,
    /// Straight along the element, length in mm.
    Along(f64),
    /// Straight at a right angle to the element, length in mm.
    Across(f64),
    /// An arc with this angle, rad, and this radius, mm.
    Arc { angle: f64, radius: f64 },
    /// An arc of this radius, mm, and a line that touches it.
    ArcAndLine { radius: f64 },
}

/// An approach that waits for the first element of its contour.
#[derive(Clone, Copy, Debug)]
pub(super) struct Approach {
    name: &'static str,
    way: Way,
    /// Position of the tool, machine coordinates, mm.
    from: Point,
    /// Motion to the auxiliary point.
    lead: Motion,
    /// Motion from there.
    motion: Motion,
    side: Option<Side>,
    line: LineNumber,
}

impl Interpreter<'_> {
    /// Returns the motion of the block before, if this one approaches.
    pub(super) fn lead_motion(&mut self, block: Block, statement: KlartextStatement) -> Option<Motion> {
        let KlartextStatement::Approach(_) = statement else { return None };
        match self.modal.mode {
            Some(Mode::Straight) if self.modal.feedrate.is_some() => {
                Some(Motion::Feed { feedrate: self.feedrate(block) })
            }
            Some(Mode::Straight) => None,
            _ => Some(Motion::RAPID),
        }
    }

    /// Runs APPR.
    pub(super) fn approach(
        &mut self,
        block: Block,
        name: &'static str,
        shape: ContourWay,
        lead: Option<Motion>,
    ) {
        self.settle_approach();
        let Some(target) = self.target(block) else { return };
        let Some(way) = self.way(block, name, shape) else { return };
        if self.klartext.side.is_some() {
            self.end_compensation_in_place();
        }
        let motion = Motion::Feed { feedrate: self.feedrate(block) };
        let side = match self.given.get(address::SIDE) {
            Some(side) if 0.0 < side => Some(Side::Left),
            Some(side) if side < 0.0 => Some(Side::Right),
            _ => None,
        };
        self.modal.mode = Some(Mode::Straight);
        let (from, line) = (self.canonical.position, block.line);
        let lead = lead.unwrap_or(motion);
        self.wait_for_contour(Approach { name, way, from, lead, motion, side, line }, target);
    }

    /// Runs L with RL or RR after R0.
    pub(super) fn lead_in(&mut self, block: Block, side: Side, target: Point, motion: Motion) {
        self.settle_approach();
        let (from, line) = (self.canonical.position, block.line);
        let way = Way::Direct;
        self.wait_for_contour(
            Approach { name: "RL/RR", way, from, lead: motion, motion, side: Some(side), line },
            target,
        );
    }

    /// Keeps an approach until its contour begins at `target`.
    fn wait_for_contour(&mut self, approach: Approach, target: Point) {
        self.klartext.side = approach.side;
        self.klartext.approach = Some(approach);
        self.canonical.position = target;
        // The side is in force from here on, even while its distance is unknown.
        self.klartext.beside = approach.side.map(|_| Beside { side: 0.0, radius: 0.0 });
    }

    /// Returns the shape of an approach or departure by LEN, CCA and R; remarks on a missing word.
    fn way(&mut self, block: Block, name: &'static str, shape: ContourWay) -> Option<Way> {
        let unit = self.modal.unit;
        let length = self.given.get(address::APPROACH_LENGTH).map(|length| length.abs() * unit);
        let radius = self.given.get(address::CIRCLE_RADIUS).map(|radius| radius * unit);
        let angle = self.given.get(address::OPENING_ANGLE).map(|angle| angle.abs().min(360.0).to_radians());
        let found = match shape {
            ContourWay::Along => length.map(Way::Along).ok_or("length LEN"),
            ContourWay::Across => length.map(Way::Across).ok_or("length LEN"),
            ContourWay::Arc => match (angle, radius) {
                (Some(angle), Some(radius)) => Ok(Way::Arc { angle, radius }),
                (None, _) => Err("angle CCA"),
                (_, None) => Err("radius R"),
            },
            ContourWay::ArcAndLine => radius.map(|radius| Way::ArcAndLine { radius }).ok_or("radius R"),
        };
        match found {
            Ok(way) => Some(way),
            Err(what) => {
                let instead = "the tool goes straight";
                self.remark(block.place(), KlartextRemark::Missing { name, what, instead });
                Some(Way::Direct)
            }
        }
    }

    /// Runs before each move: the first move of a contour completes its approach.
    pub(super) fn klartext_before_move(&mut self, end: Point, curve: &Curve, length: f64) {
        let segment = Segment {
            start: self.canonical.position,
            end,
            curve: curve.clone(),
            length,
            motion: Motion::RAPID,
            rotation: Rotation::NONE,
            exact_stop: false,
            exact_path: false,
            line: LineNumber(0),
        };
        if let Some(approach) = self.klartext.approach.take() {
            let tangent = in_plane(self.canonical.plane, segment.tangent(0.0));
            self.finish_approach(approach, tangent);
        }
        if 0.0 < length {
            self.klartext.direction = Some(segment.tangent(length));
        }
    }

    /// Ends an approach without a contour.
    pub(super) fn settle_approach(&mut self) {
        if let Some(approach) = self.klartext.approach.take() {
            self.finish_approach(approach, None);
        }
    }

    /// Moves to the contour, whose first element begins at the position along `tangent`; `None` if no element
    /// follows.
    fn finish_approach(&mut self, approach: Approach, tangent: Option<Vector>) {
        let Approach { name, way, from, lead, motion, side, line } = approach;
        let block = Block::of_words(&[], line);
        let start = self.canonical.position;
        self.canonical.position = from;
        let diameter = self.tool_diameter();
        let beside = side.map(|side| self.beside(block, side, diameter));
        self.klartext.beside = beside;
        let Some(tangent) = tangent else {
            if let Some(side) = side {
                self.compensate(block, Some((side, diameter)));
            }
            self.go(block, start, motion);
            return;
        };
        let Beside { side, radius } = beside.unwrap_or(Beside { side: 1.0, radius: 0.0 });
        let normal = side * left_of(self.canonical.plane, tangent);
        let at = start + radius * normal;
        match way {
            Way::Direct => self.go(block, at, motion),
            Way::Along(length) => {
                self.go(block, at - length * tangent, lead);
                self.go(block, at, motion);
            }
            Way::Across(length) => {
                self.go(block, at + length * normal, lead);
                self.go(block, at, motion);
            }
            Way::Arc { angle, radius: written } => {
                match self.circle(block, name, (at, tangent), (normal, written, radius)) {
                    Some(circle) => {
                        let from = circle.at(-angle);
                        self.go(block, from, lead);
                        self.go_around(block, &circle, at, motion);
                    }
                    None => self.go(block, at, motion),
                }
            }
            Way::ArcAndLine { radius: written } => {
                let circle = self.circle(block, name, (at, tangent), (normal, written, radius));
                let touching =
                    circle.as_ref().and_then(|circle| Some((circle, circle.touching(from, at, true)?)));
                if let Some((circle, point)) = touching {
                    self.go(block, point, lead);
                    self.go_around(block, circle, at, motion);
                } else {
                    self.go(block, at, motion);
                }
            }
        }
        if let Some(beside) = beside {
            let at = self.canonical.position;
            self.compensate_from(beside, at);
        }
        self.canonical.position = start;
    }

    /// Runs DEP, which ends compensation.
    pub(super) fn depart(&mut self, block: Block, name: &'static str, shape: ContourWay) {
        self.settle_approach();
        let Some(target) = self.target(block) else { return };
        let Some(way) = self.way(block, name, shape) else { return };
        let Beside { side, radius } = self.klartext.beside.unwrap_or(Beside { side: 1.0, radius: 0.0 });
        let height = target - self.canonical.position;
        (self.klartext.side, self.klartext.beside) = (None, None);
        self.end_compensation_in_place();
        self.modal.mode = Some(Mode::Straight);
        let motion = Motion::Feed { feedrate: self.feedrate(block) };
        let axis = self.canonical.plane.axes()[2];
        let mut rise = Vector::zeros();
        rise[axis] = height[axis];
        let Some(tangent) = self.klartext.direction.and_then(|way| in_plane(self.canonical.plane, way))
        else {
            let (what, instead) = ("contour before it", "the tool goes straight");
            self.remark(block.place(), KlartextRemark::Missing { name, what, instead });
            self.go(block, target, motion);
            return;
        };
        let normal = side * left_of(self.canonical.plane, tangent);
        let at = self.canonical.position;
        match way {
            Way::Direct => self.go(block, target, motion),
            Way::Along(length) => self.go(block, at + length * tangent + rise, motion),
            Way::Across(length) => self.go(block, at + length * normal + rise, motion),
            Way::Arc { angle, radius: written } => {
                if let Some(circle) = self.circle(block, name, (at, tangent), (normal, written, radius)) {
                    let end = circle.at(angle) + rise;
                    self.go_around(block, &circle, end, motion);
                }
            }
            Way::ArcAndLine { radius: written } => {
                let circle = self.circle(block, name, (at, tangent), (normal, written, radius));
                let touching =
                    circle.as_ref().and_then(|circle| Some((circle, circle.touching(target, at, false)?)));
                if let Some((circle, point)) = touching {
                    self.go_around(block, circle, point, motion);
                }
                self.go(block, target, motion);
            }
        }
    }

    /// Returns the circle of the tool centre that touches the contour at a point along a tangent; `None` after a
    /// remark if the tool does not fit.
    fn circle(
        &mut self,
        block: Block,
        name: &'static str,
        (at, tangent): (Point, Vector),
        (normal, written, tool): (Vector, f64, f64),
    ) -> Option<ContactCircle> {
        // A positive radius leads away from the contour, and the tool is inside of the contour's own arc.
        let (towards, radius) =
            if 0.0 < written { (normal, written - tool) } else { (-normal, tool - written) };
        if radius < MIN_MOVE_MM {
            self.remark(block.place(), KlartextRemark::TightApproach { name, radius: tool });
            return None;
        }
        let plane = self.canonical.plane;
        let is_left = 0.0 < left_of(plane, tangent).dot(&towards);
        let turn = if is_left { Turn::Counterclockwise } else { Turn::Clockwise };
        Some(ContactCircle { plane, center: at + radius * towards, radius, turn, start: at })
    }

    /// Moves straight to `end`.
    fn go(&mut self, block: Block, end: Point, motion: Motion) {
        let length = (end - self.canonical.position).norm();
        if MIN_MOVE_MM <= length {
            self.push(block, end, Curve::Line, length, motion);
        }
    }

    /// Moves along a circle to `end`.
    fn go_around(&mut self, block: Block, circle: &ContactCircle, end: Point, motion: Motion) {
        let ends = (self.canonical.position, end);
        match circle.plane.arc(ends, circle.center, circle.turn, 1) {
            Ok(arc) => {
                let length = Arc::length(&arc);
                self.push(block, end, Curve::Arc(arc.into()), length, motion);
            }
            Err(_) => self.go(block, end, motion),
        }
    }
}

/// A circle that touches the contour, with the sense of the motion.
#[derive(Clone, Copy, Debug)]
struct ContactCircle {
    plane: Plane,
    center: Point,
    radius: f64,
    turn: Turn,
    /// The point where it touches the contour.
    start: Point,
}

impl ContactCircle {
    /// Returns the point `angle` (rad) after the contour, or before it if negative.
    fn at(&self, angle: f64) -> Point {
        let sense = if self.turn == Turn::Counterclockwise { 1.0 } else { -1.0 };
        let [a, b, _] = self.plane.axes();
        let from = self.start - self.center;
        let (sin, cos) = (sense * angle).sin_cos();
        let mut point = self.start;
        point[a] = self.center[a] + cos * from[a] - sin * from[b];
        point[b] = self.center[b] + sin * from[a] + cos * from[b];
        point
    }

    /// Returns the point where a straight line between `outside` and the circle touches it in the sense of the
    /// motion, at the height of `at`; `None` if `outside` is within the circle.
    fn touching(&self, outside: Point, at: Point, is_way_in: bool) -> Option<Point> {
        let [a, b, _] = self.plane.axes();
        let (to_a, to_b) = (self.center[a] - outside[a], self.center[b] - outside[b]);
        let distance = to_a.hypot(to_b);
        if distance <= self.radius {
            return None;
        }
        let length = ((distance - self.radius) * (distance + self.radius)).sqrt();
        // Seen from outside, the centre is on the left of a line that continues counter-clockwise.
        let centre_is_left = (self.turn == Turn::Counterclockwise) == is_way_in;
        let aside = (self.radius / distance).asin() * if centre_is_left { -1.0 } else { 1.0 };
        let (sin, cos) = aside.sin_cos();
        let scale = length / distance;
        let mut point = at;
        point[a] = outside[a] + scale * (cos * to_a - sin * to_b);
        point[b] = outside[b] + scale * (sin * to_a + cos * to_b);
        Some(point)
    }
}

/// Returns the unit vector of a direction within the plane, or `None` if it is at a right angle to it.
fn in_plane(plane: Plane, mut direction: Vector) -> Option<Vector> {
    direction[plane.axes()[2]] = 0.0;
    direction.try_normalize(1e-6)
}

/// Returns the direction to the left of `direction`, in the plane.
fn left_of(plane: Plane, direction: Vector) -> Vector {
    let [a, b, _] = plane.axes();
    plane.vector([-direction[b], direction[a], 0.0])
}
