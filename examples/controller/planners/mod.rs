//! The planners of four controls, which need no recorder; Marlin's has two laws of corners. They follow the manuals and sources of
//! grbl, Klipper, Marlin and TinyG and share no code with the predictor. `tests.rs` compares the first two with recordings of the real software.
//! Marlin and TinyG were written to see how Truefeed judges a control whose law it does not have; both laws are among its
//! families now.
//!
//! All plan straight blocks with ramps along the path. A program becomes [`Item`]s, these become
//! [`Piece`]s of constant acceleration, and those are sampled.

mod grbl;
mod klipper;
mod piece;
mod reader;
mod s_curves;
mod settings;
#[cfg(test)]
mod tests;

use std::path::Path;

use crate::Refusal;
use crate::machine::Family;
use crate::recorder::Outcome;
use crate::trace::Trace;

use piece::Piece;
use reader::{Item, Reading, read};
use settings::Settings;

/// Runs `program` on the planner of `family` with a row every `every` milliseconds.
pub fn record(family: Family, program: &Path, every: usize, options: &[String]) -> Result<Outcome, Refusal> {
    let settings = Settings::from_options(options)?;
    let text = std::fs::read_to_string(program)?;
    Ok(Outcome::Recorded(replayed(family, &text, 1e-3 * every as f64, &settings)?))
}

/// Runs the text of a program on the planner of `family` with a row every `step` seconds.
fn replayed(family: Family, text: &str, step: f64, settings: &Settings) -> Result<Trace, Refusal> {
    type Run = fn(&[Item], &Settings) -> Vec<Piece>;
    let (reading, run, motor_step): (&Reading, Run, _) = match family {
        Family::LinuxCnc => return Err("LinuxCNC has a recorder and no planner here".into()),
        Family::Grbl => (&grbl::READING, grbl::run, Some(grbl::STEP_MM)),
        Family::Klipper => (&klipper::READING, klipper::run, None),
        Family::Marlin | Family::MarlinDeviation => (&s_curves::MARLIN, s_curves::run, None),
        Family::TinyG => (&s_curves::TINYG, s_curves::run, None),
    };
    Ok(piece::sampled(&run(&read(text, reading)?, settings), step, motor_step))
}
