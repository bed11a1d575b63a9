//! Programmed moves → moves of the tool's centre, by a queue of moves whose ends may still change.
//!
//! Each programmed move is laid beside the contour at the tool radius and joined to the move
//! before it. A joint may shorten the move before, so that the last moves are kept back:
//!
//! - The first move under compensation leads in: from where the tool is, straight to the point
//!   square to its end at the tool radius, or by [`LeadIn::SquareToNext`] square to the start of the
//!   move after it; an arc becomes the arc from there that ends square to the programmed one.
//! - A move that an inner corner would turn round is left out, and its neighbours are joined; the
//!   same goes for an inner arc smaller than the tool. Both are gouges that most controls refuse.
//! - Moves square to the plane, and stops, stay behind the move they were given after.
//! - Compensation ends at the point square to the end of the last move; the next move begins there.
//! - A change of side, radius or plane leads straight over to the new distance.
//!
//! Source: LinuxCNC's interpreter, which is followed where it does not refuse; Fanuc B-63944EN, start-up
//! of type A, and SINUMERIK 840D sl, NORM, for the other way to lead in.

use crate::simulation::gcode::LineNumber;
use crate::simulation::toolpath::compensation::corner::{Joint, OuterCorner, inner, joint};
use crate::simulation::toolpath::compensation::geometry::{
    PlanarCurve, Point2, ROUNDING_MM, Shape, angle, left_of,
};
use crate::simulation::toolpath::compensation::planar::{draw, height, point, spot, stroke};
use crate::simulation::toolpath::compensation::remark::CompensationRemark;
use crate::simulation::toolpath::plane::Plane;
use crate::simulation::toolpath::{Curve, Motion, Point, Rotation, Segment, Stop, Toolpath};
use std::collections::VecDeque;
use std::f64::consts::TAU;

/// How many moves are kept back, all of which may vanish in one inner corner.
const MAX_KEPT_BACK: usize = 16;

/// How far behind its start a move may seem to end by rounding, mm or rad.
const MAX_ROUNDING: f64 = 1e-7;

/// What a tool may be wider than an inner arc, mm.
const MAX_TIGHTNESS_MM: f64 = 1e-3;

/// Compensation in force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Setting {
    pub(crate) plane: Plane,
    /// 1 with the tool on the left of the contour, −1 on the right.
    pub(crate) side: f64,
    /// Tool radius, mm; positive.
    pub(crate) radius: f64,
}

/// Where the first move under compensation ends, at the tool radius from where the program says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LeadIn {
    /// Square to itself, or where an inner corner after it cuts it off, as on LinuxCNC.
    SquareToItself,
    /// Square to the start of the next move, whatever the corner between them.
    SquareToNext,
}

/// How the tool comes to the start of a move.
#[derive(Clone, Copy)]
enum Lead {
    /// It is there.
    None,
    Straight,
    /// On the tool radius around this point.
    Around(Point2),
}

/// What happens after a move before the next one.
enum After {
    Stop(Stop),
    /// A move square to the plane.
    Rise(Segment),
}

/// A move of the tool's centre whose end may still change.
struct Piece {
    lead: Lead,
    /// The whole programmed move, beside the contour.
    whole: PlanarCurve,
    /// Where it begins and ends, with what its corners take away.
    start: Point2,
    end: Point2,
    is_entry: bool,
    programmed: Segment,
    after: Vec<After>,
}

/// The moves kept back, and what they depend on.
pub(super) struct Queue {
    setting: Option<Setting>,
    pub(super) outer_corner: OuterCorner,
    lead_in: LeadIn,
    pieces: VecDeque<Piece>,
    /// The tool has reached its distance from the contour.
    pub(super) has_entered: bool,
    /// An inner arc was left out since the last piece.
    has_gap: bool,
    /// Where the tool's centre is after all that is put out, mm, or `None` if the programmed
    /// position says so.
    pub(super) at: Option<Point>,
    pub(super) troubles: Vec<(LineNumber, CompensationRemark)>,
}

