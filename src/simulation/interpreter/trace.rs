//! The interpreter: runs block after block under the modal state.

use crate::machine::Machine;
use crate::simulation::gcode::{
    Columns, Dialect, LineNumber, Place, Program, Word, address, in_line_order, whole_number,
};
use crate::simulation::interpreter::block::{Block, BlockStatements, UNMODELLED_WORDS, bits};
use crate::simulation::interpreter::bounds::MAX_REPEATED;
use crate::simulation::interpreter::center::Centers;
use crate::simulation::interpreter::code::Code;
use crate::simulation::interpreter::dwell::has_dwell_by_feed;
use crate::simulation::interpreter::fast::rare;
use crate::simulation::interpreter::frame::Polar;
use crate::simulation::interpreter::parameters::{Parameters, Values};
use crate::simulation::interpreter::program_counter::ProgramCounter;
use crate::simulation::interpreter::remark::TraceRemark;
use crate::simulation::interpreter::siemens;
use crate::simulation::interpreter::spline::Spline;
use crate::simulation::interpreter::state::{HeidenhainFunctions, Interpreter, Request};
use crate::simulation::interpreter::vendor_codes;
use crate::simulation::interpreter::words::{Meaning, Mode, NO_GROUP, Special, meaning, tenths};
use crate::simulation::toolpath::Toolpath;
use crate::units::MM_PER_INCH;

/// Runs `program` on the geometry of `machine`. Running never fails: the diagnostics of the toolpath list all that
/// is not run.
///
/// # Examples
///
/// ```
/// use truefeed::machine::Machine;
/// use truefeed::simulation::{gcode::read, interpreter::trace};
///
/// let toolpath = trace(&read(b"G21 G90 G17\nG1 X10 F600\nG3 X10 Y20 J10"), &Machine::default());
/// let lengths: Vec<f64> = toolpath.segments.iter().map(|segment| segment.length).collect();
/// assert_eq!(lengths[0], 10.0, "mm");
/// assert!((lengths[1] - 10.0 * std::f64::consts::PI).abs() < 1e-9, "half a circle");
/// ```
pub fn trace(program: &Program, machine: &Machine) -> Toolpath {
    trace_within(program, machine, MAX_REPEATED)
}

/// Runs `program` as [`trace`] does, with at most `most_repeated` blocks beyond the first run of each, which loops
/// and calls repeat.
pub fn trace_within(program: &Program, machine: &Machine, most_repeated: usize) -> Toolpath {
    trace_in(program, machine, most_repeated, true)
}

/// Runs `program` as [`trace`] does, but every block by the reference path, that is by the rules for all blocks,
/// as a comparison for the fast path.
pub fn trace_by_reference(program: &Program, machine: &Machine) -> Toolpath {
    trace_in(program, machine, MAX_REPEATED, false)
}

/// Runs a program, and once more if its arcs show absolute centres.
fn trace_in(program: &Program, machine: &Machine, most_repeated: usize, is_fast: bool) -> Toolpath {
    let centers = Centers::new(program.dialect, program.arc_centers);
    let mut interpreter = run(program, machine, most_repeated, centers, is_fast);
    if interpreter.centers.show_absolute() {
        interpreter = run(program, machine, most_repeated, Centers::absolute_by_arcs(), is_fast);
    }
    interpreter.finish(program)
}

