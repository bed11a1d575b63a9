//! Truefeed: the motion and cycle time of a CNC machine that runs a G-code program.
//!
//! Two pipelines, and data flows one way:
//!
//! ```text
//! simulation      bytes → blocks → toolpath → feed plan → profile → quote
//! cutting                          toolpath → engagement; with profile → load
//! identification  recording → alignment → residual → effects → fit → report
//! ```
//!
//! The core computes in mm, s and rad ([`units`]), does no I/O, reads no clock, draws no random
//! numbers and knows no JavaScript. From bytes to a cycle time:
//!
//! ```
//! use truefeed::machine::Machine;
//! use truefeed::quote::programmed_time;
//! use truefeed::simulation::{gcode::read, interpreter::trace, profile::Profile, simulate};
//!
//! let machine = Machine::default();
//! let toolpath = trace(&read(b"G21 G90 G1 X40 F3000\nY40\nX0"), &machine);
//! let (plan, errors) = simulate::within(&toolpath, &machine, 0.010, &mut |_| {});
//! assert!(programmed_time(&toolpath, &machine) < plan.cycle_time());
//!
//! let profile = Profile::new(&toolpath, &plan);
//! let corner = profile.at_time(profile.time_at_distance(40.0));
//! assert!(corner.velocity.norm() < 0.1 * 50.0, "the corner is taken slowly");
//! assert!(errors.largest() < 0.010 + 1e-9, "and within the tolerance, mm");
//! ```

pub mod cutting;
pub mod identification;
pub mod machine;
pub mod plot;
pub mod project;
pub mod quote;
pub mod side_by_side;
pub mod simulation;
pub mod units;

#[cfg(target_arch = "wasm32")]
mod web;
