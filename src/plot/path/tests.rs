use std::f64::consts::FRAC_PI_2;

use plotters::style::RGBColor;

use super::*;
use crate::machine::Machine;
use crate::simulation::feed::CornerPolicy;
use crate::simulation::gcode::read;
use crate::simulation::interpreter::trace;
use crate::simulation::profile::{Profile, Resolution};
use crate::simulation::simulate;

const PROGRAM: &str =
    "G21 G90 G94\nG0 X10 Y0 Z5\nG1 Z0 F600\nG1 X40 F3000\nG2 X40 Y20 I0 J10\nG1 X0\nG1 Y0\n";

fn whole() -> (Toolpath, Programmed, FeedCurve) {
    let machine = Machine::default();
    let toolpath = trace(&read(PROGRAM.as_bytes()), &machine);
    let plan = simulate::with_policy(&toolpath, &machine, CornerPolicy::Isolated(0.01));
    let curve = Profile::new(&toolpath, &plan).feed_curve(Resolution::CHART);
    let programmed = Programmed::of(&toolpath, &machine);
    (toolpath, programmed, curve)
}

fn scene(coloring: Coloring) -> Scene {
    let (toolpath, programmed, curve) = whole();
    Scene::new(&Trail::of(&toolpath), &programmed, &SteppedCurve::of(&curve), coloring)
}

fn seen(scene: &Scene, yaw: f64, pitch: f64) -> Camera {
    let mut camera = Camera { yaw, pitch, size: (600.0, 400.0), ..Camera::new() };
    camera.fit(scene);
    camera
}

const PLAIN: Light = Light { ground: RGBColor(255, 255, 255), reach: 1, first_pending: u32::MAX };

fn drawn(scene: &Scene, camera: Camera) -> Raster {
    let mut raster = Raster::default();
    super::raster(scene, &Drawing { camera, pen: 1, dash: 4.0, marked: None }, &mut raster);
    raster
}

#[test]
fn a_trail_is_as_long_as_its_path_and_stays_on_it() {
    let (toolpath, ..) = whole();
    let trail = Trail::of(&toolpath);
    let length: f64 = toolpath.segments.iter().map(|segment| segment.length).sum();
    assert!((trail.distance.last().unwrap() - length).abs() < 1e-9);
    for point in &trail.points {
        // Every point of the program lies on lines of the frame or on the circle about (40, 10).
        let [x, y, _] = point.map(f64::from);
        let on_circle = ((x - 40.0).hypot(y - 10.0) - 10.0).abs() < 1e-4;
        assert!(on_circle || x.abs() < 1e-4 || y.abs() < 1e-4 || (y - 20.0).abs() < 1e-4, "{point:?}");
    }
}

#[test]
fn a_pace_keeps_the_time_of_the_motion() {
    let (_, _, curve) = whole();
    let pace = SteppedCurve::of(&curve);
    let mut begin = 0.0;
    let time: f64 = pace
        .end
        .iter()
        .zip(&pace.value)
        .map(|(&end, value)| (end - std::mem::replace(&mut begin, end)) / value)
        .sum();
    assert!((time / curve.time.last().unwrap() - 1.0).abs() < 1e-9);
    assert!(pace.end.len() < curve.distance.len());
}

#[test]
fn a_scene_divides_the_trail_where_the_shade_changes() {
    let scene = scene(Coloring::Loss);
    assert!(scene.distance.windows(2).all(|pair| pair[0] <= pair[1]));
    assert_eq!(scene.rank[0], RAPID_RANK);
    let shades: std::collections::BTreeSet<u8> = scene.rank[..scene.rank.len() - 1].iter().copied().collect();
    assert!(shades.contains(&FIRST_SHADE_RANK), "at the programmed feedrate nothing is lost: {shades:?}");
    assert!(shades.contains(&(MARKED_RANK - 1)), "at a full stop all is lost: {shades:?}");
    assert!(!shades.contains(&0) && !shades.contains(&MARKED_RANK), "{shades:?}");
}

#[test]
fn all_of_a_fitted_path_is_in_sight() {
    let scene = scene(Coloring::Loss);
    for (yaw, pitch) in [(0.0, FRAC_PI_2), (0.0, 0.0), (FRAC_PI_2, 0.0), (-0.6, 0.5), (2.0, -1.0)] {
        let camera = seen(&scene, yaw, pitch);
        for point in &scene.points {
            let (x, y) = camera.project(point.map(f64::from));
            assert!((0.0..=600.0).contains(&x) && (0.0..=400.0).contains(&y), "{x} {y}");
        }
    }
}

