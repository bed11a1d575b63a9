//! The curve that the tool follows in place of a corner, where legs are blended as LinuxCNC does.
//!
//! The curve replaces the last d1 of one leg and the first d2 of the next, measured along the programmed path, as
//! s runs from −d1 to d2. Both are tangent to it. K is the corner; P1(x) is the first leg x before its end, P2(x) the
//! second leg x behind its beginning.
//!
//! ```text
//! parabola   P = P1(d1 (1 − τ)²) + P2(d2 τ²) − K      2 d1 τ + (d2 − d1) τ² = s + d1,  0 ≤ τ ≤ 1
//! circle     the cubic between P1(d1) and P2(d2), uniform in s, with the derivatives m u1 and m u2 by (s + d1)/(d1 + d2)
//!            m = 2 c tan(ψ/4)/sin(ψ/2)      c chord, u tangents, ψ angle between them
//! ```
//!
//! τ is the share of the parabola's duration that has passed: the first leg brakes evenly to rest while the second
//! speeds up evenly from rest. The speed along the programmed path is the sum of both speeds; that of the tool is less.
//! A cubic of these derivatives is within 3·10⁻⁴ of the radius of the circle of a right angle.
//!
//! ```text
//!   ------·.         P1(d1) to the left; the tool leaves the leg there
//!           `.
//!            |       P2(d2) below; the tool joins the next leg there
//! ```
//!
//! Limits: of a second leg that reaches its feedrate before the first has stopped, the constant speed afterwards is
//! spread over the whole parabola. Source: the laws of `corner_blend`; the cubic is the usual one for arcs.

use crate::simulation::toolpath::{Point, Segments, Vector};

/// A curve in place of the corner behind a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CornerCurve {
    /// Index of the segment that the corner ends.
    pub segment: u32,
    /// d1, d2: the lengths of the path that the curve replaces before and behind the corner, mm.
    pub distances: [f64; 2],
    /// `true` for a parabola, `false` for a circle.
    pub is_parabola: bool,
}

impl CornerCurve {
    /// Returns the position of the tool (mm) at the distance s along the programmed path from the corner (mm, −d1 to
    /// d2), and its derivative by s.
    pub fn at(&self, s: f64, segments: &Segments) -> (Point, Vector) {
        let passed = (s + self.distances[0]).clamp(0.0, self.distances.iter().sum());
        if self.is_parabola { self.on_parabola(passed, segments) } else { self.on_circle(passed, segments) }
    }

    fn on_parabola(&self, passed: f64, segments: &Segments) -> (Point, Vector) {
        let [d1, d2] = self.distances;
        let root = (d1 * d1 + (d2 - d1) * passed).max(0.0).sqrt();
        let tau = if 0.0 < passed { passed / (d1 + root) } else { 0.0 };
        let ((first, u1), (second, u2)) =
            (self.before(d1 * (1.0 - tau).powi(2), segments), self.behind(d2 * tau * tau, segments));
        let corner = segments.at(self.segment as usize).end;
        // dτ/ds is 1 over twice the root.
        let [of_first, of_second] =
            if 0.0 < root { [d1 * (1.0 - tau) / root, d2 * tau / root] } else { [0.0, 1.0] };
        (first + (second - corner), of_first * u1 + of_second * u2)
    }

    fn on_circle(&self, passed: f64, segments: &Segments) -> (Point, Vector) {
        let [d1, d2] = self.distances;
        let ((begin, u1), (end, u2)) = (self.before(d1, segments), self.behind(d2, segments));
        let chord = end - begin;
        let half_angle = (u2 - u1).norm().atan2((u2 + u1).norm());
        let reach = match half_angle {
            0.0 => chord.norm(),
            half => 2.0 * chord.norm() * (0.5 * half).tan() / half.sin(),
        };
        let f = passed / (d1 + d2);
        let (f2, f3) = (f * f, f * f * f);
        let position =
            begin + chord * (3.0 * f2 - 2.0 * f3) + reach * (u1 * (f - 2.0 * f2 + f3) + u2 * (f3 - f2));
        let derivative =
            chord * (6.0 * (f - f2)) + reach * (u1 * (1.0 - 4.0 * f + 3.0 * f2) + u2 * (3.0 * f2 - 2.0 * f));
        (position, derivative / (d1 + d2))
    }

