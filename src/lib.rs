//! Truefeed: what a CNC machine really does with a G-code program.
//!
//! Two pipelines, and data flows one way:
//!
//! ```text
//! simulation      bytes → blocks → toolpath → feed plan → profile → quote
//! identification  recording → alignment → residual → hypotheses → fit → report
//! ```
//!
//! The core computes in mm, s and rad ([`units`]), does no I/O, reads no clock, draws no random
//! numbers and knows no JavaScript.

pub mod identification;
pub mod machine;
pub mod plot;
pub mod project;
pub mod quote;
pub mod simulation;
pub mod units;

#[cfg(target_arch = "wasm32")]
mod web;
