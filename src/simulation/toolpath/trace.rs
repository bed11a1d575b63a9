//! The tracer: runs block after block under the modal state.

use crate::machine::Machine;
use crate::simulation::gcode::{
    ArcCenters, Dialect, LineNumber, Place, Program, Remarks, Word, address, in_line_order, whole_number,
};
use crate::simulation::toolpath::block::{Block, Given, UNMODELLED_WORDS, bits};
use crate::simulation::toolpath::center::Centers;
use crate::simulation::toolpath::compensation::{CompensationWords, Contour, LeadIn};
use crate::simulation::toolpath::cycle::Cycles;
use crate::simulation::toolpath::doubt::OpenDoubts;
use crate::simulation::toolpath::feed_mode::Feed;
use crate::simulation::toolpath::frame::{Frame, Polar};
use crate::simulation::toolpath::functions::Functions;
use crate::simulation::toolpath::increment::Points;
use crate::simulation::toolpath::klartext::{Heidenhain, Klartext};
use crate::simulation::toolpath::motion::has_dwell_by_feed;
use crate::simulation::toolpath::own::{self, OwnState};
use crate::simulation::toolpath::parameters::{Parameters, Values};
use crate::simulation::toolpath::path_mode::{InForce, PathWord};
use crate::simulation::toolpath::plain::Plain;
use crate::simulation::toolpath::plane::Plane;
use crate::simulation::toolpath::remark::{Code, Untraced};
use crate::simulation::toolpath::rotary::Rotary;
use crate::simulation::toolpath::run::{MOST_REPEATED, Run};
use crate::simulation::toolpath::siemens::{self, Siemens, Statement};
use crate::simulation::toolpath::spline::{Spline, SplineState};
use crate::simulation::toolpath::turning::Turning;
use crate::simulation::toolpath::words::{Meaning, Mode, NO_GROUP, Special, meaning, tenths};
use crate::simulation::toolpath::{Point, Stop, StopCause, Toolpath};
use crate::units::MM_PER_INCH;

/// Runs `program` on the geometry of `machine`.
pub fn trace(program: &Program, machine: &Machine) -> Toolpath {
    trace_within(program, machine, MOST_REPEATED)
}

/// The same with a bound of its own: blocks that loops and calls may run beyond once each.
pub fn trace_within(program: &Program, machine: &Machine, most_repeated: usize) -> Toolpath {
    let centers = Centers::new(program.dialect, program.arc_centers);
    let mut tracer = run(program, machine, most_repeated, centers);
    if tracer.centers.show_absolute() {
        tracer = run(program, machine, most_repeated, Centers::shown());
    }
    tracer.finish(program)
}

/// Runs all blocks of `program`.
fn run<'a>(program: &Program, machine: &'a Machine, most_repeated: usize, centers: Centers) -> Tracer<'a> {
    let mut tracer = Tracer::new(machine, program, centers);
    tracer.heidenhain = Heidenhain::of(program.dialect);
    let mut parameters = Parameters::new(program.dialect);
    tracer.compensation.known.hear(&program.comments);
    tracer.look_for_points(program);
    // Most blocks of a long program are one move each.
    tracer.toolpath.segments.try_reserve_exact(program.blocks.len()).ok();
    let mut run = Run::new(program, most_repeated);
    let mut values = Values::default();
    while let Some(index) = run.block() {
        let block = &program.blocks[index as usize];
        let formulas = program.formulas(index);
        tracer.doubt_as_read(program.doubts_before(index));
        if let Err((formula, no_value)) = parameters.values_of(program, block, formulas, &tracer, &mut values)
        {
            let place = Place { line: block.line, columns: formula.columns };
            tracer.doubt_block(block.line, program.words(block));
            tracer.remarks.add(place, no_value.into());
            run.pass();
            continue;
        }
        if values.alarm {
            tracer.remarks.add(Place::line(block.line), Untraced::Alarm);
            break;
        }
        if values.stop {
            tracer.stop(Block { words: &[], line: block.line }, StopCause::MCode { code: 0 });
        }
        let words = if formulas.is_empty() { program.words(block) } else { &values.words };
        let scaled = tracer.by_increments(words, program.words(block));
        let words = scaled.as_deref().unwrap_or(words);
        let outcome = if run.has_flow() {
            let own = run.without_call(words);
            tracer.block(Block { words: &own, line: block.line });
            run.follow(&values, words, &mut parameters)
        } else {
            tracer.block(Block { words, line: block.line });
            run.step()
        };
        if let Err(remark) = outcome {
            tracer.remarks.add(Place::line(block.line), remark);
        }
        if tracer.ended.is_some() {
            tracer.tell_rest(run.rest(index + 1));
            break;
        }
    }
    if let Some((line, parameter)) = parameters.unassigned {
        tracer.remarks.add(Place::line(line), Untraced::Unassigned { parameter });
    }
    if tracer.ended.is_none() {
        tracer.doubt_as_read(program.doubts_before(program.blocks.len() as u32));
    }
    tracer
}