    /// Returns the point of the first leg `distance` (mm) before the corner, mm, and the tangent there.
    fn before(&self, distance: f64, segments: &Segments) -> (Point, Vector) {
        let leg = segments.at(self.segment as usize);
        let offset = leg.length - distance;
        (leg.point(offset), leg.tangent(offset))
    }

    /// Returns the point of the second leg `distance` (mm) behind the corner, mm, and the tangent there.
    fn behind(&self, distance: f64, segments: &Segments) -> (Point, Vector) {
        let leg = segments.at(self.segment as usize + 1);
        (leg.point(distance), leg.tangent(distance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;

    fn path(program: &[u8]) -> Segments {
        trace(&read(program), &Machine::default()).segments
    }

    const LINE_AND_ARC: &[u8] = b"G21 G90 G1 X10 F1000\nG3 X20 Y10 J10";

    /// The derivative is that of the position, and the curve begins and ends on the path, along it.
    #[test]
    fn a_curve_goes_on_where_the_legs_leave_it() {
        for program in [&b"G21 G90 G1 X10 F1000\nX14 Y8"[..], LINE_AND_ARC] {
            let segments = path(program);
            for (is_parabola, distances) in
                [(false, [1.0, 1.0]), (true, [1.0, 1.0]), (true, [0.5, 2.0]), (true, [2.0, 0.0])]
            {
                let curve = CornerCurve { segment: 0, distances, is_parabola };
                let (begin, before) = curve.at(-distances[0], &segments);
                let (end, behind) = curve.at(distances[1], &segments);
                assert!((begin - segments.point(0, 10.0 - distances[0])).norm() < 1e-12);
                assert!((end - segments.point(1, distances[1])).norm() < 1e-12);
                assert!(before.cross(&segments.at(0).tangent(10.0)).norm() < 1e-9, "{before:?}");
                if 0.0 < distances[1] {
                    assert!(behind.cross(&segments.at(1).tangent(distances[1])).norm() < 1e-9);
                }
                for part in 1..20 {
                    let s = -distances[0] + f64::from(part) / 20.0 * (distances[0] + distances[1]);
                    let [(earlier, _), (later, _)] = [-1e-6, 1e-6].map(|by| curve.at(s + by, &segments));
                    let quotient = (later - earlier) / 2e-6;
                    assert!((quotient - curve.at(s, &segments).1).norm() < 1e-6, "{curve:?} at {s}");
                }
            }
        }
    }

    /// On a right angle the tool passes at half of its speed along each leg, 1/4 of each length from both legs.
    #[test]
    fn a_parabola_of_a_right_angle_passes_at_a_quarter_of_its_length() {
        let segments = path(b"G21 G90 G1 X10 F1000\nY10");
        let curve = CornerCurve { segment: 0, distances: [2.0, 2.0], is_parabola: true };
        let (position, derivative) = curve.at(0.0, &segments);
        assert!((position - Point::new(9.5, 0.5, 0.0)).norm() < 1e-12, "{position}");
        assert!((derivative - Vector::new(0.5, 0.5, 0.0)).norm() < 1e-12, "{derivative}");
    }

    #[test]
    fn a_circle_keeps_its_radius_and_its_speed() {
        let segments = path(b"G21 G90 G1 X10 F1000\nY10");
        let curve = CornerCurve { segment: 0, distances: [2.0, 2.0], is_parabola: false };
        let speed = std::f64::consts::FRAC_PI_2 * 2.0 / 4.0;
        for part in 0..=20 {
            let (position, derivative) = curve.at(-2.0 + 0.2 * f64::from(part), &segments);
            let radius = (position - Point::new(8.0, 2.0, 0.0)).norm();
            assert!((radius - 2.0).abs() < 6e-4, "{radius}");
            assert!((derivative.norm() / speed - 1.0).abs() < 0.01, "{}", derivative.norm() / speed);
        }
    }

    /// A parabola that ends at once on the second leg: all speed is that of the first.
    #[test]
    fn a_line_that_goes_straight_on_has_a_straight_curve() {
        let segments = path(b"G21 G90 G1 X10 F1000\nX20 F500");
        for is_parabola in [false, true] {
            let curve = CornerCurve { segment: 0, distances: [1.0, 1.0], is_parabola };
            for s in [-0.7, 0.0, 0.4] {
                let (position, derivative) = curve.at(s, &segments);
                assert!((position - Point::new(10.0 + s, 0.0, 0.0)).norm() < 1e-12, "{position}");
                assert!((derivative - Vector::x()).norm() < 1e-12);
            }
        }
    }
}
