//! Blocks as a control runs them: arcs as chords, and ends at whole steps.
//!
//! An arc of radius r, sweep θ and length L becomes n chords of equal sweep, each a block like any other:
//!
//! ```text
//! by distance δ from the arc    n = ⌊ θ r / (2 √(δ (2 r − δ))) ⌋     δ in mm; grbl $12
//! by length c                   n = ⌊ L / c ⌋                        c in mm; Klipper `resolution`
//! ```
//!
//! and at least one. The control applies its corner law between chords, and along each chord the acceleration
//! limit of the direction of the chord. Settings of the machine for arcs (contour tolerance of arcs,
//! centripetal acceleration) then have no effect.
//!
//! Source: grbl 1.1, motion_control.c, mc_arc; Klipper, gcode_arcs.py. Limits: if a program would have more
//! chords than [`MAX_ARC_CHORDS`] plus [`MAX_CHORDS_PER_SEGMENT`] for each of its segments, all chords are
//! lengthened in proportion.
//!
//! Both controls turn the radius of the start; only the last chord ends at the programmed end, whose radius may differ by the
//! last digit of the program. The last chord then turns more sharply than the others, and the control slows down for it.
//!
//! A control of stepping motors plans from whole steps: with the step s of an axis (mm), a line or chord ends at
//!
//! ```text
//! s ⌊ x / s + 1/2 ⌋              x programmed position, mm; grbl, planner.c, plan_buffer_line
//! ```
//!
//! so that short blocks turn by other angles than the program says, by about s divided by their length, and lines without a step
//! are dropped. Limits: the steps are counted from the zero of the program.

use crate::machine::{ArcChords, Machine};
use crate::simulation::feed::substitute::{Cover, Substitute};
use crate::simulation::toolpath::{Arc, Curve, Point, Rotation, Segment, Toolpath};

/// Most chords of all arcs of a program, in addition to [`MAX_CHORDS_PER_SEGMENT`].
const MAX_ARC_CHORDS: f64 = 1e6;

/// Most chords for each segment of the program, on average.
const MAX_CHORDS_PER_SEGMENT: f64 = 64.0;

/// Largest rounding error of a position, steps.
const MAX_ROUNDING_STEPS: f64 = 1e-6;

/// Returns the toolpath with the blocks that the control runs; `None` if these are the program's: if arcs are run whole or
/// there are none, and no axis has steps.
pub fn blocks(toolpath: &Toolpath, machine: &Machine) -> Option<Substitute> {
    let rule = machine.interpolator.arc_chords;
    let steps = machine.axes.map(|axis| axis.step);
    let all: f64 = match rule {
        ArcChords::Whole => 0.0,
        _ => toolpath.segments.iter().map(|segment| count(&segment, rule)).sum(),
    };
    if all == 0.0 && steps == [0.0; 3] {
        return None;
    }
    let most = MAX_ARC_CHORDS + MAX_CHORDS_PER_SEGMENT * toolpath.segments.len() as f64;
    let share = (most / all).min(1.0);
    let mut at_steps = AtWholeSteps { blocks: Substitute::default(), steps, dropped: None };
    for (number, segment) in toolpath.segments.iter().enumerate() {
        at_steps.blocks.take_before(toolpath, number);
        if segment.curve == Curve::Line || rule == ArcChords::Whole {
            let cover = Cover::whole(number, segment.length);
            at_steps.push(segment, cover);
        } else {
            let chords = (share * count(&segment, rule)).floor().max(1.0) as usize;
            add_chords(&mut at_steps, number, &segment, chords);
        }
    }
    let mut blocks = at_steps.finished()?;
    blocks.take_stops(toolpath, usize::MAX);
    Some(blocks)
}

/// The blocks of a control whose axes have steps.
struct AtWholeSteps {
    blocks: Substitute,
    /// Distance of one step of each axis, mm; 0 for an axis without steps.
    steps: [f64; 3],
    /// The part of the program since the last block that is shorter than a step.
    dropped: Option<Cover>,
}

