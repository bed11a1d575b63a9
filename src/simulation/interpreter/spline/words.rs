//! Execution of spline words: each curve becomes biarcs.

use crate::simulation::gcode::{Dialect, Place};
use crate::simulation::interpreter::block::{AXIS_WORDS, Block, CENTER_WORDS, bits};
use crate::simulation::interpreter::code::Code;
use crate::simulation::interpreter::path_mode::PathWord;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::spline::{MAX_ORDER, NoSpline, Spline};
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::MIN_MOVE_MM;
use crate::simulation::toolpath::nurbs::Nurbs;
use crate::simulation::toolpath::plane::Plane;
use crate::simulation::toolpath::{Point, Rotation, Vector};

/// Order of a NURBS without L.
const DEFAULT_ORDER: usize = 3;

impl Interpreter<'_> {
    /// Returns the spline that G5 or G5.1 begins by the words of its block, or `None` if the words are those of
    /// another control.
    pub(crate) fn spline_of(&self, word: PathWord) -> Option<Spline> {
        // G5 and G5.1 of Fanuc and its relatives, of Siemens and of Okuma are not splines.
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
    pub(crate) fn spline_to(&mut self, block: Block, spline: Spline, end: Point) {
        if spline == Spline::Nurbs {
            return self.add_control_point(block, end);
        }
        match self.spline_curve(spline, end) {
            Ok(nurbs) => self.run_nurbs(block, &nurbs),
            Err(no_spline) => {
                self.remarks.add(block.place(), TraceRemark::NoSpline { code: spline.code(), no_spline });
                self.feed_to(block, end);
            }
        }
    }

    /// Returns the Bézier curve to `end` by the words of the block.
    fn spline_curve(&mut self, spline: Spline, end: Point) -> Result<Nurbs, NoSpline> {
        let onward = self.spline.onward.take();
        if self.canonical.plane != Plane::Xy || self.given.has(bits(b"ZABC")) {
            return Err(NoSpline::OutOfPlane);
        }
        let unit = self.modal.unit;
        let pair = |first: u8, second: u8| match (self.given.get(first), self.given.get(second)) {
            (Some(x), Some(y)) => Ok(Some(Vector::new(x * unit, y * unit, 0.0))),
            (None, None) => Ok(None),
            _ => Err(NoSpline::NoDirection),
        };
        let start = self.canonical.position;
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
    pub(crate) fn add_control_point(&mut self, block: Block, point: Point) {
        let is_in_plane = self.canonical.plane == Plane::Xy && !self.given.has(bits(b"ZABC"));
        let (has_x, has_y) = (self.given.has(bits(b"X")), self.given.has(bits(b"Y")));
        let weight = self.given.get(b'P').filter(|weight| (1e-6..=1e6).contains(weight));
        let nurbs = &mut self.spline.nurbs;
        let is_weight_of_start = nurbs.points.is_empty() && !has_x && !has_y && weight.is_some();
        if nurbs.points.is_empty() {
            self.spline.nurbs_line = block.line;
            let weight_of_start = weight.filter(|_| is_weight_of_start).unwrap_or(1.0);
            *nurbs = Nurbs { order: DEFAULT_ORDER, points: vec![(self.canonical.position, weight_of_start)] };
        }
        if let Some(order) = self.given.get(b'L').filter(|order| DEFAULT_ORDER as f64 <= *order) {
            nurbs.order = order as usize;
        }
        match weight.filter(|_| has_x && has_y && is_in_plane) {
            Some(weight) => nurbs.points.push((point, weight)),
            None if is_weight_of_start => {}
            None => self.remarks.add(block.place(), TraceRemark::NoControlPoint),
        }
    }

    /// Runs G5.3: the NURBS through the kept control points, or feed moves between them.
    pub(crate) fn end_nurbs(&mut self, block: Block, code: Code) {
        let nurbs = std::mem::take(&mut self.spline.nurbs);
        self.modal.mode = None;
        if nurbs.points.is_empty() {
            self.remarks.add(block.place(), TraceRemark::NurbsNotBegun { code });
            return;
        }
        let (order, points) = (nurbs.order, nurbs.points.len());
        let no_spline = match () {
            () if MAX_ORDER < order => NoSpline::HighOrder(order),
            () if points < order => NoSpline::FewPoints { order, points },
            () => return self.run_nurbs(block, &nurbs),
        };
        self.remarks.add(block.place(), TraceRemark::NoSpline { code, no_spline });
        for (point, _) in nurbs.points {
            self.feed_to(block, point);
        }
    }

    /// Drops the control points at another motion word or the end of the program, as the control does.
    pub(crate) fn drop_nurbs(&mut self) {
        let nurbs = std::mem::take(&mut self.spline.nurbs);
        if !nurbs.points.is_empty() {
            self.remarks.add(Place::line(self.spline.nurbs_line), TraceRemark::NurbsNotEnded);
        }
    }

    /// Moves along a curve in feed.
    fn run_nurbs(&mut self, block: Block, nurbs: &Nurbs) {
        let pieces = nurbs.pieces(self.canonical.plane.axes()[2]);
        let length: f64 = pieces.iter().map(|piece| piece.length).sum();
        if length < MIN_MOVE_MM {
            return;
        }
        let feedrate = self.feedrate_along(block, length);
        let rotation = self.turned_along().map_or(Rotation::NONE, Rotation::from);
        self.canonical.nurbs_feed(block.line, pieces, feedrate, rotation);
        self.add_compensation_remarks();
    }
}
