//! The planners of four controls, which need no recorder. They follow the manuals and sources of grbl, Klipper, Marlin and
//! TinyG and share no code with the predictor. `tests.rs` compares the first two with recordings of the real software; the
//! others ask what Truefeed says of a control that it does not know.
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

use reader::read;
use settings::Settings;

/// Runs `program` on the planner of `family` with a row every `every` milliseconds.
pub fn record(family: Family, program: &Path, every: usize, options: &[String]) -> Result<Outcome, Refusal> {
    let settings = Settings::from_options(options)?;
    let text = std::fs::read_to_string(program)?;
    let step = 1e-3 * every as f64;
    Ok(Outcome::Recorded(match family {
        Family::Grbl => {
            piece::sampled(&grbl::run(&read(&text, &grbl::READING)?, &settings), step, Some(grbl::STEP_MM))
        }
        Family::Marlin => {
            piece::sampled(&s_curves::run(&read(&text, &s_curves::MARLIN)?, &settings), step, None)
        }
        Family::TinyG => {
            piece::sampled(&s_curves::run(&read(&text, &s_curves::TINYG)?, &settings), step, None)
        }
        _ => piece::sampled(&klipper::run(&read(&text, &klipper::READING)?, &settings), step, None),
    }))
}
