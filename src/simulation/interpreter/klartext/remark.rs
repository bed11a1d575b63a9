//! Remarks on running Heidenhain programs.

use crate::simulation::gcode::Severity;
use thiserror::Error;

/// A deviation from the control. Lengths are in mm.
#[derive(Clone, Debug, PartialEq, Error)]
pub(crate) enum KlartextRemark {
    #[error("{name}: {what}")]
    Statement { name: &'static str, what: &'static str },
    #[error("cycle {number} is not modelled: its moves are missing from the time")]
    Cycle { number: u32 },
    #[error("cycle {number}: {what}: hole not made")]
    NoHole { number: u32, what: String },
    #[error("cycle {number}: {what}")]
    CycleSetting { number: u32, what: &'static str },
    #[error("no cycle is defined before this call: left out")]
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
    pub(crate) fn severity(&self) -> Severity {
        match self {
            KlartextRemark::Cycle { .. }
            | KlartextRemark::NoHole { .. }
            | KlartextRemark::NoCycle
            | KlartextRemark::NoPole
            | KlartextRemark::Missing { .. } => Severity::Error,
            _ => Severity::Warning,
        }
    }

    pub(crate) fn holds_for_program(&self) -> bool {
        matches!(self, KlartextRemark::Statement { .. } | KlartextRemark::CycleSetting { .. })
    }
}

/// Statements without a model, each with the consequence.
pub(super) const UNMODELLED: &[(&str, &str)] = &[
    (
        "PLANE",
        "a tilted working plane is not modelled: moves are taken as written, and the rotation of the axes is missing from the time",
    ),
    ("PATTERN DEF", "patterns of points are not modelled: their holes are missing from the time"),
    ("SEL PATTERN", "the point table is not in this file: the time of its holes is missing"),
    ("CYCL CALL PAT", "patterns of points are not modelled: their holes are missing from the time"),
    ("CONTOUR DEF", "contours of cycles are not modelled"),
    ("SEL CONTOUR", "contours of cycles are not modelled"),
    ("DECLARE CONTOUR", "contours of cycles are not modelled"),
    ("SEL TABLE", "the datum table is not in this file: its shifts are not applied"),
    ("PRESET", "presets of the control are unknown: the current one stays in force"),
    (
        "TCH PROBE",
        "probing is not modelled: its moves and its time are missing, and its results are taken as 0",
    ),
    ("FK", "free contour programming is not modelled: this move is left out, and its time is missing"),
    ("SPL", "splines are not modelled: this move is left out, and its time is missing"),
    ("SEL PGM", "the program selected by SEL PGM is not in this file"),
    ("CALL SELECTED PGM", "the program is not in this file: its moves are missing from the time"),
    ("LBL QS", "a label named by a text parameter is not followed: its moves are missing from the time"),
    ("IS UNDEFINED", "this condition is not evaluated: the program continues without the jump"),
    ("QS", "text parameters are not followed"),
    ("FN 14", "an error message would stop the control here: the program continues"),
    ("FN 18", "this value of the control is unknown: taken as 0"),
    ("FN 18 POSITION", "the position read is the programmed one; manual moves are unknown"),
    ("FN 19", "the effect of this PLC output is unknown: no time is taken for it"),
    ("FN 20", "how long the control waits for the PLC is unknown: no time is counted"),
    ("FN 26", "tables of the control are unknown: left out"),
    ("FN 27", "tables of the control are unknown: left out"),
    ("FN 28", "tables of the control are unknown: values read are taken as 0"),
    ("FN 29", "the effect of this PLC output is unknown: no time is taken for it"),
    ("FN 37", "exported parameters are unknown"),
    ("FUNCTION FEED", "the dwells of FUNCTION FEED DWELL are not modelled: their time is missing"),
    ("FUNCTION DWELL", "FUNCTION DWELL is not modelled: its time is missing"),
    ("FUNCTION TURNDATA", "turning is not modelled: moves are taken as written"),
    ("FUNCTION MODE TURN", "turning is not modelled: moves are taken as written"),
    ("G06", "a tangential arc without an end is left out"),
];