impl Queue {
    pub(super) fn new(lead_in: LeadIn) -> Queue {
        Queue {
            setting: None,
            outer_corner: OuterCorner::Arc,
            lead_in,
            pieces: VecDeque::new(),
            has_entered: false,
            has_gap: false,
            at: None,
            troubles: Vec::new(),
        }
    }

    pub(super) fn setting(&self) -> Option<Setting> {
        self.setting
    }

    /// The tool is beside the programmed position, by a compensation that was cancelled.
    pub(super) fn is_beside(&self) -> bool {
        self.setting.is_none() && self.at.is_some()
    }

    /// Without compensation, and with the tool where the program says, a move comes out as it is given.
    pub(super) fn lets_pass(&self, segment: &Segment) -> bool {
        self.setting.is_none() && self.at.is_none() && ROUNDING_MM <= segment.length
    }

    /// Changes the compensation in force; what is kept back ends as before.
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

    /// A stop at this point of the program.
    pub(super) fn stop(&mut self, stop: Stop, out: &mut Toolpath) {
        match self.pieces.back_mut() {
            Some(last) => last.after.push(After::Stop(stop)),
            None => out.stops.push(Stop { after: out.segments.len(), ..stop }),
        }
    }

    /// The next programmed move.
    pub(super) fn take(&mut self, segment: Segment, out: &mut Toolpath) {
        match self.setting {
            None => self.leave(segment, out),
            Some(setting) => match stroke(setting.plane, &segment) {
                None => self.rise(setting, segment, out),
                Some(programmed) if self.has_entered => self.follow(setting, segment, programmed, out),
                Some(programmed) => self.enter(setting, segment, programmed),
            },
        }
    }

