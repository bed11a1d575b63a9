//! Doubts about the time that each remark leaves.

use crate::simulation::gcode::{Cause, Effect, Letters};
use crate::simulation::interpreter::code::Code;
use crate::simulation::interpreter::klartext::KlartextRemark;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::toolpath::compensation::CompensationRemark;

/// Returns the doubt that a remark leaves, or `None` if it leaves none.
// Long because it is a table: each remark is in it once, and the compiler reports those that are missing.
pub(super) fn doubt_of(remark: &TraceRemark) -> Option<(Cause, Effect)> {
    Some(match remark {
        TraceRemark::UnknownG { code } => (Cause::UnknownWords, effect_of_unknown(*code)),
        TraceRemark::UnknownM { .. } => (Cause::UnknownWords, Effect::Unbounded),
        TraceRemark::Conflict { .. } => (Cause::UnknownWords, Effect::Block),
        TraceRemark::RepeatedWord { letter } | TraceRemark::OutOfReach { letter } => {
            (Cause::UnreadWords, Effect::Words(Letters::of(&[*letter as u8])))
        }
        TraceRemark::NoPoints => (Cause::MissingPoints, Effect::Unbounded),
        TraceRemark::UnusedAxisWords { .. } | TraceRemark::BadAngle { .. } => {
            (Cause::BlocksNotRun, Effect::Words(Letters::AXES))
        }
        TraceRemark::UnusedCenter | TraceRemark::RadiusAndCenter => (Cause::OpenArcs, Effect::Arc),
        TraceRemark::UnequalRadii { .. } => (Cause::OpenArcs, Effect::Arc),
        TraceRemark::NoCenter
        | TraceRemark::NoCircle(_)
        | TraceRemark::NoArcThrough
        | TraceRemark::TiltedUnevenScale => (Cause::MissingArcs, Effect::Arc),
        // One turn is run of those in the program, and all of those that L may not mean.
        TraceRemark::BadTurns { value: turns, .. } => (Cause::UnclearTurns, Effect::Turns(turns.abs())),
        TraceRemark::TurnsByL { turns } => (Cause::UnclearTurns, Effect::Turns(f64::from(*turns) - 1.0)),
        TraceRemark::ArcWordNotRun { letter: 'L', value } => {
            (Cause::UnclearTurns, Effect::Turns(value.abs()))
        }
        TraceRemark::ArcWordNotRun { value: pitch, .. } => (Cause::UnclearTurns, Effect::Pitch(pitch.abs())),
        TraceRemark::BadFeed { .. }
        | TraceRemark::NoFeed { .. }
        | TraceRemark::ForgottenFeed { .. }
        | TraceRemark::NoInverseTime { .. }
        | TraceRemark::NoSpindleSpeed { .. } => (Cause::MissingFeeds, Effect::Feed),
        TraceRemark::FasterThanRapid { .. } => (Cause::FeedsBeyondRapid, Effect::Feed),
        TraceRemark::NoThreadFeed { .. } | TraceRemark::NoTapFeed => {
            (Cause::UnmodelledThreads, Effect::Block)
        }
        TraceRemark::GuessedTimeUnit
        | TraceRemark::NoDwellTime
        | TraceRemark::NoCycleDwell { .. }
        | TraceRemark::BadDwell { .. } => (Cause::UnclearDwells, Effect::Unbounded),
        TraceRemark::UnknownHome { .. } => (Cause::UnknownHome, Effect::Travel),
        TraceRemark::WorkOffsets { .. } => (Cause::UnknownOffsets, Effect::Travel),
        TraceRemark::NoHole { .. } | TraceRemark::NoSiemensHole { .. } | TraceRemark::BadRepeats { .. } => {
            (Cause::UnmadeHoles, Effect::Hole)
        }
        TraceRemark::DeeperPecks { per_made, .. } => (Cause::UnmadeHoles, Effect::Pecks(*per_made)),
        TraceRemark::CycleWord { .. } => (Cause::UnmadeHoles, Effect::Unbounded),
        TraceRemark::MillingCycle { .. } => (Cause::UnmodelledCycles, Effect::Unbounded),
        TraceRemark::Unsupported { .. }
        | TraceRemark::Transformation { .. }
        | TraceRemark::UnmodelledWord { .. }
        | TraceRemark::SurfaceSpeed
        | TraceRemark::TipControl { .. }
        | TraceRemark::NoOffsetNumber { .. }
        | TraceRemark::NoAngle
        | TraceRemark::BadScale
        | TraceRemark::ManualRetract { .. }
        | TraceRemark::BadSpeed { .. }
        | TraceRemark::Statement { .. }
        | TraceRemark::NotRun { .. } => (Cause::UnmodelledFunctions, Effect::Unbounded),
        TraceRemark::Curve { .. }
        | TraceRemark::NoSpline { .. }
        | TraceRemark::NoControlPoint
        | TraceRemark::NurbsNotBegun { .. }
        | TraceRemark::NurbsNotEnded => (Cause::UnmodelledCurves, Effect::Unbounded),
        TraceRemark::PerhapsLathe { .. } => (Cause::PerhapsLathe, Effect::Unbounded),
        TraceRemark::Probing { .. } => (Cause::Probing, Effect::Block),
        TraceRemark::NoLabel { .. }
        | TraceRemark::NoSubprogram
        | TraceRemark::ExternalProgram
        | TraceRemark::ModalMacro => (Cause::MissingSubprograms, Effect::Unbounded),
        TraceRemark::DeepCall
        | TraceRemark::EndlessRun { .. }
        | TraceRemark::UnevenRepeats { .. }
        | TraceRemark::TooManyRepeats { .. }
        | TraceRemark::EndlessLoop
        | TraceRemark::MissingArgument { .. }
        | TraceRemark::Alarm => (Cause::BrokenFlow, Effect::Unbounded),
        TraceRemark::Unassigned { .. } => (Cause::UnknownParameters, Effect::Unbounded),
        TraceRemark::Contour(remark) => return doubt_of_contour(remark),
        TraceRemark::Klartext(remark) => return Some(doubt_of_klartext(remark)),
        // Without a value a block is not run, and its words are known there; the tolerance is a choice of the
        // program and the machine.
        TraceRemark::NoValue(_) | TraceRemark::PathMode(_) => return None,
        // It is noticed at the end, and added there with the moves that it affects.
        TraceRemark::MissingPoint { .. } => return None,
        TraceRemark::NoMotionWord
        | TraceRemark::AbsoluteCenters
        | TraceRemark::Setting { .. }
        | TraceRemark::RotaryFeed { .. }
        | TraceRemark::DwellInSeconds
        | TraceRemark::TimeInMilliseconds
        | TraceRemark::DataSetting { .. }
        | TraceRemark::NoToolLength { .. }
        | TraceRemark::UnevenScale
        | TraceRemark::NoSpeed { .. }
        | TraceRemark::SameTool { .. }
        | TraceRemark::ManyOperations { .. }
        | TraceRemark::BeginsAgain
        | TraceRemark::AfterEnd { .. } => return None,
    })
}

