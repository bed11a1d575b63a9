//! A feed override that applies along a part of the path.
//!
//! An operator turns the override switch at any moment, usually within a block. The segments in which the
//! span (from, to) of the override begins and ends are divided there, and the feedrates of feed moves within
//! the span are multiplied by its ratio:
//!
//! ```text
//!            from                         to                      mm along the path
//!   ----------|----|-------|---------------|------
//!       F       r F   r F         r F          F                  r ratio, F programmed feedrate
//! ```
//!
//! Where the override acts on rapids too ([`Machine::rapid_ratio_at`]), those within the span become feed moves.
//!
//! Limits: the ramp to a lower feedrate ends where the switch is turned instead of beginning there, and so
//! comes too early by its length; rotary axes that turn alone keep the programmed rate.

use crate::machine::{Machine, Overrides};
use crate::simulation::feed::limits;
use crate::simulation::feed::substitute::{Cover, Substitute};
use crate::simulation::toolpath::{Motion, Segment, Toolpath};

/// Least length of a part of a segment.
const MIN_PART_MM: f64 = 1e-6;

/// Returns the toolpath with the override of its span in its feedrates, and the machine without that override;
/// `None` if the override applies to the whole path.
pub fn divided(toolpath: &Toolpath, machine: &Machine) -> Option<(Substitute, Machine)> {
    let overrides = &machine.overrides;
    if !overrides.has_span() {
        return None;
    }
    let (from, to) = overrides.span;
    // A fit varies the edges one after the other, so that they may cross: then the span is empty.
    let to = to.max(from);
    let distances = toolpath.distances_in_program();
    let mut substitute = Substitute::default();
    for (number, segment) in toolpath.segments.iter().enumerate() {
        substitute.take_before(toolpath, number);
        let begin = distances[number];
        let cuts = [from - begin, to - begin].map(|cut| cut.clamp(0.0, segment.length));
        let [first, last] = cuts.map(|cut| snapped(cut, segment.length));
        let ratio = overrides.of_feed_within(segment.line.0);
        for (start, end, ratio) in [(0.0, first, 1.0), (first, last, ratio), (last, segment.length, 1.0)] {
            if start < end {
                push(&mut substitute, number, &segment, (start, end), ratio, machine);
            }
        }
    }
    substitute.take_before(toolpath, usize::MAX);
    let overrides = Overrides { feed: 1.0, span: Overrides::WHOLE_PATH_BOUNDS_MM, ..overrides.clone() };
    Some((substitute, Machine { overrides, ..machine.clone() }))
}

/// Returns the place of a cut of a segment of `length` (both mm), moved to the end of the segment if that is
/// nearer than the least length of a part.
fn snapped(cut: f64, length: f64) -> f64 {
    match cut {
        _ if cut < MIN_PART_MM => 0.0,
        _ if length - cut < MIN_PART_MM => length,
        _ => cut,
    }
}

