//! What tracing has to say about a program.

use crate::simulation::gcode::{Cause, Effect, LabelKind, Remark, Severity, counted};
use crate::simulation::toolpath::compensation::Trouble;
use crate::simulation::toolpath::cycle::NoHole;
use crate::simulation::toolpath::doubt::doubt_of;
use crate::simulation::toolpath::klartext::KlartextRemark;
use crate::simulation::toolpath::parameters::NoValue;
use crate::simulation::toolpath::path_mode::PathRemark;
use crate::simulation::toolpath::plane::NoCircle;
use crate::simulation::toolpath::run::{DEEPEST_CALL, MAX_TURNS_BY_MISSING, MOST_COUNT};
use crate::simulation::toolpath::spline::NoSpline;
use thiserror::Error;

/// Something that was not traced as a control would run it, or that the user may want to know.
/// Lengths are in mm.
#[derive(Clone, Debug, PartialEq, Error)]
pub(super) enum Untraced {
    #[error("{0}: block not run")]
    NoValue(#[from] NoValue),
    #[error("{code} is not understood: left out, and the axis words of its block are not run")]
    UnknownG { code: Code },
    #[error("{code}: {what}")]
    Left { code: Code, what: &'static str },
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
        "{letter}{value} has no decimal point, other lengths of the program have: taken as written; set program.increment_mm = 0.001 if the control counts thousandths"
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
    #[error("I, J and K mean nothing in a straight move: left out")]
    UnusedCenter,
    #[error("{code} is a setting: the other words of its block are no move")]
    Setting { code: Code },
    #[error("axis words beside {code} are not run")]
    UnusedAxisWords { code: Code },

    #[error("F{value} is not a feedrate a machine can run: the former stays in force")]
    BadFeed { value: f64 },
    #[error(
        "{feedrate:.0} mm/min is faster than the machine's rapids ({rapid:.0} mm/min): run as written; axis.x.velocity_mm_min and so on would limit it"
    )]
    FasterThanRapid { feedrate: f64, rapid: f64 },
    #[error("no F before this move: feed moves are taken at {assumed:.0} mm/min until there is one")]
    NoFeed { assumed: f64 },
    #[error(
        "no F since {code}, which forgets the one before, so that the control stops here: the former feedrate of {former:.0} mm/min is taken"
    )]
    ForgottenFeed { code: Code, former: f64 },
    #[error("{}", inverse_time_text(*.assumed))]
    NoInverseTime { assumed: Option<f64> },
    #[error("G95 needs a spindle speed S: feed moves are taken at {assumed:.0} mm/min until there is one")]
    NoSpindleSpeed { assumed: f64 },
    #[error(
        "G96 (constant surface speed) is not modelled, since the diameter is unknown: feeds in mm/min are right, feeds per revolution (G95) go on with the last S in rev/min"
    )]
    SurfaceSpeed,

    #[error("{letter}{degrees} is beyond 10 million degrees: the axis is not turned")]
    BadAngle { letter: char, degrees: f64 },
    #[error("{}", rotary_feed_text(*.is_combined))]
    RotaryFeed { is_combined: bool },
    #[error(
        "{name} (tool centre point control): the path of the tool tip and its feed are run as written; what the machine's own axes do to turn the head or table about it is not modelled"
    )]
    TipControl { name: &'static str },
    #[error("{0}")]
    Contour(#[from] Trouble),

    #[error("{code}: {no_spline}: a straight feed move is run instead")]
    NoSpline { code: Code, no_spline: NoSpline },
    #[error("a control point of G5.2 needs X and Y in the XY plane and a positive weight P: left out")]
    NoControlPoint,
    #[error("{code} without G5.2 and its control points: left out")]
    NurbsNotBegun { code: Code },
    #[error("the curve that G5.2 began is not run, since no G5.3 follows its control points")]
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
        "absolute arc centres: the arcs of this program close with I, J and K from the origin and not from their start, and are run so; choose incremental arc centres if that is wrong"
    )]
    AbsoluteCenters,
    #[error("R and I, J, K in one block: R counts")]
    RadiusAndCenter,
    #[error("{letter}{value} is no number of turns: one turn is run")]
    BadTurns { letter: char, value: f64 },
    #[error("L{turns} of an arc is taken for its number of turns; controls without such a word run one")]
    TurnsByL { turns: f64 },
    #[error("{letter} means nothing to this arc on this control: left out")]
    ArcWordNotRun { letter: char },

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
        "{code} is a second work offset: those that neither G10 nor the machine file gives are taken as zero, so that moves between them are timed too short or too long"
    )]
    WorkOffsets { code: Code },
    #[error("{code} needs P with the number of an offset: left out")]
    NoOffsetNumber { code: Code },
    #[error(
        "the setting of this {code} is not applied: work offsets (L2, L20), tool lengths (L1) and, on Fanuc controls, radii of tools (L12) are"
    )]
    DataSetting { code: Code },
    #[error(
        "{code}: the length of this tool is not known and taken as zero; length offsets shift the whole program and change no time"
    )]
    NoToolLength { code: Code },
    #[error("G68 without an angle R: coordinates stay as they are")]
    NoAngle,
    #[error("G51 without a scale P, or I, J and K, other than 0: coordinates stay as they are")]
    BadScale,
    #[error(
        "an arc under a scale that differs from axis to axis: end and I, J, K are scaled each on its own axis and R by the larger scale, as Fanuc controls do"
    )]
    UnevenScale,
    #[error(
        "an arc in a tilted plane cannot be run under a scale that differs from axis to axis: taken as a straight line"
    )]
    TiltedUnevenScale,

    #[error("{code}: {no_hole}: hole not made")]
    NoHole { code: Code, no_hole: NoHole },
    #[error("more than {most} pecks in one hole: made with {most}")]
    DeeperPecks { most: u32 },
    #[error("{letter} of {code} is not modelled: the hole is made without it")]
    CycleWord { code: Code, letter: char },
    #[error("{code} without P: no dwell")]
    NoCycleDwell { code: Code },
    #[error("{code} waits for the tool to be taken out by hand: only the move out in rapid is timed")]
    ManualRetract { code: Code },
    #[error("a hole cannot be repeated {value} times: it is made once")]
    BadRepeats { value: f64 },
    #[error("{value} repetitions cannot be run, {MOST_COUNT} at most: they are missing from the time")]
    TooManyRepeats { value: f64 },
    #[error("S{value} is not a speed that a spindle can run: the former stays in force")]
    BadSpeed { value: f64 },
    #[error("no S before M{code}: the spindle's start is timed without its ramp")]
    NoSpeed { code: u32 },
    #[error("tool {tool} is in the spindle already: the change takes no time")]
    SameTool { tool: u32 },
    #[error("from here on all is taken as one operation: there would be {} more", counted(*.beyond, "operation"))]
    ManyOperations { beyond: usize },
    #[error("{} is not in this file: its moves are missing from the time", label_text(*.kind, .name))]
    NoLabel { kind: LabelKind, name: String },
    #[error("M98, M97 and G65 need a P with the number of a program: not called")]
    NoSubprogram,
    #[error("M198 (program from another device) is not in this file: its moves are missing from the time")]
    ExternalProgram,
    #[error("G66 (macro call after every move) is not modelled: the macro is not run")]
    ModalMacro,
    #[error("calls are nested deeper than {DEEPEST_CALL}: the program ends here")]
    DeepCall,
    #[error("more than {most} blocks were repeated: the program seems to loop for ever, and ends here")]
    EndlessRun { most: usize },
    #[error(
        "this jump back is made for ever, since a turn of the loop changes nothing that it goes by: the program ends here"
    )]
    EndlessLoop,
    #[error(
        "this loop goes by {parameter}, to which nothing is assigned, so that the program seems to be a macro without its arguments: it ends here after {MAX_TURNS_BY_MISSING} turns"
    )]
    MissingArgument { parameter: String },
    #[error("M99 at the end of the main program begins it again: one run is timed")]
    BeginsAgain,
    #[error("the program raises an alarm (#3000) and ends here")]
    Alarm,
    #[error("{name}: {what}")]
    Statement { name: &'static str, what: &'static str },
    #[error("{name} is a curve that is not modelled: its points are joined by straight lines")]
    Curve { name: &'static str },
    #[error(
        "{code} (probing): run to its end at the feedrate in force, since nobody can tell where the probe touches: the time is an upper bound, and what is measured is that end"
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
        "some parameters are read before anything is assigned to them, the first is {parameter}: taken as nothing, as the control would"
    )]
    Unassigned { parameter: String },
    #[error("{} from here on, after the end of the program ({code}): not run", counted(*.blocks, "block"))]
    AfterEnd { blocks: usize, code: Code },
}

