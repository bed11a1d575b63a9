//! Predictions against recordings of a stand-in machine that shares no code with this project.
//!
//! Only cases in which
//! nothing is concealed that changes the time are compared here, by how long the machine moves. Of a
//! real shop's program the trend is held.

use truefeed::machine::{Machine, TimeConstants};
use truefeed::project::machine_from_toml;
use truefeed::quote::programmed_time;
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::profile::{Profile, Resolution};
use truefeed::simulation::simulate;

use crate::shared::{corpus, recordings_of_others};

/// Cases that conceal nothing (5, 6, 11), backlash (3), servo lag (8) and vibration (9).
const CASES: [&str; 6] = ["case-03", "case-05", "case-06", "case-08", "case-09", "case-11"];

/// A position this far from where it began or ended has left or not yet reached it, mm.
const MOVED: f64 = 0.3;

/// How long positions are away from both the first and the last one, s.
fn moving_time(rows: &[(f64, [f64; 3])]) -> f64 {
    let away = |a: &[f64; 3], b: &[f64; 3]| (0..3).any(|k| MOVED < (a[k] - b[k]).abs());
    let (first, last) = (rows[0].1, rows[rows.len() - 1].1);
    let left = rows.iter().find(|row| away(&row.1, &first)).expect("the machine moves").0;
    let reached = rows.iter().rfind(|row| away(&row.1, &last)).expect("the machine moves").0;
    reached - left
}

#[test]
fn the_stand_in_machine_moves_as_long_as_predicted() {
    let plant = corpus::recordings().join("plant");
    for case in CASES {
        let file = |name: &str| std::fs::read(plant.join(case).join(name)).expect("each case has its files");
        let text = |name: &str| String::from_utf8(file(name)).expect("text");
        let machine = machine_from_toml(&text("machine.toml")).expect("a machine file");
        let toolpath = trace(&read(&file("program.nc")), &machine);
        let (plan, _) =
            simulate::within(&toolpath, &machine, machine.interpolator.contour_tolerance, &mut |_| {});
        let samples = Profile::new(&toolpath, &plan).samples(Resolution::FINE);
        let predicted: Vec<_> = (0..samples.time.len())
            .map(|row| (samples.time[row], [0, 1, 2].map(|axis: usize| samples.position[axis][row])))
            .collect();
        let recorded: Vec<_> = text("recording.csv")
            .lines()
            .skip(1)
            .map(|line| {
                let mut numbers = line.split(',').map(|number| number.parse::<f64>().unwrap_or(f64::NAN));
                let mut next = || numbers.next().expect("four columns");
                (next(), [next(), next(), next()])
            })
            .collect();
        let (predicted, recorded) = (moving_time(&predicted), moving_time(&recorded));
        let miss = 100.0 * (predicted / recorded - 1.0);
        eprintln!("{case}: {predicted:.3} s predicted, {recorded:.3} s recorded, {miss:+.2} %");
        assert!(miss.abs() < 1.0, "{case}: {predicted} s predicted, {recorded} s recorded");
    }
}

#[test]
fn a_real_program_takes_longer_than_programmed_and_less_at_wider_tolerances() {
    let Some(programs) = recordings_of_others("nist-hurco/programs") else { return };
    let mut machine = Machine::default();
    machine.interpolator.time_constants = TimeConstants::Equal(0.03);
    let program = std::fs::read(programs.join("box-op1.nc")).expect("the program is there");
    let toolpath = trace(&read(&program), &machine);
    let programmed = programmed_time(&toolpath, &machine);
    let times = [0.005, 0.010, 0.020, 0.050, 0.100]
        .map(|tolerance| simulate::within(&toolpath, &machine, tolerance, &mut |_| {}).0.cycle_time());
    eprintln!("box-op1: {programmed:.0} s programmed, {times:.0?} s at 5 to 100 µm");
    assert!(times.is_sorted_by(|narrow, wide| wide < narrow), "{times:?}");
    assert!(1.10 * programmed < times[1], "{} s for {programmed} s", times[1]);
}