#[test]
fn a_zoom_keeps_the_pixel_it_is_about() {
    let scene = scene(Coloring::Loss);
    let mut camera = seen(&scene, -0.6, 0.5);
    let point = scene.point(30.0).unwrap();
    let before = camera.project(point);
    camera.zoom(7.0, before);
    let after = camera.project(point);
    assert!((before.0 - after.0).abs() < 1e-6 && (before.1 - after.1).abs() < 1e-6);
    camera.pan(12.0, -5.0);
    let moved = camera.project(point);
    assert!((moved.0 - after.0 - 12.0).abs() < 1e-6 && (moved.1 - after.1 + 5.0).abs() < 1e-6);
}

#[test]
fn a_pixel_leads_back_to_its_place_on_the_path() {
    let scene = scene(Coloring::Loss);
    for (yaw, pitch) in [(0.0, FRAC_PI_2), (-0.6, 0.5)] {
        let camera = seen(&scene, yaw, pitch);
        let raster = drawn(&scene, camera);
        for k in 0..100 {
            // Rapids are dashed; and from above the plunge is a point.
            let distance = 17.0 + k as f64;
            let Some(point) = scene.point(distance).filter(|_| distance < *scene.distance.last().unwrap())
            else {
                break;
            };
            let (x, y) = camera.project(point);
            let found = raster.pick(&scene, &camera, (x, y), 3).expect("something is drawn there");
            // Seen obliquely a pixel is longer along the path; what counts is where it lies in the picture.
            let (column, row) = camera.project(scene.point(found).expect("it lies on the path"));
            assert!((column - x).hypot(row - y) < 4.0, "{found} for {distance}");
        }
        assert_eq!(raster.pick(&scene, &camera, (2.0, 2.0), 1), None, "nothing is drawn in the corner");
    }
}

#[test]
fn of_two_passes_the_worse_is_shown() {
    let points = vec![[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 0.0, 0.0]];
    for ranks in [[FIRST_SHADE_RANK, FIRST_SHADE_RANK + 9, 0], [FIRST_SHADE_RANK + 9, FIRST_SHADE_RANK, 0]] {
        let (distance, rank) = (vec![0.0, 10.0, 20.0], ranks.to_vec());
        let scene = Scene { points: points.clone(), distance, rank, ..Scene::default() }.bounded();
        let camera = seen(&scene, 0.0, FRAC_PI_2);
        let mut colors = Vec::new();
        let inks = ink(&palette(Coloring::Loss, false), false);
        drawn(&scene, camera).colors(&inks, &PLAIN, &mut colors);
        let shown: std::collections::BTreeSet<[u8; 3]> = colors
            .chunks(4)
            .filter(|pixel| pixel[3] != 0)
            .map(|pixel| [pixel[0], pixel[1], pixel[2]])
            .collect();
        let worst = inks[FIRST_SHADE_RANK as usize + 9].unwrap();
        assert_eq!(shown.into_iter().collect::<Vec<_>>(), [[worst.0, worst.1, worst.2]]);
    }
}

#[test]
fn of_two_passes_the_nearer_is_shown_and_what_lies_below_is_darker() {
    // A pass at the bottom, one 5 mm above half of it, and a rapid over both.
    let points = vec![
        [0.0, 0.0, 0.0],
        [20.0, 0.0, 0.0],
        [20.0, 0.0, 5.0],
        [10.0, 0.0, 5.0],
        [10.0, 1.0, 9.0],
        [0.0, 0.0, 9.0],
    ];
    let rank = vec![FIRST_SHADE_RANK + 3, FIRST_SHADE_RANK + 3, FIRST_SHADE_RANK, RAPID_RANK, RAPID_RANK, 0];
    let distance = vec![0.0, 20.0, 25.0, 35.0, 40.0, 50.0];
    let scene = Scene { points, distance, rank, ..Scene::default() }.bounded();
    assert_eq!(scene.bounds[1][2], 5.0, "the rapid is no part of what is fitted");
    assert!(scene.is_deep());
    let camera = seen(&scene, 0.0, FRAC_PI_2);
    let raster = drawn(&scene, camera);
    let found = |x: f64| {
        let (column, row) = camera.project([x, 0.0, 0.0]);
        raster.pick(&scene, &camera, (column, row), 2).expect("something is drawn there")
    };
    assert!((found(15.0) - 30.0).abs() < 0.2 && (found(5.0) - 5.0).abs() < 0.2);
    let light = Light { first_pending: 3, ..PLAIN };
    let ink = RGBColor(100, 50, 0);
    let [near, far, below] = [
        light.lit(ink, 0, 1.0, [1.0; 4]),
        light.lit(ink, 0, 0.0, [0.0; 4]),
        light.lit(ink, 0, 0.5, [1.0, 0.0, 0.0, 0.5]),
    ];
    assert_eq!(near, [100, 50, 0, 255]);
    assert!(near[0] < far[0] && far[2] < 255, "the far fades and keeps its colour: {far:?}");
    assert!(below[0] < light.lit(ink, 0, 0.5, [0.5; 4])[0]);
    assert!(200 < light.bare(ink, 3)[0] && light.bare(ink, 2) == near, "what is still to be run is pale");
}

