//! Remarks of tracing a program.

mod doubt;

use self::doubt::doubt_of;
use crate::simulation::gcode::{DoubtCause, DoubtEffect, LabelKind, Remark, Severity, counted};
use crate::simulation::interpreter::bounds::{MAX_CALL_DEPTH, MAX_COUNT, MAX_ITERATIONS_BY_MISSING};
use crate::simulation::interpreter::code::Code;
use crate::simulation::interpreter::cycle::NoHole;
use crate::simulation::interpreter::klartext::KlartextRemark;
use crate::simulation::interpreter::parameters::NoValue;
use crate::simulation::interpreter::path_mode::PathRemark;
use crate::simulation::interpreter::spline::NoSpline;
use crate::simulation::toolpath::compensation::CompensationRemark;
use crate::simulation::toolpath::plane::NoCircle;
use thiserror::Error;

/// A deviation from the control, or a fact that the user may want to know. Lengths are in mm.
#[derive(Clone, Debug, PartialEq, Error)]
pub(super) enum TraceRemark {
    #[error("{0}: block not run")]
    NoValue(#[from] NoValue),
    #[error("{code} is not understood: left out, and the axis words of its block are not run")]
    UnknownG { code: Code },
    #[error("{code}: {what}")]
    Unsupported { code: Code, what: &'static str },
    #[error("{code} is not understood: left out")]
    UnknownM { code: Code },
    #[error("{code} ({name}) is not modelled: from here on the path is taken as written")]
    Transformation { code: Code, name: &'static str },
    #[error("{0}")]
    PathMode(PathRemark),
    #[error("{first} and {second} exclude each other in one block: {second} is run")]
    Conflict { first: Code, second: Code },
    #[error("{letter} is given twice in one block: the last one counts")]
    RepeatedWord { letter: char },
    #[error(
        "{letter}{value} has no decimal point, unlike other lengths of the program: taken as written; set program.increment_mm = 0.001 if the control counts thousandths"
    )]
    MissingPoint { letter: char, value: f64 },
    #[error(
        "no length has a decimal point and the path extends over more than 5 m: taken as written; set program.increment_mm = 0.001 if the control counts thousandths"
    )]
    NoPoints,
    #[error("{letter} words are not modelled: only moves in X, Y, Z, A, B and C are timed")]
    UnmodelledWord { letter: char },
    #[error("no G0 to G3 before the first axis words: taken as G0")]
    NoMotionWord,
    #[error("{letter} reaches beyond 10 km: block not moved")]
    OutOfReach { letter: char },
    #[error("I, J and K have no meaning in a straight move: left out")]
    UnusedCenter,
    #[error("{code} is a setting: the other words of its block do not move the machine")]
    Setting { code: Code },
    #[error("axis words beside {code} are not run")]
    UnusedAxisWords { code: Code },

    #[error("F{value} is not a feedrate that a machine can run: the previous one stays in force")]
    BadFeed { value: f64 },
    #[error(
        "{feedrate:.0} mm/min is faster than the machine's rapids ({rapid:.0} mm/min): run as written; to limit it, set axis.x.velocity_mm_min and so on"
    )]
    FasterThanRapid { feedrate: f64, rapid: f64 },
    #[error("no F before this move: feed moves run at {assumed:.0} mm/min until the first F")]
    NoFeed { assumed: f64 },
    #[error(
        "{code} cancelled the feedrate and no F follows, so the control stops here; Truefeed continues at {former:.0} mm/min"
    )]
    ForgottenFeed { code: Code, former: f64 },
    #[error("{}", inverse_time_text(*.assumed))]
    NoInverseTime { assumed: Option<f64> },
    #[error("G95 needs a spindle speed S: feed moves run at {assumed:.0} mm/min until the first S")]
    NoSpindleSpeed { assumed: f64 },
    #[error(
        "G96 (constant surface speed) is not modelled, since the diameter is unknown: feeds in mm/min are right, feeds per revolution (G95) use the last S in rev/min"
    )]
    SurfaceSpeed,

    #[error("{letter}{degrees} is beyond 10 million degrees: the axis is not turned")]
    BadAngle { letter: char, degrees: f64 },
    #[error("{}", rotary_feed_text(*.is_combined))]
    RotaryFeed { is_combined: bool },
    #[error(
        "{name} (tool centre point control): the path and feed of the tool tip are run as written; the motion of head and table is not modelled"
    )]
    TipControl { name: &'static str },
    #[error("{0}")]
    Contour(#[from] CompensationRemark),

    #[error("{code}: {no_spline}: a straight feed move is run instead")]
    NoSpline { code: Code, no_spline: NoSpline },
    #[error("a control point of G5.2 needs X and Y in the XY plane and a positive weight P: left out")]
    NoControlPoint,
    #[error("{code} without G5.2 and its control points: left out")]
    NurbsNotBegun { code: Code },
    #[error("the curve begun by G5.2 is not run, since no G5.3 follows its control points")]
    NurbsNotEnded,
    #[error("arc without centre (I, J, K) or radius (R): taken as a straight line")]
    NoCenter,
    #[error("{0}: taken as a straight line")]
    NoCircle(#[from] NoCircle),
    #[error(
        "arc has radius {start:.4} mm at its start and {end:.4} mm at its end: run as a spiral between the two"
    )]
    UnequalRadii { start: f64, end: f64 },
    #[error(
        "absolute arc centres: the arcs of this program close if I, J and K count from the origin instead of from their start, so they are run that way; choose incremental arc centres if that is wrong"
    )]
    AbsoluteCenters,
    #[error("R and I, J, K in one block: R is used")]
    RadiusAndCenter,
    #[error("{letter}{value} is not a number of turns: one turn is run")]
    BadTurns { letter: char, value: f64 },
    #[error("L{turns} of an arc is taken as its number of turns; controls without such a word run one")]
    TurnsByL { turns: u32 },
    #[error("{letter} has no meaning for this arc on this control: left out")]
    ArcWordNotRun { letter: char, value: f64 },

    #[error("P of G4 is read as seconds")]
    DwellInSeconds,
    #[error(
        "a time without a decimal point is read as milliseconds, since the program has a % line or an O number"
    )]
    TimeInMilliseconds,
    #[error(
        "a time of 100 or more without a decimal point is read as milliseconds; if seconds are meant, write a point or choose the dialect"
    )]
    GuessedTimeUnit,
    #[error("G4 without a waiting time: no dwell")]
    NoDwellTime,
    #[error("a waiting time of {seconds} s is not possible: no dwell")]
    BadDwell { seconds: f64 },
    #[error(
        "the reference point of {axis} is unknown: moves to it (G28, G30, G53) are not timed; set axis.{key}.home_mm"
    )]
    UnknownHome { axis: char, key: char },
    #[error(
        "{code} is a second work offset: offsets that neither G10 nor the machine file gives are taken as zero, so the time of moves between them is wrong"
    )]
    WorkOffsets { code: Code },
    #[error("{code} needs P with the number of an offset: left out")]
    NoOffsetNumber { code: Code },
    #[error(
        "this {code} is ignored; Truefeed applies it to work offsets (L2, L20), tool lengths (L1) and, on Fanuc controls, tool radii (L12)"
    )]
    DataSetting { code: Code },
    #[error(
        "{code}: the length of this tool is unknown and taken as zero; length offsets shift the whole program and do not change its time"
    )]
    NoToolLength { code: Code },
    #[error("G68 without an angle R: coordinates do not change")]
    NoAngle,
    #[error("G51 without a scale P, or I, J and K, other than 0: coordinates do not change")]
    BadScale,
    #[error(
        "an arc under different scales of the axes: each axis scales its own end and centre coordinate, and the larger scale applies to R, as on Fanuc controls"
    )]
    UnevenScale,
    #[error(
        "an arc in a tilted plane cannot be run under a scale that differs from axis to axis: taken as a straight line"
    )]
    TiltedUnevenScale,

    #[error("{code}: {no_hole}: hole not made")]
    NoHole { code: Code, no_hole: NoHole },
    #[error("more than {most} pecks in one hole: made with {most}")]
    DeeperPecks { most: u32, per_made: f64 },
    #[error("{letter} of {code} is not modelled: the hole is made without it")]
    CycleWord { code: Code, letter: char },
    #[error("{code} without P: no dwell")]
    NoCycleDwell { code: Code },
    #[error("{code} waits until somebody removes the tool by hand: only the rapid move out is timed")]
    ManualRetract { code: Code },
    #[error("a hole cannot be repeated {value} times: it is made once")]
    BadRepeats { value: f64 },
    #[error("{value} repetitions cannot be run, {MAX_COUNT} at most: they are missing from the time")]
    TooManyRepeats { value: f64 },
    #[error("{value} is not a whole number of repetitions: {:.0} are run", .value.round())]
    UnevenRepeats { value: f64 },
    #[error("S{value} is not a speed that a spindle can run: the previous one stays in force")]
    BadSpeed { value: f64 },
    #[error("no S before M{code}: the start of the spindle is timed without its ramp")]
    NoSpeed { code: u32 },
    #[error("tool {tool} is already in the spindle: the change takes no time")]
    SameTool { tool: u32 },
    #[error("the rest of the program is taken as one operation; otherwise there would be {} more", counted(*.beyond, "operation"))]
    ManyOperations { beyond: usize },
    #[error("{} is not in this file: its moves are missing from the time", label_text(*.kind, .name))]
    NoLabel { kind: LabelKind, name: String },
    #[error("M98, M97 and G65 need a P with the number of a program: not called")]
    NoSubprogram,
    #[error("M198 (program from another device) is not in this file: its moves are missing from the time")]
    ExternalProgram,
    #[error("G66 (macro call after every move) is not modelled: the macro is not run")]
    ModalMacro,
    #[error("calls are nested deeper than {MAX_CALL_DEPTH}: the program ends here")]
    DeepCall,
    #[error("the program repeated more than {most} blocks and seems to loop for ever: it ends here")]
    EndlessRun { most: usize },
    #[error(
        "this jump back repeats for ever, since the loop changes nothing that its condition depends on: the program ends here"
    )]
    EndlessLoop,
    #[error(
        "this loop depends on {parameter}, to which nothing is assigned; the program seems to be a macro without its arguments: it ends here after {MAX_ITERATIONS_BY_MISSING} turns"
    )]
    MissingArgument { parameter: String },
    #[error(
        "this may be a lathe program, judging by {reasons}: Truefeed does not model turning, and runs it as a program for a mill"
    )]
    PerhapsLathe { reasons: String },
    #[error("M99 at the end of the main program restarts it: one run is timed")]
    BeginsAgain,
    #[error("the program raises an alarm (#3000) and ends here")]
    Alarm,
    #[error("{name}: {what}")]
    Statement { name: &'static str, what: &'static str },
    #[error("{name} is a curve that is not modelled: its points are joined by straight lines")]
    Curve { name: &'static str },
    #[error(
        "{code} (probing): run to its end at the feedrate in force, since the point of contact is unknown: the time is an upper bound, and that end is taken as the result"
    )]
    Probing { code: Code },
    #[error("{code} needs a pitch (K) and a spindle speed (S): run at the feedrate in force")]
    NoThreadFeed { code: Code },
    #[error(
        "{name} (milling cycle) is not modelled: its moves are missing from the time; post the operation as moves, or add its time"
    )]
    MillingCycle { name: &'static str },
    #[error("{name}: {no_hole}: hole not made")]
    NoSiemensHole { name: &'static str, no_hole: NoHole },
    #[error("no arc goes through these three points: a straight move to the end")]
    NoArcThrough,
    #[error("G33, G331 and G332 need a pitch (K) and a spindle speed (S): run at the feedrate in force")]
    NoTapFeed,
    #[error("{0}")]
    Klartext(KlartextRemark),
    #[error("{text}: not run")]
    NotRun { text: String },
    #[error(
        "the program reads parameters that have no value, the first is {parameter}: taken as empty, as on the control"
    )]
    Unassigned { parameter: String },
    #[error("{} from here on, after the end of the program ({code}): not run", counted(*.blocks, "block"))]
    AfterEnd { blocks: usize, code: Code },
}