/// Returns the effect of an unknown G word. A number beyond all G words is two words in one, of which the second
/// lost its address: `G1 10.5`.
fn effect_of_unknown(code: Code) -> Effect {
    let is_fraction = code.value.fract() != 0.0;
    let is_merged = 1000.0 <= code.value || (is_fraction && 100.0 <= code.value) || code.value < 0.0;
    if is_merged { Effect::Words(Letters::AXES.with(Letters::MOTION)) } else { Effect::Unbounded }
}

/// Returns the doubt that a remark on compensation leaves.
fn doubt_of_contour(remark: &CompensationRemark) -> Option<(Cause, Effect)> {
    match remark {
        CompensationRemark::CommentDiameter { .. } => None,
        CompensationRemark::UnknownDiameter { .. }
        | CompensationRemark::NoTool
        | CompensationRemark::BadNumber { .. } => Some((Cause::Compensation, Effect::Unbounded)),
        _ => Some((Cause::Compensation, Effect::Block)),
    }
}

/// Returns the doubt that a remark on Klartext leaves.
fn doubt_of_klartext(remark: &KlartextRemark) -> (Cause, Effect) {
    match remark {
        KlartextRemark::Statement { .. } | KlartextRemark::CycleSetting { .. } => {
            (Cause::UnmodelledFunctions, Effect::Unbounded)
        }
        KlartextRemark::Cycle { .. } => (Cause::UnmodelledCycles, Effect::Unbounded),
        KlartextRemark::NoHole { .. } | KlartextRemark::NoCycle => (Cause::UnmadeHoles, Effect::Hole),
        KlartextRemark::NoPole | KlartextRemark::Missing { .. } | KlartextRemark::TightApproach { .. } => {
            (Cause::MissingArcs, Effect::Arc)
        }
    }
}