impl AtWholeSteps {
    /// Adds a block that begins and ends at whole steps. The control drops a line that begins and ends at the same ones.
    fn push(&mut self, mut block: Segment, cover: Cover) {
        let has_steps = self.steps != [0.0; 3];
        if has_steps {
            (block.start, block.end) = (self.rounded(block.start), self.rounded(block.end));
            if block.curve == Curve::Line && block.rotation.is_none() {
                block.length = (block.end - block.start).norm();
            }
        }
        let cover = match self.dropped.take() {
            Some(before) => Cover { last: cover.last, length: before.length + cover.length, ..before },
            None => cover,
        };
        if has_steps && block.length == 0.0 {
            self.dropped = Some(cover);
        } else {
            self.blocks.push(block, cover);
        }
    }

    fn rounded(&self, mut point: Point) -> Point {
        for (axis, step) in self.steps.into_iter().enumerate().filter(|(_, step)| 0.0 < *step) {
            point[axis] = step * nearest_whole(point[axis] / step);
        }
        point
    }

    /// Returns the blocks, the last of which covers what was dropped after it; `None` if there is no block.
    fn finished(mut self) -> Option<Substitute> {
        let last = self.blocks.covers.last_mut()?;
        if let Some(dropped) = self.dropped {
            (last.last, last.length) = (dropped.last, last.length + dropped.length);
        }
        Some(self.blocks)
    }
}

/// Returns the nearest whole number of steps; of two that are as near, but for rounding errors, the larger in size, as
/// `lround` does.
fn nearest_whole(steps: f64) -> f64 {
    (steps.abs() + MAX_ROUNDING_STEPS).round().copysign(steps)
}

/// Returns the number of chords of an arc by the rule; 0 for a line.
fn count(segment: &Segment, rule: ArcChords) -> f64 {
    let Curve::Arc(arc) = &segment.curve else { return 0.0 };
    let count = match rule {
        ArcChords::Whole => 1.0,
        ArcChords::Within(distance) => by_distance(arc, distance),
        ArcChords::Long(length) => segment.length / length,
    };
    count.floor().max(1.0)
}

fn by_distance(arc: &Arc, distance: f64) -> f64 {
    let radius = arc.start_radius;
    // Half a chord, squared; an arc that lies within the distance of its centre is a single chord.
    let square = distance * (2.0 * radius - distance);
    if 0.0 < square { 0.5 * arc.sweep * radius / square.sqrt() } else { 1.0 }
}

/// Returns the arc with its radius at the start all the way.
fn of_start_radius(segment: &Segment) -> Segment {
    let mut turned = segment.clone();
    if let Curve::Arc(arc) = &mut turned.curve {
        let mut whole = (**arc).clone();
        whole.end_radius = whole.start_radius;
        *arc = whole.into();
    }
    turned
}

