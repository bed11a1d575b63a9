//! Arcs as the chords that a control runs in place of them.
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
//! lengthened in proportion. grbl rounds the ends of chords to whole steps; here they lie on the arc.
//!
//! Both controls turn the radius of the start; only the last chord ends at the programmed end, whose radius may differ by the
//! last digit of the program. The last chord then turns more sharply than the others, and the control slows down for it.

use crate::machine::{ArcChords, Machine};
use crate::simulation::feed::substitute::{Cover, Substitute};
use crate::simulation::toolpath::{Arc, Curve, Rotation, Segment, Toolpath};

/// Most chords of all arcs of a program, in addition to [`MAX_CHORDS_PER_SEGMENT`].
const MAX_ARC_CHORDS: f64 = 1e6;

/// Most chords for each segment of the program, on average.
const MAX_CHORDS_PER_SEGMENT: f64 = 64.0;

/// Returns the toolpath with its arcs as chords; `None` if arcs are run whole or there are none.
pub fn chorded(toolpath: &Toolpath, machine: &Machine) -> Option<Substitute> {
    let rule = machine.interpolator.arc_chords;
    if rule == ArcChords::Whole {
        return None;
    }
    let all: f64 = toolpath.segments.iter().map(|segment| count(&segment, rule)).sum();
    if all == 0.0 {
        return None;
    }
    let most = MAX_ARC_CHORDS + MAX_CHORDS_PER_SEGMENT * toolpath.segments.len() as f64;
    let share = (most / all).min(1.0);
    let mut chorded = Substitute::default();
    for (number, segment) in toolpath.segments.iter().enumerate() {
        chorded.take_before(toolpath, number);
        let chords = (share * count(&segment, rule)).floor().max(1.0) as usize;
        if segment.curve == Curve::Line {
            chorded.push_whole(number, segment);
        } else {
            add_chords(&mut chorded, number, &segment, chords);
        }
    }
    chorded.take_stops(toolpath, usize::MAX);
    Some(chorded)
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

fn add_chords(chorded: &mut Substitute, number: usize, segment: &Segment, chords: usize) {
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
        chorded.push(chord, Cover { first: number, offset: part * k as f64, last: number, length: part });
        start = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::TimeConstants;
    use crate::simulation::feed::{Tolerances, command};
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
        chorded(&toolpath, &machine).map(|chorded| (toolpath, chorded))
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
