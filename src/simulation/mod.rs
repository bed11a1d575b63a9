//! The simulation, stage by stage: bytes → blocks → toolpath → feed plan → profile.

pub mod contour;
pub mod feed;
pub mod filter;
pub mod gcode;
pub mod profile;
pub mod toolpath;
