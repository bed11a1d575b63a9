//! Every test of what the crate does from outside, in one binary: 28 links of the whole crate took most of the time.

// Tests of what an example writes load the example under its own name, and two examples share a module.
#![allow(clippy::duplicate_mod, clippy::module_inception)]

mod account;
mod alignment;
mod architecture;
mod archive;
mod compensation;
mod convolution;
mod corner_law;
mod corner_modes;
mod corpus;
mod cutting;
mod dependencies;
mod effects;
mod forces_page;
mod forms;
mod frames;
mod frames_linuxcnc;
mod fuzz;
mod halts;
mod hurco;
mod laws;
mod limits;
mod linuxcnc;
mod linuxcnc_runs;
mod misprints;
#[cfg(unix)]
mod outputs;
mod paper;
mod planners;
mod probe;
mod programs;
mod recording_readers;
mod recordings;
mod sceptic;
mod shared;
mod siege;
mod trust;
mod version;
mod words;
