//! Laws as measured, against the physics of a planner that was written down by hand: recordings of it are sampled, and what is
//! read off them must be its laws, whatever machine file is held against them.

use truefeed::identification::fit::{AlignedRun, Run};
use truefeed::identification::measured::{Absence, LawKind, Measured, MeasuredLaw, measure};
use truefeed::machine::Machine;
use truefeed::project::machine_from_toml;
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::profile::{Profile, Resolution};
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::Toolpath;

/// Acceleration of each axis, mm/s², and junction deviation, mm.
const ACCELERATION: f64 = 500.0;
const DEVIATION: f64 = 0.010;

const MACHINE: &str = include_str!("data/machines/grbl.toml");
/// What an M8 takes, s.
const COOLANT: f64 = 1.5;

/// grbl without its step segments: the laws are those of continuous ramps.
fn machine() -> Machine {
    let mut machine = machine_from_toml(MACHINE).expect("a machine file");
    machine.interpolator.step_segment = 0.0;
    machine.times.m_codes.insert(8, COOLANT);
    machine
}

/// A recording of a machine that runs a program, as positions every `interval` (s).
fn recording(machine: &Machine, toolpath: &Toolpath, interval: f64) -> String {
    let plan = simulate(toolpath, machine);
    let profile = Profile::new(toolpath, &plan);
    let samples = profile.samples(Resolution { feedrate: 1e-3, position: 1e-4, spacing: 0.0 });
    let count = (profile.cycle_time() / interval) as usize + 50;
    let mut row = 0;
    let rows = (0..count).map(|at| {
        let (position, _) = samples.motion_at(at as f64 * interval, &mut row);
        format!("{:.4},{:.5},{:.5},{:.5}\n", at as f64 * interval, position.x, position.y, position.z)
    });
    "t_s,x_mm,y_mm,z_mm\n".to_string() + &rows.collect::<String>()
}

fn measured(program: &str, believed: &Machine) -> Measured {
    let toolpath = trace(&read(program.as_bytes()), believed);
    let log = recording(&machine(), &toolpath, 0.002);
    let recorded = AlignedRun::new(toolpath, log.as_bytes(), believed).expect("it is of this program");
    let runs: [Run; 1] = [recorded.run()];
    measure(believed, &runs)
}

fn law<'a>(measured: &'a Measured, kind: LawKind, variant: &str) -> &'a MeasuredLaw {
    let found = measured.laws.iter().find(|law| law.kind == kind && law.variant == variant);
    found.unwrap_or_else(|| panic!("{kind:?} {variant}: {measured:?}"))
}

/// A polygonal way of lines of 25 mm that turns by these angles, degrees, at 3000 mm/min, after a way along X.
fn turning(angles: &[f64]) -> String {
    let (mut x, mut y, mut heading) = (25.0, 0.0, 0.0f64);
    let mut program = "G21 G90 G94\nG0 X0 Y0 Z0\nG1 X25 F3000\n".to_string();
    for angle in angles {
        heading += angle.to_radians();
        (x, y) = (x + 25.0 * heading.cos(), y + 25.0 * heading.sin());
        program += &format!("G1 X{x:.5} Y{y:.5}\n");
    }
    program + "M30\n"
}

/// v² = a δ sin(θ/2) / (1 − sin(θ/2)), θ the angle between the lines, a the acceleration along their bisector with each
/// axis at its own limit.
fn corner_feedrate(before: f64, turn: f64) -> f64 {
    let (from, to) = (before.to_radians(), (before + turn).to_radians());
    let change = [to.cos() - from.cos(), to.sin() - from.sin()];
    let size = change[0].hypot(change[1]);
    let largest = change.iter().map(|part| (part / size).abs()).fold(0.0, f64::max);
    let half = (0.5 * (180.0 - turn)).to_radians().sin();
    (ACCELERATION / largest * DEVIATION * half / (1.0 - half)).sqrt()
}

