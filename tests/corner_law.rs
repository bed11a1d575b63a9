//! The corner law on the profile itself: two equal legs, and the filtered path comes within exactly
//! the tolerance of the corner, or α = 1. The distance is found by a dense search of its own.

use truefeed::machine::{Machine, TimeConstants};
use truefeed::simulation::contour::contour_errors;
use truefeed::simulation::feed::{Rule, plan};
use truefeed::simulation::gcode::LineNumber;
use truefeed::simulation::profile::Profile;
use truefeed::simulation::toolpath::{Curve, Motion, Point, Segment, Toolpath, Vector};

const LEG: f64 = 40.0;

/// Two legs of equal length that turn by `turn` (rad), at `feedrate` (mm/s).
fn two_legs(turn: f64, feedrate: f64) -> Toolpath {
    let corner = Point::new(LEG, 0.0, 0.0);
    let end = corner + LEG * Vector::new(turn.cos(), turn.sin(), 0.0);
    let line = |start: Point, end: Point| Segment {
        start,
        end,
        curve: Curve::Line,
        length: (end - start).norm(),
        motion: Motion::Feed { feedrate },
        exact_stop: false,
        line: LineNumber(1),
    };
    Toolpath { segments: vec![line(Point::origin(), corner), line(corner, end)], ..Toolpath::default() }
}

/// The least distance of the filtered path from `point`, to 1e-12 of the cycle time.
fn distance_from(profile: &Profile, point: Point) -> f64 {
    let distance = |t: f64| (profile.at_time(t).position - point).norm();
    let end = profile.cycle_time();
    let nearest =
        (0..=4000).map(|i| end * i as f64 / 4000.0).min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
    let nearest = nearest.expect("there are some");
    let (mut a, mut b) = (nearest - end / 4000.0, nearest + end / 4000.0);
    for _ in 0..200 {
        let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
        if distance(c) < distance(d) { b = d } else { a = c }
    }
    distance(0.5 * (a + b))
}

#[test]
fn the_corner_takes_the_tolerance_or_is_not_slowed_down() {
    let settings = [
        TimeConstants::Equal(0.0255),
        TimeConstants::Unequal(vec![0.03]),
        TimeConstants::Unequal(vec![0.0255, 0.0255]),
        TimeConstants::Unequal(vec![0.04, 0.01]),
        TimeConstants::Unequal(vec![0.0255, 0.0255, 0.0255]),
        TimeConstants::Unequal(vec![0.02, 0.015, 0.01, 0.005]),
        TimeConstants::Unequal(vec![0.02; 4]),
    ];
    let mut slowed = 0;
    for time_constants in settings {
        let mut machine = Machine::default();
        machine.interpolator.filters = match &time_constants {
            TimeConstants::Unequal(list) => list.len(),
            _ => 3,
        };
        machine.interpolator.time_constants = time_constants.clone();
        for degrees in [10.0f64, 45.0, 90.0, 135.0, 170.0] {
            for tolerance in [0.005, 0.010, 0.050] {
                for feedrate in [1000.0 / 60.0, 3000.0 / 60.0] {
                    let toolpath = two_legs(degrees.to_radians(), feedrate);
                    let plan = plan(&toolpath, &machine, Rule::Isolated(tolerance));
                    let profile = Profile::new(&toolpath, &plan);
                    let error = distance_from(&profile, toolpath.segments[0].end);
                    let case = format!(
                        "{time_constants:?}, {degrees}°, {tolerance} mm, {feedrate} mm/s: {error} mm"
                    );
                    if plan.corner_feedrates[0] < feedrate {
                        slowed += 1;
                        assert!((error / tolerance - 1.0).abs() < 1e-3, "{case}");
                    } else {
                        assert!(error <= tolerance * (1.0 + 1e-9), "{case}");
                    }
                    let measured = contour_errors(&toolpath, &plan, &profile).largest();
                    assert!((measured / error - 1.0).abs() < 1e-6, "{case}, measured {measured} mm");
                }
            }
        }
    }
    assert!(100 < slowed, "most corners are slowed down: {slowed}");
}
