//! Programmed moves → moves of the tool centre, by a queue of moves whose ends may still change.
//!
//! Each programmed move is offset from the contour by the tool radius and joined to the move before it. A joint
//! may shorten the move before, so the queue keeps the last moves back:
//!
//! - The first move under compensation leads in: from the position of the tool, straight to the point
//!   at the tool radius from its end, at a right angle. With [`LeadIn::SquareToNext`] that angle is to the
//!   start of the move after it. An arc becomes an arc from the same position that ends parallel to the programmed one.
//! - A move that an inner corner would reverse is left out, and its neighbours are joined; so is an
//!   inner arc smaller than the tool. Both are gouges that most controls refuse.
//! - Moves at right angles to the plane, and stops, stay behind the move that they followed.
//! - Compensation ends at the point at the tool radius from the end of the last move; the next move begins there.
//! - A change of side, radius or plane leads straight to the new distance.
//!
//! Source: LinuxCNC's interpreter wherever it does not refuse; for `SquareToNext` Fanuc B-63944EN, start-up of
//! type A, and SINUMERIK 840D sl, NORM.

use crate::simulation::gcode::LineNumber;
use crate::simulation::toolpath::compensation::corner::{Joint, OuterCorner, inner_joint, joint};
use crate::simulation::toolpath::compensation::geometry::{
    PlanarCurve, PlanarShape, Point2, ROUNDING_MM, angle, left_of,
};
use crate::simulation::toolpath::compensation::planar::{
    draw, height, planar_curve, planar_point, space_point,
};
use crate::simulation::toolpath::compensation::remark::CompensationRemark;
use crate::simulation::toolpath::plane::Plane;
use crate::simulation::toolpath::{Curve, Motion, Point, Rotation, Segment, Stop, Toolpath};
use std::collections::VecDeque;
use std::f64::consts::TAU;

/// Most moves that are kept back, all of which one inner corner may remove.
const MAX_MOVES_KEPT_BACK: usize = 16;

/// Distance behind its start at which a move may end by rounding, mm or rad.
const MAX_REVERSAL: f64 = 1e-7;

/// Largest excess of the tool radius over an inner arc that still fits, mm.
const MAX_TIGHTNESS_MM: f64 = 1e-3;

/// The compensation in force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Setting {
    pub(crate) plane: Plane,
    /// 1 with the tool on the left of the contour, −1 on the right.
    pub(crate) side: f64,
    /// Tool radius, mm; positive.
    pub(crate) radius: f64,
}

/// End of the first move under compensation: the point at the tool radius from the programmed end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LeadIn {
    /// At a right angle to the move, or where an inner corner after it cuts it off, as on LinuxCNC.
    SquareToItself,
    /// At a right angle to the start of the next move, whatever the corner between them.
    SquareToNext,
}

/// The way of the tool to the start of a move.
#[derive(Clone, Copy)]
enum Lead {
    /// The tool is there already.
    None,
    /// A straight line.
    Straight,
    /// An arc of the tool radius around this point.
    Around(Point2),
}

/// An event between a move and the next one.
enum After {
    Stop(Stop),
    /// A move at a right angle to the plane.
    Rise(Segment),
}

/// A move of the tool centre whose end may still change.
struct OffsetMove {
    lead: Lead,
    /// The whole programmed move, offset from the contour.
    whole: PlanarCurve,
    /// Start and end after its corners have shortened it.
    start: Point2,
    end: Point2,
    is_entry: bool,
    programmed: Segment,
    after: Vec<After>,
}

/// The moves kept back, with the state that they depend on.
pub(super) struct Queue {
    setting: Option<Setting>,
    pub(super) outer_corner: OuterCorner,
    lead_in: LeadIn,
    moves: VecDeque<OffsetMove>,
    /// `true` once the tool has reached its distance from the contour.
    pub(super) has_entered: bool,
    /// `true` if an inner arc was left out since the last move.
    has_gap: bool,
    /// Position of the tool centre after all that was written out, mm; `None` if it is the programmed one.
    pub(super) at: Option<Point>,
    pub(super) remarks: Vec<(LineNumber, CompensationRemark)>,
}

