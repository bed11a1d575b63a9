//! Engagement against exact geometry, within a few cells of the grid and on average within two.

use std::f64::consts::{FRAC_PI_2, PI};

use truefeed::cutting::{CutPlace, Engagement, Sector, engagement};

use crate::cutting::{from, mill, setup, toolpath};

const RADIUS: f64 = 6.0;
const CELL: f64 = 0.1;
/// Four cells as an angle of the tool.
const NEAR: f64 = 4.0 * CELL / RADIUS;

const MIN: [f64; 3] = [-30.013, -30.027, -10.0];
const MAX: [f64; 3] = [60.0, 60.0, 0.0];

fn run(program: &str) -> Engagement {
    let setup = setup(MIN, MAX, mill(2.0 * RADIUS), CELL);
    engagement(&toolpath(program), &setup).expect("all is given")
}

/// Places of a line of the program, `from` to `to` of the way along it.
fn on_line(found: &Engagement, line: u32, from: f64, to: f64) -> Vec<CutPlace> {
    let places: Vec<CutPlace> = found.places.iter().filter(|place| place.line == line).cloned().collect();
    let (first, last) = (places[0].distance, places[places.len() - 1].distance);
    let is_within = |place: &CutPlace| {
        let way = (place.distance - first) / (last - first);
        from <= way && way <= to
    };
    places.into_iter().filter(is_within).collect()
}

/// All places have one sector with these ends.
fn has_sector(found: &Engagement, places: &[CutPlace], entry: f64, exit: f64, depth: f64) {
    assert!(3 < places.len());
    let mean = |of: fn(&Sector) -> f64| {
        places.iter().map(|place| of(&found.sectors(place)[0])).sum::<f64>() / places.len() as f64
    };
    assert!((mean(|sector| sector.entry) - entry).abs() < 2.0 * CELL / RADIUS);
    assert!((mean(|sector| sector.exit) - exit).abs() < 2.0 * CELL / RADIUS);
    for place in places {
        let sectors = found.sectors(place);
        assert_eq!(sectors.len(), 1, "{sectors:?}");
        let sector = sectors[0];
        assert!((sector.entry - entry).abs() < NEAR, "{} enters at {entry}", sector.entry);
        assert!((sector.exit - exit).abs() < NEAR, "{} leaves at {exit}", sector.exit);
        assert!((sector.depth - depth).abs() < 1e-9, "{}", sector.depth);
        assert!((found.axial(place) - depth).abs() < 1e-9);
        let width = RADIUS * (entry.cos() - exit.cos());
        assert!((found.radial(place, RADIUS) - width).abs() < 4.0 * CELL);
    }
}

#[test]
fn a_slot_is_cut_over_the_front_half_in_any_direction() {
    for degrees in [0.0, 17.0, 45.0, 90.0, 133.0, 250.0_f64] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let program = from(10.0, 10.0, -3.0, &format!("X{} Y{}", 10.0 + 25.0 * cos, 10.0 + 25.0 * sin));
        let found = run(&program);
        has_sector(&found, &on_line(&found, 3, 0.05, 0.95), 0.0, PI, 3.0);
    }
}

#[test]
fn a_pass_beside_a_slot_conventional_and_climbing() {
    for width in [1.0, 3.0, 6.0, 9.0] {
        let angle = f64::acos(1.0 - width / RADIUS);
        // The material lies on the right of a tool that comes back below: climbing under M3.
        let below = from(0.0, 0.0, -3.0, &format!("X30\nY{width}\nX0"));
        let found = run(&below);
        has_sector(&found, &on_line(&found, 5, 0.3, 0.7), PI - angle, PI, 3.0);
        // With the spindle the other way round the same pass is conventional.
        let found = run(&below.replace("M3", "M4"));
        has_sector(&found, &on_line(&found, 5, 0.3, 0.7), 0.0, angle, 3.0);
        // Beside the slot on the other side of the feed.
        let found = run(&below.replace(&format!("Y{width}"), &format!("Y-{width}")));
        has_sector(&found, &on_line(&found, 5, 0.3, 0.7), 0.0, angle, 3.0);
    }
}

