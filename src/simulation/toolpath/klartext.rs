//! What Heidenhain programs say: paths, poles, tools, cycles, transformations.
//!
//! Order of execution within a block: feedrate; M functions that act before the motion; the
//! statement; M functions that act after it (M0, M1, M2, M5, M9, M30); the cycle that M99 or M89
//! calls. The path module moves, the approach module leads to and from contours, the cycle module
//! makes holes, the frame module changes coordinates.
//!
//! - F holds until the next F; FMAX for its block alone. F AUTO is that of the tool call. In programs
//!   in inches F counts tenths of inches a minute. M136 makes F a feed per revolution.
//! - A tool call changes the tool and ends the turn of the spindle; M6 beside it changes nothing.
//! - M91 and M92 take the words of their block in machine coordinates.
//! - With R0 after RL or RR the tool leaves the contour square to its last element.
//!
//! Source: TNC 640, Klartext Programming, 2018. Limits: tilted planes, FK, splines, patterns by
//! PATTERN DEF, pockets and contour cycles are not modelled; each says so.

mod approach;
mod cycle;
mod frame;
mod hole;
mod path;
mod remark;
#[cfg(test)]
mod tests;

pub(super) use remark::KlartextRemark;

use crate::simulation::gcode::{Dialect, KLARTEXT_STATEMENTS, POSITION_PARAMETERS, Place, address};
use crate::simulation::toolpath::block::{AXIS_WORDS, Block, POLAR_WORDS, bits};
use crate::simulation::toolpath::compensation::{Beside, Diameter, Side};
use crate::simulation::toolpath::feed_mode::FeedMode;
use crate::simulation::toolpath::klartext::approach::Approach;
use crate::simulation::toolpath::klartext::cycle::Cycle;
use crate::simulation::toolpath::klartext::remark::UNMODELLED;
use crate::simulation::toolpath::plane::Plane;
use crate::simulation::toolpath::remark::{Code, Untraced};
use crate::simulation::toolpath::trace::{Family, Tracer};
use crate::simulation::toolpath::turning::Sign;
use crate::simulation::toolpath::words::Mode;
use crate::simulation::toolpath::{Curve, Point, StopCause, Vector};
use crate::units::MM_PER_INCH;
use std::collections::BTreeMap;

/// What stays in force in Heidenhain programs alone.
#[derive(Default)]
pub(super) struct Klartext {
    /// Program coordinates, mm.
    pole: Option<Point>,
    /// Angle, rad, and radius, mm, of the last polar word about this pole.
    polar: Option<(f64, f64)>,
    /// Sense of the last arc.
    sense: f64,
    /// The way the last move went at its end, in machine coordinates.
    direction: Option<Vector>,
    /// RL or RR.
    side: Option<Side>,
    /// How the tool is beside the contour.
    beside: Option<Beside>,
    /// An approach whose contour is not known yet.
    approach: Option<Approach>,
    /// Radii that TOOL DEF gives, mm, by tool.
    radii: BTreeMap<u32, f64>,
    /// DR of the tool call, mm.
    radius_difference: f64,
    /// F of the tool call, mm/s.
    auto_feed: Option<f64>,
    /// M136.
    has_feed_per_revolution: bool,
    cycle: Cycle,
    /// The shift of cycle 7, mm.
    datum: Vector,
    /// The angle of cycle 10, rad.
    angle: f64,
}

/// M functions that change neither path nor time here, or that the block is looked through for.
const SILENT: &[u32] = &[
    6, 89, 90, 91, 92, 94, 97, 98, 99, 101, 102, 103, 107, 108, 109, 110, 111, 112, 113, 114, 115, 116, 117,
    118, 120, 124, 126, 127, 128, 129, 130, 134, 135, 136, 137, 138, 140, 141, 142, 143, 144, 145, 148, 149,
    150, 197,
];

/// What is done otherwise in Heidenhain programs. Handed over as functions, so that a module that runs none of them does
/// not carry what they need.
pub(super) struct Heidenhain {
    /// Runs one block.
    pub(super) block: fn(&mut Tracer, Block),
    /// Takes notice of a move before it is made.
    pub(super) before_move: fn(&mut Tracer, Point, &Curve, f64),
    /// Does what is left at the end of the program.
    pub(super) end: fn(&mut Tracer),
}

impl Heidenhain {
    /// What holds for a dialect; none for those of other controls.
    pub(super) fn of(dialect: Dialect) -> Option<Heidenhain> {
        matches!(dialect, Dialect::Klartext | Dialect::HeidenhainIso).then_some(Heidenhain {
            block: |tracer, block| tracer.klartext_block(block),
            before_move: |tracer, end, curve, length| tracer.klartext_before_move(end, curve, length),
            end: |tracer| {
                tracer.run_pattern();
                tracer.settle_approach();
            },
        })
    }
}

