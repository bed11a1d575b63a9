//! The order of execution in blocks of Heidenhain programs: feedrates, M functions, tools and statements.

use crate::simulation::gcode::{Dialect, Keyword, KlartextStatement, Place, address};
use crate::simulation::interpreter::block::{Block, POLAR_WORDS, bits};
use crate::simulation::interpreter::bounds::MAX_TOOL_NUMBER;
use crate::simulation::interpreter::code::Code;
use crate::simulation::interpreter::feed_mode::FeedMode;
use crate::simulation::interpreter::klartext::KlartextRemark;
use crate::simulation::interpreter::klartext::remark::UNMODELLED;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::state::{Family, HeidenhainFunctions, Interpreter};
use crate::simulation::interpreter::turning::Sign;
use crate::simulation::toolpath::Motion;
use crate::simulation::toolpath::plane::Plane;
use crate::units::MM_PER_INCH;

/// The numbers of the parameters that are arguments of cycles.
const CYCLE_PARAMETERS: std::ops::Range<u32> = 200..500;

/// M functions that change neither path nor time, or that other rules search for.
const SILENT: &[u32] = &[
    6, 89, 90, 91, 92, 94, 97, 98, 99, 101, 102, 103, 107, 108, 109, 110, 111, 112, 113, 114, 115, 116, 117,
    118, 120, 124, 126, 127, 128, 129, 130, 134, 135, 136, 137, 138, 140, 141, 142, 143, 144, 145, 148, 149,
    150, 197,
];

impl HeidenhainFunctions {
    /// Returns the functions of a Heidenhain dialect; `None` for other controls.
    pub(crate) fn of(dialect: Dialect) -> Option<HeidenhainFunctions> {
        matches!(dialect, Dialect::Klartext | Dialect::HeidenhainIso).then_some(HeidenhainFunctions {
            block: |interpreter, block| interpreter.klartext_block(block),
            before_move: |interpreter, end, curve, length| {
                interpreter.klartext_before_move(end, curve, length)
            },
            end: |interpreter| {
                interpreter.run_pattern();
                interpreter.settle_approach();
            },
        })
    }
}

