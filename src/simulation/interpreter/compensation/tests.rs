//! Laws of compensation and of corner treatments.

use crate::machine::{Machine, Tool};
use crate::simulation::gcode::{Dialect, Options, read_with};
use crate::simulation::interpreter::trace::trace;
use crate::simulation::toolpath::compensation::{
    Contour, CornerShape, CornerTreatment, LeadIn, OuterCorner, Setting,
};
use crate::simulation::toolpath::plane::Plane;
use crate::simulation::toolpath::random::Random;
use crate::simulation::toolpath::{Curve, Motion, Point, Segment, Toolpath};
use std::fmt::Write;

fn run(text: &str) -> Toolpath {
    run_as(Dialect::Iso, text)
}

fn run_as(dialect: Dialect, text: &str) -> Toolpath {
    let mut machine = Machine::default();
    machine.tools.insert(1, Tool { diameter: 6.0 });
    machine.tools.insert(2, Tool { diameter: -6.0 });
    let options = Options { dialect: Some(dialect), ..Options::default() };
    let toolpath = trace(&read_with(text.as_bytes(), &options), &machine);
    check_laws(&toolpath, text);
    toolpath
}

/// What holds of every toolpath.
#[track_caller]
fn check_laws(toolpath: &Toolpath, text: &str) {
    assert!(toolpath.segments.iter().is_sorted_by_key(|segment| segment.line), "{text}");
    for segment in &toolpath.segments {
        assert!(0.0 < segment.length && segment.length.is_finite(), "{text}\n{segment:?}");
        let size = 1.0 + segment.start.coords.norm() + segment.end.coords.norm();
        assert!((segment.point(0.0) - segment.start).norm() <= 1e-9 * size, "{text}\n{segment:?}");
        assert!((segment.point(segment.length) - segment.end).norm() <= 1e-9 * size, "{text}\n{segment:?}");
    }
    assert!(toolpath.stops.is_sorted_by_key(|stop| stop.after), "{text}");
    assert!(toolpath.stops.iter().all(|stop| stop.after <= toolpath.segments.len()), "{text}");
}

fn messages(toolpath: &Toolpath) -> Vec<(u32, &str)> {
    toolpath.diagnostics.iter().map(|found| (found.line.0, found.message.as_str())).collect()
}

fn ends(toolpath: &Toolpath) -> Vec<[f64; 2]> {
    toolpath
        .segments
        .iter()
        .map(|segment| [segment.end.x, segment.end.y].map(|x| (1e6 * x).round() / 1e6))
        .collect()
}

