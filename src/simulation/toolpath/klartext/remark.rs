//! What running Heidenhain programs has to say.

use crate::simulation::gcode::Severity;
use thiserror::Error;

/// Something that was not run as the control would. Lengths are in mm.
#[derive(Clone, Debug, PartialEq, Error)]
pub(in crate::simulation::toolpath) enum KlartextRemark {
    #[error("{name}: {what}")]
    Statement { name: &'static str, what: &'static str },
    #[error("cycle {number} is not modelled: its moves are missing from the time")]
    Cycle { number: u32 },
    #[error("cycle {number}: {what}: hole not made")]
    NoHole { number: u32, what: String },
    #[error("cycle {number}: {what}")]
    CycleSetting { number: u32, what: &'static str },
    #[error("no cycle is defined before this call: nothing is done")]
    NoCycle,
    #[error("no pole (CC) before this block: the origin is taken")]
    NoPole,
    #[error("{name} has no {what}: {instead}")]
    Missing { name: &'static str, what: &'static str, instead: &'static str },
    #[error(
        "{name}: the tool (radius {radius:.4} mm) does not fit into this arc: a straight line is run instead"
    )]
    TightApproach { name: &'static str, radius: f64 },
}

impl KlartextRemark {
    pub(in crate::simulation::toolpath) fn severity(&self) -> Severity {
        match self {
            KlartextRemark::Cycle { .. }
            | KlartextRemark::NoHole { .. }
            | KlartextRemark::NoCycle
            | KlartextRemark::NoPole
            | KlartextRemark::Missing { .. } => Severity::Error,
            _ => Severity::Warning,
        }
    }

    pub(in crate::simulation::toolpath) fn is_said_once(&self) -> bool {
        matches!(self, KlartextRemark::Statement { .. } | KlartextRemark::CycleSetting { .. })
    }
}

/// Statements that are not modelled, and what follows from that.
pub(super) const UNMODELLED: &[(&str, &str)] = &[
    (
        "PLANE",
        "a tilted working plane is not modelled: moves are taken as written, and the turn of the axes is missing from the time",
    ),
    ("PATTERN DEF", "patterns of points are not modelled: their holes are missing from the time"),
    ("SEL PATTERN", "tables of points are not in this file: their holes are missing from the time"),
    ("CYCL CALL PAT", "patterns of points are not modelled: their holes are missing from the time"),
    ("CONTOUR DEF", "contours of cycles are not modelled"),
    ("SEL CONTOUR", "contours of cycles are not modelled"),
    ("DECLARE CONTOUR", "contours of cycles are not modelled"),
    ("SEL TABLE", "the datum table is not in this file: its shifts are not applied"),
    ("PRESET", "presets of the control are not known: coordinates go on in the one in force"),
    (
        "TCH PROBE",
        "probing is not modelled: its moves and its time are missing, and what it measures is taken as 0",
    ),
    ("FK", "free contour programming is not modelled: this move is left out, and its time is missing"),
    ("SPL", "splines are not modelled: this move is left out, and its time is missing"),
    ("SEL PGM", "a program that is chosen by SEL PGM is not in this file"),
    ("CALL SELECTED PGM", "the program is not in this file: its moves are missing from the time"),
    ("LBL QS", "a label named by a text parameter is not followed: its moves are missing from the time"),
    ("IS UNDEFINED", "this condition is not worked out: the program goes on without the jump"),
    ("QS", "text parameters are not followed"),
    ("FN 14", "an error message would stop the control here: the program goes on"),
    ("FN 18", "this value of the control is not known: taken as 0"),
    ("FN 18 POSITION", "the position read is where the program has the tool; moves by hand are not known"),
    ("FN 19", "what is sent to the PLC is not known: no time is taken for it"),
    ("FN 20", "the wait for the PLC is not known: no time is taken for it"),
    ("FN 26", "tables of the control are not known: left out"),
    ("FN 27", "tables of the control are not known: left out"),
    ("FN 28", "tables of the control are not known: what is read is taken as 0"),
    ("FN 29", "what is sent to the PLC is not known: no time is taken for it"),
    ("FN 37", "exported parameters are not known"),
    ("FUNCTION FEED", "the dwells of FUNCTION FEED DWELL are not modelled: their time is missing"),
    ("FUNCTION DWELL", "FUNCTION DWELL is not modelled: its time is missing"),
    ("FUNCTION TURNDATA", "turning is not modelled: moves are taken as written"),
    ("FUNCTION MODE TURN", "turning is not modelled: moves are taken as written"),
    ("G06", "a tangential arc without an end is left out"),
];
