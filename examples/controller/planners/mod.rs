//! The planners of two controls, which need no recorder. They follow the manuals and sources of grbl and Klipper and share
//! no code with the predictor. `tests.rs` compares them with recordings of the real software.
//!
//! Both plan straight blocks at constant acceleration along the path. A program becomes [`Item`]s, these become
//! [`Piece`]s of constant acceleration, and those are sampled.

mod grbl;
mod klipper;
mod piece;
mod reader;
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
        _ => piece::sampled(&klipper::run(&read(&text, &klipper::READING)?, &settings), step, None),
    }))
}
