//! The simulation, stage by stage: bytes → blocks → toolpath → feed plan → profile.

pub mod compact;
pub mod gcode;
pub mod toolpath;
pub mod filter;
pub mod feed;
pub mod profile;
pub mod drive;
pub mod contour;