impl Queue {
    pub(super) fn new(lead_in: LeadIn) -> Queue {
        Queue {
            setting: None,
            outer_corner: OuterCorner::Arc,
            lead_in,
            moves: VecDeque::new(),
            has_entered: false,
            has_gap: false,
            at: None,
            remarks: Vec::new(),
        }
    }

    pub(super) fn setting(&self) -> Option<Setting> {
        self.setting
    }

    /// Returns `true` if the tool is beside the programmed position because of a compensation that was cancelled.
    pub(super) fn is_beside(&self) -> bool {
        self.setting.is_none() && self.at.is_some()
    }

    /// Returns `true` if a move comes out unchanged: without compensation, from the programmed position, and with
    /// a length.
    pub(super) fn lets_pass(&self, segment: &Segment) -> bool {
        self.setting.is_none() && self.at.is_none() && ROUNDING_MM <= segment.length
    }

    /// Sets the compensation; the moves kept back end under the previous one.
    pub(super) fn set(&mut self, setting: Option<Setting>, out: &mut Toolpath) {
        if setting == self.setting {
            return;
        }
        self.flush(out);
        if self.setting.is_none() || setting.is_none() {
            self.has_entered = false;
        }
        self.setting = setting;
    }

    /// Adds a stop at this point of the program.
    pub(super) fn stop(&mut self, stop: Stop, out: &mut Toolpath) {
        match self.moves.back_mut() {
            Some(last) => last.after.push(After::Stop(stop)),
            None => out.stops.push(Stop { after: out.segments.len(), ..stop }),
        }
    }

    /// Adds the next programmed move.
    pub(super) fn add(&mut self, segment: Segment, out: &mut Toolpath) {
        match self.setting {
            None => self.leave(segment, out),
            Some(setting) => match planar_curve(setting.plane, &segment) {
                None => self.rise(setting, segment, out),
                Some(programmed) if self.has_entered => self.follow(setting, segment, programmed, out),
                Some(programmed) => self.enter(setting, segment, programmed),
            },
        }
    }

    /// Writes out a move without compensation: as programmed, but from the position of the tool.
    fn leave(&mut self, segment: Segment, out: &mut Toolpath) {
        let Some(at) = self.at.take().filter(|at| *at != segment.start) else {
            // A move of no length is accepted for a tool beside the path; here the tool is on the path but for
            // rounding.
            if ROUNDING_MM <= segment.length {
                out.segments.push(segment);
            } else if segment.start != segment.end {
                self.at = Some(segment.start);
            }
            return;
        };
        let straight_to = |end: Point| {
            let length = (end - at).norm();
            let line = Segment { start: at, end, curve: Curve::Line, length, ..segment.clone() };
            (ROUNDING_MM <= length).then_some(line)
        };
        match segment.curve {
            Curve::Line => match straight_to(segment.end) {
                Some(line) => out.segments.push(line),
                None => self.at = Some(at),
            },
            Curve::Arc(_) => {
                self.remarks.push((segment.line, CompensationRemark::ArcAtEnd));
                let line = straight_to(segment.start).map(|line| Segment { exact_stop: false, ..line });
                let segment = Segment { start: line.as_ref().map_or(at, |line| line.end), ..segment };
                out.segments.extend(line);
                out.segments.push(segment);
            }
        }
    }

    /// Adds a move at a right angle to the plane.
    fn rise(&mut self, setting: Setting, segment: Segment, out: &mut Toolpath) {
        match self.moves.back_mut() {
            Some(last) => last.after.push(After::Rise(segment)),
            None => self.put_rise(setting.plane, &segment, out),
        }
    }

    /// Adds the first move under compensation.
    fn enter(&mut self, setting: Setting, segment: Segment, programmed: PlanarCurve) {
        let Setting { plane, side, radius } = setting;
        let at = *self.at.get_or_insert(segment.start);
        let start = planar_point(plane, at);
        if (programmed.end - start).norm() <= radius {
            self.remarks.push((segment.line, CompensationRemark::ShortEntry { radius }));
        }
        let straight = || PlanarCurve::line(start, programmed.end)?.parallel(side * radius);
        let whole = match programmed.shape {
            PlanarShape::Line { .. } => straight(),
            PlanarShape::Circle { center, turn, .. } => {
                let arc = entry_arc(start, &programmed, center, turn, side * radius);
                if arc.is_none() {
                    self.remarks.push((segment.line, CompensationRemark::NoEntryArc));
                }
                arc.or_else(straight)
            }
        };
        // A full circle from the tool's own position leaves no direction to approach in.
        let Some(whole) = whole else { return };
        let end = whole.end;
        let (lead, after) = (Lead::None, Vec::new());
        self.moves.push_back(OffsetMove {
            lead,
            whole,
            start,
            end,
            is_entry: true,
            programmed: segment,
            after,
        });
        self.has_entered = true;
        self.has_gap = false;
    }

