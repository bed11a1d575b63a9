//! NURBS and Bézier curves as biarcs.
//!
//! Curves have clamped uniform knots and are evaluated by de Boor's recurrence. As on LinuxCNC, the curve is cut
//! at four equal steps of its parameter for each control point. Each piece becomes a biarc: two arcs that have the
//! tangents of the curve at the ends of the piece, and a common tangent where they meet. So there are no corners
//! inside a curve. With four control points within 10 mm the biarcs deviate by about a micrometre.
//!
//! Source: LinuxCNC 2.9, `emccanon.cc`; Piegl, Tiller, The NURBS Book, 1997, Sect. 4.3.

use crate::simulation::toolpath::{Arc, Curve, MIN_MOVE_MM, Point, Vector};

/// A part of a path.
pub(crate) struct PathPiece {
    /// End, mm.
    pub(crate) end: Point,
    /// Shape from the end of the piece before.
    pub(crate) curve: Curve,
    /// Length, mm.
    pub(crate) length: f64,
}

/// Biarcs for each control point of a curve.
const PIECES_PER_POINT: usize = 4;

/// A NURBS with clamped uniform knots.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Nurbs {
    /// Degree plus one.
    pub(crate) order: usize,
    /// Control points in machine coordinates, mm, each with its weight.
    pub(crate) points: Vec<(Point, f64)>,
}

impl Nurbs {
    /// Returns the biarcs of the curve about the axis `normal`.
    pub(crate) fn pieces(&self, normal: usize) -> Vec<PathPiece> {
        let count = PIECES_PER_POINT * self.points.len();
        let past = (self.points.len() + 1 - self.order) as f64;
        let mut pieces = Vec::with_capacity(2 * count);
        let (mut start, mut direction) = self.at(0.0);
        for index in 1..=count {
            let (end, arrival) = self.at(past * index as f64 / count as f64);
            if MIN_MOVE_MM <= (end - start).norm() {
                biarc((start, direction), (end, arrival), normal, &mut pieces);
                start = end;
            }
            direction = arrival;
        }
        pieces
    }

    /// Returns the position on the curve at the parameter `u`, mm, and the direction of its derivative, without
    /// unit; the direction is zero where control points coincide.
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

/// Appends two arcs from `start` to `end` that leave and arrive in the given directions, or a line if a direction
/// is unknown.
fn biarc(
    (start, leave): (Point, Vector),
    (end, arrive): (Point, Vector),
    normal: usize,
    pieces: &mut Vec<PathPiece>,
) {
    let chord = end - start;
    let mut arc = |from: Point, direction: Vector, to: Point| {
        let arc = Arc::along(from, direction, to, normal);
        let piece = match arc {
            Some(arc) => {
                let length = arc.length();
                PathPiece { end: to, curve: Curve::Arc(arc.into()), length }
            }
            None => PathPiece { end: to, curve: Curve::Line, length: (to - from).norm() },
        };
        pieces.push(piece);
    };
    // With tangents of one length d: |chord − d (leave + arrive)| = 2 d.
    let both = leave + arrive;
    let (along, apart) = (chord.dot(&both), 2.0 * (1.0 - leave.dot(&arrive)));
    let square = chord.norm_squared();
    let reach = square / (along + (along * along + apart * square).sqrt());
    if leave == Vector::zeros() || arrive == Vector::zeros() || !(reach.is_finite() && 0.0 < reach) {
        return pieces.push(PathPiece { end, curve: Curve::Line, length: chord.norm() });
    }
    let meeting = nalgebra::center(&(start + reach * leave), &(end - reach * arrive));
    let onward = (end - reach * arrive - meeting).try_normalize(1e-12).unwrap_or(arrive);
    arc(start, leave, meeting);
    arc(meeting, onward, end);
}
