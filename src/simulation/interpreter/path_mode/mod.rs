//! Path modes: the stops and tolerances that a program sets.
//!
//! Two states are in force at a time. Exact stop (G61) stops the tool after each move. A tolerance says how far
//! the motion may leave the path at corners and along arcs; by default it is the machine's. A [`PathMode`] is the
//! combination of the two from one segment on: during exact stop there are no corners, and arcs keep the machine's
//! tolerance.
//!
//! | word | meaning here |
//! | --- | --- |
//! | G61.1 | exact stop, until G64 |
//! | G61 | exact stop, until G64; on LinuxCNC exact path: a stop where a corner cannot be passed as programmed |
//! | G9 | exact stop in its own block; it changes no mode |
//! | G64 | no exact stop; ends the tolerance of a `G64 P` |
//! | G64 P | no exact stop, tolerance P in the program's unit (LinuxCNC); P0 as without P |
//! | G64 Q | distance within which LinuxCNC runs lines as one; without it P |
//! | G187 E | tolerance E in the program's unit, through G61 and G64 (Haas, largest rounding of a corner); E0 exact stop |
//! | G187 P1, P2, P3 | the machine's tolerance for rough, medium, finish, where it is known (Haas) |
//! | G187 | ends the tolerance of G187 |
//! | G5.1 Q1 R1 to R10 | between the machine's tolerances for level 1 and 10, where they are known (Fanuc AI contour control) |
//! | G5.1 Q0 | ends the tolerance of G5.1 |
//! | G8 P, G5 P | look-ahead on and off (Fanuc): sets no tolerance |
//!
//! LinuxCNC's G64 without P is "as fast as possible, however far from the path". No machine deviates without
//! bound: here it is the tolerance of the machine file. LinuxCNC's naive CAM detector, which merges lines within Q
//! (or else P) of one line, is in the path smoothing of the feed plan, and active if the machine file has
//! LinuxCNC's junctions.
//!
//! Sources differ on whether G187 P1 or P3 is rough: Truefeed takes 1 as rough, 2 as medium, 3 as finish, and an E
//! beside it counts alone.
//!
//! Sources: LinuxCNC manual, G64, and the behaviour of its interpreter with P0 and without Q; Haas, G187 and
//! Setting 85; Fanuc, machining condition selecting function.

mod words;

use crate::simulation::gcode::Severity;
use crate::simulation::toolpath::Blending;
use thiserror::Error;

/// The group of words that a tolerance belongs to; only a word of the same group ends it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ToleranceGroup {
    /// G64 P, and other modes of its group: a plain G64 ends it.
    Group,
    /// A separate word (G187, G5.1, a cycle): its tolerance remains through exact stop and G64.
    Own,
}

/// A word about the path mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PathWord {
    /// G61.1.
    ExactStop,
    /// G61.
    ExactPath,
    /// G64.
    Continuous,
    /// G187.
    Smoothness,
    /// G5.1.
    ContourControl,
    /// G5 and G8.
    LookAhead,
}

/// The exact stop and the tolerance in force.
#[derive(Default)]
pub(super) struct PathModeState {
    /// Exact path or exact stop, with the word that set it.
    exact_stop: Option<(Blending, String)>,
    tolerance: Option<(Blending, String, ToleranceGroup)>,
    /// Q of G64, mm.
    merging: Option<f64>,
}

impl PathModeState {
    pub(super) fn has_exact_stop(&self) -> bool {
        self.exact_stop.is_some() || matches!(self.tolerance, Some((Blending::ExactStop, ..)))
    }
}

/// A deviation from the control, or a fact on path modes that the user may want to know. Lengths are in mm.
#[derive(Clone, Debug, PartialEq, Error)]
pub(super) enum PathRemark {
    #[error("{source_words} sets {value} mm, outside 0.000001 to 10 mm: the tolerance of the machine holds")]
    BadTolerance { source_words: String, value: f64 },
    #[error(
        "lines within Q (or P) of one line are merged by LinuxCNC after G64 P: this machine runs each line as written; with interpolator.junction_rule = acceleration_blend it merges them"
    )]
    NaiveCam,
    #[error(
        "{source_words} sets no tolerance from here on (on LinuxCNC: as fast as possible): the machine's tolerance holds"
    )]
    NoTolerance { source_words: String },
    #[error("the tolerance of {source_words} is unknown: the machine's tolerance holds; set {keys}")]
    UnknownLevel { source_words: String, keys: &'static str },
    #[error("{source_words} is no level of the control: left out")]
    BadLevel { source_words: String },
    #[error(
        "{source_words} switches the control's look-ahead: it sets no tolerance, and the machine's look-ahead holds"
    )]
    LookAhead { source_words: String },
}

impl PathRemark {
    pub(super) fn severity(&self) -> Severity {
        match self {
            PathRemark::BadTolerance { .. } | PathRemark::BadLevel { .. } => Severity::Error,
            PathRemark::NaiveCam | PathRemark::UnknownLevel { .. } => Severity::Warning,
            PathRemark::NoTolerance { .. } | PathRemark::LookAhead { .. } => Severity::Info,
        }
    }

    pub(super) fn holds_for_program(&self) -> bool {
        !matches!(self, PathRemark::BadTolerance { .. } | PathRemark::BadLevel { .. })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;

    fn blendings(program: &str, machine: &Machine) -> Vec<(usize, Blending)> {
        let modes = trace(&read(program.as_bytes()), machine).path_modes;
        modes.into_iter().map(|mode| (mode.from, mode.blending)).collect()
    }

    #[test]
    fn levels_are_those_of_the_machine() {
        let mut machine = Machine::default();
        machine.path_modes.finish = Some(0.002);
        (machine.path_modes.level_1, machine.path_modes.level_10) = (Some(0.1), Some(0.01));
        let found =
            blendings("G1 F1 X1\nG187 P3\nX2\nG187 P1\nX3\nG5.1 Q1 R1\nX4\nG5.1 Q1 R10\nX5", &machine);
        let within = Blending::Within;
        assert_eq!(found, [(1, within(0.002)), (2, Blending::Machine), (3, within(0.1)), (4, within(0.01))]);
    }

    #[test]
    fn a_mode_is_put_down_once_and_only_where_it_changes_something() {
        let machine = Machine::default();
        assert_eq!(blendings("G64\nG1 F1 X1\nG61\nG64\nX2\nG64 P0\nX3", &machine), []);
        let twice = "G64 P.1\nG1 F1 X1\nG64 P.1\nX2\nG64 P.2\nG64 P.1\nX3";
        assert_eq!(blendings(twice, &machine), [(0, Blending::Within(0.1))]);
    }

    #[test]
    fn a_tolerance_of_its_vendor_word_outlives_exact_stop_and_g64() {
        let program = "G187 E.02\nG1 F1 X1\nG61\nX2\nG64\nX3\nG187\nX4";
        let toolpath = trace(&read(program.as_bytes()), &Machine::default());
        let sources: Vec<&str> = toolpath.path_modes.iter().map(|mode| mode.source.as_str()).collect();
        assert_eq!(sources, ["G187 E0.02", "G61", "G187 E0.02", "G187"]);
        let stops: Vec<bool> = toolpath.segments.iter().map(|segment| segment.exact_stop).collect();
        assert_eq!(stops, [false, true, false, false]);
    }
}
