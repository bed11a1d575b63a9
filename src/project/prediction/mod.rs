//! Predictions as text: results, time losses, ranges and doubts, archives of many, and revisions of a program.

pub mod archive;
pub mod results;
pub mod revisions;
pub mod time_losses;
pub mod time_range;
pub mod trust;
