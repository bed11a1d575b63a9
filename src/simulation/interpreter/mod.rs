//! Blocks → canonical functions: the meaning of the words of a program.
//!
//! Order of execution within a block: units, plane, distance and path modes; F; T; S; M words that act before the
//! motion (M6 and all not named below, in the order of the block); work offset; tool length; dwell, change of
//! coordinates, reference move or motion; M words that act after it (M0, M1, M2, M5, M9, M30, M60). That is
//! RS274/NGC, Table 5, except for M5 and M9, which wait for the motion as on Fanuc controls.
//!
//! Rules for differences between controls, and for missing words:
//! - The tool begins at the machine's zero, in mm, G17, G54, G90, G91.1, G94, G64; axis words before
//!   the first motion word move in rapid.
//! - Formulas are computed before their block is run, by the rules of the `parameters` module; a value that is not
//!   whole counts as written with a decimal point.
//! - P of G4 is in seconds; without a decimal point, in a program with a `%` line or an O
//!   number, in milliseconds. X and U of G4 are in seconds.
//! - Work offsets and tool lengths without a value in the program and the machine file are zero. G28, G30 and G53
//!   move the axes whose reference point is in the machine file; the others do not move.
//! - G61, G61.1 and G9 request a full stop at the end of rapid and feed moves alike; the `path_mode` module has
//!   all other words on tolerances.
//! - Rotary axes turn as their words say, neither by the shortest way nor modulo 360. Beside a move F holds along
//!   X, Y and Z, or on Fanuc controls along all axes.
//! - Cycles (G73 to G89) are run hole by hole, by the rules of the `cycle` module.
//! - Corner treatments and cutter compensation are in the `compensation` module.
//! - A lathe program is declined, by the signs of the `turning` module.
//! - Tilted planes (G68.2) and cylindrical or polar interpolation are not applied; a remark names each.
//! - Lengths without a decimal point count at their value, unless the machine file gives an increment for them.
//!
//! If controls read a word in two ways, the dialect decides: Fanuc for ISO programs and Okuma's, RS274/NGC and
//! LinuxCNC for the others.
//!
//! Source: NIST RS274/NGC (Kramer, Proctor, Messina 2000), Sect. 3.5 to 3.8.

mod block;
mod bounds;
mod center;
mod code;
mod compensation;
mod cycle;
mod doubt;
mod dwell;
mod execute;
mod fast;
mod feed_mode;
mod frame;
mod input_increment;
mod klartext;
mod motion;
mod parameters;
mod path_mode;
mod probe_and_thread;
mod program_counter;
mod reach;
mod reference;
mod remark;
mod rotary;
mod siemens;
mod spindle_and_tool;
mod spline;
mod state;
mod system_variables;
mod trace;
mod turning;
mod vendor_codes;
mod words;

pub use fast::streaming::{LINES_PER_PART, trace_plain, trace_streaming, trace_text};
pub use trace::{trace, trace_by_reference, trace_within};
