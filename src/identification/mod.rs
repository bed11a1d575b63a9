//! Identification: recording → what the control is made of.

pub mod recording;
pub mod step;
