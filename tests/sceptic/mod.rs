//! What somebody who trusts nothing would try: recordings that are not what they claim to be, and diagnoses
//! that must not say more than there is.
//!
//! The recordings are simulated by the core itself, sampled and roughened; whether effects are found that another
//! formulation conceals is measured with the stand-in machine in `examples/standin`.

mod claims;
mod refusals;

use truefeed::identification::diagnosis::{Diagnosis, diagnose};
use truefeed::identification::fit::{AlignedRun, AlignedRunError, Run};
use truefeed::machine::{Machine, TimeConstants};
use truefeed::simulation::feed::Tolerances;
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::profile::Profile;
use truefeed::simulation::simulate;
use truefeed::simulation::toolpath::Toolpath;

/// Seconds the machine stands before and after.
const STANDS: f64 = 0.4;

/// A machine with three filters.
pub fn machine() -> Machine {
    let mut machine = Machine::default();
    machine.interpolator.time_constants = TimeConstants::Equal(0.02);
    machine.interpolator.contour_tolerance = 0.02;
    machine.rapid.feedrate = 10_000.0 / 60.0;
    machine
}

/// A part that is not the same in X and in Y, backwards or in another size.
pub fn program() -> String {
    let mut text = String::from("G21 G90 G94\nG0 X0 Y0 Z5\nG1 Z-1 F600\n");
    for row in 0..8 {
        let (y, feed) = (3.0 * f64::from(row), 1500 + 500 * (row % 4));
        text += &format!("G1 X{} Y{y} F{feed}\n", if row % 2 == 0 { 40.0 } else { 2.0 });
        text += &format!("G1 Y{}\n", y + 3.0);
    }
    text += "G2 X14 Y36 I6 J6 F2000\nG3 X30 Y44 I8\nM8\nG0 Z5\nG0 X60 Y10\nG1 Z-1 F400\n";
    for step in 0..40 {
        let angle = 0.16 * f64::from(step);
        text += &format!(
            "G1 X{:.4} Y{:.4} F2400\n",
            60.0 + 2.0 * f64::from(step) * 0.3,
            10.0 + 4.0 * angle.sin()
        );
    }
    text + "G0 Z20\nM30\n"
}

fn toolpath(text: &str, machine: &Machine) -> Toolpath {
    trace(&read(text.as_bytes()), machine)
}

/// Rows of time (s) and position (mm).
pub type Rows = Vec<[f64; 4]>;

/// The positions of a program on a machine, `rate` times a second, a micrometre or so off.
pub fn recorded(text: &str, machine: &Machine, rate: f64) -> Rows {
    let toolpath = toolpath(text, machine);
    let (plan, _) = simulate::within(&toolpath, machine, Tolerances::Programmed, &mut |_| {});
    let profile = Profile::new(&toolpath, &plan);
    let mut seed = 88_172_645_463_325_252u64;
    let mut rough = move || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        2e-3 * ((seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5)
    };
    let last = profile.cycle_time() + 2.0 * STANDS;
    (0..=(last * rate) as usize)
        .map(|sample| {
            let time = sample as f64 / rate;
            let at = profile.at_time((time - STANDS).clamp(0.0, profile.cycle_time())).position;
            [time, at.x + rough(), at.y + rough(), at.z + rough()]
        })
        .collect()
}

pub fn csv(rows: &Rows) -> String {
    let row = |row: &[f64; 4]| format!("{:.5},{:.4},{:.4},{:.4}\n", row[0], row[1], row[2], row[3]);
    String::from("t_s,x_mm,y_mm,z_mm\n") + &rows.iter().map(row).collect::<String>()
}

fn laid(text: &str, recording: &str, machine: &Machine) -> Result<AlignedRun, AlignedRunError> {
    AlignedRun::new(toolpath(text, machine), recording.as_bytes(), machine)
}

/// The diagnosis of recordings of the program against a machine.
fn diagnosed(recordings: &[&Rows], machine: &Machine) -> Diagnosis {
    let recorded: Vec<AlignedRun> = recordings
        .iter()
        .map(|rows| laid(&program(), &csv(rows), machine).expect("it is of this program"))
        .collect();
    let runs: Vec<Run> = recorded.iter().map(AlignedRun::run_ignoring_overrides).collect();
    diagnose(machine, &runs, &mut |_| {})
}
