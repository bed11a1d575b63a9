//! Quotes as text: the terms of an offer, the offer of one program, and jobs of several programs.

pub mod job;
pub mod offer;
pub mod terms;
