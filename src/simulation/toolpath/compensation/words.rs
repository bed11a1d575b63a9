//! Where compensation and corner treatments meet the tracer: what G40 to G42.1 and D ask for, and
//! the calls for words of other dialects.

use crate::simulation::gcode::{Dialect, Place, address};
use crate::simulation::toolpath::block::{Block, bits};
use crate::simulation::toolpath::compensation::queue::Setting;
use crate::simulation::toolpath::compensation::{
    CornerShape, CornerTreatment, KnownDiameters, LARGEST, OuterCorner, Trouble,
};
use crate::simulation::toolpath::remark::Untraced;
use crate::simulation::toolpath::trace::Tracer;
use crate::simulation::toolpath::{Stop, StopCause};
use std::collections::BTreeSet;

/// The greatest number a tool can have.
const LAST_TOOL: f64 = 99_999_999.0;

/// Where the tool is, seen along the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::simulation::toolpath) enum Side {
    /// G41, RL.
    Left,
    /// G42, RR.
    Right,
}

/// How the diameter of the tool is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::simulation::toolpath) enum Diameter {
    /// That of the tool in the spindle; before the first tool change, of the one called by T.
    Spindle,
    /// That of this tool.
    Tool(u32),
    /// This, mm; negative: on the other side.
    Given(f64),
}

/// A word of group 7.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::simulation::toolpath) enum CompensationWord {
    /// G40.
    Off,
    /// G41 and G42.
    ByTool(Side),
    /// G41.1 and G42.1.
    ByDiameter(Side),
}

/// What compensation takes from the blocks.
#[derive(Default)]
pub(in crate::simulation::toolpath) struct CompensationWords {
    /// Of the block being run.
    pub(in crate::simulation::toolpath) word: Option<CompensationWord>,
    /// The tool in the spindle, where there was a tool change.
    pub(super) spindle: Option<u32>,
    /// D of the last G41 or G42 on a tape, where it stays in force.
    number: Option<u32>,
    /// The tools whose diameter was found missing.
    missing: BTreeSet<Option<u32>>,
    /// What the program tells of diameters.
    pub(in crate::simulation::toolpath) known: KnownDiameters,
    /// The tools whose diameter was taken from a comment.
    pub(super) remarked: BTreeSet<u32>,
}