#[test]
fn parts_have_colours_of_their_own() {
    let (toolpath, programmed, _) = whole();
    let parts = SteppedCurve { end: vec![20.0, 60.0, 1e9], value: vec![0.0, 1.0, 0.0] };
    let scene = Scene::new(&Trail::of(&toolpath), &programmed, &parts, Coloring::Part);
    let at = |distance: f64| scene.rank[scene.distance.partition_point(|&end| end <= distance) - 1];
    assert_eq!([at(18.0), at(30.0), at(70.0)], [FIRST_SHADE_RANK, FIRST_SHADE_RANK + 1, FIRST_SHADE_RANK]);
}

#[test]
fn shades_stand_out_from_the_ground() {
    let luminance = |color: RGBColor| {
        let linear = |c: u8| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(color.0) + 0.7152 * linear(color.1) + 0.0722 * linear(color.2)
    };
    for (dark, ground) in [(false, RGBColor(255, 255, 255)), (true, RGBColor(22, 26, 31))] {
        for coloring in [Coloring::Loss, Coloring::Feedrate(1.0), Coloring::Lost(1.0), Coloring::Part] {
            for color in palette(coloring, dark) {
                let (a, b) = (luminance(color), luminance(ground));
                let contrast = (a.max(b) + 0.05) / (a.min(b) + 0.05);
                assert!(3.0 <= contrast, "{color:?} on {ground:?}: {contrast}");
            }
        }
    }
}

#[test]
fn lines_far_outside_cost_nothing_and_break_nothing() {
    let points = vec![[-1e6, 0.0, 0.0], [1e6, 1.0, 0.0], [f32::MAX, 0.0, 0.0], [0.0, 0.0, 0.0]];
    let (distance, rank) = (vec![0.0, 1.0, 2.0, 3.0], vec![2, RAPID_RANK, 2, 0]);
    let scene = Scene { points, distance, rank, ..Scene::default() }.bounded();
    let camera = Camera { size: (100.0, 100.0), ..Camera::new() };
    let raster = drawn(&scene, camera);
    assert_eq!(raster.size(), (100, 100));
}

/// The picture of a scene as SVG.
fn sheet(scene: &Scene, marked: Option<(f64, f64)>) -> String {
    let inks = ink(&palette(Coloring::Loss, false), false);
    let camera = seen(scene, 0.0, FRAC_PI_2);
    let ends = ["0 %".to_string(), "100 %".to_string()];
    svg_of_path(scene, &Sheet { camera, marked, inks: &inks, ends, length: (10.0, "< 10 mm".to_string()) })
}

#[test]
fn a_document_shows_each_rank_in_its_colour_and_what_is_marked() {
    let scene = scene(Coloring::Loss);
    let inks = ink(&palette(Coloring::Loss, false), false);
    let text = sheet(&scene, Some((20.0, 30.0)));
    let document = roxmltree::Document::parse(&text).expect("it is XML");
    let strokes: Vec<_> = document.descendants().filter_map(|node| node.attribute("stroke")).collect();
    let hex = |RGBColor(r, g, b): RGBColor| format!("#{r:02x}{g:02x}{b:02x}");
    for &rank in scene.rank.iter().take(scene.points.len() - 1) {
        assert!(strokes.contains(&&*hex(inks[usize::from(rank)].expect("a rank has a colour"))), "{rank}");
    }
    let mark = hex(inks[usize::from(MARKED_RANK)].expect("the mark has a colour"));
    assert_eq!(strokes.iter().filter(|stroke| **stroke == mark).count(), 1);
    assert!(!sheet(&scene, None).contains(&mark));
    assert!(text.contains("&lt; 10 mm"));
}

#[test]
fn a_document_grows_with_what_is_seen_and_not_with_the_program() {
    let line = |points: usize| {
        let points: Vec<_> =
            (0..=points).map(|index| [100.0 * index as f32 / points as f32, 0.0, 0.0]).collect();
        let distance = points.iter().map(|point| f64::from(point[0])).collect();
        let rank = vec![FIRST_SHADE_RANK; points.len()];
        Scene { points, distance, rank, ..Scene::default() }.bounded()
    };
    let (few, many) = (sheet(&line(1_000), None).len(), sheet(&line(100_000), None).len());
    assert!(many < 2 * few, "{few} and {many} bytes");
}