/// Runs all blocks of `program`.
fn run<'a>(
    program: &Program,
    machine: &'a Machine,
    most_repeated: usize,
    centers: Centers,
    is_fast: bool,
) -> Interpreter<'a> {
    let mut interpreter = Interpreter::new(machine, program, centers, rare::ALL);
    interpreter.takes_fast_path = is_fast;
    interpreter.heidenhain = HeidenhainFunctions::of(program.dialect);
    let mut parameters = Parameters::new(program.dialect);
    interpreter.compensation.known.add_comments(&program.comments);
    interpreter.look_for_points(program);
    // Most blocks of a long program are one move each.
    interpreter.canonical.reserve(program.blocks.len());
    let mut counter = ProgramCounter::new(program, most_repeated);
    let mut values = Values::default();
    let mut next_statement = 0;
    while let Some(index) = counter.block() {
        let block = &program.blocks[index as usize];
        let formulas = program.formulas(index);
        let statements = program.statements(index, &mut next_statement);
        interpreter.add_doubts_of_reading(program.doubts_before(index));
        if let Err((formula, no_value)) =
            parameters.values_of(program, block, statements, formulas, &interpreter, &mut values)
        {
            let place = Place { line: block.line, columns: formula.columns };
            interpreter.doubt_block(block.line, program.words(block));
            interpreter.remarks.add(place, no_value.into());
            counter.pass();
            continue;
        }
        if values.alarm {
            interpreter.remarks.add(Place::line(block.line), TraceRemark::Alarm);
            break;
        }
        if values.stop {
            interpreter.canonical.machine_function(block.line, 0);
        }
        interpreter.keep_cycle_parameters(&values.assigned);
        let (words, arguments) = match formulas.is_empty() {
            true => (program.words(block), program.arguments(statements)),
            false => (values.words.as_slice(), values.statement_arguments.as_slice()),
        };
        let (statements, line) = (BlockStatements { list: statements, arguments }, block.line);
        let scaled = interpreter.by_increments(words, program.words(block));
        let words = scaled.as_deref().unwrap_or(words);
        let outcome = if counter.has_flow() {
            let own = counter.without_call(words);
            interpreter.block(Block { words: &own, statements: &statements, line });
            counter.follow(&values, words, &mut parameters)
        } else {
            interpreter.block(Block { words, statements: &statements, line });
            counter.step()
        };
        if let Err(remark) = outcome {
            interpreter.remarks.add(Place::line(block.line), remark);
        }
        if interpreter.ended.is_some() {
            interpreter.remark_on_rest(counter.rest(index + 1));
            break;
        }
    }
    if let Some((line, parameter)) = parameters.unassigned {
        interpreter.remarks.add(Place::line(line), TraceRemark::Unassigned { parameter });
    }
    if interpreter.ended.is_none() {
        interpreter.add_doubts_of_reading(program.doubts_before(program.blocks.len() as u32));
    }
    interpreter
}

/// The time at which an M word acts in its block.
#[derive(Clone, Copy, PartialEq, Eq)]
enum MWordTiming {
    BeforeMotion,
    AfterMotion,
}

impl<'a> Interpreter<'a> {
    /// Remarks on the blocks behind the end, given the first line and their number.
    pub(super) fn remark_on_rest(&mut self, rest: Option<(LineNumber, usize)>) {
        // In Heidenhain programs, subprograms follow the end.
        let rest = rest.filter(|_| !self.is_heidenhain());
        if let Some(((line, blocks), code)) = rest.zip(self.ended) {
            self.remarks.add(Place::line(line), TraceRemark::AfterEnd { blocks, code });
        }
    }

    /// Returns the toolpath, after all blocks of the program.
    pub(super) fn finish(mut self, program: &Program) -> Toolpath {
        self.drop_nurbs();
        if let Some(end) = self.heidenhain.as_ref().map(|own| own.end) {
            end(&mut self);
        }
        self.end_path(&program.comments);
        self.remarks.set_place(self.canonical.segment_count());
        if let Some(declined) = self.declined() {
            return declined;
        }
        self.follow_doubts(Block::of_words(&[], LineNumber(0)));
        self.remark_on_missing_points();
        let doubts = std::mem::take(&mut self.remarks.doubts);
        let diagnostics = [program.diagnostics.clone(), self.remarks.finish()].concat();
        Toolpath { diagnostics: in_line_order(diagnostics), doubts, ..self.canonical.into_toolpath() }
    }

    /// Runs one block in the order of execution at the head of the `interpreter` module.
    pub(super) fn block(&mut self, block: Block) {
        self.remarks.set_place(self.canonical.segment_count());
        self.run_block(block);
        self.follow_doubts(block);
    }

