//! Splines against their formulas, and the words that LinuxCNC takes.

use crate::machine::Machine;
use crate::simulation::gcode::{Dialect, Options, Severity, read_with};
use crate::simulation::interpreter::trace;
use crate::simulation::toolpath::{Motion, Point, Toolpath};

fn run(text: &str) -> Toolpath {
    let options = Options { dialect: Some(Dialect::LinuxCnc), ..Options::default() };
    trace(&read_with(text.as_bytes(), &options), &Machine::default())
}

fn errors(toolpath: &Toolpath) -> Vec<(u32, &str)> {
    let is_error = |severity: Severity| severity == Severity::Error;
    let found = toolpath.diagnostics.iter().filter(|diagnostic| is_error(diagnostic.severity));
    found.map(|diagnostic| (diagnostic.line.0, diagnostic.message.as_str())).collect()
}

/// The point of a Bézier curve at `t`, by Bernstein's polynomials.
fn bezier(points: &[[f64; 2]], t: f64) -> Point {
    let degree = points.len() - 1;
    let binomial = |index: usize| (0..index).fold(1.0, |all, k| all * (degree - k) as f64 / (k + 1) as f64);
    let share =
        |index: usize| binomial(index) * t.powi(index as i32) * (1.0 - t).powi((degree - index) as i32);
    let sum = |axis: usize| points.iter().enumerate().map(|(index, point)| share(index) * point[axis]).sum();
    Point::new(sum(0), sum(1), 0.0)
}

/// The length of a Bézier curve, by chords.
fn length(points: &[[f64; 2]]) -> f64 {
    let at = |index: u32| bezier(points, f64::from(index) / 1e5);
    (0..100_000).map(|index| (at(index + 1) - at(index)).norm()).sum()
}

/// The largest distance of a path from a finely sampled curve, mm.
fn deviation(toolpath: &Toolpath, points: &[[f64; 2]]) -> f64 {
    let samples: Vec<Point> = (0..=20_000).map(|index| bezier(points, f64::from(index) / 2e4)).collect();
    let mut largest = 0.0_f64;
    for segment in toolpath.segments.iter() {
        for step in 0..=4 {
            let point = segment.point(segment.length * f64::from(step) / 4.0);
            let nearest = samples.iter().map(|sample| (sample - point).norm()).fold(f64::INFINITY, f64::min);
            largest = largest.max(nearest);
        }
    }
    largest
}

/// The largest angle between two segments in a row, rad.
fn largest_corner(toolpath: &Toolpath) -> f64 {
    let tangents: Vec<_> = toolpath.segments.iter().map(|segment| segment.tangents()).collect();
    tangents.windows(2).map(|pair| pair[0][1].angle(&pair[1][0])).fold(0.0, f64::max)
}

#[test]
fn a_cubic_spline_after_a_rapid_is_a_curve_in_feed() {
    let toolpath = run("G21 G90 G94 G17\nG0 X0 Y0\nG5 I0 J3 P1 Q-3 X10 Y10 F60\nM2");
    assert_eq!(errors(&toolpath), []);
    let points = [[0.0, 0.0], [0.0, 3.0], [11.0, 7.0], [10.0, 10.0]];
    let total: f64 = toolpath.segments.iter().map(|segment| segment.length).sum();
    assert!((total - length(&points)).abs() < 1e-4, "{total} mm and {} mm", length(&points));
    assert!(deviation(&toolpath, &points) < 1.5e-3, "{} mm", deviation(&toolpath, &points));
    assert!(largest_corner(&toolpath) < 1e-6, "{} rad", largest_corner(&toolpath));
    assert!(toolpath.segments.iter().all(|segment| segment.motion == Motion::Feed { feedrate: 1.0 }));
    assert_eq!(toolpath.segments.last().map(|last| last.end), Some(Point::new(10.0, 10.0, 0.0)));
}

#[test]
fn splines_are_scaled_and_turned_with_their_coordinates() {
    let plain = run("G21 F100\nG5 I1 J2 P-2 Q1 X10 Y4\nG5.1 X20 Y0 I5 J5\nM2");
    let inch = run(
        "G20 F3.93700787401574803\nG5 I[1/25.4] J[2/25.4] P[-2/25.4] Q[1/25.4] X[10/25.4] Y[4/25.4]\nG91 G5.1 X[10/25.4] Y[-4/25.4] I[5/25.4] J[5/25.4]\nM2",
    );
    let turned = run("G10 L2 P1 R90\nG21 F100\nG5 I1 J2 P-2 Q1 X10 Y4\nG5.1 X20 Y0 I5 J5\nM2");
    for toolpath in [&plain, &inch, &turned] {
        assert_eq!(errors(toolpath), []);
    }
    assert!(32 < plain.segments.len());
    assert_eq!(plain.segments.len(), inch.segments.len());
    assert_eq!(plain.segments.len(), turned.segments.len());
    for ((one, other), turned) in plain.segments.iter().zip(inch.segments.iter()).zip(turned.segments.iter())
    {
        assert!((one.end - other.end).norm() < 1e-9 && (one.length - other.length).abs() < 1e-9);
        assert!((Point::new(-one.end.y, one.end.x, 0.0) - turned.end).norm() < 1e-9);
    }
}

