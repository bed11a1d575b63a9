//! Identification: recording → what the control is made of.

pub mod alignment;
pub mod calibration;
pub mod comparison;
pub mod diagnosis;
pub mod effects;
pub mod fit;
pub mod measured;
pub mod probe;
pub mod recording;
pub mod step;