    /// A move without compensation: as programmed, from wherever the tool is.
    fn leave(&mut self, segment: Segment, out: &mut Toolpath) {
        let Some(at) = self.at.take().filter(|at| *at != segment.start) else {
            // A move of no length was let in for a tool beside the path; here it is on it, or off by what rounding left.
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
                self.troubles.push((segment.line, CompensationRemark::ArcAtEnd));
                let line = straight_to(segment.start).map(|line| Segment { exact_stop: false, ..line });
                let segment = Segment { start: line.as_ref().map_or(at, |line| line.end), ..segment };
                out.segments.extend(line);
                out.segments.push(segment);
            }
        }
    }

    /// A move square to the plane.
    fn rise(&mut self, setting: Setting, segment: Segment, out: &mut Toolpath) {
        match self.pieces.back_mut() {
            Some(last) => last.after.push(After::Rise(segment)),
            None => self.put_rise(setting.plane, &segment, out),
        }
    }

    /// The first move under compensation.
    fn enter(&mut self, setting: Setting, segment: Segment, programmed: PlanarCurve) {
        let Setting { plane, side, radius } = setting;
        let at = *self.at.get_or_insert(segment.start);
        let start = spot(plane, at);
        if (programmed.end - start).norm() <= radius {
            self.troubles.push((segment.line, CompensationRemark::ShortEntry { radius }));
        }
        let straight = || PlanarCurve::line(start, programmed.end)?.parallel(side * radius);
        let whole = match programmed.shape {
            Shape::Line { .. } => straight(),
            Shape::Circle { center, turn, .. } => {
                let arc = entry_arc(start, &programmed, center, turn, side * radius);
                if arc.is_none() {
                    self.troubles.push((segment.line, CompensationRemark::NoEntryArc));
                }
                arc.or_else(straight)
            }
        };
        // A full circle from the tool's own place leaves no direction to approach in.
        let Some(whole) = whole else { return };
        let end = whole.end;
        let (lead, after) = (Lead::None, Vec::new());
        self.pieces.push_back(Piece { lead, whole, start, end, is_entry: true, programmed: segment, after });
        self.has_entered = true;
        self.has_gap = false;
    }

    /// Any later move.
    fn follow(&mut self, setting: Setting, segment: Segment, programmed: PlanarCurve, out: &mut Toolpath) {
        let Setting { side, radius, .. } = setting;
        let at = *self.at.get_or_insert(segment.start);
        let Some(whole) = programmed.parallel(side * radius) else {
            // In an arc of its own radius the tool stands still.
            let is_tight = |own: f64| MAX_TIGHTNESS_MM < radius - own;
            if matches!(programmed.shape, Shape::Circle { radius: own, .. } if is_tight(own)) {
                self.troubles.push((segment.line, CompensationRemark::TightArc { radius }));
            }
            self.has_gap = true;
            return;
        };
        let mut piece = Piece {
            lead: Lead::None,
            whole,
            start: whole.start,
            end: whole.end,
            is_entry: false,
            programmed: segment,
            after: Vec::new(),
        };
        self.join(setting, programmed.start, &mut piece, at, out);
        self.pieces.push_back(piece);
        if MAX_KEPT_BACK < self.pieces.len() {
            let first = self.pieces.pop_front();
            first.into_iter().for_each(|first| self.put(setting, first, out));
        }
    }

    /// Joins a new piece to the last one that stays.
    fn join(&mut self, setting: Setting, corner: Point2, piece: &mut Piece, at: Point, out: &mut Toolpath) {
        let Setting { plane, side, radius } = setting;
        let mut is_corner = !std::mem::take(&mut self.has_gap);
        loop {
            let Some(last) = self.pieces.back_mut() else {
                if ROUNDING_MM < (spot(plane, at) - piece.start).norm() {
                    piece.lead = Lead::Straight;
                }
                return;
            };
            if last.is_entry && last.whole.is_line() && self.lead_in == LeadIn::SquareToNext {
                last.end = piece.start;
                return;
            }
            let joint = match is_corner {
                true => joint(&last.whole, &piece.whole, corner, side, (self.outer_corner, radius)),
                false => nearby(inner(&last.whole, &piece.whole, corner), last, piece, radius),
            };
            let end = if let Joint::Meet(meeting) = joint { meeting } else { last.whole.end };
            if last.is_entry || -MAX_ROUNDING <= last.whole.left_between(last.start, end) {
                last.end = end;
                match joint {
                    Joint::Smooth => piece.start = end,
                    Joint::Meet(meeting) => piece.start = meeting,
                    Joint::Around => piece.lead = Lead::Around(corner),
                    Joint::Apart => {
                        piece.lead = Lead::Straight;
                        if is_corner {
                            self.troubles.push((piece.programmed.line, CompensationRemark::NoWay { radius }));
                        }
                    }
                }
                return;
            }
            self.troubles.push((last.programmed.line, CompensationRemark::Vanished { radius }));
            is_corner = false;
            let gone = self.pieces.pop_back();
            for after in gone.into_iter().flat_map(|piece| piece.after) {
                match self.pieces.back_mut() {
                    Some(before) => before.after.push(after),
                    None => self.put_after(plane, after, out),
                }
            }
        }
    }

    /// Puts compensation in force with the tool at its distance, at `at`.
    pub(super) fn begin_beside(&mut self, setting: Setting, at: Point, out: &mut Toolpath) {
        self.set(Some(setting), out);
        self.has_entered = true;
        self.at = Some(at);
    }

    /// Puts out all that is kept back.
    pub(super) fn flush(&mut self, out: &mut Toolpath) {
        let Some(setting) = self.setting else { return };
        if let Some(last) = self.pieces.back_mut()
            && !last.is_entry
            && last.whole.left_between(last.start, last.end) < -MAX_ROUNDING
        {
            self.troubles
                .push((last.programmed.line, CompensationRemark::Reversed { radius: setting.radius }));
        }
        while let Some(piece) = self.pieces.pop_front() {
            self.put(setting, piece, out);
        }
        self.has_gap = false;
    }

    fn put(&mut self, setting: Setting, piece: Piece, out: &mut Toolpath) {
        let Setting { plane, side, .. } = setting;
        let Piece { lead, whole, start, end, programmed, after, .. } = piece;
        let at = self.at.unwrap_or(programmed.start);
        let like = Segment { exact_stop: false, rotation: Rotation::NONE, ..programmed.clone() };
        let straight = Shape::Line { through: start, along: whole.way_in() };
        let leading = match lead {
            Lead::None => None,
            Lead::Around(center) if !matches!(programmed.motion, Motion::Rapid) => {
                let turn = -side;
                let sweep = turn * angle(spot(plane, at) - center, start - center);
                let sweep = if sweep < 0.0 { sweep + TAU } else { sweep };
                let circle = Shape::Circle { center, radius: setting.radius, turn };
                draw(plane, &like, at, (&circle, sweep), (start, height(plane, at)))
            }
            Lead::Around(_) | Lead::Straight => {
                draw(plane, &like, at, (&straight, 0.0), (start, height(plane, at)))
            }
        };
        let at = leading.as_ref().map_or(at, |segment| segment.end);
        out.segments.extend(leading);
        let sweep = whole.left_between(start, end);
        let to = (end, height(plane, programmed.end));
        let segment = draw(plane, &programmed, at, (&whole.shape, sweep), to);
        self.at = Some(segment.as_ref().map_or(at, |segment| segment.end));
        out.segments.extend(segment);
        for after in after {
            self.put_after(plane, after, out);
        }
    }

    fn put_after(&mut self, plane: Plane, after: After, out: &mut Toolpath) {
        match after {
            After::Stop(stop) => out.stops.push(Stop { after: out.segments.len(), ..stop }),
            After::Rise(segment) => self.put_rise(plane, &segment, out),
        }
    }

    fn put_rise(&mut self, plane: Plane, segment: &Segment, out: &mut Toolpath) {
        let start = self.at.unwrap_or(segment.start);
        let end = point(plane, spot(plane, start), height(plane, segment.end));
        let length = (end - start).norm();
        if ROUNDING_MM <= length {
            self.at = Some(end);
            out.segments.push(Segment { start, end, curve: Curve::Line, length, ..segment.clone() });
        }
    }
}

