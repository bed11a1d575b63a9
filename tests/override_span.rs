//! A feed override along a part of the path: the machine loses the time of the slower feedrate there, and nowhere else.

use truefeed::machine::{Machine, Overrides, Planner};
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::simulate;

const PROGRAM: &str = "G0 Z5\nG1 F1200 X40\nG2 X60 Y20 I0 J20 F600\nG4 P0.5\nG1 X0 F1200\nG61 Y0";

fn machines() -> [Machine; 3] {
    let filters = Machine::default();
    [None, Some(Planner::AccelerationBlend), Some(Planner::JunctionDeviation)].map(|planner| {
        let mut machine = filters.clone();
        planner.into_iter().for_each(|planner| machine.become_planner(planner, 500.0));
        machine
    })
}

/// The machine with an X that is slower than most of the program asks for.
fn held_back(mut machine: Machine) -> Machine {
    machine.axes[0].velocity = 15.0;
    machine
}

fn with(machine: &Machine, feed: f64, span: (f64, f64)) -> Machine {
    let mut machine = machine.clone();
    (machine.overrides.feed, machine.overrides.span) = (feed, span);
    machine
}

#[test]
fn all_along_the_path_it_is_the_override_of_the_whole_program() {
    for machine in machines() {
        let toolpath = trace(&read(PROGRAM.as_bytes()), &machine);
        let machine = held_back(machine);
        let whole = simulate(&toolpath, &with(&machine, 0.7, Overrides::WHOLE_PATH_BOUNDS_MM)).cycle_time();
        let spanned = simulate(&toolpath, &with(&machine, 0.7, (0.0, 1e9))).cycle_time();
        assert!((spanned / whole - 1.0).abs() < 1e-12, "{spanned} s, {whole} s");
    }
}

#[test]
fn a_part_of_a_block_takes_longer_by_its_length() {
    for machine in machines() {
        let toolpath = trace(&read(PROGRAM.as_bytes()), &machine);
        let plain = simulate(&toolpath, &machine).cycle_time();
        // Within the first cut of 40 mm at 20 mm/s, 5 mm after the rapid.
        let slowed = simulate(&toolpath, &with(&machine, 0.5, (15.0, 25.0))).cycle_time();
        let lost = 10.0 / 10.0 - 10.0 / 20.0;
        // Two ramps of 10 mm/s lose less than this.
        assert!((slowed - plain - lost).abs() < 0.1, "{plain} s, {slowed} s");
    }
}

/// LinuxCNC clamps a feedrate to the axes before the override multiplies it, and the product once more; other controls clamp the
/// product alone. An X of 15 mm/s cuts 60 mm programmed at 20 mm/s.
#[test]
fn an_override_slows_what_an_axis_of_linuxcnc_holds_back() {
    let [_, linuxcnc, grbl] = machines().map(held_back);
    let toolpath = trace(&read(b"G1 X60 F1200"), &linuxcnc);
    let seconds = |machine: &Machine, feed: f64| {
        simulate(&toolpath, &with(machine, feed, Overrides::WHOLE_PATH_BOUNDS_MM)).cycle_time()
    };
    // The ramps at 500 mm/s² are shorter at less speed, by hundredths of a second.
    let lost = |machine: &Machine, feed: f64| seconds(machine, feed) - seconds(machine, 1.0);
    assert!((lost(&linuxcnc, 0.8) - 60.0 / 12.0 + 60.0 / 15.0).abs() < 0.02, "{}", lost(&linuxcnc, 0.8));
    assert!(lost(&grbl, 0.8).abs() < 1e-9, "{}", lost(&grbl, 0.8));
    assert_eq!(lost(&linuxcnc, 1.2), 0.0);
}

#[test]
fn edges_that_cross_leave_the_program_as_it_is() {
    for machine in machines() {
        let toolpath = trace(&read(PROGRAM.as_bytes()), &machine);
        let plain = simulate(&toolpath, &machine).cycle_time();
        let crossed = simulate(&toolpath, &with(&machine, 0.5, (25.0, 15.0))).cycle_time();
        assert!((crossed / plain - 1.0).abs() < 1e-3, "{plain} s, {crossed} s");
    }
}