impl Interpreter<'_> {
    /// Runs one block.
    fn klartext_block(&mut self, block: Block) {
        self.given.clear();
        for word in block.words.iter().filter(|word| word.letter != b'M') {
            self.given.set(word.letter, word.value);
            self.given.refer(word.letter, word.reference);
        }
        let Some(statement) = block.statements.list.last() else { return };
        let Keyword::Klartext(written) = statement.keyword else { return };
        self.run_pattern();
        self.modal.has_incremental_center = false;
        self.canonical.exact_stop = self.path_mode.has_exact_stop();
        let lead = self.lead_motion(block, written);
        self.klartext_feed(block, written);
        let (called, is_modal) = self.klartext_m_words(block, true);
        self.klartext_statement(block, written, lead, statement.place(block.line));
        self.klartext_m_words(block, false);
        self.call_after_move(block, called, is_modal);
    }

    /// Runs a statement.
    fn klartext_statement(
        &mut self,
        block: Block,
        statement: KlartextStatement,
        lead: Option<Motion>,
        place: Place,
    ) {
        use KlartextStatement::*;
        match statement {
            Line | LineWithNormal | PolarLine => self.straight(block),
            CircleCenter => self.set_pole_here(block),
            Circle | PolarCircle | CircleByRadius | TangentialArc | PolarTangentialArc => {
                self.klartext_arc(block, statement);
            }
            Rounding | Chamfer => self.klartext_corner(block, statement),
            Approach(way) => self.approach(block, statement.name(), way, lead),
            Departure(way) => self.depart(block, statement.name(), way),
            ToolCall => self.tool_call(block),
            ToolDefinition => self.tool_definition(),
            Stop => self.canonical.machine_function(block.line, 0),
            CycleDefinition { number, step } => self.define_cycle(block, number, step),
            CycleCall => self.call_cycle(block),
            CycleCallAt => self.call_cycle_at(block),
            Unit { is_inch } => self.modal.unit = if is_inch { MM_PER_INCH } else { 1.0 },
            TipControl(true) => self.tip_control(block, statement.name()),
            TipControl(false) => self.family = Family::Fanuc,
            Transform(transformation) => self.transform(block, transformation),
            ResetTransform(transformation) => self.reset_transform(transformation),
            TurningMode => {
                let name = statement.name();
                self.turning.note(Sign::TurningMode, block.line, || name.to_string());
                self.no_model_of(place, name);
            }
            Unmodelled(name) => self.no_model_of(place, name),
            Functions | Neutral => {}
        }
        if matches!(statement, Line | Circle | CircleByRadius | TangentialArc | CircleCenter)
            && !self.given.has(POLAR_WORDS)
        {
            self.klartext.polar = None;
        }
    }

    /// Remarks on a statement without a model.
    fn no_model_of(&mut self, place: Place, name: &'static str) {
        if let Some((name, what)) = UNMODELLED.iter().find(|(known, _)| *known == name) {
            self.remark(place, KlartextRemark::Statement { name, what });
        }
    }

    /// Keeps the values that a block assigns to the parameters of cycles.
    pub(crate) fn keep_cycle_parameters(&mut self, assigned: &[(u32, f64)]) {
        if self.is_heidenhain() {
            let parameters = assigned.iter().filter(|(number, _)| CYCLE_PARAMETERS.contains(number));
            self.klartext.cycle.parameters.extend(parameters.copied());
        }
    }

    /// Starts tool centre point control: F is the feedrate of the tip, whatever the rotary axes do.
    fn tip_control(&mut self, block: Block, name: &'static str) {
        self.family = Family::Rs274;
        self.remarks.add(block.place(), TraceRemark::TipControl { name });
    }

    /// Runs F, FU, FZ, FT and F AUTO.
    fn klartext_feed(&mut self, block: Block, statement: KlartextStatement) {
        use KlartextStatement::{Chamfer, CycleDefinition, Rounding, ToolCall};
        if matches!(statement, Rounding | Chamfer | CycleDefinition { .. }) {
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
                    address::FEED_TIME => (
                        "FT",
                        "a feed by the time of the move is not modelled: the previous F stays in force",
                    ),
                    _ => (
                        "FZ",
                        "a feed per tooth needs the number of teeth, which is unknown: the previous F stays in force",
                    ),
                };
                self.remark(block.place_of_letter(address), KlartextRemark::Statement { name, what });
            }
        }
        if self.given.has(bits(b"F")) {
            let is_per_turn = per_revolution.is_some() || self.klartext.has_feed_per_revolution;
            self.modal.feed.mode = if is_per_turn { FeedMode::PerRevolution } else { FeedMode::PerMinute };
            self.set_feed(block, self.given.get(b'F'));
            if statement == ToolCall {
                self.klartext.auto_feed = self.modal.feedrate;
            }
        }
        if let (true, Some(feedrate)) =
            (self.given.get(address::AUTO_FEED).is_some(), self.klartext.auto_feed)
        {
            self.modal.feedrate = Some(feedrate);
        }
    }

    /// Runs the M functions before or after the motion; returns `true` for M99 and for M89 among them.
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
                _ if !is_number => self.remarks.add(block.place_of(word), TraceRemark::UnknownM { code }),
                89 => is_modal = true,
                99 => called = true,
                128 => self.tip_control(block, "M128"),
                129 => self.family = Family::Fanuc,
                136 => self.klartext.has_feed_per_revolution = true,
                137 => self.klartext.has_feed_per_revolution = false,
                3 | 4 | 5 | 19 => self.turn_spindle(block, number),
                13 | 14 => {
                    self.cycle.m_word(Some(number - 10));
                    self.turn_spindle(block, number - 10);
                    self.canonical.machine_function(block.line, 8);
                }
                _ if SILENT.contains(&number) => {}
                _ => self.canonical.machine_function(block.line, number),
            }
            if is_number && matches!(number, 2 | 30) {
                self.ended = Some(code);
            }
        }
        (called, is_modal)
    }

    /// Runs TOOL CALL.
    fn tool_call(&mut self, block: Block) {
        self.settle_approach();
        if let Some(axis) = self.given.get(address::TOOL_AXIS) {
            self.canonical.plane = [Plane::Yz, Plane::Zx, Plane::Xy][(axis as usize).min(2)];
        }
        let number = self.given.get(b'T').filter(|tool| (0.0..=MAX_TOOL_NUMBER).contains(tool));
        let is_named = self.given.get(address::TOOL_NAME).is_some();
        if number.is_some() || is_named {
            self.modal.tool = number.map(|tool| tool as u32);
            self.change_tool(block);
            self.klartext.radius_difference = 0.0;
        }
        if let Some(difference) = self.given.get(address::RADIUS_DIFFERENCE) {
            self.klartext.radius_difference = difference * self.modal.unit;
        }
        self.set_speed(block);
    }

    /// Runs TOOL DEF.
    fn tool_definition(&mut self) {
        let tool = self.given.get(address::DEFINED_TOOL);
        let tool = tool.filter(|tool| (0.0..=MAX_TOOL_NUMBER).contains(tool));
        if let (Some(tool), Some(radius)) = (tool, self.given.get(address::TOOL_RADIUS)) {
            self.klartext.radii.insert(tool as u32, radius * self.modal.unit);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::machine::Machine;
    use crate::simulation::gcode::{Dialect, Options, read_with};
    use crate::simulation::interpreter::trace;
    use crate::simulation::toolpath::StopCause;

    #[test]
    fn a_parameter_is_the_value_of_a_setting_of_din_iso() {
        let options = Options { dialect: Some(Dialect::HeidenhainIso), ..Options::default() };
        let toolpath = trace(&read_with(b"%A G71\nD00 Q5 P01 2\nG04 FQ5\n", &options), &Machine::default());
        let causes: Vec<StopCause> = toolpath.stops.iter().map(|stop| stop.cause).collect();
        assert_eq!(causes, [StopCause::Dwell { seconds: 2.0 }]);
    }
}
