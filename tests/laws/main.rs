//! Laws of the interpolator over seeded random paths: what must hold whatever the program.

mod conservation;
mod guaranteed;
mod halts;
mod limits;
mod path_modes;
mod paths;
mod retiming;
mod smoothing;
mod symmetry;
mod table;
mod times;