    /// Runs one block, by the fast path if it is plain.
    fn run_block(&mut self, block: Block) {
        if self.note_diameters(block) {
            return;
        }
        if let Some(block_of_heidenhain) = self.heidenhain.as_ref().map(|own| own.block) {
            return block_of_heidenhain(self, block);
        }
        if self.takes_fast_path && self.plain_block(block) {
            return;
        }
        self.plain = None;
        let mut request = self.read_words(block);
        for (word, code, place) in std::mem::take(&mut request.path_words) {
            if let Some(spline) = self.spline_of(word) {
                self.cycle.end();
                self.modal.mode = Some(Mode::Spline(spline));
                request.has_motion_word = true;
                continue;
            }
            let has_cycle = request.groups[9].is_some() && self.cycle.is_active();
            let takes_p = matches!(request.special, Some((Special::Dwell, _))) || has_cycle;
            if !self.path_word(place, word, code, !takes_p) {
                self.remarks.add(place, TraceRemark::UnknownG { code });
                request.has_foreign_axis_words = true;
            }
        }
        self.canonical.exact_stop = self.path_mode.has_exact_stop() || request.exact_stop;
        self.canonical.stops_for_cycle = false;
        if matches!(request.special, Some((Special::Dwell, _))) && has_dwell_by_feed(self.dialect) {
            self.given.take(b'F');
        }
        self.set_feed(block, self.given.get(b'F'));
        if let Some(tool) = self.given.get(b'T') {
            self.modal.tool = whole_number(tool);
        } else if self.given.get(address::TOOL_NAME).is_some() {
            // A tool by its name differs from the last one by its number.
            self.modal.tool = None;
        }
        self.set_speed(block);
        self.orient_spindle(block);
        self.one_touch_change(block, request.special);
        if request.has_m_word {
            self.m_words(block, MWordTiming::BeforeMotion);
        }
        if let Some((code, place)) = request.work_offset {
            self.choose_work_offset(code, place);
        }
        if let Some(code) = request.tool_length {
            request.special = self.choose_tool_length(block, code).or(request.special);
        }
        self.compensation_word(block);
        self.act(block, &request);
        if request.has_m_word {
            self.m_words(block, MWordTiming::AfterMotion);
        }
        self.end_vendor_words();
    }

    /// Reads all words: G words change the modal state, the others are kept by letter.
    fn read_words(&mut self, block: Block) -> Request {
        let mut request = Request {
            special: None,
            exact_stop: false,
            siemens: None,
            path_words: Vec::new(),
            has_motion_word: false,
            has_foreign_axis_words: false,
            has_m_word: false,
            work_offset: None,
            tool_length: None,
            groups: [None; 15],
        };
        self.given.clear();
        let mut statements = block.statements.list.iter().peekable();
        let begin = |columns: Columns| <(u32, u32)>::from(columns).0;
        for word in block.words {
            // Items act in the order of the text.
            while let Some(before) = statements.next_if(|next| begin(next.columns) < begin(word.columns)) {
                (self.rare.siemens_statement)(self, block, before, &mut request.siemens);
            }
            match word.letter {
                b'G' => self.g_word(block, word, &mut request),
                b'M' => request.has_m_word = true,
                // Mazak's `T1 T2 M6`: the first tool comes in, the second is prepared.
                b'T' if self.dialect == Dialect::Iso && self.given.has(bits(b"T")) && changes_tool(block) => {
                }
                letter => {
                    if letter.is_ascii_uppercase() && self.given.has(bits(&[letter])) {
                        let letter = letter as char;
                        self.remarks.add(block.place_of(word), TraceRemark::RepeatedWord { letter });
                    }
                    self.given.set(letter, word.value);
                    self.given.refer(letter, word.reference);
                }
            }
        }
        for statement in statements {
            (self.rare.siemens_statement)(self, block, statement, &mut request.siemens);
        }
        self.look_for_turning(block);
        if request.has_m_word {
            self.leave_out_settings(block);
        }
        request
    }

