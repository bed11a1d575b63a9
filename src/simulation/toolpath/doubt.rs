//! From which segment to which a doubt reaches: a missing axis word up to where the axis is given again, a missing feed up
//! to the next F, a missing motion word up to the next one.

use crate::simulation::gcode::{Cause, Doubt, Effect, Letters, LineNumber, Word};
use crate::simulation::toolpath::block::Block;
use crate::simulation::toolpath::compensation::Trouble;
use crate::simulation::toolpath::klartext::KlartextRemark;
use crate::simulation::toolpath::remark::{Code, Untraced};
use crate::simulation::toolpath::trace::Tracer;

/// Axes and centres.
const POSITIONS: Letters = Letters::AXES.with(Letters::of(b"UVW")).with(CENTRES);
const CENTRES: Letters = Letters::of(b"IJKR");
const FEED: Letters = Letters::of(b"F");
const MOTION: Letters = Letters::of(b"G");

/// Doubts that reach on.
#[derive(Default)]
pub(super) struct OpenDoubts {
    /// How many doubts are looked at.
    seen: usize,
    /// Each by its index, and the letters that end it.
    open: Vec<(usize, Letters)>,
}

impl OpenDoubts {
    /// No doubt reaches on.
    pub(super) fn is_empty(&self) -> bool {
        self.open.is_empty()
    }
}

/// The letters of words; a G word counts where it is a motion word or calls a cycle, which is one too.
pub(super) fn letters(words: &[Word]) -> Letters {
    words.iter().fold(Letters::default(), |letters, word| {
        letters.with(match word.letter {
            b'G' if (73.0..90.0).contains(&word.value) => MOTION.with(Letters::CYCLE),
            b'G' if !(0.0..4.0).contains(&word.value) => Letters::default(),
            letter => Letters::of(&[letter]),
        })
    })
}

impl Tracer<'_> {
    /// Takes over what reading left in doubt before the block that is run next.
    pub(super) fn doubt_as_read(&mut self, doubts: &[Doubt]) {
        if doubts.is_empty() {
            return;
        }
        self.remarks.look_behind(self.toolpath.segments.len());
        for doubt in doubts {
            self.remarks.doubt(doubt.line, doubt.cause, doubt.effect);
        }
    }

    /// A block that is not run, by its words.
    pub(super) fn doubt_block(&mut self, line: LineNumber, words: &[Word]) {
        self.remarks.look_behind(self.toolpath.segments.len());
        self.remarks.doubt(line, Cause::BlocksNotRun, Effect::Words(letters(words)));
    }

    /// Ends the doubts that `block`, which has just been run, resolves, and begins new ones.
    #[inline]
    pub(super) fn follow_doubts(&mut self, block: Block) {
        if !self.doubts.is_empty() || self.doubts.seen < self.remarks.doubts.len() {
            self.end_and_begin_doubts(block);
        }
    }

    fn end_and_begin_doubts(&mut self, block: Block) {
        let given = letters(block.words);
        let (before, count) = (self.remarks.behind(), self.toolpath.segments.len());
        let doubts = &mut self.remarks.doubts;
        self.doubts.open.retain_mut(|(index, letters)| {
            *letters = letters.without(given);
            // An axis moves from a doubtful position here; F and motion words hold from here on.
            let is_position = matches!(doubts[*index].effect, Effect::Words(_));
            doubts[*index].until = if is_position || !letters.is_empty() { count } else { before };
            !letters.is_empty()
        });
        let fresh = doubts.split_off(self.doubts.seen);
        for mut doubt in fresh {
            // What follows from the flow between blocks touches no move of the next block.
            if doubt.effect != Effect::Unbounded {
                doubt.until = count;
            }
            let is_feed_open = self.doubts.open.iter().any(|(_, letters)| letters.meets(FEED));
            let Effect::Words(missing) = doubt.effect else {
                if doubt.effect != Effect::Feed {
                    doubts.push(doubt);
                } else if !is_feed_open {
                    doubts.push(doubt);
                    self.doubts.open.push((doubts.len() - 1, FEED));
                }
                continue;
            };
            let is_motion_open = self.doubts.open.iter().any(|(_, letters)| letters.meets(MOTION));
            let is_hole = self.cycle.is_active() || self.siemens.modal.is_some();
            let is_motion_modal = !self.dialect.names_each_motion();
            let parts = [
                (POSITIONS, Effect::Words(missing.without(FEED.with(MOTION).with(Letters::CYCLE))), true),
                (FEED, Effect::Feed, !is_feed_open && !given.meets(FEED)),
                (MOTION, Effect::MotionWord, is_motion_modal && !is_motion_open && !given.meets(MOTION)),
                (Letters::CYCLE, Effect::CycleWord, !is_motion_open),
                (POSITIONS.with(FEED), Effect::Hole, is_hole),
            ];
            for (letters, effect, is_open) in parts {
                if !missing.meets(letters) || !is_open {
                    continue;
                }
                doubts.push(Doubt { effect, ..doubt });
                let ends = match effect {
                    Effect::Words(missing) if self.modal.is_incremental => missing.without(POSITIONS),
                    Effect::Words(missing) => missing.without(CENTRES).without(given),
                    Effect::Hole => Letters::default(),
                    Effect::CycleWord => MOTION,
                    _ => letters,
                };
                if !ends.is_empty() {
                    self.doubts.open.push((doubts.len() - 1, ends));
                }
            }
        }
        self.doubts.seen = doubts.len();
    }
}

