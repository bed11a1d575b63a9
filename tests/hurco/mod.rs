//! Runs of two real mills: what a calibration on some predicts of others, and what a diagnosis finds in them.
//!
//! The data are not part of the project: they lie in `../shared/recordings/nist-hurco` or in the folder of that
//! name under `TRUEFEED_RECORDINGS`, and the tests say so and end where they are absent. Origin of the data: NIST's
//! smstestbed.

mod calibration;
mod diagnosis;

use std::path::Path;

use truefeed::identification::fit::AlignedRun;
use truefeed::machine::Machine;
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;

/// The folder of their recordings.
const HURCO: &str = "nist-hurco";

/// What a machine log says of the operator.
const OPERATOR: [&str; 4] = ["|Feed_Override|", "|Rapid_Override|", "|Spindle_Override|", "|Program_Status|"];

/// A run of a program, with what its log says of the operator or without.
fn recorded(folder: &Path, program: &str, run: &str, machine: &Machine, with_operator: bool) -> AlignedRun {
    let file = |name: String| std::fs::read(folder.join(name)).expect("each run has its files");
    let toolpath = trace(&read(&file(format!("programs/{program}.nc"))), machine);
    let log = String::from_utf8(file(format!("runs/{run}.shdr"))).expect("logs are plain text");
    let is_told = |line: &&str| with_operator || !OPERATOR.iter().any(|item| line.contains(item));
    let log: String = log.lines().filter(is_told).map(|line| format!("{line}\n")).collect();
    AlignedRun::new(toolpath, log.as_bytes(), machine).expect("it is of that program")
}
