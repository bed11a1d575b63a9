//! The curve that the tool follows in place of a corner, where legs are blended as LinuxCNC does.
//!
//! The curve replaces the last d1 of one leg and the first d2 of the next, measured along the programmed path, as
//! s runs from −d1 to d2. It is tangent to lines. K is the corner; P1(x) is the first leg x before its end, P2(x) the
//! second leg x behind its beginning.
//!
//! ```text
//! parabola   P = P1(d1 (1 − τ)²) + P2(d2 τ²) − K      2 d1 τ + (d2 − d1) τ² = s + d1,  0 ≤ τ ≤ 1
//! circle     P = P1(d1) + R (sin φ u1 + (1 − cos φ) n) + φ/ψ e      φ = ψ (s + d1)/(d1 + d2),  R = c / (2 sin(ψ/2))
//!            u1, u2 unit tangents of the legs at the ends of the curve     ψ angle between u1 and u2
//!            n inward unit normal at the beginning     c length of the chord P1(d1) P2(d2)
//!            e vector from the end of the circle to P2(d2)
//! ```
//!
//! τ is the share of the parabola's duration that has passed. The first leg brakes evenly to rest while the second speeds
//! up evenly from rest. The speed along the programmed path is the sum of the speeds of both legs, and the tool moves at the
//! magnitude of the sum of their velocities, which is smaller. Between two lines e is 0.
//!
//! ```text
//!   ------·.         P1(d1) to the left; the tool leaves the leg there
//!           `.
//!            |       P2(d2) below; the tool joins the next leg there
//! ```
//!
//! Limits: of a second leg that reaches its feedrate before the first has stopped, the constant speed afterwards is
//! spread over the whole parabola. A circle beside an arc is that of two tangents, which touches the arc at a small angle.
//! Source: the laws of `corner_blend`.

use crate::simulation::toolpath::{Point, Segments, Vector, angle_between};

/// Least angle of a circle, rad; below it the circle counts as its chord.
const MIN_ARC_ANGLE_RAD: f64 = 1e-6;

/// A curve in place of the corner behind a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CornerCurve {
    /// d1, d2: the lengths of the path that the curve replaces before and behind the corner, mm; both 0 if there is no
    /// curve.
    pub distances: [f64; 2],
    /// `true` for a parabola, `false` for a circle.
    pub is_parabola: bool,
}

/// Returns the position of the tool (mm) on the curve in place of a corner, at the distance `offset` from the start of a
/// segment (mm), and its derivative by that distance; `None` if there is no curve. `curves` has the curve behind each
/// segment.
pub fn on_curve(
    curves: &[CornerCurve],
    segment: usize,
    offset: f64,
    segments: &Segments,
) -> Option<(Point, Vector)> {
    let begun = segment.checked_sub(1).filter(|before| offset < curves[*before].distances[1]);
    if let Some(before) = begun {
        return Some(curves[before].at(offset, before, segments));
    }
    // By rounding, the offset may exceed the length.
    let (to_end, ends) = ((segments.length(segment) - offset).max(0.0), &curves[segment]);
    (to_end < ends.distances[0]).then(|| ends.at(-to_end, segment, segments))
}

impl CornerCurve {
    /// The corner itself.
    pub const NONE: CornerCurve = CornerCurve { distances: [0.0; 2], is_parabola: false };

    /// Returns the position of the tool (mm) at the distance s along the programmed path from the corner behind a segment
    /// (mm, −d1 to d2), and its derivative by s.
    fn at(&self, s: f64, segment: usize, segments: &Segments) -> (Point, Vector) {
        let passed = (s + self.distances[0]).clamp(0.0, self.distances.iter().sum());
        if self.is_parabola {
            self.on_parabola(passed, segment, segments)
        } else {
            self.on_circle(passed, segment, segments)
        }
    }

    fn on_parabola(&self, passed: f64, segment: usize, segments: &Segments) -> (Point, Vector) {
        let [d1, d2] = self.distances;
        let root = (d1 * d1 + (d2 - d1) * passed).max(0.0).sqrt();
        let tau = if 0.0 < passed { passed / (d1 + root) } else { 0.0 };
        let ((first, u1), (second, u2)) = (
            before_end(d1 * (1.0 - tau).powi(2), segment, segments),
            segments.point_and_tangent(segment + 1, d2 * tau * tau),
        );
        let corner = segments.at(segment).end;
        // dτ/ds is 1 over twice the root.
        let [of_first, of_second] =
            if 0.0 < root { [d1 * (1.0 - tau) / root, d2 * tau / root] } else { [0.0, 1.0] };
        (first + (second - corner), of_first * u1 + of_second * u2)
    }

