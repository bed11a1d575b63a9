//! Laws of the interpolator over seeded random paths: what must hold whatever the program.

mod buffered;
mod conservation;
mod guaranteed;
mod halts;
mod limits;
mod path_modes;
mod paths;
mod time_scaling;
mod smoothing;
mod symmetry;
mod table;
mod tapping;
mod times;