fn inverse_time_text(assumed: Option<f64>) -> String {
    let instead = assumed.map_or("the F of the block before is taken".to_string(), |assumed| {
        format!("this one is taken at {assumed:.0} mm/min")
    });
    format!("every feed move under G93 needs its own F: {instead}")
}

fn rotary_feed_text(is_combined: bool) -> &'static str {
    if is_combined {
        "F applies to linear and rotary axes together, and a degree counts as a unit of length"
    } else {
        "F applies to X, Y and Z, while rotary axes turn with them (RS274/NGC); controls that count degrees as lengths are slower"
    }
}

fn label_text(kind: LabelKind, name: &str) -> String {
    match kind {
        LabelKind::Sequence => format!("block N{name}"),
        LabelKind::Program => format!("program O{name}"),
        LabelKind::Numbered => format!("subprogram or label {name}"),
        LabelKind::Named => format!("subprogram or label `{name}`"),
    }
}

impl Remark for TraceRemark {
    // Long because it is a table: each remark is in it once, and the compiler reports those that are missing.
    fn severity(&self) -> Severity {
        match self {
            TraceRemark::Contour(remark) => remark.severity(),
            TraceRemark::NoValue(_)
            | TraceRemark::UnknownG { .. }
            | TraceRemark::UnknownM { .. }
            | TraceRemark::Unsupported { .. }
            | TraceRemark::Transformation { .. }
            | TraceRemark::Conflict { .. }
            | TraceRemark::RepeatedWord { .. }
            | TraceRemark::OutOfReach { .. }
            | TraceRemark::UnusedAxisWords { .. }
            | TraceRemark::BadFeed { .. }
            | TraceRemark::NoFeed { .. }
            | TraceRemark::NoInverseTime { .. }
            | TraceRemark::NoSpindleSpeed { .. }
            | TraceRemark::BadAngle { .. }
            | TraceRemark::NoOffsetNumber { .. }
            | TraceRemark::NoAngle
            | TraceRemark::BadScale
            | TraceRemark::TiltedUnevenScale
            | TraceRemark::NoSpline { .. }
            | TraceRemark::NoControlPoint
            | TraceRemark::NurbsNotBegun { .. }
            | TraceRemark::NurbsNotEnded
            | TraceRemark::ForgottenFeed { .. }
            | TraceRemark::NoCenter
            | TraceRemark::NoCircle(_)
            | TraceRemark::BadTurns { .. }
            | TraceRemark::BadRepeats { .. }
            | TraceRemark::TooManyRepeats { .. }
            | TraceRemark::NoHole { .. }
            | TraceRemark::NoDwellTime
            | TraceRemark::BadDwell { .. }
            | TraceRemark::BadSpeed { .. }
            | TraceRemark::NoLabel { .. }
            | TraceRemark::NoSubprogram
            | TraceRemark::ExternalProgram
            | TraceRemark::ModalMacro
            | TraceRemark::DeepCall
            | TraceRemark::EndlessRun { .. }
            | TraceRemark::EndlessLoop
            | TraceRemark::MissingArgument { .. }
            | TraceRemark::Alarm
            | TraceRemark::MillingCycle { .. }
            | TraceRemark::NoSiemensHole { .. }
            | TraceRemark::NoArcThrough
            | TraceRemark::NotRun { .. } => Severity::Error,
            TraceRemark::UnmodelledWord { .. }
            | TraceRemark::MissingPoint { .. }
            | TraceRemark::NoPoints
            | TraceRemark::GuessedTimeUnit
            | TraceRemark::UnusedCenter
            | TraceRemark::SurfaceSpeed
            | TraceRemark::FasterThanRapid { .. }
            | TraceRemark::TipControl { .. }
            | TraceRemark::UnevenScale
            | TraceRemark::UnequalRadii { .. }
            | TraceRemark::RadiusAndCenter
            | TraceRemark::NoSpeed { .. }
            | TraceRemark::DeeperPecks { .. }
            | TraceRemark::TurnsByL { .. }
            | TraceRemark::ArcWordNotRun { .. }
            | TraceRemark::CycleWord { .. }
            | TraceRemark::NoCycleDwell { .. }
            | TraceRemark::ManualRetract { .. }
            | TraceRemark::Statement { .. }
            | TraceRemark::Curve { .. }
            | TraceRemark::NoTapFeed
            | TraceRemark::Probing { .. }
            | TraceRemark::NoThreadFeed { .. }
            | TraceRemark::PerhapsLathe { .. }
            | TraceRemark::UnevenRepeats { .. }
            | TraceRemark::Unassigned { .. } => Severity::Warning,
            TraceRemark::PathMode(remark) => remark.severity(),
            TraceRemark::Klartext(remark) => remark.severity(),
            TraceRemark::NoMotionWord
            | TraceRemark::AbsoluteCenters
            | TraceRemark::Setting { .. }
            | TraceRemark::DwellInSeconds
            | TraceRemark::TimeInMilliseconds
            | TraceRemark::UnknownHome { .. }
            | TraceRemark::WorkOffsets { .. }
            | TraceRemark::DataSetting { .. }
            | TraceRemark::NoToolLength { .. }
            | TraceRemark::RotaryFeed { .. }
            | TraceRemark::SameTool { .. }
            | TraceRemark::ManyOperations { .. }
            | TraceRemark::BeginsAgain
            | TraceRemark::AfterEnd { .. } => Severity::Info,
        }
    }