fn push(
    substitute: &mut Substitute,
    number: usize,
    segment: &Segment,
    (start, end): (f64, f64),
    ratio: f64,
    machine: &Machine,
) {
    let mut part = segment.part(start, end);
    match &mut part.motion {
        Motion::Feed { feedrate } => *feedrate = limits::overridable(*feedrate, segment, machine) * ratio,
        Motion::Rapid { .. } if machine.rapid_ratio_at(ratio) == 1.0 => {}
        Motion::Rapid { .. } => {
            let feedrate = limits::overridden_rapid(segment, machine, ratio);
            part.motion = Motion::Feed { feedrate: feedrate * machine.overrides.of_rapid(segment.line.0) };
        }
    }
    substitute.push(part, Cover { first: number, offset: start, last: number, length: end - start });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Junction;
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;

    const PROGRAM: &str = "G0 Z5\nG1 F1200 X40\nG2 X60 Y20 I0 J20 F600\nG4 P0.5\nG1 X0 F1200\nG61 Y0";

    fn with(machine: &Machine, feed: f64, span: (f64, f64)) -> Machine {
        let mut machine = machine.clone();
        (machine.overrides.feed, machine.overrides.span) = (feed, span);
        machine
    }

    #[test]
    fn parts_cover_the_program() {
        let machine = with(&Machine::default(), 0.5, (12.0, 50.0));
        let toolpath = trace(&read(PROGRAM.as_bytes()), &machine);
        let (substitute, _) = divided(&toolpath, &machine).expect("there is a span");
        assert_eq!(substitute.covers.len(), toolpath.segments.len() + 2);
        for (part, cover) in substitute.toolpath.segments.iter().zip(&substitute.covers) {
            let segment = toolpath.segments.at(cover.first);
            for share in [0.0, 0.3, 1.0] {
                let expected = segment.point(cover.offset + share * cover.length);
                assert!((part.point(share * part.length) - expected).norm() < 1e-9, "{cover:?}");
            }
        }
        assert_eq!(substitute.toolpath.stops.len(), toolpath.stops.len());
    }

    #[test]
    fn an_excerpt_has_its_part_of_the_span() {
        let machine = with(&Machine::default(), 0.5, (12.0, 50.0));
        let whole = trace(&read(PROGRAM.as_bytes()), &machine);
        let excerpt = Toolpath {
            segments: whole.segments.range(2..whole.segments.len()).collect(),
            begins_at: whole.distances()[2],
            ..Toolpath::default()
        };
        let parts = |toolpath: &Toolpath| {
            let (substitute, _) = divided(toolpath, &machine).expect("there is a span");
            substitute.toolpath.segments.iter().map(|part| (part.motion, part.length)).collect::<Vec<_>>()
        };
        let (of_whole, of_excerpt) = (parts(&whole), parts(&excerpt));
        assert_eq!(of_whole[of_whole.len() - of_excerpt.len()..], of_excerpt);
        assert_eq!(of_excerpt.len(), excerpt.segments.len() + 1);
    }

    #[test]
    fn klipper_overrides_rapids_by_the_feed_override_and_makes_none_faster() {
        let feedrates = |machine: &Machine, span: (f64, f64)| -> Vec<f64> {
            let toolpath = trace(&read(b"G0 X40 Y30\nG1 X0 F1200"), machine);
            let all = |ratio: f64| {
                let machine = with(machine, ratio, span);
                let (divided, machine) = divided(&toolpath, &machine)
                    .map_or((toolpath.clone(), machine.clone()), |(parts, own)| (parts.toolpath, own));
                let of = |segment: Segment| limits::requested_feedrate(&segment, &machine);
                divided.segments.iter().map(of).collect::<Vec<_>>()
            };
            let (own, slowed, sped_up) = (all(1.0), all(0.5), all(1.2));
            let ratios =
                |others: Vec<f64>| others.into_iter().zip(own.clone()).map(|(other, own)| other / own);
            ratios(slowed).chain(ratios(sped_up)).map(|ratio| (1e6 * ratio).round() / 1e6).collect()
        };
        let mut klipper = Machine::default();
        klipper.interpolator.junction = Junction::SquareCorner(5.0);
        for span in [Overrides::WHOLE_PATH_BOUNDS_MM, (0.0, 1e6)] {
            assert_eq!(feedrates(&klipper, span), [0.5, 0.5, 1.0, 1.2], "{span:?}");
            assert_eq!(feedrates(&Machine::default(), span), [1.0, 0.5, 1.0, 1.2], "{span:?}");
        }
        // The rapid of this program precedes F; a later one runs at F, and an override makes it faster.
        klipper.rapid.at_feedrate = true;
        let program = b"G1 X1 F600\nG0 X40\n";
        let toolpath = trace(&read(program), &klipper);
        let machine = with(&klipper, 1.2, (10.0, 20.0));
        let (parts, own) = divided(&toolpath, &machine).expect("there is a span");
        let of = |segment: Segment| limits::requested_feedrate(&segment, &own);
        let all: Vec<f64> = parts.toolpath.segments.iter().map(of).collect();
        assert_eq!(all, [10.0, 10.0, 12.0, 10.0]);
    }
}
