//! What does not change the time, and what changes it in one direction only.

use crate::laws::paths::{Case, Random, cases};
use truefeed::machine::{Machine, TimeConstants};
use truefeed::simulation::feed::CornerPolicy;
use truefeed::simulation::toolpath::{Arc, Curve, Motion, Point, Segment, Stop, StopCause, Toolpath};

fn case_count() -> usize {
    crate::shared::case_count(10_000)
}

/// The case with its path and its machine changed.
fn changed(case: &Case, toolpath: Toolpath, machine: Machine) -> Case {
    Case { number: case.number, toolpath, machine }
}

/// The path with every point x at `scale` M x, M orthogonal, and every arc with it.
fn transformed(toolpath: &Toolpath, matrix: &nalgebra::Matrix3<f64>, scale: f64) -> Toolpath {
    let point = |point: &Point| Point::from(scale * (matrix * point.coords));
    let segments = toolpath.segments.iter().map(|segment| {
        let curve = match &segment.curve {
            Curve::Line => Curve::Line,
            Curve::Arc(arc) => Curve::Arc(std::sync::Arc::new(Arc {
                center: point(&arc.center),
                e1: matrix * arc.e1,
                e2: matrix * arc.e2,
                start_radius: scale * arc.start_radius,
                end_radius: scale * arc.end_radius,
                sweep: arc.sweep,
                rise: scale * (matrix * arc.rise),
            })),
        };
        let length = scale * segment.length;
        Segment { start: point(&segment.start), end: point(&segment.end), curve, length, ..segment.clone() }
    });
    Toolpath { segments: segments.collect(), ..toolpath.clone() }
}

/// A random rotation, or rotation and mirror image.
fn orthogonal(random: &mut Random) -> nalgebra::Matrix3<f64> {
    let first = random.direction();
    let second = random.across(&first).normalize();
    let third = first.cross(&second);
    let side = if random.chance(0.5) { 1.0 } else { -1.0 };
    nalgebra::Matrix3::from_columns(&[first, second, side * third])
}

/// The path run from its end to its beginning.
fn reversed(toolpath: &Toolpath) -> Toolpath {
    let count = toolpath.segments.len();
    let segments = toolpath.segments.iter().enumerate().rev().map(|(index, segment)| {
        let curve = match &segment.curve {
            Curve::Line => Curve::Line,
            Curve::Arc(arc) => {
                let (sin, cos) = arc.sweep.sin_cos();
                Curve::Arc(std::sync::Arc::new(Arc {
                    center: arc.center + arc.rise,
                    e1: cos * arc.e1 + sin * arc.e2,
                    e2: sin * arc.e1 - cos * arc.e2,
                    start_radius: arc.end_radius,
                    end_radius: arc.start_radius,
                    sweep: arc.sweep,
                    rise: -arc.rise,
                }))
            }
        };
        // What stops at the end of a segment stops before the next: that is its end now.
        let exact_stop = 0 < index && toolpath.segments.at(index - 1).exact_stop;
        Segment { start: segment.end, end: segment.start, curve, exact_stop, ..segment.clone() }
    });
    let stops = toolpath.stops.iter().rev().map(|stop| Stop { after: count - stop.after, ..*stop });
    Toolpath { segments: segments.collect(), stops: stops.collect(), ..Toolpath::default() }
}

/// The path with other feedrates and dwells.
fn retimed(toolpath: &Toolpath, feed_factor: f64, dwell_factor: f64) -> Toolpath {
    let mut toolpath = toolpath.clone();
    let faster = |mut segment: Segment| {
        if let Motion::Feed { feedrate } = &mut segment.motion {
            *feedrate *= feed_factor;
        }
        segment
    };
    toolpath.segments = toolpath.segments.iter().map(faster).collect();
    for stop in &mut toolpath.stops {
        if let StopCause::Dwell { seconds } = &mut stop.cause {
            *seconds *= dwell_factor;
        }
    }
    toolpath
}