    /// Reads a G word: changes the modal state or the request of the block.
    fn g_word(&mut self, block: Block, word: &Word, request: &mut Request) {
        let code = Code { letter: 'G', value: word.value };
        let place = block.place_of(word);
        let tenths = tenths(word);
        let own = |tenths| match self.dialect {
            Dialect::Siemens => siemens::meaning(tenths),
            dialect => vendor_codes::meaning(dialect, tenths),
        };
        let Some((group, meaning)) = tenths.and_then(|tenths| own(tenths).or_else(|| meaning(tenths))) else {
            self.remarks.add(place, TraceRemark::UnknownG { code });
            request.has_foreign_axis_words = true;
            return;
        };
        if group != NO_GROUP {
            match request.groups[group].replace(code) {
                Some(first) if first != code => {
                    self.remarks.add(place, TraceRemark::Conflict { first, second: code });
                }
                _ => {}
            }
        }
        match meaning {
            Meaning::Motion(mode) => {
                self.cycle.end();
                self.modal.mode = Some(mode);
                request.has_motion_word = true;
            }
            Meaning::Plane(plane) => self.canonical.plane = plane,
            Meaning::Inch(is_inch) => self.modal.unit = if is_inch { MM_PER_INCH } else { 1.0 },
            Meaning::Incremental(is_incremental) => self.modal.is_incremental = is_incremental,
            Meaning::IncrementalCenter(is_incremental) => {
                self.modal.has_incremental_center = is_incremental;
                self.centers.fix();
            }
            Meaning::FeedMode(mode) => self.choose_feed_mode(code, mode),
            Meaning::Path(word) => request.path_words.push((word, code, place)),
            Meaning::ExactStopHere => request.exact_stop = true,
            Meaning::Special(special) => request.special = Some((special, code)),
            Meaning::Cycle => self.begin_cycle(code, tenths.unwrap_or_default()),
            Meaning::CycleEnd => self.cycle.end(),
            Meaning::ReturnToReference(to_reference) => self.cycle.returns_to_reference = Some(to_reference),
            Meaning::WorkOffset => request.work_offset = Some((code, place)),
            Meaning::ToolLength => request.tool_length = Some(code),
            Meaning::EndOf(kind) => self.frame.unset(kind),
            Meaning::Polar(is_on) => self.frame.polar = is_on.then(Polar::default),
            Meaning::TipControl(name) => self.remarks.add(place, TraceRemark::TipControl { name }),
            Meaning::Compensation(word) => self.compensation.word = Some(word),
            Meaning::SurfaceSpeed => self.remarks.add(place, TraceRemark::SurfaceSpeed),
            Meaning::Transformation(name) => {
                self.remarks.add(place, TraceRemark::Transformation { code, name })
            }
            Meaning::TransformationAbout(name) => {
                self.remarks.add(place, TraceRemark::Transformation { code, name });
                request.has_foreign_axis_words = true;
            }
            Meaning::Vendor(word) => self.vendor_g_word(block, place, code, word, request),
            Meaning::Siemens(word) => {
                (self.rare.siemens_g_word)(self, block, place, code, word, request);
            }
            Meaning::Neutral => {}
            Meaning::NeutralAbout => request.has_foreign_axis_words = true,
        }
    }

    /// Runs the M words before or after the motion.
    fn m_words(&mut self, block: Block, when: MWordTiming) {
        for word in block.words.iter().filter(|word| word.letter == b'M') {
            let code = Code { letter: 'M', value: word.value };
            let number = whole_number(word.value);
            let acts = match number {
                Some(0 | 1 | 2 | 5 | 9 | 30 | 60) => MWordTiming::AfterMotion,
                _ => MWordTiming::BeforeMotion,
            };
            if acts != when {
                continue;
            }
            self.cycle.m_word(number);
            if self.vendor_m_word(number) {
                continue;
            }
            match number {
                None => {
                    self.remarks.add(block.place_of(word), TraceRemark::UnknownM { code });
                    continue;
                }
                Some(6) => self.change_tool(block),
                Some(number @ (3 | 4 | 5 | 19)) => self.turn_spindle(block, number),
                Some(number) => self.canonical.machine_function(block.line, number),
            }
            if self.is_end(block, number) {
                self.ended = Some(code);
            }
        }
    }

    /// Runs the axis words of the block.
    fn act(&mut self, block: Block, request: &Request) {
        let special = request.special;
        let is_nurbs = self.modal.mode == Some(Mode::Spline(Spline::Nurbs));
        if !is_nurbs && !matches!(special, Some((Special::NurbsEnd, _))) {
            self.drop_nurbs();
        }
        let is_dwell = matches!(special, Some((Special::Dwell, _)));
        if self.given.has(UNMODELLED_WORDS) && !is_dwell {
            for letter in (b'A'..=b'Z').filter(|letter| self.given.has(bits(&[*letter]) & UNMODELLED_WORDS)) {
                let remark = TraceRemark::UnmodelledWord { letter: letter as char };
                self.remarks.add(block.place_of_letter(letter), remark);
            }
        }
        if let Some(action) = &request.siemens {
            return (self.rare.siemens_act)(self, block, action);
        }
        match special {
            Some((special, code)) => self.special(block, special, code),
            None if request.has_foreign_axis_words => {}
            None => {
                self.read_rotary_words(block);
                self.motion(block, request.has_motion_word);
                self.turn_remaining(block);
                self.corner_words(block);
                (self.rare.siemens_after_move)(self, block);
            }
        }
    }
}

/// Returns `true` if the block has M6.
fn changes_tool(block: Block) -> bool {
    block.words.iter().any(|word| word.letter == b'M' && word.value == 6.0)
}

#[cfg(test)]
#[path = "trace_tests.rs"]
mod tests;
