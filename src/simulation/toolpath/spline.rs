//! Splines of LinuxCNC: G5, G5.1 and G5.2 … G5.3.
//!
//! ```text
//! G5    X Y I J P Q    cubic Bézier curve: control points at I J from the start and at P Q from the end;
//!                      without I J the curve leaves in the direction in which the G5 before it arrived
//! G5.1  X Y I J        quadratic Bézier curve: control point at I J from the start
//! G5.2  X Y P L        a control point with the weight P of a NURBS of the order L (3), and all blocks with
//!                      axis words that follow; the first point is the start, whose weight is a P without X Y
//! G5.3                 runs the NURBS; its knots are uniform, and it touches its first and last point
//! ```
//!
//! All are NURBS with clamped uniform knots, evaluated by de Boor's recurrence. As LinuxCNC does, the curve is cut
//! at four equal steps of its parameter for each control point, and each piece is run as a biarc: two arcs that
//! share the tangents of the curve at the ends of the piece and each other's where they meet. So there are no
//! corners inside a curve. Four control points within 10 mm are met to about a micrometre.
//!
//! Splines lie in the XY plane. G6.2 (NURBS with given knots) is not modelled: feed moves join its control points.
//!
//! Source: LinuxCNC 2.9, G5 to G5.3, `emccanon.cc`; Piegl, Tiller, The NURBS Book, 1997, Sect. 4.3.

use crate::simulation::gcode::{Dialect, LineNumber, Place};
use crate::simulation::toolpath::block::{AXIS_WORDS, Block, CENTER_WORDS, bits};
use crate::simulation::toolpath::motion::SHORTEST;
use crate::simulation::toolpath::path_mode::PathWord;
use crate::simulation::toolpath::plane::Plane;
use crate::simulation::toolpath::remark::{Code, Untraced};
use crate::simulation::toolpath::trace::Tracer;
use crate::simulation::toolpath::{Arc, Curve, Motion, Point, Vector};

/// Biarcs for each control point of a curve.
const PIECES_PER_POINT: usize = 4;

/// The highest order of a NURBS; the work at a point of the curve grows with its square.
const MAX_ORDER: usize = 16;

/// The order of a NURBS without L.
const USUAL_ORDER: usize = 3;

/// A curve that axis words lead along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Spline {
    /// G5.
    Cubic,
    /// G5.1.
    Quadratic,
    /// G5.2.
    Nurbs,
    /// G6.2, whose control points feed moves join.
    GivenKnots,
}

impl Spline {
    fn code(self) -> Code {
        let value = match self {
            Spline::Cubic => 5.0,
            Spline::Quadratic => 5.1,
            Spline::Nurbs => 5.2,
            Spline::GivenKnots => 6.2,
        };
        Code { letter: 'G', value }
    }
}

/// Why a spline is not run as written.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub(super) enum NoSpline {
    #[error("the curve needs both I and J")]
    NoDirection,
    #[error("the curve needs both P and Q")]
    NoEndDirection,
    #[error("X and Y without G5 and its P and Q, where LinuxCNC stops")]
    NoWord,
    #[error("splines lie in the XY plane (G17), where LinuxCNC allows no other axis")]
    OutOfPlane,
    #[error("the order {order} needs at least as many control points, there are {points}")]
    FewPoints { order: usize, points: usize },
    #[error("the order {0} is beyond {MAX_ORDER}")]
    HighOrder(usize),
    #[error("the knots (K) are not modelled")]
    GivenKnots,
}

/// What a spline keeps from block to block.
#[derive(Debug, Default)]
pub(super) struct SplineState {
    /// From the end of the last G5 to where its direction points, in program coordinates, mm.
    onward: Option<Vector>,
    /// The NURBS that G5.2 began, and its line.
    nurbs: Nurbs,
    nurbs_line: LineNumber,
}

/// A NURBS with clamped uniform knots.
#[derive(Clone, Debug, Default, PartialEq)]
struct Nurbs {
    order: usize,
    /// Control points in machine coordinates, mm, and their weights.
    points: Vec<(Point, f64)>,
}