#[test]
fn corners_are_passed_by_the_junction_law_that_was_recorded() {
    let angles = [40.0, 50.0, 60.0, 75.0, 90.0, 120.0];
    let found = measured(&turning(&angles), &machine());
    let law = law(&found, LawKind::Corner, "long blocks");
    assert_eq!(law.points.len(), angles.len(), "{law:?}");
    let mut heading = 0.0;
    for (point, angle) in law.points.iter().zip(angles) {
        let expected = corner_feedrate(heading, angle);
        heading += angle;
        assert!((point.over.to_degrees() - angle).abs() < 0.1, "{point:?}");
        assert!((point.value / expected - 1.0).abs() < 0.1, "{angle}°: {} for {expected} mm/s", point.value);
    }
    assert!(law.curve.windows(2).all(|pair| pair[1].value <= pair[0].value), "{:?}", law.curve);
    let error = law.error.expect("the machine has the same corners");
    assert!(error.mean.abs() < 0.2 && error.spread < 0.5 && error.count == angles.len(), "{error:?}");
}

#[test]
fn a_wrong_machine_file_changes_what_is_missed_and_not_what_is_measured() {
    let program = turning(&[40.0, 60.0, 90.0, 120.0]);
    let mut believed = machine();
    believed.axes.iter_mut().for_each(|axis| axis.acceleration = 2000.0);
    let [right, wrong] = [measured(&program, &machine()), measured(&program, &believed)];
    let of = |measured: &Measured| law(measured, LawKind::Corner, "long blocks").clone();
    let (right, wrong) = (of(&right), of(&wrong));
    assert_eq!(right.points, wrong.points);
    // Four times the acceleration is twice the feedrate.
    let mean = right.points.iter().map(|point| point.value).sum::<f64>() / right.points.len() as f64;
    let error = wrong.error.expect("the machine has the same corners").mean;
    assert!((error / mean - 1.0).abs() < 0.15, "{error} mm/s over {mean}");
}

#[test]
fn ramps_and_rapids_take_the_time_of_trapezoids() {
    let mut program = "G21 G90 G94\nG0 X0 Y0 Z0\n".to_string();
    for (at, length) in [10.0, 20.0, 40.0, 80.0].into_iter().enumerate() {
        program += &format!(
            "G4 P0.3\nG1 X60 F{}\nG4 P0.3\nG0 X0\nG4 P0.3\nG0 Y{length}\nG4 P0.3\nG0 Y0\n",
            1000 * (at + 1)
        );
    }
    let found = measured(&(program + "G4 P0.3\nG1 X5 F600\nM8\nG1 X10\nM30\n"), &machine());
    let ramps = law(&found, LawKind::Ramp, "X");
    for point in &ramps.points {
        let expected = 0.8 * point.over / ACCELERATION;
        // A window of 6 ms makes short ramps longer.
        assert!((point.value - expected).abs() < 0.05 * expected + 0.003, "{point:?} for {expected} s");
    }
    assert!(2 <= ramps.points.len(), "{ramps:?}");
    let rapids = law(&found, LawKind::Rapid, "Y");
    assert_eq!(rapids.points.len(), 4, "{rapids:?}");
    for point in &rapids.points {
        let reached = (100.0f64).min((point.over * ACCELERATION).sqrt());
        let expected = point.over / reached + reached / ACCELERATION;
        assert!((point.value - expected).abs() < 0.012, "{point:?} for {expected} s");
    }
    let wait = &law(&found, LawKind::Wait, "M8").points[0];
    assert!((wait.value - COOLANT).abs() < 0.03, "{wait:?}");
    let dwell = law(&found, LawKind::Wait, "G4").points.iter().find(|point| (point.over - 0.3).abs() < 1e-9);
    assert!(dwell.is_some_and(|dwell| (dwell.value - 0.3).abs() < 0.03), "{dwell:?}");
}

#[test]
fn what_a_program_does_not_ask_for_is_absent_with_the_reason() {
    let found = measured("G21 G90 G94\nG1 X50 F600\nX0\nX50\nX0\nM30\n", &machine());
    let reason = |kind: LawKind| found.absent.iter().find(|(own, _)| *own == kind).map(|(_, reason)| *reason);
    assert_eq!(reason(LawKind::Arc), Some(Absence::NotInProgram));
    assert_eq!(reason(LawKind::Rapid), Some(Absence::NotInProgram));
    assert_eq!(reason(LawKind::Block), Some(Absence::NotInProgram));
    assert_eq!(reason(LawKind::Ramp), None);
}
