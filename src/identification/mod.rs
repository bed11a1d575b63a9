//! Identification: recording → what the control is made of.

pub mod alignment;
pub mod comparison;
pub mod recording;
pub mod step;