/// The time constants times `factor`; `jerk_factor` does that to those that come from the jerk.
fn rescaled(constants: &TimeConstants, factor: f64, jerk_factor: f64) -> TimeConstants {
    match constants {
        TimeConstants::Equal(constant) => TimeConstants::Equal(factor * constant),
        TimeConstants::Unequal(list) => TimeConstants::Unequal(list.iter().map(|c| factor * c).collect()),
        TimeConstants::FromJerk(jerk) => TimeConstants::FromJerk(jerk_factor * jerk),
    }
}

fn assert_same_time(case: &Case, other: &Case, factor: f64) {
    let (time, other) = (factor * case.time(), other.time());
    assert!((other / time - 1.0).abs() <= 1e-9, "case {}: {other} s, not {time} s", case.number);
}

#[test]
fn a_reversed_path_keeps_its_time() {
    for (case, _) in cases(11, case_count()) {
        let back = changed(&case, reversed(&case.toolpath), case.machine.clone());
        assert_same_time(&case, &back, 1.0);
    }
}

#[test]
fn a_turned_or_mirrored_path_keeps_its_time() {
    for (case, mut random) in cases(12, case_count()) {
        let toolpath = transformed(&case.toolpath, &orthogonal(&mut random), 1.0);
        assert_same_time(&case, &changed(&case, toolpath, case.machine.clone()), 1.0);
    }
}

#[test]
fn a_path_scaled_with_its_feedrates_keeps_its_time() {
    for (case, mut random) in cases(13, case_count()) {
        let factor = random.log_between(0.01, 100.0);
        let toolpath = transformed(&case.toolpath, &nalgebra::Matrix3::identity(), factor);
        let mut machine = case.machine.clone();
        machine.interpolator.contour_tolerance *= factor;
        machine.interpolator.time_constants =
            rescaled(&case.machine.interpolator.time_constants, 1.0, factor);
        machine.rapid.feedrate *= factor;
        machine.path.acceleration *= factor;
        assert_same_time(&case, &changed(&case, retimed(&toolpath, factor, 1.0), machine), 1.0);
    }
}

#[test]
fn a_slower_clock_stretches_every_time() {
    for (case, mut random) in cases(14, case_count()) {
        let factor = random.log_between(0.1, 10.0);
        let mut machine = case.machine.clone();
        let jerk_factor = factor.powi(-3);
        machine.interpolator.time_constants =
            rescaled(&case.machine.interpolator.time_constants, factor, jerk_factor);
        machine.rapid.time_constants =
            case.machine.rapid.time_constants.as_ref().map(|own| rescaled(own, factor, jerk_factor));
        machine.rapid.feedrate /= factor;
        machine.path.acceleration /= factor * factor;
        let toolpath = retimed(&case.toolpath, 1.0 / factor, factor);
        assert_same_time(&case, &changed(&case, toolpath, machine), factor);
    }
}

/// A wider tolerance never costs time: corners and arcs are commanded faster, and holds depend on
/// no feedrate that the tolerance changes.
#[test]
fn time_falls_with_the_tolerance() {
    for (case, mut random) in cases(15, case_count()) {
        let mut machine = case.machine.clone();
        machine.interpolator.contour_tolerance *= random.log_between(1.001, 20.0);
        let wide = changed(&case, case.toolpath.clone(), machine);
        let (time, wide_time) = (case.plan().cycle_time(), wide.plan().cycle_time());
        assert!(wide_time <= time * (1.0 + 1e-12), "case {}: {wide_time} s, not {time} s", case.number);
    }
}

/// Where a block has no room for the holds of both its corners the slower one wins, so raising any
/// one corner never costs time.
#[test]
fn a_faster_corner_never_costs_time() {
    for (case, mut random) in cases(16, case_count()) {
        let plan = case.plan();
        let segments = &plan.segment_feedrates;
        let mut corners = plan.corner_feedrates.clone();
        let given = |corners: &[f64]| {
            let rule = CornerPolicy::Given { corners, segments };
            truefeed::simulation::simulate::with_policy(&case.toolpath, &case.machine, rule).cycle_time()
        };
        let time = given(&corners);
        let raised = random.between(0.0, corners.len() as f64) as usize;
        corners[raised] *= random.log_between(1.001, 20.0);
        let raised_time = given(&corners);
        assert!(raised_time <= time * (1.0 + 1e-12), "case {}: {raised_time} s, not {time} s", case.number);
    }
}