fn add_chords(blocks: &mut AtWholeSteps, number: usize, segment: &Segment, chords: usize) {
    let part = segment.length / chords as f64;
    let rotation = Rotation::from(*segment.rotation / chords as f64);
    let turned = of_start_radius(segment);
    let mut start = segment.start;
    for k in 0..chords {
        let is_last = k + 1 == chords;
        let end = if is_last { segment.end } else { turned.point(part * (k + 1) as f64) };
        let length = (end - start).norm();
        // The chord of a full circle has no length.
        let (curve, length) =
            if 0.0 < length { (Curve::Line, length) } else { (segment.curve.clone(), part) };
        let exact_stop = is_last && segment.exact_stop;
        let chord = Segment { start, end, curve, length, rotation: rotation.clone(), exact_stop, ..*segment };
        blocks.push(chord, Cover { first: number, offset: part * k as f64, last: number, length: part });
        start = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{Junction, TimeConstants};
    use crate::simulation::feed::{FeedPlan, Tolerances, command};
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;
    use crate::simulation::toolpath::Vector;
    use std::f64::consts::TAU;

    fn machine(arc_chords: ArcChords) -> Machine {
        let mut machine = Machine::default();
        machine.interpolator.filters = 1;
        machine.interpolator.time_constants = TimeConstants::Equal(1e-4);
        machine.interpolator.contour_tolerance = 10.0;
        machine.interpolator.arc_chords = arc_chords;
        machine
    }

    fn chords_of(program: &str, rule: ArcChords) -> Option<(Toolpath, Substitute)> {
        let machine = machine(rule);
        let toolpath = trace(&read(program.as_bytes()), &machine);
        blocks(&toolpath, &machine).map(|chorded| (toolpath, chorded))
    }

    const CIRCLE: &str = "G1 F2000 X10\nG2 X10 Y0 I-5 J0\nG1 X20\n";

    /// An arc in inches whose end is 2.5 µm off its circle, as four decimals make it.
    #[test]
    fn the_last_chord_goes_from_the_circle_of_the_start_to_the_programmed_end() {
        let program = "G20 G1 F100 X0 Y0\nG3 X0 Y0.2179 I0 J0.1089\n";
        let (toolpath, chorded) = chords_of(program, ArcChords::Long(0.1)).expect("there is an arc");
        let arc = toolpath.segments.iter().next_back().expect("an arc");
        let center = arc.start + Vector::new(0.0, 0.1089 * 25.4, 0.0);
        let chords: Vec<Segment> = chorded.toolpath.segments.iter().collect();
        let (last, others) = chords.split_last().expect("chords");
        for chord in others {
            assert!(((chord.end - center).norm() - 0.1089 * 25.4).abs() < 1e-9);
        }
        assert_eq!(last.end, arc.end);
        let turn = |one: &Segment, other: &Segment| one.tangent(0.0).angle(&other.tangent(0.0));
        let usual = turn(&others[0], &others[1]);
        assert!(0.02 < (turn(&others[others.len() - 1], last) - usual).abs(), "{usual}");
    }

    /// Lines of 0.1 mm in one direction, whose ends lie between steps of 0.004 mm.
    #[test]
    fn short_lines_turn_by_the_angles_between_whole_steps() {
        let points =
            (1..40).map(|k| format!("G1 F3000 X{:.3} Y{:.3}\n", 0.1 * f64::from(k), 0.017 * f64::from(k)));
        let program = format!("{}X3.9 Y0.6631\nZ-0.001\n", points.collect::<String>());
        let mut machine = machine(ArcChords::Whole);
        machine.interpolator.junction = Junction::Deviation(2e-5);
        machine.axes.iter_mut().for_each(|axis| axis.acceleration = 5000.0);
        let toolpath = trace(&read(program.as_bytes()), &machine);
        assert!(blocks(&toolpath, &machine).is_none(), "no step and no arc");
        let exact = command(&toolpath, &machine, Tolerances::Programmed.into());
        machine.axes.iter_mut().for_each(|axis| axis.step = 0.004);
        let at_steps = blocks(&toolpath, &machine).expect("the axes have steps");
        for (block, line) in at_steps.toolpath.segments.iter().zip(toolpath.segments.iter()).take(39) {
            for axis in 0..3 {
                let steps = block.end[axis] / 0.004;
                assert!((steps - steps.round()).abs() < 1e-9, "{} mm", block.end[axis]);
                assert!((block.end[axis] - line.end[axis]).abs() <= 0.002 + 1e-9);
            }
            assert!(((block.end - block.start).norm() - block.length).abs() < 1e-12);
        }
        // The last line is shorter than a step, the one before it ends at its end.
        assert_eq!(at_steps.covers.len(), toolpath.segments.len() - 2);
        assert_eq!(at_steps.covers.last().map(|cover| cover.last), Some(toolpath.segments.len() - 1));
        let covered: f64 = at_steps.covers.iter().map(|cover| cover.length).sum();
        let programmed: f64 = toolpath.segments.iter().map(|line| line.length).sum();
        assert!((covered - programmed).abs() < 1e-9);
        let slower = command(&toolpath, &machine, Tolerances::Programmed.into());
        // Turns of up to 0.04 rad, where v² = 8 a δ / θ².
        let slowest =
            |plan: &FeedPlan| plan.corner_feedrates[15..25].iter().copied().fold(f64::INFINITY, f64::min);
        assert!((slowest(&exact) - 50.0).abs() < 1e-9, "{} mm/s", slowest(&exact));
        assert!(slowest(&slower) < 45.0, "{} mm/s", slowest(&slower));
    }

    #[test]
    fn half_steps_round_away_from_zero_whatever_the_last_bit_of_the_number() {
        for steps in [0.5, 996.5, 24_999.5] {
            for factor in [1.0 - 1e-12, 1.0, 1.0 + 1e-12] {
                assert_eq!(nearest_whole(steps * factor), steps + 0.5);
                assert_eq!(nearest_whole(-steps * factor), -steps - 0.5);
            }
        }
        assert_eq!([0.0, 0.49, 2.51].map(nearest_whole), [0.0, 0.0, 3.0]);
    }

    #[test]
    fn a_circle_has_as_many_chords_as_the_control_makes() {
        for (rule, expected) in [
            (ArcChords::Within(0.002), (TAU * 5.0 / (2.0 * (0.002 * 9.998f64).sqrt())) as usize),
            (ArcChords::Long(0.1), (TAU * 5.0 / 0.1) as usize),
            (ArcChords::Long(100.0), 1),
            (ArcChords::Within(10.0), 1),
        ] {
            let (_, chorded) = chords_of(CIRCLE, rule).expect("there is an arc");
            assert_eq!(chorded.covers.len(), expected + 2, "{rule:?}");
        }
    }

    #[test]
    fn chords_cover_the_program_and_end_on_the_arc() {
        let program = "G1 F2000 X10\nG2 X10 Y0 I-5 J0\nG4 P1\nG3 X20 Z3 I5 J1\nG61 G2 X30 Y0 I5 J-9\nG0 X5\n";
        for rule in [ArcChords::Within(0.01), ArcChords::Long(0.37)] {
            let (toolpath, chorded) = chords_of(program, rule).expect("there are arcs");
            let (mut at, mut end) = ((0, 0.0), toolpath.segments.at(0).start);
            for (chord, cover) in chorded.toolpath.segments.iter().zip(&chorded.covers) {
                assert_eq!((chord.start, cover.first), (end, cover.last));
                assert!(cover.first == at.0 && (cover.offset - at.1).abs() < 1e-9 || cover.offset == 0.0);
                let segment = toolpath.segments.at(cover.first);
                let on_arc = segment.point(cover.offset + cover.length);
                assert!((chord.end - on_arc).norm() < 1e-9, "{cover:?}");
                (at, end) = ((cover.first, cover.offset + cover.length), chord.end);
            }
            let stops = |toolpath: &Toolpath| toolpath.segments.iter().filter(|s| s.exact_stop).count();
            assert_eq!(stops(&chorded.toolpath), stops(&toolpath));
            assert_eq!(chorded.toolpath.stops.len(), toolpath.stops.len());
        }
    }

    #[test]
    fn a_circle_takes_as_long_as_its_polygon() {
        let machine = machine(ArcChords::Long(1.0));
        let toolpath = trace(&read(CIRCLE.as_bytes()), &machine);
        let time = command(&toolpath, &machine, Tolerances::Programmed.into()).cycle_time();
        let polygon = 31.0 * 2.0 * 5.0 * (TAU / 62.0).sin();
        let expected = (20.0 + polygon) / (2000.0 / 60.0) + 1e-4;
        assert!((time / expected - 1.0).abs() < 1e-5, "{time} s, {expected} s");
    }

    #[test]
    fn programs_without_arcs_and_machines_without_chords_are_as_they_were() {
        assert!(chords_of("G1 F2000 X10\nY5\n", ArcChords::Long(0.1)).is_none());
        assert!(chords_of(CIRCLE, ArcChords::Whole).is_none());
    }

    #[test]
    fn there_is_a_bound_on_all_chords() {
        let (_, chorded) = chords_of("G1 F2000 X10\nG2 X10 Y0 I-50000 J0\n", ArcChords::Long(1e-3))
            .expect("there is an arc");
        assert!((chorded.covers.len() as f64) <= 1.0 + MAX_ARC_CHORDS + 2.0 * MAX_CHORDS_PER_SEGMENT);
    }
}
