//! Laws of maps, and the words whose meaning depends on the family of the control.

use super::*;
use crate::simulation::gcode::{Dialect, Program, read};
use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::center::Centers;
use crate::simulation::interpreter::fast::rare;
use crate::simulation::interpreter::state::{Family, Interpreter};
use crate::simulation::interpreter::trace::trace;
use crate::simulation::toolpath::random::Random;
use crate::simulation::toolpath::{Motion, StopCause};

fn point(random: &mut Random) -> Point {
    Point::from(Vector::from_fn(|_, _| random.below(200_001) as f64 / 1000.0 - 100.0))
}

#[test]
fn a_turn_and_its_reverse_and_two_mirrors_do_nothing() {
    let mut random = Random(3);
    for case in 0..1000 {
        let plane = [Plane::Xy, Plane::Zx, Plane::Yz][case % 3];
        let (center, probe) = (point(&mut random), point(&mut random));
        let angle = (random.below(720_000) as f64 / 1000.0).to_radians();
        let turn = |angle| Affine::rotation(plane, center, angle);
        let there_and_back = turn(-angle).after(&turn(angle));
        assert!((there_and_back.point(&probe) - probe).amax() <= 1e-12 * 400.0);
        let mirror = Affine::mirror([Some(center.x), None, Some(center.z)]);
        assert!((mirror.after(&mirror).point(&probe) - probe).amax() <= 1e-12 * 400.0);
        let chain = turn(angle).after(&Affine::scaling(center, [2.0, -0.5, 3.0])).after(&mirror);
        let back = chain.inverse().expect("no factor is 0");
        assert!((back.point(&chain.point(&probe)) - probe).amax() <= 1e-10);
    }
}

#[test]
fn quarter_turns_keep_right_angles() {
    for (angle, end) in [(90.0, [0.0, 1.0]), (180.0, [-1.0, 0.0]), (-90.0, [0.0, -1.0]), (720.0, [1.0, 0.0])]
    {
        let turn = Affine::rotation(Plane::Xy, Point::origin(), f64::to_radians(angle));
        assert_eq!(turn.point(&Point::new(1.0, 0.0, 5.0)), Point::new(end[0], end[1], 5.0));
    }
}

/// Runs a program by the rules of a family.
fn run<'a>(text: &str, family: Family, machine: &'a Machine) -> Interpreter<'a> {
    let program = read(text.as_bytes());
    let centers = Centers::new(Dialect::default(), None);
    let mut interpreter = Interpreter::new(machine, &Program::default(), centers, rare::ALL);
    interpreter.family = family;
    for block in &program.blocks {
        interpreter.block(Block::of_words(program.words(block), block.line));
    }
    interpreter
}

#[test]
fn settings_of_work_offsets_follow_the_family() {
    let machine = Machine::default();
    let end = |text: &str, family: Family| run(text, family, &machine).canonical.position;
    let named = "G0 X10\nG10 L20 P1 X3\nG0 X4";
    assert_eq!(end(named, Family::Rs274).x, 11.0);
    assert_eq!(end(named, Family::Fanuc).x, 4.0, "it is G54.1 P1, which is not in force");
    assert_eq!(end("G10 L20 P7 X3\nG54.1 P7 G0 X4", Family::Fanuc).x, 7.0);
    let added = "G91 G10 L2 P1 X3\nG10 L2 P1 X3\nG90 G0 X0";
    assert_eq!((end(added, Family::Rs274).x, end(added, Family::Fanuc).x), (3.0, 6.0));
    let external = "G54\nG10 L2 P1 X100.\nG10 L2 P0 X5.\nG0 X0";
    assert_eq!(end(external, Family::Rs274).x, 5.0, "P0 is the offset in force");
    assert_eq!(end(external, Family::Fanuc).x, 105.0, "P0 adds to all");
    assert_eq!(end("G10 L2 P0 X5.\nG55 G0 X1.", Family::Fanuc).x, 6.0);
    assert_eq!(end("G10 L2 P0 X5.\nG91 G10 L2 P0 X2.\nG90 G0 X0", Family::Fanuc).x, 7.0);
    assert_eq!(
        run("G10 L2 P0 A5.\nG0 A10.", Family::Fanuc, &machine).rotary.position.x.to_degrees().round(),
        15.0
    );
}