    /// Adds any later move.
    fn follow(&mut self, setting: Setting, segment: Segment, programmed: PlanarCurve, out: &mut Toolpath) {
        let Setting { side, radius, .. } = setting;
        let at = *self.at.get_or_insert(segment.start);
        let Some(whole) = programmed.parallel(side * radius) else {
            // In an arc of its own radius the tool does not move.
            let is_tight = |own: f64| MAX_TIGHTNESS_MM < radius - own;
            if matches!(programmed.shape, PlanarShape::Circle { radius: own, .. } if is_tight(own)) {
                self.remarks.push((segment.line, CompensationRemark::TightArc { radius }));
            }
            self.has_gap = true;
            return;
        };
        let mut next = OffsetMove {
            lead: Lead::None,
            whole,
            start: whole.start,
            end: whole.end,
            is_entry: false,
            programmed: segment,
            after: Vec::new(),
        };
        self.join(setting, programmed.start, &mut next, at, out);
        self.moves.push_back(next);
        if MAX_MOVES_KEPT_BACK < self.moves.len() {
            let first = self.moves.pop_front();
            first.into_iter().for_each(|first| self.put(setting, first, out));
        }
    }

    /// Joins a new move to the last one that remains.
    fn join(
        &mut self,
        setting: Setting,
        corner: Point2,
        next: &mut OffsetMove,
        at: Point,
        out: &mut Toolpath,
    ) {
        let Setting { plane, side, radius } = setting;
        let mut is_corner = !std::mem::take(&mut self.has_gap);
        loop {
            let Some(last) = self.moves.back_mut() else {
                if ROUNDING_MM < (planar_point(plane, at) - next.start).norm() {
                    next.lead = Lead::Straight;
                }
                return;
            };
            if last.is_entry && last.whole.is_line() && self.lead_in == LeadIn::SquareToNext {
                last.end = next.start;
                return;
            }
            let joint = match is_corner {
                true => joint(&last.whole, &next.whole, corner, side, (self.outer_corner, radius)),
                false => nearby(inner_joint(&last.whole, &next.whole, corner), last, next, radius),
            };
            let end = if let Joint::Meet(meeting) = joint { meeting } else { last.whole.end };
            if last.is_entry || -MAX_REVERSAL <= last.whole.remaining_between(last.start, end) {
                last.end = end;
                match joint {
                    Joint::Smooth => next.start = end,
                    Joint::Meet(meeting) => next.start = meeting,
                    Joint::Around => next.lead = Lead::Around(corner),
                    Joint::Apart => {
                        next.lead = Lead::Straight;
                        if is_corner {
                            self.remarks
                                .push((next.programmed.line, CompensationRemark::NoInnerJoint { radius }));
                        }
                    }
                }
                return;
            }
            self.remarks.push((last.programmed.line, CompensationRemark::Vanished { radius }));
            is_corner = false;
            let removed = self.moves.pop_back();
            for after in removed.into_iter().flat_map(|removed| removed.after) {
                match self.moves.back_mut() {
                    Some(before) => before.after.push(after),
                    None => self.put_after(plane, after, out),
                }
            }
        }
    }

    /// Sets the compensation with the tool at its distance already, at `at`.
    pub(super) fn begin_beside(&mut self, setting: Setting, at: Point, out: &mut Toolpath) {
        self.set(Some(setting), out);
        self.has_entered = true;
        self.at = Some(at);
    }

    /// Writes out all that is kept back.
    pub(super) fn flush(&mut self, out: &mut Toolpath) {
        let Some(setting) = self.setting else { return };
        if let Some(last) = self.moves.back_mut()
            && !last.is_entry
            && last.whole.remaining_between(last.start, last.end) < -MAX_REVERSAL
        {
            self.remarks
                .push((last.programmed.line, CompensationRemark::Reversed { radius: setting.radius }));
        }
        while let Some(next) = self.moves.pop_front() {
            self.put(setting, next, out);
        }
        self.has_gap = false;
    }

