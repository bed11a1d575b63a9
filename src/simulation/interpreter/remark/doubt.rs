//! Doubts about the time that each remark leaves.

use crate::simulation::gcode::{DoubtCause, DoubtEffect, Letters};
use crate::simulation::interpreter::code::Code;
use crate::simulation::interpreter::klartext::KlartextRemark;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::toolpath::compensation::CompensationRemark;

/// Returns the doubt that a remark leaves, or `None` if it leaves none.
// Long because it is a table: each remark is in it once, and the compiler reports those that are missing.
pub(super) fn doubt_of(remark: &TraceRemark) -> Option<(DoubtCause, DoubtEffect)> {
    Some(match remark {
        TraceRemark::UnknownG { code } => (DoubtCause::UnknownWords, effect_of_unknown(*code)),
        TraceRemark::UnknownM { .. } => (DoubtCause::UnknownWords, DoubtEffect::Unbounded),
        TraceRemark::Conflict { .. } => (DoubtCause::UnknownWords, DoubtEffect::Block),
        TraceRemark::RepeatedWord { letter } | TraceRemark::OutOfReach { letter } => {
            (DoubtCause::UnreadWords, DoubtEffect::Words(Letters::of(&[*letter as u8])))
        }
        TraceRemark::NoPoints => (DoubtCause::MissingPoints, DoubtEffect::Unbounded),
        TraceRemark::UnusedAxisWords { .. } | TraceRemark::BadAngle { .. } => {
            (DoubtCause::BlocksNotRun, DoubtEffect::Words(Letters::AXES))
        }
        TraceRemark::UnusedCenter | TraceRemark::RadiusAndCenter => (DoubtCause::OpenArcs, DoubtEffect::Arc),
        TraceRemark::UnequalRadii { .. } => (DoubtCause::OpenArcs, DoubtEffect::Arc),
        TraceRemark::NoCenter
        | TraceRemark::NoCircle(_)
        | TraceRemark::NoArcThrough
        | TraceRemark::TiltedUnevenScale => (DoubtCause::MissingArcs, DoubtEffect::Arc),
        // One turn is run of those in the program, and all of those that L may not mean.
        TraceRemark::BadTurns { value: turns, .. } => {
            (DoubtCause::UnclearTurns, DoubtEffect::Turns(turns.abs()))
        }
        TraceRemark::TurnsByL { turns } => {
            (DoubtCause::UnclearTurns, DoubtEffect::Turns(f64::from(*turns) - 1.0))
        }
        TraceRemark::ArcWordNotRun { letter: 'L', value } => {
            (DoubtCause::UnclearTurns, DoubtEffect::Turns(value.abs()))
        }
        TraceRemark::ArcWordNotRun { value: pitch, .. } => {
            (DoubtCause::UnclearTurns, DoubtEffect::Pitch(pitch.abs()))
        }
        TraceRemark::BadFeed { .. }
        | TraceRemark::NoFeed { .. }
        | TraceRemark::ForgottenFeed { .. }
        | TraceRemark::NoInverseTime { .. }
        | TraceRemark::NoSpindleSpeed { .. } => (DoubtCause::MissingFeeds, DoubtEffect::Feed),
        TraceRemark::FasterThanRapid { .. } => (DoubtCause::FeedsBeyondRapid, DoubtEffect::Feed),
        TraceRemark::NoThreadFeed { .. } | TraceRemark::NoTapFeed => {
            (DoubtCause::UnmodelledThreads, DoubtEffect::Block)
        }
        TraceRemark::GuessedTimeUnit
        | TraceRemark::NoDwellTime
        | TraceRemark::NoCycleDwell { .. }
        | TraceRemark::BadDwell { .. } => (DoubtCause::UnclearDwells, DoubtEffect::Unbounded),
        TraceRemark::UnknownHome { .. } => (DoubtCause::UnknownHome, DoubtEffect::Travel),
        TraceRemark::WorkOffsets { .. } => (DoubtCause::UnknownOffsets, DoubtEffect::Travel),
        TraceRemark::NoHole { .. } | TraceRemark::NoSiemensHole { .. } | TraceRemark::BadRepeats { .. } => {
            (DoubtCause::UnmadeHoles, DoubtEffect::Hole)
        }
        TraceRemark::DeeperPecks { per_made, .. } => (DoubtCause::UnmadeHoles, DoubtEffect::Pecks(*per_made)),
        TraceRemark::CycleWord { .. } => (DoubtCause::UnmadeHoles, DoubtEffect::Unbounded),
        TraceRemark::MillingCycle { .. } => (DoubtCause::UnmodelledCycles, DoubtEffect::Unbounded),
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
        | TraceRemark::NotRun { .. } => (DoubtCause::UnmodelledFunctions, DoubtEffect::Unbounded),
        TraceRemark::Curve { .. }
        | TraceRemark::NoSpline { .. }
        | TraceRemark::NoControlPoint
        | TraceRemark::NurbsNotBegun { .. }
        | TraceRemark::NurbsNotEnded => (DoubtCause::UnmodelledCurves, DoubtEffect::Unbounded),
        TraceRemark::PerhapsLathe { .. } => (DoubtCause::PerhapsLathe, DoubtEffect::Unbounded),
        TraceRemark::Probing { .. } => (DoubtCause::Probing, DoubtEffect::Block),
        TraceRemark::NoLabel { .. }
        | TraceRemark::NoSubprogram
        | TraceRemark::ExternalProgram
        | TraceRemark::ModalMacro => (DoubtCause::MissingSubprograms, DoubtEffect::Unbounded),
        TraceRemark::DeepCall
        | TraceRemark::EndlessRun { .. }
        | TraceRemark::UnevenRepeats { .. }
        | TraceRemark::TooManyRepeats { .. }
        | TraceRemark::EndlessLoop
        | TraceRemark::MissingArgument { .. }
        | TraceRemark::Alarm => (DoubtCause::BrokenFlow, DoubtEffect::Unbounded),
        TraceRemark::Unassigned { .. } => (DoubtCause::UnknownParameters, DoubtEffect::Unbounded),
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
fn effect_of_unknown(code: Code) -> DoubtEffect {
    let is_fraction = code.value.fract() != 0.0;
    let is_merged = 1000.0 <= code.value || (is_fraction && 100.0 <= code.value) || code.value < 0.0;
    if is_merged { DoubtEffect::Words(Letters::AXES.with(Letters::MOTION)) } else { DoubtEffect::Unbounded }
}

/// Returns the doubt that a remark on compensation leaves.
fn doubt_of_contour(remark: &CompensationRemark) -> Option<(DoubtCause, DoubtEffect)> {
    match remark {
        CompensationRemark::CommentDiameter { .. } => None,
        CompensationRemark::UnknownDiameter { .. }
        | CompensationRemark::NoTool
        | CompensationRemark::BadNumber { .. } => Some((DoubtCause::Compensation, DoubtEffect::Unbounded)),
        _ => Some((DoubtCause::Compensation, DoubtEffect::Block)),
    }
}

/// Returns the doubt that a remark on Klartext leaves.
fn doubt_of_klartext(remark: &KlartextRemark) -> (DoubtCause, DoubtEffect) {
    match remark {
        KlartextRemark::Statement { .. } | KlartextRemark::CycleSetting { .. } => {
            (DoubtCause::UnmodelledFunctions, DoubtEffect::Unbounded)
        }
        KlartextRemark::Cycle { .. } => (DoubtCause::UnmodelledCycles, DoubtEffect::Unbounded),
        KlartextRemark::NoHole { .. } | KlartextRemark::NoCycle => {
            (DoubtCause::UnmadeHoles, DoubtEffect::Hole)
        }
        KlartextRemark::NoPole | KlartextRemark::Missing { .. } | KlartextRemark::TightApproach { .. } => {
            (DoubtCause::MissingArcs, DoubtEffect::Arc)
        }
    }
}