/// A letter with its number, as people write it: G91.1, M30.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Code {
    /// `G` or `M`.
    pub(super) letter: char,
    /// Its number.
    pub(super) value: f64,
}

impl std::fmt::Display for Code {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}{}", self.letter, self.value)
    }
}

fn inverse_time_text(assumed: Option<f64>) -> String {
    let instead = assumed.map_or("that of the block before is taken".to_string(), |assumed| {
        format!("this one is taken at {assumed:.0} mm/min")
    });
    format!("every feed move under G93 needs its own F: {instead}")
}

fn rotary_feed_text(is_combined: bool) -> &'static str {
    if is_combined {
        "F holds along linear and rotary axes together, a degree counting as a unit of length"
    } else {
        "F holds along X, Y and Z, and rotary axes turn along (RS274/NGC); controls that count degrees as lengths are slower"
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

impl Remark for Untraced {
    fn severity(&self) -> Severity {
        match self {
            Untraced::Contour(trouble) => trouble.severity(),
            Untraced::NoValue(_)
            | Untraced::UnknownG { .. }
            | Untraced::UnknownM { .. }
            | Untraced::Left { .. }
            | Untraced::Transformation { .. }
            | Untraced::Conflict { .. }
            | Untraced::RepeatedWord { .. }
            | Untraced::OutOfReach { .. }
            | Untraced::UnusedAxisWords { .. }
            | Untraced::BadFeed { .. }
            | Untraced::NoFeed { .. }
            | Untraced::NoInverseTime { .. }
            | Untraced::NoSpindleSpeed { .. }
            | Untraced::BadAngle { .. }
            | Untraced::NoOffsetNumber { .. }
            | Untraced::NoAngle
            | Untraced::BadScale
            | Untraced::TiltedUnevenScale
            | Untraced::NoSpline { .. }
            | Untraced::NoControlPoint
            | Untraced::NurbsNotBegun { .. }
            | Untraced::NurbsNotEnded
            | Untraced::ForgottenFeed { .. }
            | Untraced::NoCenter
            | Untraced::NoCircle(_)
            | Untraced::BadTurns { .. }
            | Untraced::BadRepeats { .. }
            | Untraced::TooManyRepeats { .. }
            | Untraced::NoHole { .. }
            | Untraced::NoDwellTime
            | Untraced::BadDwell { .. }
            | Untraced::BadSpeed { .. }
            | Untraced::NoLabel { .. }
            | Untraced::NoSubprogram
            | Untraced::ExternalProgram
            | Untraced::ModalMacro
            | Untraced::DeepCall
            | Untraced::EndlessRun { .. }
            | Untraced::EndlessLoop
            | Untraced::MissingArgument { .. }
            | Untraced::Alarm
            | Untraced::MillingCycle { .. }
            | Untraced::NoSiemensHole { .. }
            | Untraced::NoArcThrough
            | Untraced::NotRun { .. } => Severity::Error,
            Untraced::UnmodelledWord { .. }
            | Untraced::MissingPoint { .. }
            | Untraced::NoPoints
            | Untraced::GuessedTimeUnit
            | Untraced::UnusedCenter
            | Untraced::SurfaceSpeed
            | Untraced::FasterThanRapid { .. }
            | Untraced::TipControl { .. }
            | Untraced::UnevenScale
            | Untraced::UnequalRadii { .. }
            | Untraced::RadiusAndCenter
            | Untraced::NoSpeed { .. }
            | Untraced::DeeperPecks { .. }
            | Untraced::TurnsByL { .. }
            | Untraced::ArcWordNotRun { .. }
            | Untraced::CycleWord { .. }
            | Untraced::NoCycleDwell { .. }
            | Untraced::ManualRetract { .. }
            | Untraced::Statement { .. }
            | Untraced::Curve { .. }
            | Untraced::NoTapFeed
            | Untraced::Probing { .. }
            | Untraced::NoThreadFeed { .. }
            | Untraced::Unassigned { .. } => Severity::Warning,
            Untraced::PathMode(remark) => remark.severity(),
            Untraced::Klartext(remark) => remark.severity(),
            Untraced::NoMotionWord
            | Untraced::AbsoluteCenters
            | Untraced::Setting { .. }
            | Untraced::DwellInSeconds
            | Untraced::TimeInMilliseconds
            | Untraced::UnknownHome { .. }
            | Untraced::WorkOffsets { .. }
            | Untraced::DataSetting { .. }
            | Untraced::NoToolLength { .. }
            | Untraced::RotaryFeed { .. }
            | Untraced::SameTool { .. }
            | Untraced::ManyOperations { .. }
            | Untraced::BeginsAgain
            | Untraced::AfterEnd { .. } => Severity::Info,
        }
    }

    fn is_said_once(&self) -> bool {
        if let Untraced::PathMode(remark) = self {
            return remark.is_said_once();
        }
        if let Untraced::Klartext(remark) = self {
            return remark.is_said_once();
        }
        matches!(
            self,
            Untraced::Transformation { .. }
                | Untraced::Statement { .. }
                | Untraced::Curve { .. }
                | Untraced::UnmodelledWord { .. }
                | Untraced::NoMotionWord
                | Untraced::AbsoluteCenters
                | Untraced::Probing { .. }
                | Untraced::NoFeed { .. }
                | Untraced::NoSpline { no_spline: NoSpline::GivenKnots, .. }
                | Untraced::NoSpindleSpeed { .. }
                | Untraced::RotaryFeed { .. }
                | Untraced::TipControl { .. }
                | Untraced::UnevenScale
                | Untraced::NoToolLength { .. }
                | Untraced::SurfaceSpeed
                | Untraced::FasterThanRapid { .. }
                | Untraced::DwellInSeconds
                | Untraced::GuessedTimeUnit
                | Untraced::TimeInMilliseconds
                | Untraced::ManualRetract { .. }
                | Untraced::UnknownHome { .. }
                | Untraced::DataSetting { .. }
        )
    }

    fn doubt(&self) -> Option<(Cause, Effect)> {
        doubt_of(self)
    }
}

#[cfg(test)]
mod tests;