    /// Writes out a move with its lead and the events after it.
    fn put(&mut self, setting: Setting, next: OffsetMove, out: &mut Toolpath) {
        let Setting { plane, side, .. } = setting;
        let OffsetMove { lead, whole, start, end, programmed, after, .. } = next;
        let at = self.at.unwrap_or(programmed.start);
        let like = Segment { exact_stop: false, rotation: Rotation::NONE, ..programmed.clone() };
        let straight = PlanarShape::Line { through: start, along: whole.start_direction() };
        let leading = match lead {
            Lead::None => None,
            Lead::Around(center) if !matches!(programmed.motion, Motion::Rapid { .. }) => {
                let turn = -side;
                let sweep = turn * angle(planar_point(plane, at) - center, start - center);
                let sweep = if sweep < 0.0 { sweep + TAU } else { sweep };
                let circle = PlanarShape::Circle { center, radius: setting.radius, turn };
                draw(plane, &like, at, (&circle, sweep), (start, height(plane, at)))
            }
            Lead::Around(_) | Lead::Straight => {
                draw(plane, &like, at, (&straight, 0.0), (start, height(plane, at)))
            }
        };
        let at = leading.as_ref().map_or(at, |segment| segment.end);
        out.segments.extend(leading);
        let sweep = whole.remaining_between(start, end);
        let to = (end, height(plane, programmed.end));
        let segment = draw(plane, &programmed, at, (&whole.shape, sweep), to);
        self.at = Some(segment.as_ref().map_or(at, |segment| segment.end));
        out.segments.extend(segment);
        for after in after {
            self.put_after(plane, after, out);
        }
    }

    /// Writes out an event after a move.
    fn put_after(&mut self, plane: Plane, after: After, out: &mut Toolpath) {
        match after {
            After::Stop(stop) => out.stops.push(Stop { after: out.segments.len(), ..stop }),
            After::Rise(segment) => self.put_rise(plane, &segment, out),
        }
    }

    /// Writes out a move at a right angle to the plane, from the position of the tool.
    fn put_rise(&mut self, plane: Plane, segment: &Segment, out: &mut Toolpath) {
        let start = self.at.unwrap_or(segment.start);
        let end = space_point(plane, planar_point(plane, start), height(plane, segment.end));
        let length = (end - start).norm();
        if ROUNDING_MM <= length {
            self.at = Some(end);
            out.segments.push(Segment { start, end, curve: Curve::Line, length, ..segment.clone() });
        }
    }
}

/// Returns the arc that leads in from `start` and ends `distance` (mm) to the left of the end of a programmed arc,
/// in its direction. Its centre is on the line through that end and the programmed centre, equally far from both
/// ends. Returns `None` if there is no such arc.
fn entry_arc(
    start: Point2,
    programmed: &PlanarCurve,
    center: Point2,
    turn: f64,
    distance: f64,
) -> Option<PlanarCurve> {
    let end = programmed.end + left_of(programmed.end_direction()) * distance;
    let inwards = left_of(programmed.end_direction()) * turn;
    let chord = start - end;
    let cosine = chord.dot(&inwards) / chord.norm();
    if cosine.is_nan() || cosine < 1e-4 || (center - end).dot(&inwards) <= 0.0 {
        return None;
    }
    let radius = 0.5 * chord.norm() / cosine;
    let center = end + inwards * radius;
    let once = turn * angle(start - center, end - center);
    let sweep = if once <= 0.0 { once + TAU } else { once };
    Some(PlanarCurve { start, end, shape: PlanarShape::Circle { center, radius, turn }, sweep })
}

/// Returns a joint of moves that are not neighbours in the program if it is near to both, else [`Joint::Apart`].
fn nearby(joint: Joint, last: &OffsetMove, next: &OffsetMove, radius: f64) -> Joint {
    match joint {
        Joint::Meet(meeting) => {
            let beyond = (meeting - last.whole.end).dot(&last.whole.end_direction());
            let before = (next.whole.start - meeting).dot(&next.whole.start_direction());
            if beyond.max(before) <= 2.0 * radius { joint } else { Joint::Apart }
        }
        other => other,
    }
}