/// The arc that leads in from `start` and ends `distance` to the left of the end of a programmed
/// arc, in its direction: its centre lies on the line through the end and the programmed centre,
/// as far from the one end as from the other.
fn entry_arc(
    start: Point2,
    programmed: &PlanarCurve,
    center: Point2,
    turn: f64,
    distance: f64,
) -> Option<PlanarCurve> {
    let end = programmed.end + left_of(programmed.way_out()) * distance;
    let inwards = left_of(programmed.way_out()) * turn;
    let chord = start - end;
    let cosine = chord.dot(&inwards) / chord.norm();
    if cosine.is_nan() || cosine < 1e-4 || (center - end).dot(&inwards) <= 0.0 {
        return None;
    }
    let radius = 0.5 * chord.norm() / cosine;
    let center = end + inwards * radius;
    let once = turn * angle(start - center, end - center);
    let sweep = if once <= 0.0 { once + TAU } else { once };
    Some(PlanarCurve { start, end, shape: Shape::Circle { center, radius, turn }, sweep })
}

/// A joint of moves that are no neighbours in the program, where it lies near to both.
fn nearby(joint: Joint, last: &Piece, piece: &Piece, radius: f64) -> Joint {
    match joint {
        Joint::Meet(meeting) => {
            let beyond = (meeting - last.whole.end).dot(&last.whole.way_out());
            let before = (piece.whole.start - meeting).dot(&piece.whole.way_in());
            if beyond.max(before) <= 2.0 * radius { joint } else { Joint::Apart }
        }
        other => other,
    }
}
