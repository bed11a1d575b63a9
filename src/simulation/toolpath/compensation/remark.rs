//! Remarks on compensation and corner treatments: where Truefeed does not do what a control would.

use crate::simulation::gcode::{LineNumber, Severity};
use thiserror::Error;

/// A deviation of compensation, rounding or chamfer from a control. Lengths are in mm.
#[derive(Clone, Debug, PartialEq, Error)]
pub(crate) enum CompensationRemark {
    #[error(
        "gouge: the tool (radius {radius:.4} mm) does not fit into the inner corner at this move: Truefeed leaves it out and joins the moves around it"
    )]
    Vanished { radius: f64 },
    #[error(
        "gouge: the tool (radius {radius:.4} mm) does not fit into the inner corner before this move: Truefeed runs the move as a straight line to its end"
    )]
    Reversed { radius: f64 },
    #[error(
        "gouge: the tool (radius {radius:.4} mm) does not fit into this inner arc: Truefeed leaves it out and joins the moves around it"
    )]
    TightArc { radius: f64 },
    #[error(
        "gouge: the tool (radius {radius:.4} mm) does not fit into the inner corner before this move: Truefeed runs both moves in full and joins them with a straight line"
    )]
    NoInnerJoint { radius: f64 },
    #[error(
        "the first move under cutter compensation is not longer than the tool radius ({radius:.4} mm): run anyway, although controls stop here"
    )]
    ShortEntry { radius: f64 },
    #[error("no arc leads in to this compensated arc: the tool goes straight to its end")]
    NoEntryArc,
    #[error("cutter compensation cannot end with an arc: the tool goes straight to the start of the arc")]
    ArcAtEnd,

    #[error("no room for the {name} between this move and the next: left out")]
    NoRoom { name: &'static str },
    #[error("a {name} needs two moves in the working plane, straight for a chamfer: left out")]
    NotInPlane { name: &'static str },
    #[error("a {name} of {size} mm is not possible: left out")]
    BadSize { name: &'static str, size: f64 },

    #[error(
        "cutter compensation: the diameter of tool {tool} is unknown: path taken as programmed; set tools.{tool}.diameter_mm"
    )]
    UnknownDiameter { tool: u32 },
    #[error(
        "diameter {diameter} mm of tool {tool} taken from the comment in line {}; if the program gives the path of the tool centre and the register only wear, set tools.{tool}.diameter_mm = 0", .line.0
    )]
    CommentDiameter { tool: u32, diameter: f64, line: LineNumber },
    #[error(
        "cutter compensation without a tool number: path taken as programmed; give D, and set tools.1.diameter_mm and so on"
    )]
    NoTool,
    #[error("D{value} is no tool number: path taken as programmed")]
    BadNumber { value: f64 },
}

impl CompensationRemark {
    pub(crate) fn severity(&self) -> Severity {
        match self {
            CompensationRemark::NotInPlane { .. }
            | CompensationRemark::BadSize { .. }
            | CompensationRemark::BadNumber { .. } => Severity::Error,
            CompensationRemark::CommentDiameter { .. } => Severity::Info,
            _ => Severity::Warning,
        }
    }
}