/// What stays in force from block to block.
pub(super) struct Modal {
    pub(super) mode: Option<Mode>,
    pub(super) plane: Plane,
    /// Millimetres in the unit of length in force.
    pub(super) unit: f64,
    pub(super) is_incremental: bool,
    pub(super) has_incremental_center: bool,
    pub(super) feed: Feed,
    /// By F under G94, mm/s.
    pub(super) feedrate: Option<f64>,
    pub(super) tool: Option<u32>,
    pub(super) has_work_offset: bool,
    pub(super) has_several_offsets: bool,
}

/// What the G words of a block ask for beyond the modal state.
pub(super) struct Request {
    pub(super) special: Option<(Special, Code)>,
    pub(super) exact_stop: bool,
    /// What a statement of a SINUMERIK program asks for.
    pub(super) statement: Option<Statement>,
    path_words: Vec<(PathWord, Code, Place)>,
    has_motion_word: bool,
    /// The axis words belong to a G word that is not run.
    pub(super) has_foreign_axis_words: bool,
    has_m_word: bool,
    work_offset: Option<(Code, Place)>,
    pub(super) tool_length: Option<Code>,
    /// The word of each modal group so far.
    groups: [Option<Code>; 15],
}

/// When an M-word acts in its block.
#[derive(Clone, Copy, PartialEq, Eq)]
enum When {
    BeforeMotion,
    AfterMotion,
}

/// Whose rules hold where controls read the same word in two ways.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Family {
    /// RS274/NGC and LinuxCNC: G10 L20 names the position, G10 L2 R turns X Y, G52 is a G92 by
    /// its values, F holds along X Y Z.
    #[default]
    Rs274,
    /// Fanuc and Haas: G10 L20 gives the values of G54.1 Pn, G10 under G91 adds, F counts a degree
    /// of a rotary axis as a unit of length.
    Fanuc,
}

impl Family {
    fn of(dialect: Dialect) -> Family {
        match dialect {
            // TNC controls too count a degree of a rotary axis as a millimetre.
            Dialect::Iso | Dialect::Okuma | Dialect::Klartext | Dialect::HeidenhainIso => Family::Fanuc,
            _ => Family::Rs274,
        }
    }
}

