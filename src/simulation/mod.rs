//! The simulation, stage by stage: bytes → blocks → toolpath → feed plan → profile. [`simulate`](simulate())
//! is the entry point.

pub mod packed;
pub mod ordered;
pub mod running_sum;
pub mod sampled;
pub mod gcode;
pub mod interpreter;
pub mod toolpath;
pub mod filter;
pub mod feed;
pub mod profile;
pub mod drive;
pub mod contour;
pub mod simulate;

pub use simulate::simulate;
