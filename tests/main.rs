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
mod documentation;
mod effects;
mod families;
mod figures;
mod forces_page;
mod forms;
mod frames;
mod frames_linuxcnc;
mod fuzz;
mod guard;
mod halts;
mod hurco;
#[cfg(unix)]
mod jobs;
mod laws;
mod limits;
mod linuxcnc;
mod linuxcnc_planner;
mod linuxcnc_runs;
mod measured;
mod misprints;
#[cfg(unix)]
mod outputs;
mod override_span;
mod paper;
mod plain_english;
mod planners;
mod probe;
mod programs;
mod recording_readers;
mod recordings;
mod reference;
mod sceptic;
mod shared;
mod siege;
mod traces;
mod trust;
mod untold;
mod version;
mod words;