impl Tracer<'_> {
    pub(super) fn is_heidenhain(&self) -> bool {
        self.heidenhain.is_some()
    }

    pub(super) fn remark(&mut self, place: Place, remark: KlartextRemark) {
        self.remarks.add(place, Untraced::Klartext(remark));
    }

    fn klartext_block(&mut self, block: Block) {
        self.given.clear();
        let mut name = "";
        for word in block.words {
            match word.letter {
                b'M' => {}
                address::STATEMENT => {
                    name = KLARTEXT_STATEMENTS.get(word.value as usize).copied().unwrap_or_default();
                }
                letter if address::ARGUMENT <= letter => self.klartext.cycle.take_word(word),
                letter => {
                    self.given.set(letter, word.value);
                    self.given.refer(letter, word.reference);
                }
            }
        }
        if name.is_empty() {
            return;
        }
        self.run_pattern();
        self.modal.has_incremental_center = false;
        self.exact_stop = self.path_mode.has_exact_stop();
        let lead = self.lead_motion(block, name);
        self.klartext_feed(block, name);
        let (called, is_modal) = self.klartext_m_words(block, true);
        self.klartext_statement(block, name, lead);
        self.klartext_m_words(block, false);
        self.call_after_move(block, called, is_modal);
    }

    fn klartext_statement(&mut self, block: Block, name: &'static str, lead: Option<approach::Lead>) {
        match name {
            "L" | "LN" | "LP" => self.straight(block),
            "CC" => self.set_pole_here(block),
            "C" | "CP" | "CR" | "CT" | "CTP" => self.klartext_arc(block, name),
            "RND" | "CHF" => self.klartext_corner(block, name),
            "APPR LT" | "APPR LN" | "APPR CT" | "APPR LCT" => self.approach(block, name, lead),
            "DEP LT" | "DEP LN" | "DEP CT" | "DEP LCT" => self.depart(block, name),
            "TOOL CALL" => self.tool_call(block),
            "TOOL DEF" => self.tool_definition(block),
            "STOP" => self.stop(block, StopCause::MCode { code: 0 }),
            "CYCL DEF" => self.define_cycle(block),
            "CYCL CALL" => self.call_cycle(block),
            "CYCL CALL POS" => self.call_cycle_at(block),
            "MM" | "INCH" => self.modal.unit = if name == "MM" { 1.0 } else { MM_PER_INCH },
            "FUNCTION TCPM" => self.tip_control(block, "FUNCTION TCPM"),
            "FUNCTION RESET TCPM" => self.family = Family::Fanuc,
            _ if name.starts_with("TRANS") => self.transform(block, name),
            _ => {
                if name == "FUNCTION MODE TURN" {
                    self.turning.note(Sign::TurningMode, block.line, || name.to_string());
                }
                if let Some((name, what)) = UNMODELLED.iter().find(|(known, _)| *known == name) {
                    let word = block.words.iter().find(|word| word.letter == address::STATEMENT);
                    let place = word.map_or(block.place(), |word| block.place_of(word));
                    self.remark(place, KlartextRemark::Statement { name, what });
                }
            }
        }
        if matches!(name, "L" | "C" | "CR" | "CT" | "CC") && !self.given.has(POLAR_WORDS) {
            self.klartext.polar = None;
        }
    }

    /// Tool centre point control: F is that of the tip, whatever the rotary axes do.
    fn tip_control(&mut self, block: Block, name: &'static str) {
        self.family = Family::Rs274;
        self.remarks.add(block.place(), Untraced::TipControl { name });
    }

    /// F, FU, FZ, FT, F AUTO.
    fn klartext_feed(&mut self, block: Block, name: &str) {
        if matches!(name, "RND" | "CHF" | "CYCL DEF") {
            return;
        }
        let per_revolution = self.given.get(address::FEED_PER_REVOLUTION);
        if let Some(value) = per_revolution {
            self.given.set(b'F', value);
        } else if self.modal.unit == MM_PER_INCH
            && !self.klartext.has_feed_per_revolution
            && let Some(value) = self.given.get(b'F')
        {
            self.given.set(b'F', 0.1 * value);
        }
        for address in [address::FEED_PER_TOOTH, address::FEED_TIME] {
            if self.given.get(address).is_some() {
                let (name, what) = match address {
                    address::FEED_TIME => {
                        ("FT", "a feed by the time of the move is not modelled: the former F stays in force")
                    }
                    _ => (
                        "FZ",
                        "a feed per tooth needs the number of teeth, which is not known: the former F stays in force",
                    ),
                };
                self.remark(block.place_of_letter(address), KlartextRemark::Statement { name, what });
            }
        }
        if self.given.has(bits(b"F")) {
            let is_per_turn = per_revolution.is_some() || self.klartext.has_feed_per_revolution;
            self.modal.feed.mode = if is_per_turn { FeedMode::PerRevolution } else { FeedMode::PerMinute };
            self.take_feed(block, self.given.get(b'F'));
            if name == "TOOL CALL" {
                self.klartext.auto_feed = self.modal.feedrate;
            }
        }
        if let (true, Some(feedrate)) =
            (self.given.get(address::AUTO_FEED).is_some(), self.klartext.auto_feed)
        {
            self.modal.feedrate = Some(feedrate);
        }
    }

    /// M functions before or after the motion; whether M99 and M89 are among them.
    fn klartext_m_words(&mut self, block: Block, is_before: bool) -> (bool, bool) {
        let (mut called, mut is_modal) = (false, false);
        for word in block.words.iter().filter(|word| word.letter == b'M') {
            let code = Code { letter: 'M', value: word.value };
            let is_number = (0.0..=99_999_999.0).contains(&word.value) && word.value.fract() == 0.0;
            let number = word.value as u32;
            if is_before == (is_number && matches!(number, 0 | 1 | 2 | 5 | 9 | 30)) {
                continue;
            }
            self.cycle.m_word(Some(number));
            match number {
                _ if !is_number => self.remarks.add(block.place_of(word), Untraced::UnknownM { code }),
                89 => is_modal = true,
                99 => called = true,
                128 => self.tip_control(block, "M128"),
                129 => self.family = Family::Fanuc,
                136 => self.klartext.has_feed_per_revolution = true,
                137 => self.klartext.has_feed_per_revolution = false,
                3 | 4 | 5 | 19 => self.spindle_stop(block, number),
                13 | 14 => {
                    self.cycle.m_word(Some(number - 10));
                    self.spindle_stop(block, number - 10);
                    self.stop(block, StopCause::MCode { code: 8 });
                }
                _ if SILENT.contains(&number) => {}
                _ => self.stop(block, StopCause::MCode { code: number }),
            }
            if is_number && matches!(number, 2 | 30) {
                self.ended = Some(code);
            }
        }
        (called, is_modal)
    }

    fn has_m(&self, block: Block, numbers: &[f64]) -> bool {
        block.words.iter().any(|word| word.letter == b'M' && numbers.contains(&word.value))
    }

    fn tool_call(&mut self, block: Block) {
        self.settle_approach();
        if let Some(axis) = self.given.get(address::TOOL_AXIS) {
            self.modal.plane = [Plane::Yz, Plane::Zx, Plane::Xy][(axis as usize).min(2)];
        }
        let number = self.given.get(b'T').filter(|tool| (0.0..=99_999_999.0).contains(tool));
        let is_named = self.given.get(address::TOOL_NAME).is_some();
        if number.is_some() || is_named {
            self.modal.tool = number.map(|tool| tool as u32);
            let cause = self.change_tool(block);
            self.stop(block, cause);
            self.klartext.radius_difference = 0.0;
        }
        if let Some(difference) = self.given.get(address::RADIUS_DIFFERENCE) {
            self.klartext.radius_difference = difference * self.modal.unit;
        }
        self.take_speed(block);
    }

    fn tool_definition(&mut self, block: Block) {
        let tool = block.words.iter().find(|word| word.letter == address::ARGUMENT).map(|word| word.value);
        let tool = tool.filter(|tool| (0.0..=99_999_999.0).contains(tool));
        if let (Some(tool), Some(radius)) = (tool, self.given.get(address::TOOL_RADIUS)) {
            self.klartext.radii.insert(tool as u32, radius * self.modal.unit);
        }
    }

    /// Radius of the tool in use, mm, where it is known.
    fn tool_radius(&self) -> Option<f64> {
        let tool = self.modal.tool?;
        let defined = self.klartext.radii.get(&tool).copied();
        let radius = defined.or(self.machine.tools.get(&tool).map(|tool| 0.5 * tool.diameter))?;
        Some(radius + self.klartext.radius_difference)
    }

    fn tool_diameter(&self) -> Diameter {
        self.tool_radius().map_or(Diameter::Spindle, |radius| Diameter::Given(2.0 * radius))
    }

    /// What a program may ask the control for by a Q parameter that it did not set.
    pub(super) fn klartext_parameter(&self, number: u32) -> Option<f64> {
        if let Some(axis) = POSITION_PARAMETERS.iter().position(|known| *known == number) {
            return Some(self.program_position(axis));
        }
        match number {
            108 => self.tool_radius().map(|radius| radius / self.modal.unit),
            109 => Some(self.modal.plane.axes()[2] as f64),
            113 => Some(if self.modal.unit == MM_PER_INCH { 1.0 } else { 0.0 }),
            _ => None,
        }
    }

    fn moves_axes(&self) -> bool {
        self.given.has(AXIS_WORDS | POLAR_WORDS)
    }

    fn mode_of(&self) -> Mode {
        if self.given.get(address::RAPID).is_some() { Mode::Rapid } else { Mode::Straight }
    }
}