impl Random {
    fn unit(&mut self) -> f64 {
        self.below(1_000_000) as f64 / 1e6
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

/// Points every 0.02 mm along segments, with their ends.
fn samples(segments: impl IntoIterator<Item = Segment>) -> Vec<Point> {
    let along = |segment: Segment| {
        let count = (segment.length / 0.02).ceil().max(1.0) as usize;
        (0..=count).map(move |k| segment.point(segment.length * k as f64 / count as f64))
    };
    segments.into_iter().flat_map(along).collect()
}

/// A random contour in blocks, from X0 Y0 along X: lines and arcs that are longer and wider than
/// a tool of 3 mm radius needs, with smooth, convex and concave corners. `is_turned`: by a
/// quarter turn counter-clockwise.
fn contour(random: &mut Random, moves: usize, is_turned: bool) -> Vec<String> {
    let turned = |x: f64, y: f64| if is_turned { (-y, x) } else { (x, y) };
    let (mut x, mut y, mut direction) = (0.0f64, 0.0f64, 0.0f64);
    let mut blocks = Vec::new();
    for _ in 0..moves {
        if random.below(4) != 0 {
            direction += random.between(-1.3, 1.3);
        }
        if random.below(2) == 0 {
            let length = random.between(15.0, 30.0);
            (x, y) = (x + length * direction.cos(), y + length * direction.sin());
            let (a, b) = turned(x, y);
            blocks.push(format!("G1 X{a:.12} Y{b:.12}"));
        } else {
            let turn = if random.below(2) == 0 { 1.0 } else { -1.0 };
            let (radius, sweep) = (random.between(15.0, 30.0), random.between(0.6, 1.5));
            let (i, j) = (-turn * direction.sin() * radius, turn * direction.cos() * radius);
            direction += turn * sweep;
            (x, y) = (x + i + turn * direction.sin() * radius, y + j - turn * direction.cos() * radius);
            let ((a, b), (i, j)) = (turned(x, y), turned(i, j));
            let g = if 0.0 < turn { 3 } else { 2 };
            blocks.push(format!("G{g} X{a:.12} Y{b:.12} I{i:.12} J{j:.12}"));
        }
    }
    blocks
}

/// A program that leads in from X-20, or from Y-20 where it is turned; the contour begins in line 5.
fn program(word: &str, blocks: &[String], is_turned: bool) -> String {
    let start = if is_turned { "G0 X0 Y-20" } else { "G0 X-20 Y0" };
    format!("F1000\n{start}\n{word}\nG1 X0 Y0\n{}\nG40\n", blocks.join("\n"))
}

/// Checked by dense sampling of the contour, which knows nothing of parallels: each move of the
/// path lies at the radius from the block it is made for, an arc around a corner at the radius
/// from the corner, and no point is nearer than that to the blocks before and after. On other controls than
/// LinuxCNC the tool may stand across the move that leads in.
#[test]
fn the_path_keeps_the_radius_from_the_contour() {
    let mut random = Random(0xC0FFEE);
    // Turns too slight for a corner are passed in a straight line.
    let (radius, slight) = (3.0, 3.0 * (1.0 - 0.05f64.cos()) + 1e-4);
    let mut compared = 0;
    for case in 0..120 {
        let blocks = contour(&mut random, 6, false);
        let contour = run(&program("G40", &blocks, false));
        let text = program(if case % 2 == 0 { "G41.1 D6" } else { "G42.1 D6" }, &blocks, false);
        let path = run_as(Dialect::LinuxCnc, &text);
        if !path.diagnostics.is_empty() {
            continue;
        }
        let of_line = |line: u32| samples(contour.segments.iter().filter(|segment| segment.line.0 == line));
        for segment in path.segments.iter().filter(|segment| 5 <= segment.line.0) {
            let line = segment.line.0;
            let parts = [of_line(line - 1), of_line(line), of_line(line + 1)];
            for point in samples([segment]).iter().step_by(11) {
                let distance = |part: &Vec<Point>| {
                    let squares = part.iter().map(|on| (on - point).norm_squared());
                    squares.fold(f64::INFINITY, f64::min).sqrt()
                };
                let [before, own, after] = parts.each_ref().map(distance);
                assert!((own - radius).abs() <= slight, "{text}\n{point} of line {line}: {own} mm");
                assert!(radius - slight <= before.min(after), "{text}\n{point}: {before}, {after}");
                compared += 1;
            }
        }
    }
    assert!(20_000 < compared, "{compared}");
}

#[test]
fn a_turned_program_gives_the_turned_path() {
    for seed in 1..40 {
        let [one, two] = [false, true].map(|is_turned| {
            let blocks = contour(&mut Random(seed), 8, is_turned);
            run(&program("G42.1 D6", &blocks, is_turned))
        });
        assert_eq!(one.segments.len(), two.segments.len());
        for (one, two) in one.segments.iter().zip(&two.segments).skip(1) {
            for share in [0.0, 0.5, 1.0] {
                let (p, q) = (one.point(share * one.length), two.point(share * two.length));
                assert!((Point::new(-p.y, p.x, p.z) - q).norm() < 1e-8, "{one:?}\n{two:?}");
            }
        }
    }
}

/// The path on the left of a contour is the one on the right of the contour run backwards, but
/// for lead-in and end.
#[test]
fn left_is_right_of_the_contour_run_backwards() {
    let mut random = Random(99);
    let mut compared = 0;
    for _ in 0..40 {
        let mut corners = vec![(0.0, 0.0), (20.0, 0.0)];
        let mut direction: f64 = 0.0;
        for _ in 0..8 {
            direction += random.between(-1.5, 1.5);
            let (x, y): (f64, f64) = corners[corners.len() - 1];
            let length = random.between(15.0, 25.0);
            corners.push((x + length * direction.cos(), y + length * direction.sin()));
        }
        let path = |word: &str, corners: &[(f64, f64)]| {
            let (from, to) = (corners[0], corners[1]);
            let (dx, dy) = (from.0 - to.0, from.1 - to.1);
            let mut text = format!("F1000\nG0 X{:.12} Y{:.12}\n{word} D6\n", from.0 + dx, from.1 + dy);
            for (x, y) in corners {
                writeln!(text, "G1 X{x:.12} Y{y:.12}").expect("text grows");
            }
            run(&format!("{text}G40\n"))
        };
        let backwards: Vec<_> = corners.iter().rev().copied().collect();
        let (left, right) = (path("G41.1", &corners), path("G42.1", &backwards));
        if !left.diagnostics.is_empty() {
            continue;
        }
        assert_eq!(left.segments.len(), right.segments.len());
        for (one, two) in left.segments.iter().skip(2).zip(right.segments.iter().skip(2).rev()) {
            for share in [0.0, 0.4, 1.0] {
                let apart = one.point(share * one.length) - two.point((1.0 - share) * two.length);
                // An inner corner keeps no trace of the direction; a slight turn does.
                assert!(apart.norm() < 0.16, "{one:?}\n{two:?}");
                compared += usize::from(apart.norm() < 1e-8);
            }
        }
    }
    assert!(400 < compared, "{compared}");
}

#[test]
fn no_radius_leaves_every_bit_as_it_was() {
    for seed in 1..20 {
        let blocks = contour(&mut Random(seed), 8, false);
        let off = run(&program("G40", &blocks, false));
        for word in ["G41.1 D0", "G42.1 D0", "G41 D0"] {
            assert_eq!(run(&program(word, &blocks, false)), off);
        }
        let unknown = run(&program("G42 D7", &blocks, false));
        assert_eq!(unknown.segments, off.segments);
        let expected = "cutter compensation: the diameter of tool 7 is unknown: path taken as programmed; set tools.7.diameter_mm";
        assert_eq!(messages(&unknown), [(3, expected)]);
    }
}

/// Diameters come from the table, from the word and from the tool in the spindle; a negative one
/// changes the side.
#[test]
fn diameters_are_found() {
    let blocks = contour(&mut Random(5), 8, false);
    let expected = run(&program("G41.1 D6", &blocks, false)).segments;
    for word in ["G41 D1", "T1 M6 G41", "T1 G41", "G42 D2", "G42.1 D-6"] {
        assert_eq!(run(&program(word, &blocks, false)).segments, expected, "{word}");
    }
    let next_is_ready = run(&program("G41", &blocks, false).replacen("F1000", "F1000 T1 M6\nT2", 1));
    for (found, expected) in next_is_ready.segments.iter().zip(&expected) {
        assert_eq!(found.end, expected.end);
    }
    // A tape keeps its D.
    let tape =
        |again: &str| run(&format!("%\nT3 M6\nG41 D1 G1 X10 F100\nG40 X0\nG41 {again}\nX20\nX30\n%\n"));
    assert_eq!(tape("").segments, tape("D1").segments);
    let inch = run(&program("G20 G41.1 D0.5 G21", &blocks, false));
    assert_ne!(inch.segments, expected);
    let none = run("G41\nG1 X10 F100\n");
    assert!(messages(&none)[0].1.contains("without a tool number"));
    assert!(messages(&run("G41 D1.5\nG1 X10 F100\n"))[0].1.contains("D1.5 is no tool number"));
}

/// Stops stay between the moves they were written between, whatever is kept back.
#[test]
fn stops_and_heights_stay_in_their_place() {
    let path = run("F600\nG41.1 D4\nM8\nG1 X10 Y0\nG4 P1\nY20\nM9\nG1 Z-5\nG4 P2\nX-10\nM7\nG40\nM30\n");
    assert_eq!(messages(&path), [(5, "P of G4 is read as seconds")]);
    // Left of X+, then an inner corner to Y+, then one to X-.
    assert_eq!(ends(&path), [[8.0, 0.0], [8.0, 18.0], [8.0, 18.0], [-10.0, 18.0]]);
    let lines: Vec<_> = path.segments.iter().map(|segment| segment.line.0).collect();
    assert_eq!(lines, [4, 6, 8, 10]);
    let stops: Vec<_> = path.stops.iter().map(|stop| (stop.line.0, stop.after)).collect();
    assert_eq!(stops, [(3, 0), (5, 1), (7, 2), (9, 3), (11, 4), (13, 4)]);
    assert_eq!(path.segments.at(2).end.z, -5.0);
}

/// Fanuc and Siemens lead in square to the start of the second move, whatever the corner; all lead out from
/// square to the end of the last one.
#[test]
fn the_lead_in_ends_as_on_the_control() {
    use Dialect::{Iso, LinuxCnc, Okuma, Siemens};
    let word = |dialect| if dialect == Siemens { "T1 D1\nG41" } else { "G41 D1" };
    let inner = |dialect| {
        let text = format!("F600\nG0 X25 Y25\n{}\nG1 X0\nY0\nX50\nG40 Y25\n", word(dialect));
        ends(&run_as(dialect, &text))
    };
    let outer = |dialect| {
        let text = format!("F600\nG0 X-20 Y0\n{}\nG1 X0\nY-20\nG40 X20\n", word(dialect));
        ends(&run_as(dialect, &text))
    };
    for dialect in [Iso, Okuma, Siemens] {
        assert_eq!(inner(dialect), [[25.0, 25.0], [3.0, 25.0], [3.0, 3.0], [50.0, 3.0], [50.0, 25.0]]);
        assert_eq!(outer(dialect), [[-20.0, 0.0], [3.0, 0.0], [3.0, -20.0], [20.0, -20.0]]);
    }
    assert_eq!(inner(LinuxCnc), [[25.0, 25.0], [3.0, 22.0], [3.0, 3.0], [50.0, 3.0], [50.0, 25.0]]);
    assert_eq!(outer(LinuxCnc)[1..3], [[0.0, 3.0], [3.0, 0.0]]);
}

/// A tool as wide as a rounding stands still in it.
#[test]
fn an_arc_of_the_tools_own_radius_is_no_gouge() {
    let path = |radius: &str| run(&format!("F600\nG0 X-20\nG41 D1\nG1 X0\nX40,R{radius}\nY40\nG40 Y60\n"));
    let same = path("3.");
    assert_eq!(messages(&same), []);
    assert_eq!(ends(&same), [[-20.0, 0.0], [0.0, 3.0], [37.0, 3.0], [37.0, 40.0], [40.0, 60.0]]);
    assert!(messages(&path("2.9"))[0].1.contains("gouge"));
}

/// What does not fit is left out or run straight, and says so.
#[test]
fn gouges_are_named() {
    let first = |text: &str| {
        let path = run(text);
        let found = messages(&path).first().map(|(line, message)| (*line, message.to_string()));
        (found, ends(&path))
    };
    // A step of 1 mm under a tool of 5 mm radius.
    let (found, path) = first("F600\nG41.1 D10\nG1 X20 Y0\nX40\nY1\nX30 Y31\nY60\nG40\n");
    let (line, message) = found.expect("a gouge");
    assert_eq!(line, 5);
    assert!(message.contains("leaves it out and joins the moves around it"), "{message}");
    assert_eq!(path.last(), Some(&[25.0, 60.0]));
    // An inner arc of 2 mm between two walls.
    let (found, path) = first("F600\nG41.1 D10\nG1 X20 Y0\nX38\nG3 X40 Y2 J2\nG1 Y40\nG40\n");
    assert!(found.expect("a gouge").1.contains("does not fit into this inner arc"));
    assert_eq!(path[path.len() - 2..], [[35.0, 5.0], [35.0, 40.0]]);
    let (found, _) = first("F600\nG41.1 D10\nG1 X2 Y0\nX40\nG40\n");
    assert!(found.expect("a warning").1.contains("not longer than the tool radius"));
}

/// Any moves at all: no panic, a whole chain, and no more moves than a few for each block.
#[test]
fn any_moves_are_survived() {
    let mut random = Random(7);
    for case in 0..300 {
        let mut text = String::from("F1000 G91.1\n");
        let blocks = 60;
        for _ in 0..blocks {
            let mut value = || match random.below(4) {
                0 => 0.0,
                1 => (random.below(5) as f64) - 2.0,
                _ => random.between(-8.0, 8.0),
            };
            let (x, y, i, j) = (value(), value(), value(), value());
            match random.below(16) {
                0 => writeln!(text, "G41.1 D{:.3}", random.between(-4.0, 12.0)),
                1 => writeln!(text, "G42.1 D{:.3}", random.between(0.0, 12.0)),
                2 => writeln!(text, "G40"),
                3 => writeln!(text, "G{} Z{x:.2}", random.below(2)),
                4 => writeln!(text, "G1{} X{y:.2}", 7 + random.below(3)),
                5 => writeln!(text, "G{} I{i:.3} J{j:.3} K{x:.3}", 2 + random.below(2)),
                6 | 7 => writeln!(text, "G{} X{x:.3} Y{y:.3} I{i:.3} J{j:.3}", 2 + random.below(2)),
                8 => writeln!(text, "G{} X{x:.3} Y{y:.3} R{i:.3}", 2 + random.below(2)),
                9 => writeln!(text, "G4 P1"),
                10 => writeln!(text, "G0 X{x:.3} Y{y:.3}"),
                _ => writeln!(text, "G1 X{x:.3} Y{y:.3}"),
            }
            .expect("text grows");
        }
        let path = run(&text);
        assert!(path.segments.len() <= 3 * blocks + 3, "case {case}\n{text}");
    }
}

/// The path of the blocks with a treatment of their corners, all or by index.
fn treated(text: &str, setting: Option<Setting>, at: impl Fn(usize) -> Option<CornerTreatment>) -> Toolpath {
    let mut contour = Contour::new(LeadIn::SquareToItself);
    let mut path = Toolpath::default();
    contour.set(setting, &mut path);
    for (index, segment) in run(text).segments.into_iter().enumerate() {
        contour.add(segment, Plane::Xy, &mut path);
        if let Some(treatment) = at(index) {
            contour.treat_next_corner(treatment, Plane::Xy, &mut path);
        }
    }
    contour.finish(&mut path);
    for (line, remark) in contour.take_remarks() {
        let (message, severity) = (remark.to_string(), remark.severity());
        path.diagnostics.push(crate::simulation::gcode::Diagnostic {
            line,
            columns: Default::default(),
            severity,
            message,
        });
    }
    check_laws(&path, text);
    path
}

const SQUARE: &str = "F600\nG1 X40\nY40\nX0 Z8\nY0\n";

fn rounding(radius: f64) -> Option<CornerTreatment> {
    Some(CornerTreatment { shape: CornerShape::Rounding { radius }, feedrate: None })
}

fn length(path: &Toolpath) -> f64 {
    path.segments.iter().map(|segment| segment.length).sum()
}

/// Three corners of the square: nothing is bent, and the length is that of the square less
/// 2 r − π r / 2 for each.
#[test]
fn roundings_touch_both_moves() {
    let flat = SQUARE.replace(" Z8", "");
    let path = treated(&flat, None, |_| rounding(5.0));
    assert!(path.diagnostics.is_empty());
    assert_eq!(path.segments.len(), 7);
    for (before, after) in path.segments.pairs() {
        assert!((before.tangent(before.length) - after.tangent(0.0)).norm() < 1e-9);
    }
    let expected = 160.0 - 3.0 * (10.0 - 2.5 * std::f64::consts::PI);
    assert!((length(&path) - expected).abs() < 1e-9);
    let risen = treated(SQUARE, None, |_| rounding(5.0));
    assert_eq!(risen.segments.last().map(|last| last.end), Some(Point::new(0.0, 0.0, 8.0)));
    assert!(risen.segments.pairs().all(|(before, after)| before.end.z <= after.end.z));
    // The line in X has 40 mm for its 8; its corners take 5 mm off each end.
    assert_eq!(risen.segments.at(3).end.z, 1.0);
}

#[test]
fn roundings_touch_arcs_too() {
    let random = &mut Random(3);
    let (mut rounded, mut left_out) = (0, 0);
    for _ in 0..60 {
        let text = format!("F600\n{}\n", contour(random, 8, false).join("\n"));
        let path = treated(&text, None, |_| rounding(2.0));
        for (before, after) in path.segments.pairs() {
            let bend = (before.tangent(before.length) - after.tangent(0.0)).norm();
            let is_said = path.diagnostics.iter().any(|found| found.line == before.line);
            assert!(bend < 2e-4 || is_said, "{bend}\n{text}\n{:?}", path.diagnostics);
        }
        left_out += path.diagnostics.len();
        rounded += path.segments.len() - 8;
    }
    assert!(200 < rounded && left_out < rounded / 10, "{rounded}, {left_out}");
}

#[test]
fn chamfers_take_off_what_they_say() {
    let flat = SQUARE.replace(" Z8", "");
    let chamfer = |shape| move |index| (index == 0).then_some(CornerTreatment { shape, feedrate: Some(3.0) });
    let by_leg = treated(&flat, None, chamfer(CornerShape::Chamfer { leg: 4.0 }));
    assert_eq!(ends(&by_leg)[..2], [[36.0, 0.0], [40.0, 4.0]]);
    assert_eq!(by_leg.segments.at(1).motion, Motion::Feed { feedrate: 3.0 });
    assert_eq!(by_leg.segments.at(2).motion, Motion::Feed { feedrate: 10.0 });
    let by_width = treated(&flat, None, chamfer(CornerShape::ChamferWidth { width: 4.0 * 2f64.sqrt() }));
    assert_eq!(ends(&by_width), ends(&by_leg));
    let whole = treated(&flat, None, chamfer(CornerShape::Chamfer { leg: 40.0 }));
    assert_eq!(ends(&whole), [[40.0, 40.0], [0.0, 40.0], [0.0, 0.0]]);
    let wide = treated(&flat, None, chamfer(CornerShape::Chamfer { leg: 41.0 }));
    assert_eq!(wide.segments, run(&flat).segments);
    assert_eq!(messages(&wide), [(2, "no room for the chamfer between this move and the next: left out")]);
}

/// Rounding comes before compensation: on the outside the arc is wider by the tool radius.
#[test]
fn compensation_runs_beside_roundings() {
    let text = SQUARE.replace(" Z8", "").replacen("G1", "G1 X-20\nX0\nG1", 1);
    let right = |radius| Some(Setting { plane: Plane::Xy, side: -1.0, radius });
    let path = treated(&text, right(2.0), |index| rounding(5.0).filter(|_| 1 < index));
    assert!(path.diagnostics.is_empty());
    let radii = path.segments.iter().filter_map(|segment| match &segment.curve {
        Curve::Arc(arc) => Some((1e9 * arc.start_radius).round() / 1e9),
        Curve::Line => None,
    });
    // The first goes around the end of the move that leads in.
    assert_eq!(radii.collect::<Vec<_>>(), [2.0, 7.0, 7.0, 7.0]);
}

/// With corners prolonged, a square outside has no arcs and sharp corners; a turn of 150° is
/// beyond reach and gets an arc.
#[test]
fn outer_corners_can_be_prolonged() {
    let path = |outer_corner, text: &str| {
        let (mut contour, mut path) = (Contour::new(LeadIn::SquareToItself), Toolpath::default());
        contour.set_outer_corner_rule(outer_corner);
        contour.set(Some(Setting { plane: Plane::Xy, side: -1.0, radius: 2.0 }), &mut path);
        for segment in &run(text).segments {
            contour.add(segment, Plane::Xy, &mut path);
        }
        contour.finish(&mut path);
        check_laws(&path, text);
        ends(&path)
    };
    let text = "F600\nG1 X20\nX40\nY40\nX20 Y5.3589838\n";
    let sharp = path(OuterCorner::Intersection { reach: 2.0 }, text);
    assert_eq!(sharp[..3], [[20.0, -2.0], [42.0, -2.0], [42.0, 40.0]]);
    assert_eq!(sharp.len(), 5);
    assert_eq!(path(OuterCorner::Arc, text).len(), 6);
}

/// A rounding of every corner leaves the moves square to the plane and rapids alone, and ends.
#[test]
fn every_corner_is_treated_until_it_is_taken_back() {
    let text = "F600\nG1 X20\nY20\nZ-5\nX0\nG0 Y40\nG1 X30\nY0\n";
    let (mut contour, mut path) = (Contour::new(LeadIn::SquareToItself), Toolpath::default());
    contour.treat_every_corner(rounding(3.0));
    for (index, segment) in run(text).segments.into_iter().enumerate() {
        contour.add(segment, Plane::Xy, &mut path);
        if index == 5 {
            contour.treat_every_corner(None);
        }
    }
    contour.finish(&mut path);
    check_laws(&path, text);
    assert!(contour.take_remarks().is_empty());
    let arcs = path.segments.iter().filter(|segment| matches!(segment.curve, Curve::Arc(_)));
    assert_eq!(arcs.map(|segment| segment.line.0).collect::<Vec<_>>(), [2]);
}
