//! G words with another meaning on SINUMERIK controls than in ISO, or without one there.

use crate::simulation::gcode::Place;
use crate::simulation::gcode::address;
use crate::simulation::interpreter::block::Block;
use crate::simulation::interpreter::code::Code;
use crate::simulation::interpreter::frame::ADDITIONAL;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::siemens::SiemensAction;
use crate::simulation::interpreter::state::{Interpreter, Request};
use crate::simulation::interpreter::words::{Meaning, NO_GROUP, Special};
use crate::simulation::toolpath::Blending;
use crate::simulation::toolpath::compensation::OuterCorner;
use crate::units::MM_PER_INCH;

/// A G word of SINUMERIK controls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SiemensWord {
    /// G70 and G71, and for feeds too G700 and G710.
    Unit,
    /// G60, and G641 to G645.
    Path,
    /// G110 to G112.
    Pole,
    /// G500, or G505 and on, which follow G57.
    Offset,
    /// G25, G26: limits, not moves.
    Limits,
    /// G58 and G59: shifts, not moves.
    AxialOffset,
    /// G147, G148, G247, G248, G347 and G348: soft approach and departure.
    SoftApproach,
    /// G33 to G35, G331 and G332: a move along a thread.
    Thread,
    /// G63: a tap in a floating chuck.
    FloatingTap,
    /// G450 and G451: outer corners by an arc, or by the point where the offset paths meet.
    OuterCorner,
}

/// Returns the modal group and meaning of a G word, given ten times its number, or `None` if the meaning of ISO
/// holds.
pub(crate) fn meaning(tenths: u16) -> Option<(usize, Meaning)> {
    use Meaning::*;
    Some(match tenths {
        700 | 710 | 7000 | 7100 => (6, Siemens(SiemensWord::Unit)),
        530 | 1530 => (NO_GROUP, Special(self::Special::MachineCoordinates)),
        740 | 750 => (NO_GROUP, Special(self::Special::Reference)),
        600 | 6410 | 6420 | 6430 | 6440 | 6450 => (13, Siemens(SiemensWord::Path)),
        1100 | 1110 | 1120 => (NO_GROUP, Siemens(SiemensWord::Pole)),
        5000 | 5050..=5990 => (12, Siemens(SiemensWord::Offset)),
        250 | 260 => (NO_GROUP, Siemens(SiemensWord::Limits)),
        580 | 590 => (NO_GROUP, Siemens(SiemensWord::AxialOffset)),
        1470 | 1480 | 2470 | 2480 | 3470 | 3480 => (NO_GROUP, Siemens(SiemensWord::SoftApproach)),
        4500 | 4510 => (NO_GROUP, Siemens(SiemensWord::OuterCorner)),
        330 | 340 | 350 | 3310 | 3320 => (1, Siemens(SiemensWord::Thread)),
        630 => (NO_GROUP, Siemens(SiemensWord::FloatingTap)),
        6010 | 6020 | 6030 | 3400 | 3410 | 4600 | 4610 | 4620 | 1400 | 1410 | 1420 | 1430 | 2900 | 9610
        | 9710 | 9620 | 9720 | 8100 | 8110 | 8200 | 8210 => (NO_GROUP, Neutral),
        2910 => (NO_GROUP, Transformation("ISO mode")),
        _ => return None,
    })
}

impl Interpreter<'_> {
    /// Reads a G word of SINUMERIK controls.
    pub(crate) fn siemens_g_word(
        &mut self,
        block: Block,
        place: Place,
        code: Code,
        word: SiemensWord,
        request: &mut Request,
    ) {
        match word {
            SiemensWord::Unit => {
                let code = code.value as u16;
                self.modal.unit = if matches!(code, 70 | 700) { MM_PER_INCH } else { 1.0 };
                self.siemens.leaves_feeds = matches!(code, 70 | 71);
            }
            SiemensWord::Path => {
                let distance = block.words.iter().rfind(|word| word.letter == address::SMOOTHING);
                let (source, blending) = match (code.value as u32, distance) {
                    (60, _) => (code.to_string(), Blending::ExactStop),
                    (641, Some(word)) => (
                        format!("{code} ADIS={}", word.value),
                        Blending::Distance(word.value * self.modal.unit),
                    ),
                    _ => (code.to_string(), Blending::Machine),
                };
                self.set_path_mode(place, source, blending);
            }
            SiemensWord::Pole => request.siemens = Some(Box::new(SiemensAction::Pole(code.value as u16))),
            SiemensWord::Offset => {
                let number = match code.value as u16 {
                    500 => NO_WORK_OFFSET,
                    further => ADDITIONAL + further - 504,
                };
                self.frame.select_work_offset(number);
            }
            SiemensWord::Limits => request.has_foreign_axis_words = true,
            SiemensWord::AxialOffset => {
                request.has_foreign_axis_words = true;
                let what = "shifts axis by axis are not applied: moves to and from the offset are too short or too long";
                self.remarks.add(place, TraceRemark::Statement { name: "G58, G59", what });
            }
            SiemensWord::SoftApproach => {
                let what = "the soft approach is not modelled: a straight move to its end";
                self.remarks.add(place, TraceRemark::Statement { name: "G147 to G348", what });
            }
            SiemensWord::OuterCorner => self.canonical.set_outer_corner_rule(match code.value as u16 {
                451 => OuterCorner::Intersection { reach: MAX_REACH_RADII },
                _ => OuterCorner::Arc,
            }),
            SiemensWord::Thread => {
                let turn = match code.value as u16 {
                    331 => Some(4),
                    332 => Some(3),
                    _ => None,
                };
                request.siemens = Some(Box::new(SiemensAction::Thread(turn)));
            }
            SiemensWord::FloatingTap => request.siemens = Some(Box::new(SiemensAction::FloatingTap)),
        }
    }
}

/// Largest distance from an outer corner at which offset paths meet, as a multiple of the tool radius: an arc
/// replaces a more acute corner.
const MAX_REACH_RADII: f64 = 2.0;

/// The number of the zero work offset, which no program can set.
const NO_WORK_OFFSET: u16 = 0;