#[test]
fn a_degree_is_a_millimetre_of_feed_on_fanuc_controls_alone() {
    let machine = Machine::default();
    let feedrate = |family: Family| match run("G94 G1 F600 X3 A4", family, &machine)
        .canonical
        .toolpath()
        .segments
        .at(0)
        .motion
    {
        Motion::Feed { feedrate } => feedrate,
        Motion::Rapid { .. } => 0.0,
    };
    assert!((feedrate(Family::Rs274) - 10.0).abs() < 1e-12);
    assert!((feedrate(Family::Fanuc) - 6.0).abs() < 1e-12);
}

#[test]
fn work_offsets_of_the_machine_are_in_force_from_the_start() {
    let mut machine = Machine::default();
    machine.work_offsets[0] = Some([100.0, 50.0, -20.0]);
    machine.work_offsets[1] = Some([-7.0, 0.0, 0.0]);
    let interpreter = run("G0 X1 Y2 Z3\nG55 X1", Family::Rs274, &machine);
    let ends: Vec<Point> =
        interpreter.canonical.toolpath().segments.iter().map(|segment| segment.end).collect();
    assert_eq!(ends, [Point::new(101.0, 52.0, -17.0), Point::new(-6.0, 52.0, -17.0)]);
}

#[test]
fn rotary_words_are_read_as_positions() {
    let machine = Machine::default();
    let turns = |text: &str| -> Vec<f64> {
        let interpreter = run(text, Family::Rs274, &machine);
        let stops = interpreter.canonical.toolpath().stops.iter().map(|stop| match stop.cause {
            StopCause::Rotary { rotation, .. } => rotation.x.to_degrees().round(),
            _ => f64::NAN,
        });
        stops.collect()
    };
    assert_eq!(turns("G0 A90\nA450\nA450\nG91 A-10\nG90 A0"), [90.0, 360.0, -10.0, -440.0]);
    assert_eq!(turns("G0 A90\nG92 A0\nA10\nG92.1\nA0"), [90.0, 10.0, -100.0]);
    assert_eq!(turns("G0 A90\nG28 A0"), [90.0, -90.0]);
    assert_eq!(turns("G0 A90\nG10 L20 P1 A0\nA10\nG10 L2 P1 A0\nA10"), [90.0, 10.0, -90.0]);
    assert_eq!(turns("G0 A90\nG53 A10"), [90.0, -80.0]);
}

/// The places in X and Y that a program moves to, rounded as LinuxCNC prints them.
fn ends(text: &str) -> Vec<[f64; 2]> {
    let rounded = |value: f64| (1e4 * value).round() / 1e4 + 0.0;
    let toolpath = trace(&read(text.as_bytes()), &Machine::default());
    let ends = toolpath.segments.iter().map(|segment| [rounded(segment.end.x), rounded(segment.end.y)]);
    let mut ends: Vec<_> = ends.collect();
    ends.dedup();
    ends
}

/// What LinuxCNC's interpreter prints for the same words.
#[test]
fn radius_and_angle_words_are_those_of_linuxcnc() {
    let found = ends("G0 X15\nG91 ^60\n@5\nG90 ^90\n@10");
    assert_eq!(found, [[15.0, 0.0], [7.5, 12.9904], [10.0, 17.3205], [0.0, 20.0], [0.0, 10.0]]);
}

#[test]
fn angles_repeat_in_cycles() {
    let on_circle =
        [[7.5, 12.9904], [-7.5, 12.9904], [-15.0, 0.0], [-7.5, -12.9904], [7.5, -12.9904], [15.0, 0.0]];
    assert_eq!(ends("G0 X15\nG91 G81 R.1 Z-.5 ^60 L6 F10")[1..], on_circle);
    assert_eq!(ends("G16 G0 X15 Y0\nG91 G81 R.1 Z-.5 Y60 L6 F10")[1..], on_circle);
}