/// What a remark leaves in doubt.
pub(super) fn doubt_of(remark: &Untraced) -> Option<(Cause, Effect)> {
    Some(match remark {
        Untraced::UnknownG { code } => (Cause::UnknownWords, effect_of_unknown(*code)),
        Untraced::UnknownM { .. } => (Cause::UnknownWords, Effect::Unbounded),
        Untraced::Conflict { .. } => (Cause::UnknownWords, Effect::Block),
        Untraced::RepeatedWord { letter } | Untraced::OutOfReach { letter } => {
            (Cause::UnreadWords, Effect::Words(Letters::of(&[*letter as u8])))
        }
        Untraced::MissingPoint { letter, .. } => {
            (Cause::MissingPoints, Effect::Words(Letters::of(&[*letter as u8])))
        }
        Untraced::NoPoints => (Cause::MissingPoints, Effect::Unbounded),
        Untraced::UnusedAxisWords { .. } | Untraced::BadAngle { .. } => {
            (Cause::BlocksNotRun, Effect::Words(Letters::AXES))
        }
        Untraced::UnusedCenter | Untraced::RadiusAndCenter => (Cause::OpenArcs, Effect::Arc),
        Untraced::UnequalRadii { .. } => (Cause::OpenArcs, Effect::Arc),
        Untraced::NoCenter | Untraced::NoCircle(_) | Untraced::NoArcThrough | Untraced::TiltedUnevenScale => {
            (Cause::MissingArcs, Effect::Arc)
        }
        Untraced::BadTurns { .. } | Untraced::TurnsByL { .. } => (Cause::OpenArcs, Effect::Unbounded),
        Untraced::ArcWordNotRun { .. } => (Cause::OpenArcs, Effect::Arc),
        Untraced::BadFeed { .. }
        | Untraced::NoFeed { .. }
        | Untraced::ForgottenFeed { .. }
        | Untraced::NoInverseTime { .. }
        | Untraced::NoSpindleSpeed { .. } => (Cause::MissingFeeds, Effect::Feed),
        Untraced::FasterThanRapid { .. } => (Cause::FeedsBeyondRapid, Effect::Feed),
        Untraced::NoThreadFeed { .. } | Untraced::NoTapFeed => (Cause::UnmodelledThreads, Effect::Block),
        Untraced::GuessedTimeUnit
        | Untraced::NoDwellTime
        | Untraced::NoCycleDwell { .. }
        | Untraced::BadDwell { .. } => (Cause::UnclearDwells, Effect::Unbounded),
        Untraced::UnknownHome { .. } => (Cause::UnknownHome, Effect::Travel),
        Untraced::WorkOffsets { .. } => (Cause::UnknownOffsets, Effect::Travel),
        Untraced::NoHole { .. } | Untraced::NoSiemensHole { .. } | Untraced::BadRepeats { .. } => {
            (Cause::UnmadeHoles, Effect::Hole)
        }
        Untraced::DeeperPecks { .. } | Untraced::CycleWord { .. } | Untraced::TooManyRepeats { .. } => {
            (Cause::UnmadeHoles, Effect::Unbounded)
        }
        Untraced::MillingCycle { .. } => (Cause::UnmodelledCycles, Effect::Unbounded),
        Untraced::Left { .. }
        | Untraced::Transformation { .. }
        | Untraced::UnmodelledWord { .. }
        | Untraced::SurfaceSpeed
        | Untraced::TipControl { .. }
        | Untraced::NoOffsetNumber { .. }
        | Untraced::NoAngle
        | Untraced::BadScale
        | Untraced::ManualRetract { .. }
        | Untraced::BadSpeed { .. }
        | Untraced::Statement { .. }
        | Untraced::NotRun { .. } => (Cause::UnmodelledFunctions, Effect::Unbounded),
        Untraced::Curve { .. }
        | Untraced::NoSpline { .. }
        | Untraced::NoControlPoint
        | Untraced::NurbsNotBegun { .. }
        | Untraced::NurbsNotEnded => (Cause::UnmodelledCurves, Effect::Unbounded),
        Untraced::Probing { .. } => (Cause::Probing, Effect::Block),
        Untraced::NoLabel { .. }
        | Untraced::NoSubprogram
        | Untraced::ExternalProgram
        | Untraced::ModalMacro => (Cause::MissingSubprograms, Effect::Unbounded),
        Untraced::DeepCall
        | Untraced::EndlessRun { .. }
        | Untraced::EndlessLoop
        | Untraced::MissingArgument { .. }
        | Untraced::Alarm => (Cause::BrokenFlow, Effect::Unbounded),
        Untraced::Unassigned { .. } => (Cause::UnknownParameters, Effect::Unbounded),
        Untraced::Contour(trouble) => return doubt_of_contour(trouble),
        Untraced::Klartext(remark) => return Some(doubt_of_klartext(remark)),
        // Without a value a block is not run, and its words are known there; the tolerance is the request's and the machine's.
        Untraced::NoValue(_) | Untraced::PathMode(_) => return None,
        Untraced::NoMotionWord
        | Untraced::AbsoluteCenters
        | Untraced::Setting { .. }
        | Untraced::RotaryFeed { .. }
        | Untraced::DwellInSeconds
        | Untraced::TimeInMilliseconds
        | Untraced::DataSetting { .. }
        | Untraced::NoToolLength { .. }
        | Untraced::UnevenScale
        | Untraced::NoSpeed { .. }
        | Untraced::SameTool { .. }
        | Untraced::ManyOperations { .. }
        | Untraced::BeginsAgain
        | Untraced::AfterEnd { .. } => return None,
    })
}

/// A G word beyond all that controls have is two words in one, of which the second lost its address: `G1 10.5`.
fn effect_of_unknown(code: Code) -> Effect {
    let is_fraction = code.value.fract() != 0.0;
    let is_merged = 1000.0 <= code.value || (is_fraction && 100.0 <= code.value) || code.value < 0.0;
    if is_merged { Effect::Words(Letters::AXES.with(MOTION)) } else { Effect::Unbounded }
}

fn doubt_of_contour(trouble: &Trouble) -> Option<(Cause, Effect)> {
    match trouble {
        Trouble::ToldDiameter { .. } => None,
        Trouble::UnknownDiameter { .. } | Trouble::NoTool | Trouble::BadNumber { .. } => {
            Some((Cause::Compensation, Effect::Unbounded))
        }
        _ => Some((Cause::Compensation, Effect::Block)),
    }
}

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