impl Tracer<'_> {
    /// The spline that G5 or G5.1 begins by the words of its block; none where they are those of another control.
    pub(super) fn spline_of(&self, word: PathWord) -> Option<Spline> {
        // G5 and G5.1 of Fanuc and its relatives, of Siemens and of Okuma are none.
        if self.is_tape || self.dialect == Dialect::Siemens {
            return None;
        }
        let has_direction = self.given.has(CENTER_WORDS);
        let is_point = self.given.has(AXIS_WORDS) && self.dialect == Dialect::LinuxCnc;
        match word {
            PathWord::LookAhead if is_point => Some(Spline::Cubic),
            PathWord::ContourControl if is_point => Some(Spline::Quadratic),
            PathWord::LookAhead if has_direction => Some(Spline::Cubic),
            PathWord::LookAhead if self.given.has(AXIS_WORDS) && self.given.has(bits(b"Q")) => {
                Some(Spline::Cubic)
            }
            PathWord::ContourControl if has_direction && !self.given.has(bits(b"Q")) => {
                Some(Spline::Quadratic)
            }
            _ => None,
        }
    }

    /// Runs the axis words of a block under a spline.
    pub(super) fn spline_to(&mut self, block: Block, spline: Spline, end: Point) {
        if spline == Spline::Nurbs {
            return self.take_control_point(block, end);
        }
        match self.spline_curve(spline, end) {
            Ok(nurbs) => self.run_nurbs(block, &nurbs),
            Err(no_spline) => {
                self.remarks.add(block.place(), Untraced::NoSpline { code: spline.code(), no_spline });
                self.feed_to(block, end);
            }
        }
    }

    /// The Bézier curve to `end` by the words of the block.
    fn spline_curve(&mut self, spline: Spline, end: Point) -> Result<Nurbs, NoSpline> {
        let onward = self.spline.onward.take();
        if self.modal.plane != Plane::Xy || self.given.has(bits(b"ZABC")) {
            return Err(NoSpline::OutOfPlane);
        }
        let unit = self.modal.unit;
        let pair = |first: u8, second: u8| match (self.given.get(first), self.given.get(second)) {
            (Some(x), Some(y)) => Ok(Some(Vector::new(x * unit, y * unit, 0.0))),
            (None, None) => Ok(None),
            _ => Err(NoSpline::NoDirection),
        };
        let start = self.position;
        let (from, to) = (self.frame.to_program(&start), self.frame.to_program(&end));
        let leave = pair(b'I', b'J');
        let points = match spline {
            Spline::Quadratic => {
                let leave = leave?.ok_or(NoSpline::NoDirection)?;
                vec![start, self.frame.to_machine(&(from + leave)), end]
            }
            Spline::Cubic => {
                let arrive = match pair(b'P', b'Q') {
                    Ok(Some(arrive)) => arrive,
                    Ok(None) if leave == Ok(None) => return Err(NoSpline::NoWord),
                    _ => return Err(NoSpline::NoEndDirection),
                };
                let leave = leave?.or(onward).ok_or(NoSpline::NoDirection)?;
                self.spline.onward = Some(-arrive);
                let control = |point: Point| self.frame.to_machine(&point);
                vec![start, control(from + leave), control(to + arrive), end]
            }
            Spline::Nurbs | Spline::GivenKnots => return Err(NoSpline::GivenKnots),
        };
        let order = points.len();
        Ok(Nurbs { order, points: points.into_iter().map(|point| (point, 1.0)).collect() })
    }

    /// Keeps the control point of a block under G5.2, the weight of the start, and the order.
    pub(super) fn take_control_point(&mut self, block: Block, point: Point) {
        let is_in_plane = self.modal.plane == Plane::Xy && !self.given.has(bits(b"ZABC"));
        let (has_x, has_y) = (self.given.has(bits(b"X")), self.given.has(bits(b"Y")));
        let weight = self.given.get(b'P').filter(|weight| (1e-6..=1e6).contains(weight));
        let nurbs = &mut self.spline.nurbs;
        let is_weight_of_start = nurbs.points.is_empty() && !has_x && !has_y && weight.is_some();
        if nurbs.points.is_empty() {
            self.spline.nurbs_line = block.line;
            let weight_of_start = weight.filter(|_| is_weight_of_start).unwrap_or(1.0);
            *nurbs = Nurbs { order: USUAL_ORDER, points: vec![(self.position, weight_of_start)] };
        }
        if let Some(order) = self.given.get(b'L').filter(|order| USUAL_ORDER as f64 <= *order) {
            nurbs.order = order as usize;
        }
        match weight.filter(|_| has_x && has_y && is_in_plane) {
            Some(weight) => nurbs.points.push((point, weight)),
            None if is_weight_of_start => {}
            None => self.remarks.add(block.place(), Untraced::NoControlPoint),
        }
    }

    /// G5.3: runs the NURBS whose control points were collected, or joins them by feed moves.
    pub(super) fn end_nurbs(&mut self, block: Block, code: Code) {
        let nurbs = std::mem::take(&mut self.spline.nurbs);
        self.modal.mode = None;
        if nurbs.points.is_empty() {
            self.remarks.add(block.place(), Untraced::NurbsNotBegun { code });
            return;
        }
        let (order, points) = (nurbs.order, nurbs.points.len());
        let no_spline = match () {
            () if MAX_ORDER < order => NoSpline::HighOrder(order),
            () if points < order => NoSpline::FewPoints { order, points },
            () => return self.run_nurbs(block, &nurbs),
        };
        self.remarks.add(block.place(), Untraced::NoSpline { code, no_spline });
        for (point, _) in nurbs.points {
            self.feed_to(block, point);
        }
    }

    /// Forgets the control points that another motion word or the end of the program leaves behind, as the control
    /// does.
    pub(super) fn forget_nurbs(&mut self) {
        let nurbs = std::mem::take(&mut self.spline.nurbs);
        if !nurbs.points.is_empty() {
            self.remarks.add(Place::line(self.spline.nurbs_line), Untraced::NurbsNotEnded);
        }
    }

    /// Along a curve in feed.
    fn run_nurbs(&mut self, block: Block, nurbs: &Nurbs) {
        let pieces = nurbs.pieces(self.modal.plane.axes()[2]);
        let length: f64 = pieces.iter().map(|(_, _, length)| length).sum();
        if length < SHORTEST {
            return;
        }
        let feedrate = self.feedrate_along(block, length);
        for (end, curve, length) in pieces {
            self.push(block, end, curve, length, Motion::Feed { feedrate });
        }
    }
}

