//! Identification: recording → what the control is made of.

pub mod step;