    fn holds_for_program(&self) -> bool {
        if let TraceRemark::PathMode(remark) = self {
            return remark.holds_for_program();
        }
        if let TraceRemark::Klartext(remark) = self {
            return remark.holds_for_program();
        }
        matches!(
            self,
            TraceRemark::Transformation { .. }
                | TraceRemark::Statement { .. }
                | TraceRemark::Curve { .. }
                | TraceRemark::UnmodelledWord { .. }
                | TraceRemark::NoMotionWord
                | TraceRemark::AbsoluteCenters
                | TraceRemark::Probing { .. }
                | TraceRemark::NoFeed { .. }
                | TraceRemark::NoSpline { no_spline: NoSpline::GivenKnots, .. }
                | TraceRemark::NoSpindleSpeed { .. }
                | TraceRemark::RotaryFeed { .. }
                | TraceRemark::TipControl { .. }
                | TraceRemark::UnevenScale
                | TraceRemark::NoToolLength { .. }
                | TraceRemark::SurfaceSpeed
                | TraceRemark::FasterThanRapid { .. }
                | TraceRemark::DwellInSeconds
                | TraceRemark::GuessedTimeUnit
                | TraceRemark::TimeInMilliseconds
                | TraceRemark::ManualRetract { .. }
                | TraceRemark::UnknownHome { .. }
                | TraceRemark::DataSetting { .. }
        )
    }

    fn doubt(&self) -> Option<(DoubtCause, DoubtEffect)> {
        doubt_of(self)
    }
}

#[cfg(test)]
mod tests;