#[test]
fn a_step_gives_two_depths() {
    // A slot 2 mm deep, then one 5 mm deep half beside it.
    let found = run(&from(0.0, 0.0, -2.0, "X30\nG0 Z5\nX0 Y6\nG1 Z-5\nX30"));
    for place in on_line(&found, 7, 0.3, 0.7) {
        // What is left of the feed is untouched; on the right 3 mm stand below the slot.
        let [left, right] = found.sectors(&place) else { panic!("{:?}", found.sectors(&place)) };
        assert!(left.entry == 0.0 && (right.exit - PI).abs() < 1e-9);
        assert!((left.exit - FRAC_PI_2).abs() < NEAR && (right.entry - FRAC_PI_2).abs() < NEAR);
        assert!((left.depth - 5.0).abs() < 1e-9 && (right.depth - 3.0).abs() < 1e-9);
    }
}

#[test]
fn along_a_finished_wall_nothing_is_cut() {
    let found = run(&from(0.0, 0.0, -3.0, "X30\nX0\nX30"));
    assert!(found.places.iter().all(|place| place.line < 4), "{:?}", found.places.last());
}

#[test]
fn a_circle_in_the_full_is_cut_over_the_front_half() {
    let found = run(&from(20.0, 0.0, -3.0, "G3 X20 Y0 I-15 J0"));
    has_sector(&found, &on_line(&found, 3, 0.1, 0.6), 0.0, PI, 3.0);
}

/// A second circle, wider by w: in its front stand the points beyond the wall of the first,
/// |C + R û| > r1 + R. With the centre of the path on the left of the feed (G3) and φ from the left,
/// |C + R û|² = r2² + R² − 2 r2 R cos φ.
#[test]
fn a_wider_circle_is_cut_where_the_circles_of_the_tool_meet_the_wall() {
    let (first, second) = (10.0, 12.5);
    let found = run(&from(
        first,
        0.0,
        -3.0,
        &format!("G3 X{first} Y0 I-{first} J0\nG1 X{second}\nG3 X{second} Y0 I-{second} J0"),
    ));
    let wall: f64 = first + RADIUS;
    let cos = (second * second + RADIUS * RADIUS - wall * wall) / (2.0 * second * RADIUS);
    has_sector(&found, &on_line(&found, 5, 0.2, 0.9), cos.acos(), PI, 3.0);
}

/// Into a corner along a wall w deep, with the same w in front: cos φ < −(1 − w/R) on the right, and
/// at the end of the way sin φ > 1 − w/R in front.
#[test]
fn in_a_corner_the_engagement_grows_by_what_stands_in_front() {
    let width = 2.0;
    let free = RADIUS - width;
    // The slots leave a corner with walls at y = 0 and x = 0 beside them; the pass runs into it
    // along −x with the wall on its left.
    let found = run(&from(40.0, 6.0, -3.0, &format!("X6\nY40\nM4 G0 Z5\nX40 Y{free}\nG1 Z-3\nX{free}")));
    let places = on_line(&found, 8, 0.2, 1.0);
    let angle = f64::acos(1.0 - width / RADIUS);
    let before: Vec<CutPlace> =
        places.iter().filter(|place| place.distance < places[0].distance + 8.0).cloned().collect();
    has_sector(&found, &before, PI - angle, PI, 3.0);
    // At the corner itself the two meet: from the front wall's near end on.
    let last = places.last().expect("there are some");
    let entry = found.sectors(last)[0].entry;
    let exact = f64::asin(1.0 - width / RADIUS);
    let missing = 0.5 * last.length;
    // The last place is half a stretch before the corner.
    let there = f64::asin((free + missing) / RADIUS);
    assert!(exact <= there && (entry - there).abs() < NEAR, "{entry} {there}");
}

#[test]
fn a_tool_straight_down_has_no_sectors_and_its_volume_counts() {
    let found = run("G21 G90 G0 X10 Y10 Z5\nG1 Z-3 F1000");
    assert!(found.places.iter().all(|place| found.sectors(place).is_empty() && place.level < 1e-9));
    let removed: f64 = found.places.iter().map(|place| place.removed).sum();
    assert!((removed / (PI * RADIUS * RADIUS * 3.0) - 1.0).abs() < 0.01);
}
