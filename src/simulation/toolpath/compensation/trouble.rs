//! What the stage between contour and toolpath could not do as a control would.

use crate::simulation::gcode::{LineNumber, Severity};
use thiserror::Error;

/// Where compensation, rounding or a chamfer gave way. Lengths are in mm.
#[derive(Clone, Debug, PartialEq, Error)]
pub(in crate::simulation::toolpath) enum Trouble {
    #[error(
        "gouge: the tool (radius {radius:.4} mm) does not fit into the inner corner at this move: it is left out, and the moves around it are joined"
    )]
    Vanished { radius: f64 },
    #[error(
        "gouge: the tool (radius {radius:.4} mm) does not fit into the inner corner before this move: it is run in a straight line to its end"
    )]
    Reversed { radius: f64 },
    #[error(
        "gouge: this inner arc cannot be entered by the tool (radius {radius:.4} mm): it is left out, and the moves around it are joined"
    )]
    TightArc { radius: f64 },
    #[error(
        "gouge: the inner corner before this move cannot be entered by the tool (radius {radius:.4} mm): both moves are run in full, with a straight line between them"
    )]
    NoWay { radius: f64 },
    #[error(
        "the first move under cutter compensation is not longer than the tool radius ({radius:.4} mm): it is run all the same, where controls stop"
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
        "diameter {diameter} mm of tool {tool} taken from the comment in line {}; where the path is that of the tool's centre and its register holds wear alone, set tools.{tool}.diameter_mm = 0", .line.0
    )]
    ToldDiameter { tool: u32, diameter: f64, line: LineNumber },
    #[error(
        "cutter compensation without a tool number: path taken as programmed; give D, and set tools.1.diameter_mm and so on"
    )]
    NoTool,
    #[error("D{value} is no tool number: path taken as programmed")]
    BadNumber { value: f64 },
}

impl Trouble {
    pub(in crate::simulation::toolpath) fn severity(&self) -> Severity {
        match self {
            Trouble::NotInPlane { .. } | Trouble::BadSize { .. } | Trouble::BadNumber { .. } => {
                Severity::Error
            }
            Trouble::ToldDiameter { .. } => Severity::Info,
            _ => Severity::Warning,
        }
    }
}