#[test]
fn a_cubic_spline_goes_on_in_the_direction_of_the_one_before() {
    let toolpath = run("G21 F100\nG5 I0 J3 P0 Q-3 X1 Y1\nG5 P0 Q-3 X2 Y2\nM2");
    assert_eq!(errors(&toolpath), []);
    assert!(largest_corner(&toolpath) < 1e-6);
}

#[test]
fn under_inverse_time_a_whole_spline_lasts_one_over_f() {
    let toolpath = run("G21 G93\nG5 I0 J3 P1 Q-3 X10 Y10 F2\nM2");
    let seconds = toolpath.segments.iter().map(|segment| match segment.motion {
        Motion::Feed { feedrate } => segment.length / feedrate,
        Motion::Rapid { .. } => 0.0,
    });
    assert!((seconds.sum::<f64>() - 30.0).abs() < 1e-9);
}

/// A circle by a rational curve of second degree: its weights make it exact.
#[test]
fn a_nurbs_with_weights_is_a_quarter_of_a_circle() {
    let toolpath = run("G21 F100\nG0 X10 Y0\nG5.2 X10 Y10 P0.70710678118654752\nX0 Y10 P1\nG5.3\nM2");
    assert_eq!(errors(&toolpath), []);
    let feeds: Vec<_> = toolpath.segments.iter().filter(|segment| !segment.motion.is_rapid()).collect();
    let total: f64 = feeds.iter().map(|segment| segment.length).sum();
    assert!((total - 5.0 * std::f64::consts::PI).abs() < 1e-6, "{total} mm");
    for segment in feeds {
        assert!((segment.point(0.5 * segment.length).coords.norm() - 10.0).abs() < 1e-6);
    }
}

/// One interval of knots makes a NURBS without weights a Bézier curve.
#[test]
fn a_nurbs_of_as_many_points_as_its_order_is_a_bezier_curve() {
    let toolpath = run("G21 F100\nG5.2 P1 L4\nX0 Y3 P1\nX11 Y7 P1\nX10 Y10 P1\nG5.3\nG1 X0\nM2");
    assert_eq!(errors(&toolpath), []);
    let bezier = run("G21 F100\nG5 I0 J3 P1 Q-3 X10 Y10\nG1 X0\nM2");
    assert_eq!(toolpath.segments.len(), bezier.segments.len());
    for (one, other) in toolpath.segments.iter().zip(bezier.segments.iter()) {
        assert!((one.end - other.end).norm() < 1e-9);
    }
}

/// What `rs274 -g` of LinuxCNC 2.9 refuses.
#[test]
fn what_linuxcnc_refuses_is_told_and_run_as_feed_moves() {
    for (block, said) in [
        ("G5 P1 Q1 X5 Y5", "needs both I and J"),
        ("G5 I1 P1 Q1 X5 Y5", "needs both I and J"),
        ("G5 I1 J1 P1 X5 Y5", "needs both P and Q"),
        ("G5 X5 Y5", "without G5 and its P and Q"),
        ("G5.1 I1 X5 Y5", "needs both I and J"),
        ("G5.1 X5 Y5", "needs both I and J"),
        ("G18 G5 I1 J1 P1 Q1 X5 Y5", "XY plane"),
        ("G5 I1 J1 P1 Q1 X5 Y5 Z1", "XY plane"),
    ] {
        let toolpath = run(&format!("G21 F60\nG0 X0\n{block}\nM2"));
        let errors = errors(&toolpath);
        assert!(errors.len() == 1 && errors[0].0 == 3 && errors[0].1.contains(said), "{block}: {errors:?}");
        assert_eq!(toolpath.segments.len(), 1, "{block}");
        let motion = toolpath.segments.last().expect("a move").motion;
        assert_eq!(motion, Motion::Feed { feedrate: 1.0 }, "{block}");
    }
    for (text, said) in [
        ("G5.3", "without G5.2"),
        ("G5.2 X1 Y1\nX2 Y2 P1\nG5.3", "positive weight"),
        ("G5.2 X1 P1\nX2 Y2 P1\nX3 Y3 P1\nG5.3", "needs X and Y"),
        ("G5.2 X1 Y1 P1\nX2 Y2 P1\nG1 X3", "no G5.3 follows"),
        ("G5.2 X1 Y1 P1\nX2 Y2 P1", "no G5.3 follows"),
        ("G5.2 X1 Y1 P1 L5\nX2 Y2 P1\nG5.3", "at least as many"),
        ("G5.2 X1 Y1 P1 L17\nX2 Y2 P1\nG5.3", "beyond 16"),
        ("G6.2 X1 Y1 P3 K0\nX2 Y2 K1", "knots"),
    ] {
        let toolpath = run(&format!("G21 F60\nG0 X0 Y0\n{text}"));
        let errors = errors(&toolpath);
        assert!(errors.iter().any(|(_, message)| message.contains(said)), "{text}: {errors:?}");
        assert!(toolpath.segments.iter().all(|segment| !segment.motion.is_rapid()), "{text}");
    }
}

#[test]
fn look_ahead_of_fanuc_is_no_spline() {
    let options = Options { dialect: Some(Dialect::Iso), ..Options::default() };
    let text = b"G21 F60\nG5 P10000\nG1 X5\nG5 P0\nG5.1 Q1\nX6\nG5.1 Q0 X0 Y0 Z0\nX7\nM30";
    let toolpath = trace(&read_with(text, &options), &Machine::default());
    assert_eq!(errors(&toolpath), []);
    assert_eq!(toolpath.segments.len(), 3);
}
