use std::f64::consts::FRAC_PI_2;

use plotters::style::RGBColor;

use super::*;
use crate::machine::Machine;
use crate::simulation::feed::Rule;
use crate::simulation::gcode::read;
use crate::simulation::profile::{Profile, Resolution};
use crate::simulation::simulate;
use crate::simulation::toolpath::trace;

const PROGRAM: &str =
    "G21 G90 G94\nG0 X10 Y0 Z5\nG1 Z0 F600\nG1 X40 F3000\nG2 X40 Y20 I0 J10\nG1 X0\nG1 Y0\n";

fn whole() -> (Toolpath, Programmed, FeedCurve) {
    let machine = Machine::default();
    let toolpath = trace(&read(PROGRAM.as_bytes()), &machine);
    let plan = simulate::by_rule(&toolpath, &machine, Rule::Isolated(0.01));
    let curve = Profile::new(&toolpath, &plan).feed_curve(Resolution::CHART);
    let programmed = Programmed::of(&toolpath, &machine);
    (toolpath, programmed, curve)
}

fn scene(coloring: Coloring) -> Scene {
    let (toolpath, programmed, curve) = whole();
    Scene::new(&Trail::of(&toolpath), &programmed, &Pace::of(&curve), coloring)
}

fn seen(scene: &Scene, yaw: f64, pitch: f64) -> Camera {
    let mut camera = Camera { yaw, pitch, size: (600.0, 400.0), ..Camera::new() };
    camera.fit(&scene.points);
    camera
}

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
    let pace = Pace::of(&curve);
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
    assert_eq!(scene.rank[0], RAPID);
    let shades: std::collections::BTreeSet<u8> = scene.rank[..scene.rank.len() - 1].iter().copied().collect();
    assert!(shades.contains(&FIRST_SHADE), "at the programmed feedrate nothing is lost: {shades:?}");
    assert!(shades.contains(&(MARKED - 1)), "at a full stop all is lost: {shades:?}");
    assert!(!shades.contains(&0) && !shades.contains(&MARKED), "{shades:?}");
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
    for ranks in [[FIRST_SHADE, FIRST_SHADE + 9, 0], [FIRST_SHADE + 9, FIRST_SHADE, 0]] {
        let scene = Scene { points: points.clone(), distance: vec![0.0, 10.0, 20.0], rank: ranks.to_vec() };
        let camera = seen(&scene, 0.0, FRAC_PI_2);
        let mut colors = Vec::new();
        let inks = ink(&palette(Coloring::Loss, false), false);
        drawn(&scene, camera).colors(&inks, &mut colors);
        let shown: std::collections::BTreeSet<[u8; 3]> = colors
            .chunks(4)
            .filter(|pixel| pixel[3] != 0)
            .map(|pixel| [pixel[0], pixel[1], pixel[2]])
            .collect();
        let worst = inks[FIRST_SHADE as usize + 9].unwrap();
        assert_eq!(shown.into_iter().collect::<Vec<_>>(), [[worst.0, worst.1, worst.2]]);
    }
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
        for coloring in [Coloring::Loss, Coloring::Feedrate(1.0), Coloring::Lost(1.0)] {
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
    let scene = Scene { points, distance: vec![0.0, 1.0, 2.0, 3.0], rank: vec![2, RAPID, 2, 0] };
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
    let mark = hex(inks[usize::from(MARKED)].expect("the mark has a colour"));
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
        let rank = vec![FIRST_SHADE; points.len()];
        Scene { points, distance, rank }
    };
    let (few, many) = (sheet(&line(1_000), None).len(), sheet(&line(100_000), None).len());
    assert!(many < 2 * few, "{few} and {many} bytes");
}
