//! Tapping: pitch times speed along the thread, and the spindle's ramps at each reversal.

use truefeed::machine::Machine;
use truefeed::simulation::feed::Tolerances;
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::simulate;

const SPEED_RPM: f64 = 600.0;
const PITCH_MM: f64 = 1.0;

/// s for each rpm.
const RAMP: f64 = 5e-4;

fn seconds(program: &str, ramp: f64) -> f64 {
    let mut machine = Machine::default();
    machine.times.spindle.ramp = ramp;
    let toolpath = trace(&read(program.as_bytes()), &machine);
    simulate::with_policy(&toolpath, &machine, Tolerances::Programmed.into()).cycle_time()
}

/// Programs that tap a hole of a depth so often.
/// A program of holes of a depth (mm).
type TappedHoles = fn(f64, usize) -> String;

fn programs() -> [(&'static str, TappedHoles); 4] {
    [
        ("G84 after M29", |depth, times| {
            let holes = (0..times).map(|_| format!("X0 Z{:.3}\n", -depth)).collect::<String>();
            format!("%\nO1\nG21 G90 M3 S600\nG0 X0 Y0 Z5.\nM29 S600\nG98 G84 R5. F600.\n{holes}G80\nM30\n%\n")
        }),
        ("G33.1", |depth, times| {
            let taps = (0..times).map(|_| format!("G33.1 Z{} K1\n", -depth)).collect::<String>();
            format!("G21 G90 G0 Z5\nM3 S600\n{taps}M2\n")
        }),
        ("CYCLE84", |depth, times| {
            let cycles = format!("CYCLE84(5,0,2,{},,0,3,,1,0,600,600)\n", -depth).repeat(times);
            format!("G17 G90 G54 G71\nT1 D1\nM6\nS600 M3\nG0 X0 Y0 Z5\n{cycles}M30\n")
        }),
        ("G84 in pecks of 4 mm", |depth, times| {
            let holes = (0..times).map(|_| format!("X0 Z{:.3}\n", -depth)).collect::<String>();
            format!(
                "%\nO1\nG21 G90 M3 S600\nG0 X0 Y0 Z5.\nM29 S600\nG98 G84 R5. Q4. F600.\n{holes}G80\nM30\n%\n"
            )
        }),
    ]
}

#[test]
fn a_thread_takes_both_ways_at_pitch_times_speed() {
    let feedrate = PITCH_MM * SPEED_RPM / 60.0;
    for (name, program) in &programs()[..3] {
        let deeper = seconds(&program(20.0, 1), RAMP) - seconds(&program(10.0, 1), RAMP);
        assert!((deeper - 2.0 * 10.0 / feedrate).abs() < 1e-9, "{name}: {deeper} s");
    }
}

#[test]
fn each_reversal_takes_the_ramp_down_and_up() {
    // Pecks of 4 mm from R at 5 mm down to -10 mm are four.
    for ((name, program), reversals) in programs().iter().zip([2.0, 2.0, 2.0, 8.0]) {
        let hole = |ramp: f64| seconds(&program(10.0, 3), ramp) - seconds(&program(10.0, 2), ramp);
        let ramps = hole(RAMP) - hole(0.0);
        assert!((ramps - reversals * 2.0 * SPEED_RPM * RAMP).abs() < 1e-9, "{name}: {ramps} s");
    }
}

#[test]
fn pecks_add_what_they_go_back() {
    let feedrate = PITCH_MM * SPEED_RPM / 60.0;
    let [(_, whole), .., (_, pecked)] = programs();
    let time = |program: fn(f64, usize) -> String| seconds(&program(10.0, 1), 0.0);
    // Three times back by 1 mm and again, and a filter delay for each of the six moves.
    let delay = 3.0 * 0.0255;
    let expected = 3.0 * 2.0 * (1.0 / feedrate + delay);
    let pecks = time(pecked) - time(whole);
    assert!((pecks - expected).abs() < 1e-9, "{pecks} s, {expected} s");
}