impl Tracer<'_> {
    /// Runs the compensation word of the block, once all its words are known.
    pub(in crate::simulation::toolpath) fn compensation_word(&mut self, block: Block) {
        let Some(word) = self.compensation.word.take() else { return };
        let number = self.given.get(b'D');
        match (word, number) {
            (CompensationWord::Off, _) => self.compensate(block, None),
            (CompensationWord::ByTool(side) | CompensationWord::ByDiameter(side), None) => {
                let known = self.compensation.number.map_or(Diameter::Spindle, Diameter::Tool);
                self.compensate(block, Some((side, known)));
            }
            (CompensationWord::ByTool(side), Some(value)) => {
                // On SINUMERIK controls D chooses an edge of the tool in the spindle.
                if self.dialect == Dialect::Siemens && value != 0.0 {
                    self.compensate(block, Some((side, Diameter::Spindle)));
                    return;
                }
                let is_number = (0.0..=LAST_TOOL).contains(&value) && value.fract() == 0.0;
                if is_number {
                    self.compensation.number = (self.is_tape && 0.0 < value).then_some(value as u32);
                    let diameter =
                        if value == 0.0 { Diameter::Given(0.0) } else { Diameter::Tool(value as u32) };
                    self.compensate(block, Some((side, diameter)));
                } else {
                    self.remarks.add(block.place_of_letter(b'D'), Trouble::BadNumber { value }.into());
                    self.compensate(block, None);
                }
            }
            (CompensationWord::ByDiameter(side), Some(value)) => {
                self.compensate(block, Some((side, Diameter::Given(value * self.modal.unit))));
            }
        }
    }

    /// Turns compensation on from the next move on, in the plane in force, or off. Where the
    /// diameter is unknown it says so, and the path is taken as programmed.
    pub(in crate::simulation::toolpath) fn compensate(
        &mut self,
        block: Block,
        request: Option<(Side, Diameter)>,
    ) {
        let diameter = request.map(|(_, diameter)| self.diameter(block, diameter).unwrap_or(0.0));
        let setting = request.zip(diameter).and_then(|((side, _), diameter)| {
            let side = if (side == Side::Left) != self.is_mirrored() { 1.0 } else { -1.0 };
            let radius = 0.5 * diameter.abs();
            let is_possible = 0.0 < radius && radius <= LARGEST;
            is_possible.then(|| Setting { plane: self.modal.plane, side: side * diameter.signum(), radius })
        });
        self.contour.set(setting, &mut self.toolpath);
        self.tell_troubles();
    }

    /// Left of the program is right of the machine.
    pub(super) fn is_mirrored(&self) -> bool {
        self.frame.turned().is_some_and(|chain| chain.flips(self.modal.plane))
    }

    /// Moves without compensation, which is then entered anew: G28, G30 and G53, which name points
    /// of the machine.
    pub(in crate::simulation::toolpath) fn uncompensated(&mut self, moves: impl FnOnce(&mut Self)) {
        let setting = self.contour.queue.setting();
        self.contour.set(None, &mut self.toolpath);
        moves(self);
        self.contour.set(setting, &mut self.toolpath);
        self.tell_troubles();
    }

    /// Diameter of a tool, mm, or a remark on the key that would tell it.
    pub(super) fn diameter(&mut self, block: Block, diameter: Diameter) -> Option<f64> {
        let tool = match diameter {
            Diameter::Given(diameter) => return Some(diameter),
            Diameter::Tool(tool) => Some(tool),
            Diameter::Spindle => self.compensation.spindle.or(self.modal.tool),
        };
        let known = self.known_diameter(block, tool);
        if known.is_none() && self.compensation.missing.insert(tool) {
            let trouble = tool.map_or(Trouble::NoTool, |tool| Trouble::UnknownDiameter { tool });
            self.remarks.add(block.place(), trouble.into());
        }
        known
    }

    /// RND, CHF, CHR, RNDM, and `,R` and `,C`, once the move of their block was run.
    pub(in crate::simulation::toolpath) fn corner_words(&mut self, block: Block) {
        const WORDS: u64 =
            bits(&[address::ROUNDING, address::CHAMFER_LEG, address::CHAMFER, address::MODAL_ROUNDING]);
        if !self.given.has(WORDS) {
            return;
        }
        let unit = self.modal.unit;
        let size = |address: u8| self.given.get(address).map(|value| value * unit);
        let feedrate = self.given.get(address::CORNER_FEED).map(|feed| feed * self.unit_of_feeds() / 60.0);
        let feedrate = feedrate.filter(|feed| (1e-6..=1e6).contains(feed));
        let next = (size(address::ROUNDING).map(|radius| CornerShape::Rounding { radius }))
            .or(size(address::CHAMFER_LEG).map(|leg| CornerShape::Chamfer { leg }))
            .or(size(address::CHAMFER).map(|width| CornerShape::ChamferWidth { width }));
        let every = size(address::MODAL_ROUNDING);
        // RNDM rounds the corner at the end of its own block too.
        let next =
            next.or(every.filter(|radius| *radius != 0.0).map(|radius| CornerShape::Rounding { radius }));
        if let Some(shape) = next {
            self.treat_next_corner(block, CornerTreatment { shape, feedrate });
        }
        if let Some(radius) = every {
            let shape = CornerShape::Rounding { radius };
            self.treat_every_corner(block, (radius != 0.0).then_some(CornerTreatment { shape, feedrate }));
        }
    }

    /// Puts this in place of the corner between the last move given and the next one.
    pub(in crate::simulation::toolpath) fn treat_next_corner(
        &mut self,
        block: Block,
        treatment: CornerTreatment,
    ) {
        if self.is_possible(block, &treatment) {
            self.contour.treat_next_corner(treatment, self.modal.plane, &mut self.toolpath);
        }
    }

    /// Puts this in place of every corner between two feed moves from here on, or no longer.
    pub(in crate::simulation::toolpath) fn treat_every_corner(
        &mut self,
        block: Block,
        treatment: Option<CornerTreatment>,
    ) {
        let treatment = treatment.filter(|treatment| self.is_possible(block, treatment));
        self.contour.treat_every_corner(treatment);
    }

    fn is_possible(&mut self, block: Block, treatment: &CornerTreatment) -> bool {
        let (name, size) = (treatment.name(), treatment.size());
        let is_possible = (0.0..=LARGEST).contains(&size);
        if !is_possible {
            self.remarks.add(block.place(), Trouble::BadSize { name, size }.into());
        }
        is_possible
    }

    /// How the compensated tool goes around outer corners from the next one on.
    pub(in crate::simulation::toolpath) fn go_around_corners(&mut self, outer_corner: OuterCorner) {
        self.contour.queue.outer_corner = outer_corner;
    }

    /// A stop at this point of the program, between the moves it was given between.
    pub(in crate::simulation::toolpath) fn stop_in_contour(&mut self, stop: Stop) {
        match stop.cause {
            StopCause::ToolChange { tool } => self.compensation.spindle = tool,
            StopCause::SameTool { tool } => self.compensation.spindle = Some(tool),
            _ => {}
        }
        self.contour.stop(stop, &mut self.toolpath);
    }

    /// Puts out what is kept back at the end of the program.
    pub(in crate::simulation::toolpath) fn end_contour(&mut self) {
        self.contour.finish(&mut self.toolpath);
        self.settle_path_modes();
        self.tell_troubles();
    }

    pub(in crate::simulation::toolpath) fn tell_troubles(&mut self) {
        for (line, trouble) in self.contour.troubles() {
            self.remarks.add(Place::line(line), Untraced::Contour(trouble));
        }
    }
}
