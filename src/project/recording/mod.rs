//! Recordings as text: comparison with the simulation, and the laws of a machine as measured.

pub mod comparison;
pub mod measured_laws;