impl Nurbs {
    /// The biarcs of the curve about the axis `normal`: their ends, shapes and lengths (mm).
    fn pieces(&self, normal: usize) -> Vec<(Point, Curve, f64)> {
        let count = PIECES_PER_POINT * self.points.len();
        let past = (self.points.len() + 1 - self.order) as f64;
        let mut pieces = Vec::with_capacity(2 * count);
        let (mut start, mut direction) = self.at(0.0);
        for index in 1..=count {
            let (end, arrival) = self.at(past * index as f64 / count as f64);
            if SHORTEST <= (end - start).norm() {
                biarc((start, direction), (end, arrival), normal, &mut pieces);
                start = end;
            }
            direction = arrival;
        }
        pieces
    }

    /// Position on the curve at the parameter `u`, mm, and the direction of its derivative, without unit; zero where
    /// control points coincide.
    fn at(&self, u: f64) -> (Point, Vector) {
        let (last, degree) = (self.points.len() - 1, self.order - 1);
        let knot = |index: usize| (index.saturating_sub(degree).min(last + 1 - degree)) as f64;
        let span = (u as usize + degree).min(last);
        let mut row: Vec<(Vector, f64)> = self.points[span - degree..=span]
            .iter()
            .map(|(point, weight)| (point.coords * *weight, *weight))
            .collect();
        let mut derivative = (Vector::zeros(), 0.0);
        for level in 1..=degree {
            if level == degree {
                let width = knot(span + 1) - knot(span);
                let scale = degree as f64 / width;
                derivative = (
                    (row[degree].0 - row[degree - 1].0) * scale,
                    (row[degree].1 - row[degree - 1].1) * scale,
                );
            }
            for index in (level..=degree).rev() {
                let first = knot(span + index - degree);
                let share = (u - first) / (knot(span + 1 + index - level) - first);
                row[index].0 = row[index - 1].0.lerp(&row[index].0, share);
                row[index].1 += (row[index - 1].1 - row[index].1) * (1.0 - share);
            }
        }
        let (position, weight) = (row[degree].0 / row[degree].1, row[degree].1);
        let tangent = (derivative.0 - position * derivative.1) / weight;
        (Point::from(position), tangent.try_normalize(1e-9).unwrap_or_default())
    }
}

/// Appends two arcs from `start` to `end`, which leave and arrive in the directions given, or a line where a
/// direction is unknown.
fn biarc(
    (start, leave): (Point, Vector),
    (end, arrive): (Point, Vector),
    normal: usize,
    pieces: &mut Vec<(Point, Curve, f64)>,
) {
    let chord = end - start;
    let mut arc = |from: Point, direction: Vector, to: Point| {
        let arc = Arc::along(from, direction, to, normal);
        let piece = match arc {
            Some(arc) => {
                let length = arc.length();
                (to, Curve::Arc(arc.into()), length)
            }
            None => (to, Curve::Line, (to - from).norm()),
        };
        pieces.push(piece);
    };
    // With tangents of one length d: |chord − d (leave + arrive)| = 2 d.
    let both = leave + arrive;
    let (along, apart) = (chord.dot(&both), 2.0 * (1.0 - leave.dot(&arrive)));
    let square = chord.norm_squared();
    let reach = square / (along + (along * along + apart * square).sqrt());
    if leave == Vector::zeros() || arrive == Vector::zeros() || !(reach.is_finite() && 0.0 < reach) {
        return pieces.push((end, Curve::Line, chord.norm()));
    }
    let meeting = nalgebra::center(&(start + reach * leave), &(end - reach * arrive));
    let onward = (end - reach * arrive - meeting).try_normalize(1e-12).unwrap_or(arrive);
    arc(start, leave, meeting);
    arc(meeting, onward, end);
}

#[cfg(test)]
mod tests;
