//! Alignment of a whole log: the recording in it that covers most of the program.

use crate::identification::alignment::map_matching::MIN_PASS_RATIO;
use crate::identification::alignment::{Alignment, AlignmentError, align};
use crate::identification::recording::Log;
use crate::machine::Machine;
use crate::simulation::toolpath::Toolpath;

/// Aligns a log with a program: returns the index of the recording that covers most of the program, and its
/// alignment.
///
/// # Errors
///
/// Returns the error of the first recording if none of them fits.
///
/// # Examples
///
/// ```
/// use truefeed::identification::{alignment::align_log, recording::read};
/// use truefeed::machine::Machine;
/// use truefeed::simulation::{gcode, profile::Profile, simulate, interpreter::trace};
///
/// let machine = Machine::default();
/// let toolpath = trace(&gcode::read(b"G21 G90 G1 X40 F3000\nY30\nX5 Y10\nX0"), &machine);
/// let plan = simulate(&toolpath, &machine);
/// let profile = Profile::new(&toolpath, &plan);
/// // A recorder that looks every 10 ms, in the coordinates of the machine.
/// let rows = (0..=(100.0 * profile.cycle_time()) as usize).map(|row| {
///     let at = profile.at_time(0.01 * row as f64).position;
///     format!("{:.2},{:.4},{:.4},{:.4}\n", 0.01 * row as f64, at.x - 300.0, at.y - 200.0, at.z)
/// });
/// let log = read(("t_s,x_mm,y_mm,z_mm\n".to_string() + &rows.collect::<String>()).as_bytes()).expect("a table");
/// let (_, alignment) = align_log(&log, &toolpath, &machine).expect("it is of this program");
/// assert!((alignment.shift.x + 300.0).abs() < 0.01, "mm");
/// assert!(0.9 * profile.length() < alignment.covered.end - alignment.covered.start);
/// ```
pub fn align_log(
    log: &Log,
    toolpath: &Toolpath,
    machine: &Machine,
) -> Result<(usize, Alignment), AlignmentError> {
    let mut best: Option<(usize, Alignment)> = None;
    let mut refusal = None;
    let covered = |alignment: &Alignment| alignment.covered.end - alignment.covered.start;
    for (index, recording) in log.recordings.iter().enumerate() {
        match align(recording, toolpath, machine) {
            Ok(other)
                if best.as_ref().is_none_or(|(_, best)| covered(best) < MIN_PASS_RATIO * covered(&other)) =>
            {
                best = Some((index, other));
            }
            Ok(_) => {}
            Err(error) => refusal = refusal.or(Some(error)),
        }
    }
    let (index, mut alignment) = best.ok_or(refusal.unwrap_or(AlignmentError::NothingToFollow))?;
    let of = log.recordings.len();
    if 1 < of {
        alignment.remarks.push(format!("this is recording {} of the {of} in the file", index + 1));
    }
    Ok((index, alignment))
}
