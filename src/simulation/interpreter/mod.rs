//! Blocks → canonical moves: what the words of a program mean.
//!
//! Order of execution within a block: units, plane, distance and path modes; F; T; S; M-words that
//! act before the motion (M6 and all not named below, as written); work offset; tool length; dwell,
//! change of coordinates, reference move or motion; M-words that act after it (M0, M1, M2, M5, M9,
//! M30, M60). That is RS274/NGC, Table 5, but for M5 and M9, which wait for the motion as on Fanuc
//! controls.
//!
//! Rules where controls differ or a program does not say:
//! - The tool begins at the machine's zero, in mm, G17, G54, G90, G91.1, G94, G64; axis words before
//!   the first motion word move in rapid.
//! - The values of expressions are worked out before their block is run, by the rules of the
//!   parameters module; a value that is not whole counts as written with a decimal point.
//! - P of G4 is in seconds; without a decimal point, in a program with a `%` line or an O
//!   number, in milliseconds. X and U of G4 are in seconds.
//! - Work offsets and tool lengths that neither program nor machine file gives are zero. G28, G30
//!   and G53 are run in the axes whose reference point the machine knows; in the others the tool
//!   stays where it is.
//! - G61, G61.1 and G9 ask for a full stop at the end of rapid and feed moves alike; what else a
//!   program says about tolerances is in the path mode module.
//! - Rotary axes go where their words say, neither the shortest way nor modulo 360. Beside a move
//!   F holds along X, Y and Z, or on Fanuc controls along all axes.
//! - Cycles (G73 to G89) are run hole by hole, by the rules of the cycle module.
//! - Corner treatments and cutter compensation are in the compensation module.
//! - A program that shows itself as one for a lathe is declined, by the signs of the turning module.
//! - Tilted planes (G68.2) and cylindrical or polar interpolation are not applied. Each says so.
//! - Lengths without a decimal point are lengths as written, but where the machine file gives an
//!   increment for them.
//!
//! Where controls read a word in two ways, the dialect decides: Fanuc for ISO programs and Okuma's,
//! RS274/NGC and LinuxCNC for the others.
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

pub use fast::streaming::{LINES_OF_A_PART, trace_plain, trace_streaming, trace_text};
pub use trace::{trace, trace_by_reference, trace_within};