/// The modal state, and what came out so far.
pub(super) struct Tracer<'a> {
    pub(super) machine: &'a Machine,
    /// Times without a point are in milliseconds.
    pub(super) is_tape: bool,
    pub(super) modal: Modal,
    pub(super) given: Given,
    pub(super) cycle: Cycles,
    /// Where the tool is, mm.
    pub(super) position: Point,
    /// From program coordinates to the machine's.
    pub(super) frame: Frame,
    /// Where the last probing move ended, mm.
    pub(super) probed: Option<Point>,
    pub(super) rotary: Rotary,
    pub(super) family: Family,
    pub(super) dialect: Dialect,
    pub(super) siemens: Siemens,
    pub(super) own: OwnState,
    pub(super) spline: SplineState,
    pub(super) klartext: Klartext,
    pub(super) heidenhain: Option<Heidenhain>,
    /// Ask for a full stop at the end of the block's moves.
    pub(super) exact_stop: bool,
    /// As long as nothing else is run than plain blocks; none where it is to be looked for.
    pub(super) plain: Option<Plain>,
    pub(super) functions: Functions,
    pub(super) path_mode: InForce,
    pub(super) ended: Option<Code>,
    pub(super) compensation: CompensationWords,
    pub(super) contour: Contour,
    pub(super) points: Points,
    pub(super) turning: Turning,
    pub(super) doubts: OpenDoubts,
    pub(super) centers: Centers,
    pub(super) toolpath: Toolpath,
    pub(super) remarks: Remarks<Untraced>,
}

