//! The words of compensation and corner treatments: G40 to G42.1 and D, and the entry points for words of other
//! dialects.

use crate::simulation::gcode::{Comment, Dialect, Place, address};
use crate::simulation::interpreter::block::{Block, bits};
use crate::simulation::interpreter::bounds::{FEEDRATES_MM_S, MAX_TOOL_NUMBER};
use crate::simulation::interpreter::compensation::KnownDiameters;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::Interpreter;
use crate::simulation::toolpath::compensation::Setting;
use crate::simulation::toolpath::compensation::{
    CompensationRemark, CornerShape, CornerTreatment, MAX_SIZE_MM,
};
use std::collections::BTreeSet;

/// The side of the contour that the tool is on, seen along the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// G41, RL.
    Left,
    /// G42, RR.
    Right,
}

/// The source of the diameter of the tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Diameter {
    /// The tool in the spindle; before the first tool change, the tool of the last T.
    Spindle,
    /// The tool with this number.
    Tool(u32),
    /// This value, mm; negative for the other side.
    Given(f64),
}

/// A word of group 7.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum CompensationWord {
    /// G40.
    Off,
    /// G41 and G42.
    ByTool(Side),
    /// G41.1 and G42.1.
    ByDiameter(Side),
}

/// State of compensation from block to block.
#[derive(Default)]
pub(crate) struct CompensationWords {
    /// The word of the block being run.
    pub(crate) word: Option<CompensationWord>,
    /// D of the last G41 or G42 in a program with a `%` line or an O number, where it is modal.
    number: Option<u32>,
    /// The tools whose diameter is missing, each with a remark.
    missing: BTreeSet<Option<u32>>,
    /// The diameters in the program.
    pub(crate) known: KnownDiameters,
    /// The tools whose diameter came from a comment, each with a remark.
    pub(super) remarked: BTreeSet<u32>,
}

impl Interpreter<'_> {
    /// Runs the compensation word of the block, once all its words are known.
    pub(crate) fn compensation_word(&mut self, block: Block) {
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
                let is_number = (0.0..=MAX_TOOL_NUMBER).contains(&value) && value.fract() == 0.0;
                if is_number {
                    self.compensation.number = (self.is_tape && 0.0 < value).then_some(value as u32);
                    let diameter =
                        if value == 0.0 { Diameter::Given(0.0) } else { Diameter::Tool(value as u32) };
                    self.compensate(block, Some((side, diameter)));
                } else {
                    self.remarks
                        .add(block.place_of_letter(b'D'), CompensationRemark::BadNumber { value }.into());
                    self.compensate(block, None);
                }
            }
            (CompensationWord::ByDiameter(side), Some(value)) => {
                self.compensate(block, Some((side, Diameter::Given(value * self.modal.unit))));
            }
        }
    }

    /// Sets the compensation from the next move on, in the plane in force, or ends it. If the diameter is unknown,
    /// remarks on it and leaves the path as programmed.
    pub(crate) fn compensate(&mut self, block: Block, request: Option<(Side, Diameter)>) {
        let diameter = request.map(|(_, diameter)| self.diameter(block, diameter).unwrap_or(0.0));
        let setting = request.zip(diameter).and_then(|((side, _), diameter)| {
            let side = if (side == Side::Left) != self.is_mirrored() { 1.0 } else { -1.0 };
            let radius = 0.5 * diameter.abs();
            let is_possible = 0.0 < radius && radius <= MAX_SIZE_MM;
            is_possible.then(|| Setting {
                plane: self.canonical.plane,
                side: side * diameter.signum(),
                radius,
            })
        });
        self.canonical.set_compensation(setting);
        self.add_compensation_remarks();
    }

    /// Returns `true` if a mirror puts the left of the program on the right of the machine.
    pub(super) fn is_mirrored(&self) -> bool {
        self.frame.turned().is_some_and(|chain| chain.flips(self.canonical.plane))
    }

    /// Runs moves without compensation, and starts it again after them: G28, G30 and G53, which name points of the
    /// machine.
    pub(crate) fn uncompensated(&mut self, moves: impl FnOnce(&mut Self)) {
        let setting = self.canonical.compensation();
        self.canonical.set_compensation(None);
        moves(self);
        self.canonical.set_compensation(setting);
        self.add_compensation_remarks();
    }

    /// Returns the diameter of a tool, mm, or remarks on the setting for it and returns `None`.
    pub(super) fn diameter(&mut self, block: Block, diameter: Diameter) -> Option<f64> {
        let tool = match diameter {
            Diameter::Given(diameter) => return Some(diameter),
            Diameter::Tool(tool) => Some(tool),
            Diameter::Spindle => self.canonical.tool().or(self.modal.tool),
        };
        let known = self.known_diameter(block, tool);
        if known.is_none() && self.compensation.missing.insert(tool) {
            let remark =
                tool.map_or(CompensationRemark::NoTool, |tool| CompensationRemark::UnknownDiameter { tool });
            self.remarks.add(block.place(), remark.into());
        }
        known
    }

    /// Runs RND, CHF, CHR, RNDM, and `,R` and `,C`, after the move of their block.
    pub(crate) fn corner_words(&mut self, block: Block) {
        const WORDS: u64 =
            bits(&[address::ROUNDING, address::CHAMFER_LEG, address::CHAMFER, address::MODAL_ROUNDING]);
        if !self.given.has(WORDS) {
            return;
        }
        let unit = self.modal.unit;
        let size = |address: u8| self.given.get(address).map(|value| value * unit);
        let feedrate = self.given.get(address::CORNER_FEED).map(|feed| feed * self.unit_of_feeds() / 60.0);
        let feedrate = feedrate.filter(|feed| FEEDRATES_MM_S.contains(feed));
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

    /// Treats the corner between the last move and the next one.
    pub(crate) fn treat_next_corner(&mut self, block: Block, treatment: CornerTreatment) {
        if self.is_possible(block, &treatment) {
            self.canonical.treat_next_corner(treatment);
        }
    }

    /// Treats every corner between two feed moves from here on; `None` ends that.
    pub(crate) fn treat_every_corner(&mut self, block: Block, treatment: Option<CornerTreatment>) {
        let treatment = treatment.filter(|treatment| self.is_possible(block, treatment));
        self.canonical.treat_every_corner(treatment);
    }

    /// Returns `true` if a treatment has a possible size, else remarks on it.
    fn is_possible(&mut self, block: Block, treatment: &CornerTreatment) -> bool {
        let (name, size) = (treatment.name(), treatment.size());
        let is_possible = (0.0..=MAX_SIZE_MM).contains(&size);
        if !is_possible {
            self.remarks.add(block.place(), CompensationRemark::BadSize { name, size }.into());
        }
        is_possible
    }

    /// Ends the path, and cuts it into operations by the comments of the program.
    pub(crate) fn end_path(&mut self, comments: &[Comment]) {
        let beyond = self.canonical.finish(comments);
        self.add_compensation_remarks();
        if let Some(last) = self.canonical.toolpath().operations.last().filter(|_| 0 < beyond) {
            self.remarks.add(Place::line(last.line), TraceRemark::ManyOperations { beyond });
        }
    }

    /// Adds the remarks of compensation and corner treatments.
    pub(crate) fn add_compensation_remarks(&mut self) {
        for (line, remark) in self.canonical.take_remarks() {
            self.remarks.add(Place::line(line), TraceRemark::Contour(remark));
        }
    }
}