    fn on_circle(&self, passed: f64, segment: usize, segments: &Segments) -> (Point, Vector) {
        let [d1, d2] = self.distances;
        let ((begin, u1), (end, u2)) =
            (before_end(d1, segment, segments), segments.point_and_tangent(segment + 1, d2));
        let (chord, share) = (end - begin, passed / (d1 + d2));
        let angle = angle_between(&u1, &u2);
        let inwards = (u2 - u1.dot(&u2) * u1).normalize();
        if angle < MIN_ARC_ANGLE_RAD || !inwards.iter().all(|part| part.is_finite()) {
            return (begin + share * chord, chord / (d1 + d2));
        }
        let radius = 0.5 * chord.norm() / (0.5 * angle).sin();
        // The travel up to a share of the angle, and its derivative by the share.
        let on_arc = |share: f64| {
            let (sin, cos) = (share * angle).sin_cos();
            let travel = radius * (sin * u1 + (1.0 - cos) * inwards);
            (travel, radius * angle * (cos * u1 + sin * inwards))
        };
        let (travel, derivative) = on_arc(share);
        let missing = chord - on_arc(1.0).0;
        (begin + travel + share * missing, (derivative + missing) / (d1 + d2))
    }
}

/// Returns the point `distance` (mm) before the end of a segment, mm, and the tangent there.
fn before_end(distance: f64, segment: usize, segments: &Segments) -> (Point, Vector) {
    segments.point_and_tangent(segment, segments.length(segment) - distance)
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

    const LINES: &[u8] = b"G21 G90 G1 X10 F1000\nX14 Y8";
    const LINE_AND_ARC: &[u8] = b"G21 G90 G1 X10 F1000\nG3 X20 Y10 J10";

    /// The curve begins and ends on the path and is tangent to it there. The derivative agrees with difference quotients of
    /// the position.
    #[test]
    fn a_curve_goes_on_where_the_legs_leave_it() {
        let parabolas = [[1.0, 1.0], [0.5, 2.0], [2.0, 0.0]].map(|distances| (true, distances));
        let on_lines = [&parabolas[..], &[(false, [1.0, 1.0])]].concat();
        for (program, curves) in [(LINES, &on_lines[..]), (LINE_AND_ARC, &parabolas)] {
            let segments = path(program);
            for &(is_parabola, distances) in curves {
                let curve = CornerCurve { distances, is_parabola };
                let (begin, before) = curve.at(-distances[0], 0, &segments);
                let (end, behind) = curve.at(distances[1], 0, &segments);
                assert!((begin - segments.point(0, 10.0 - distances[0])).norm() < 1e-12);
                assert!((end - segments.point(1, distances[1])).norm() < 1e-12);
                assert!(before.cross(&segments.at(0).tangent(10.0)).norm() < 1e-9, "{before:?}");
                if 0.0 < distances[1] {
                    assert!(behind.cross(&segments.at(1).tangent(distances[1])).norm() < 1e-9);
                }
                for part in 1..20 {
                    let s = -distances[0] + f64::from(part) / 20.0 * (distances[0] + distances[1]);
                    let [(earlier, _), (later, _)] = [-1e-6, 1e-6].map(|by| curve.at(s + by, 0, &segments));
                    let quotient = (later - earlier) / 2e-6;
                    assert!((quotient - curve.at(s, 0, &segments).1).norm() < 1e-6, "{curve:?} at {s}");
                }
            }
        }
    }

    /// On a right angle the tool passes at half of its speed along each leg, 1/4 of each length from both legs.
    #[test]
    fn a_parabola_of_a_right_angle_passes_at_a_quarter_of_its_length() {
        let segments = path(b"G21 G90 G1 X10 F1000\nY10");
        let curve = CornerCurve { distances: [2.0, 2.0], is_parabola: true };
        let (position, derivative) = curve.at(0.0, 0, &segments);
        assert!((position - Point::new(9.5, 0.5, 0.0)).norm() < 1e-12, "{position}");
        assert!((derivative - Vector::new(0.5, 0.5, 0.0)).norm() < 1e-12, "{derivative}");
    }

    #[test]
    fn a_circle_keeps_its_radius_and_its_speed() {
        let segments = path(b"G21 G90 G1 X10 F1000\nY10");
        let curve = CornerCurve { distances: [2.0, 2.0], is_parabola: false };
        let speed = std::f64::consts::FRAC_PI_2 * 2.0 / 4.0;
        for part in 0..=20 {
            let (position, derivative) = curve.at(-2.0 + 0.2 * f64::from(part), 0, &segments);
            let radius = (position - Point::new(8.0, 2.0, 0.0)).norm();
            assert!((radius - 2.0).abs() < 1e-12, "{radius}");
            assert!((derivative.norm() - speed).abs() < 1e-12, "{}", derivative.norm());
        }
    }

    #[test]
    fn a_line_that_goes_straight_on_has_a_straight_curve() {
        let segments = path(b"G21 G90 G1 X10 F1000\nX20 F500");
        for is_parabola in [false, true] {
            let curve = CornerCurve { distances: [1.0, 1.0], is_parabola };
            for s in [-0.7, 0.0, 0.4] {
                let (position, derivative) = curve.at(s, 0, &segments);
                assert!((position - Point::new(10.0 + s, 0.0, 0.0)).norm() < 1e-12, "{position}");
                assert!((derivative - Vector::x()).norm() < 1e-12);
            }
        }
    }
}