impl<'a> Tracer<'a> {
    /// Before the first block of `program`.
    pub(super) fn new(machine: &'a Machine, program: &Program, centers: Centers) -> Tracer<'a> {
        let Program { dialect, is_tape, arc_centers, .. } = *program;
        Tracer {
            machine,
            is_tape: is_tape || dialect == Dialect::Okuma,
            modal: Modal {
                mode: None,
                plane: Plane::Xy,
                unit: 1.0,
                is_incremental: false,
                has_incremental_center: !centers.are_absolute() && arc_centers != Some(ArcCenters::Absolute),
                feed: Feed::default(),
                feedrate: None,
                tool: None,
                has_work_offset: false,
                has_several_offsets: false,
            },
            given: Given::default(),
            cycle: Cycles::default(),
            position: Point::origin(),
            frame: Frame::new(machine),
            probed: None,
            rotary: Rotary::default(),
            family: Family::of(dialect),
            dialect,
            siemens: Siemens::default(),
            own: OwnState::default(),
            spline: SplineState::default(),
            klartext: Klartext::default(),
            heidenhain: None,
            exact_stop: false,
            plain: None,
            functions: Functions::default(),
            path_mode: InForce::default(),
            ended: None,
            compensation: CompensationWords::default(),
            contour: Contour::new(lead_in(dialect)),
            points: Points::default(),
            turning: Turning::default(),
            doubts: OpenDoubts::default(),
            centers,
            toolpath: Toolpath { dialect, ..Toolpath::default() },
            remarks: Remarks::default(),
        }
    }

    /// Tells of what stands behind the end, by its first line and how many blocks.
    pub(super) fn tell_rest(&mut self, rest: Option<(LineNumber, usize)>) {
        // Subprograms stand behind the end of Heidenhain programs.
        let rest = rest.filter(|_| !self.is_heidenhain());
        if let Some(((line, blocks), code)) = rest.zip(self.ended) {
            self.remarks.add(Place::line(line), Untraced::AfterEnd { blocks, code });
        }
    }

    /// The toolpath, once all blocks of the program are run.
    pub(super) fn finish(mut self, program: &Program) -> Toolpath {
        self.forget_nurbs();
        if let Some(end) = self.heidenhain.as_ref().map(|own| own.end) {
            end(&mut self);
        }
        self.end_contour();
        self.find_operations(&program.comments);
        self.remarks.look_behind(self.toolpath.segments.len());
        self.tell_missing_points();
        if let Some(declined) = self.declined() {
            return declined;
        }
        self.follow_doubts(Block { words: &[], line: LineNumber(0) });
        let doubts = std::mem::take(&mut self.remarks.doubts);
        let diagnostics = [program.diagnostics.clone(), self.remarks.finish()].concat();
        Toolpath { diagnostics: in_line_order(diagnostics), doubts, ..self.toolpath }
    }

    /// Runs one block in the order of execution of the module's head.
    pub(super) fn block(&mut self, block: Block) {
        self.remarks.look_behind(self.toolpath.segments.len());
        self.run_block(block);
        self.follow_doubts(block);
    }

    fn run_block(&mut self, block: Block) {
        if let Some(block_of_heidenhain) = self.heidenhain.as_ref().map(|own| own.block) {
            return block_of_heidenhain(self, block);
        }
        if self.plain_block(block) {
            return;
        }
        self.plain = None;
        let mut request = self.take_words(block);
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
                self.remarks.add(place, Untraced::UnknownG { code });
                request.has_foreign_axis_words = true;
            }
        }
        self.exact_stop = self.path_mode.has_exact_stop() || request.exact_stop;
        if matches!(request.special, Some((Special::Dwell, _))) && has_dwell_by_feed(self.dialect) {
            self.given.take(b'F');
        }
        self.take_feed(block, self.given.get(b'F'));
        if let Some(tool) = self.given.get(b'T') {
            self.modal.tool = whole_number(tool);
        } else if self.given.get(address::TOOL_NAME).is_some() {
            // A tool by its name is another one than the last by its number.
            self.modal.tool = None;
        }
        self.take_speed(block);
        self.orient_spindle(block);
        self.one_touch_change(block, request.special);
        if request.has_m_word {
            self.m_words(block, When::BeforeMotion);
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
            self.m_words(block, When::AfterMotion);
        }
        self.end_own_words();
    }

    /// Takes in all words: G words change the modal state, the others are kept by letter.
    fn take_words(&mut self, block: Block) -> Request {
        let mut request = Request {
            special: None,
            exact_stop: false,
            statement: None,
            path_words: Vec::new(),
            has_motion_word: false,
            has_foreign_axis_words: false,
            has_m_word: false,
            work_offset: None,
            tool_length: None,
            groups: [None; 15],
        };
        self.given.clear();
        for word in block.words {
            match word.letter {
                b'G' => self.g_word(block, word, &mut request),
                b'M' => request.has_m_word = true,
                address if address::ARGUMENT <= address => {}
                address::STATEMENT if self.dialect == Dialect::Siemens => {
                    self.siemens_statement(block, word, &mut request.statement);
                }
                // Mazak's `T1 T2 M6`: the first comes in, the second is got ready.
                b'T' if self.dialect == Dialect::Iso && self.given.has(bits(b"T")) && changes_tool(block) => {
                }
                letter => {
                    if letter.is_ascii_uppercase() && self.given.has(bits(&[letter])) {
                        let letter = letter as char;
                        self.remarks.add(block.place_of(word), Untraced::RepeatedWord { letter });
                    }
                    self.given.set(letter, word.value);
                    self.given.refer(letter, word.reference);
                }
            }
        }
        self.look_for_turning(block);
        if request.has_m_word {
            self.leave_out_settings(block);
        }
        request
    }

    fn g_word(&mut self, block: Block, word: &Word, request: &mut Request) {
        let code = Code { letter: 'G', value: word.value };
        let place = block.place_of(word);
        let tenths = tenths(word);
        let own = |tenths| match self.dialect {
            Dialect::Siemens => siemens::meaning(tenths),
            dialect => own::meaning(dialect, tenths),
        };
        let Some((group, meaning)) = tenths.and_then(|tenths| own(tenths).or_else(|| meaning(tenths))) else {
            self.remarks.add(place, Untraced::UnknownG { code });
            request.has_foreign_axis_words = true;
            return;
        };
        if group != NO_GROUP {
            match request.groups[group].replace(code) {
                Some(first) if first != code => {
                    self.remarks.add(place, Untraced::Conflict { first, second: code });
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
            Meaning::Plane(plane) => self.modal.plane = plane,
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
            Meaning::ReturnToReference(is_so) => self.cycle.returns_to_reference = Some(is_so),
            Meaning::WorkOffset => request.work_offset = Some((code, place)),
            Meaning::ToolLength => request.tool_length = Some(code),
            Meaning::EndOf(kind) => self.frame.unset(kind),
            Meaning::Polar(is_on) => self.frame.polar = is_on.then(Polar::default),
            Meaning::TipControl(name) => self.remarks.add(place, Untraced::TipControl { name }),
            Meaning::Compensation(word) => self.compensation.word = Some(word),
            Meaning::SurfaceSpeed => self.remarks.add(place, Untraced::SurfaceSpeed),
            Meaning::Transformation(name) => self.remarks.add(place, Untraced::Transformation { code, name }),
            Meaning::TransformationAbout(name) => {
                self.remarks.add(place, Untraced::Transformation { code, name });
                request.has_foreign_axis_words = true;
            }
            Meaning::Own(word) => self.own_g_word(block, place, code, word, request),
            Meaning::Siemens(word) => self.siemens_g_word(block, place, code, word, request),
            Meaning::Neutral => {}
            Meaning::NeutralAbout => request.has_foreign_axis_words = true,
        }
    }

    fn m_words(&mut self, block: Block, when: When) {
        for word in block.words.iter().filter(|word| word.letter == b'M') {
            let code = Code { letter: 'M', value: word.value };
            let number = whole_number(word.value);
            let acts = match number {
                Some(0 | 1 | 2 | 5 | 9 | 30 | 60) => When::AfterMotion,
                _ => When::BeforeMotion,
            };
            if acts != when {
                continue;
            }
            self.cycle.m_word(number);
            if self.own_m_word(number) {
                continue;
            }
            let cause = match number {
                None => {
                    self.remarks.add(block.place_of(word), Untraced::UnknownM { code });
                    continue;
                }
                Some(6) => self.change_tool(block),
                Some(number @ (3 | 4 | 5 | 19)) => self.turn_spindle(block, number),
                Some(number) => StopCause::MCode { code: number },
            };
            self.stop(block, cause);
            if self.is_end(block, number) {
                self.ended = Some(code);
            }
        }
    }

    /// What the block does with its axis words.
    fn act(&mut self, block: Block, request: &Request) {
        let special = request.special;
        let is_nurbs = self.modal.mode == Some(Mode::Spline(Spline::Nurbs));
        if !is_nurbs && !matches!(special, Some((Special::NurbsEnd, _))) {
            self.forget_nurbs();
        }
        let is_dwell = matches!(special, Some((Special::Dwell, _)));
        if self.given.has(UNMODELLED_WORDS) && !is_dwell {
            for letter in (b'A'..=b'Z').filter(|letter| self.given.has(bits(&[*letter]) & UNMODELLED_WORDS)) {
                let remark = Untraced::UnmodelledWord { letter: letter as char };
                self.remarks.add(block.place_of_letter(letter), remark);
            }
        }
        if let Some(statement) = request.statement {
            self.siemens_act(block, statement);
            return;
        }
        match special {
            Some((special, code)) => self.special(block, special, code),
            None if request.has_foreign_axis_words => {}
            None => {
                self.take_rotary(block);
                self.motion(block, request.has_motion_word);
                self.turn_the_rest(block);
                self.corner_words(block);
                self.siemens_after_move(block);
            }
        }
    }

    pub(super) fn stop(&mut self, block: Block, cause: StopCause) {
        let after = self.toolpath.segments.len();
        self.stop_in_contour(Stop { after, cause, line: block.line });
    }
}

/// Whether M6 stands in the block.
fn changes_tool(block: Block) -> bool {
    block.words.iter().any(|word| word.letter == b'M' && word.value == 6.0)
}

/// How cutter compensation begins.
fn lead_in(dialect: Dialect) -> LeadIn {
    match dialect {
        Dialect::Iso | Dialect::Okuma | Dialect::Siemens => LeadIn::SquareToNext,
        _ => LeadIn::SquareToItself,
    }
}

#[cfg(test)]
mod tests;
