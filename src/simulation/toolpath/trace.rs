//! The tracer: runs block after block under the modal state.

use crate::machine::{AXES, Machine};
use crate::simulation::gcode::{LineNumber, Place, Program, Remarks, Word};
use crate::simulation::toolpath::cycle::Cycle;
use crate::simulation::toolpath::plane::{Plane, Turn, tolerated_difference};
use crate::simulation::toolpath::remark::{Code, Untraced};
use crate::simulation::toolpath::words::{Meaning, Mode, NO_GROUP, Special, meaning, tenths};
use crate::simulation::toolpath::{Curve, Motion, Point, Segment, Stop, StopCause, Toolpath, Vector};
use crate::units::{MM_PER_INCH, mm_per_min, mm_per_s};

/// Feedrate of feed moves before the first F, mm/s: 1000 mm/min.
pub const ASSUMED_FEEDRATE: f64 = 1000.0 / 60.0;

/// Coordinates and radii beyond this are slips of the pen, mm.
const REACH: f64 = 1e7;

/// Moves shorter than this are rounding, mm.
const SHORTEST: f64 = 1e-9;

/// The feedrates that are taken at their word, mm/s.
const FEEDRATES: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

/// The longest dwell that is taken at its word, s: some 11 days.
const LONGEST_DWELL: f64 = 1e6;

/// The most turns of one arc.
const MOST_TURNS: f64 = 10_000.0;

/// Runs `program` on the geometry of `machine`.
pub fn trace(program: &Program, machine: &Machine) -> Toolpath {
    let mut tracer = Tracer::new(machine, program.is_tape);
    for (index, block) in program.blocks.iter().enumerate() {
        tracer.block(Block { words: program.words(block), line: block.line });
        if let Some(code) = tracer.ended {
            if let Some(next) = program.blocks.get(index + 1) {
                let blocks = program.blocks.len() - index - 1;
                tracer.remarks.add(Place::line(next.line), Untraced::AfterEnd { blocks, code });
            }
            break;
        }
    }
    tracer.end_cycle();
    let mut toolpath = tracer.toolpath;
    toolpath.diagnostics = program.diagnostics.clone();
    toolpath.diagnostics.append(&mut tracer.remarks.finish());
    toolpath.diagnostics.sort_by_key(|diagnostic| diagnostic.line);
    toolpath
}

/// The block being run.
#[derive(Clone, Copy)]
pub(super) struct Block<'a> {
    pub(super) words: &'a [Word],
    pub(super) line: LineNumber,
}

impl Block<'_> {
    fn place(self) -> Place {
        Place::line(self.line)
    }

    fn place_of(self, word: &Word) -> Place {
        Place { line: self.line, columns: word.columns }
    }

    /// Where the last word with `letter` stands.
    fn place_of_letter(self, letter: u8) -> Place {
        let word = self.words.iter().rfind(|word| word.letter == letter);
        word.map_or(self.place(), |word| self.place_of(word))
    }
}

/// The values of a block's words other than G and M, by letter.
#[derive(Default)]
pub(super) struct Given {
    letters: u32,
    values: [f64; 26],
}

const fn bits(letters: &[u8]) -> u32 {
    let (mut bits, mut index) = (0, 0);
    while index < letters.len() {
        bits |= 1 << (letters[index] - b'A');
        index += 1;
    }
    bits
}

impl Given {
    fn set(&mut self, letter: u8, value: f64) {
        self.letters |= bits(&[letter]);
        self.values[usize::from(letter - b'A')] = value;
    }

    pub(super) fn get(&self, letter: u8) -> Option<f64> {
        self.has(bits(&[letter])).then(|| self.values[usize::from(letter - b'A')])
    }

    /// Whether any of the letters is given.
    fn has(&self, letters: u32) -> bool {
        self.letters & letters != 0
    }
}

const AXIS_WORDS: u32 = bits(b"XYZ");
const CENTER_WORDS: u32 = bits(b"IJK");
const UNMODELLED_WORDS: u32 = bits(b"ABCEUVW");

/// What stays in force from block to block.
pub(super) struct Modal {
    mode: Option<Mode>,
    pub(super) plane: Plane,
    /// Millimetres in the unit of length in force.
    unit: f64,
    is_incremental: bool,
    has_incremental_center: bool,
    has_feed_per_minute: bool,
    has_exact_stop: bool,
    /// mm/s.
    feedrate: Option<f64>,
    tool: Option<u32>,
    work_offset: Option<u16>,
    has_several_offsets: bool,
}

/// What the G words of a block ask for beyond the modal state.
struct Request {
    special: Option<(Special, Code)>,
    exact_stop: bool,
    has_motion_word: bool,
    /// A G word was not understood, so that nobody knows what the axis words mean.
    is_obscure: bool,
    has_m_word: bool,
    /// The word of each modal group so far.
    groups: [Option<Code>; 15],
}

/// When an M-word acts in its block.
#[derive(Clone, Copy, PartialEq, Eq)]
enum When {
    BeforeMotion,
    AfterMotion,
}

pub(super) struct Tracer<'a> {
    machine: &'a Machine,
    /// P of G4 without a point is in milliseconds.
    is_tape: bool,
    pub(super) modal: Modal,
    pub(super) given: Given,
    pub(super) cycle: Option<Cycle>,
    /// Where the tool is, mm.
    pub(super) position: Point,
    /// Position less program coordinate, by G92 and by G52, mm.
    shift: Vector,
    local_shift: Vector,
    suspended_shift: Vector,
    /// Ask for a full stop at the end of the block's moves.
    exact_stop: bool,
    ended: Option<Code>,
    toolpath: Toolpath,
    pub(super) remarks: Remarks<Untraced>,
}

impl<'a> Tracer<'a> {
    fn new(machine: &'a Machine, is_tape: bool) -> Tracer<'a> {
        Tracer {
            machine,
            is_tape,
            modal: Modal {
                mode: None,
                plane: Plane::Xy,
                unit: 1.0,
                is_incremental: false,
                has_incremental_center: true,
                has_feed_per_minute: true,
                has_exact_stop: false,
                feedrate: None,
                tool: None,
                work_offset: None,
                has_several_offsets: false,
            },
            given: Given::default(),
            cycle: None,
            position: Point::origin(),
            shift: Vector::zeros(),
            local_shift: Vector::zeros(),
            suspended_shift: Vector::zeros(),
            exact_stop: false,
            ended: None,
            toolpath: Toolpath::default(),
            remarks: Remarks::default(),
        }
    }

    /// Runs one block in the order of execution of the module's head.
    fn block(&mut self, block: Block) {
        let request = self.take_words(block);
        self.exact_stop = self.modal.has_exact_stop || request.exact_stop;
        self.take_feed(block);
        if let Some(tool) = self.given.get(b'T') {
            self.modal.tool = whole(tool);
        }
        if request.has_m_word {
            self.m_words(block, When::BeforeMotion);
        }
        self.act(block, &request);
        if request.has_m_word {
            self.m_words(block, When::AfterMotion);
        }
    }

    /// Takes in all words: G words change the modal state, the others are kept by letter.
    fn take_words(&mut self, block: Block) -> Request {
        let mut request = Request {
            special: None,
            exact_stop: false,
            has_motion_word: false,
            is_obscure: false,
            has_m_word: false,
            groups: [None; 15],
        };
        self.given.letters = 0;
        for word in block.words {
            match word.letter {
                b'G' => self.g_word(block, word, &mut request),
                b'M' => request.has_m_word = true,
                letter => {
                    if self.given.has(bits(&[letter])) {
                        let letter = letter as char;
                        self.remarks.add(block.place_of(word), Untraced::RepeatedWord { letter });
                    }
                    self.given.set(letter, word.value);
                }
            }
        }
        request
    }

    fn g_word(&mut self, block: Block, word: &Word, request: &mut Request) {
        let code = Code { letter: 'G', value: word.value };
        let place = block.place_of(word);
        let tenths = tenths(word);
        let Some((group, meaning)) = tenths.and_then(meaning) else {
            self.remarks.add(place, Untraced::UnknownG { code });
            request.is_obscure = true;
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
                self.end_cycle();
                self.modal.mode = Some(mode);
                request.has_motion_word = true;
            }
            Meaning::Plane(plane) => self.modal.plane = plane,
            Meaning::Inch(is_inch) => self.modal.unit = if is_inch { MM_PER_INCH } else { 1.0 },
            Meaning::Incremental(is_incremental) => self.modal.is_incremental = is_incremental,
            Meaning::IncrementalCenter(is_incremental) => self.modal.has_incremental_center = is_incremental,
            Meaning::FeedPerMinute(is_so) => {
                self.modal.has_feed_per_minute = is_so.is_ok();
                if let Err(name) = is_so {
                    self.remarks.add(place, Untraced::FeedMode { code, name });
                }
            }
            Meaning::ExactStop(has_exact_stop) => self.modal.has_exact_stop = has_exact_stop,
            Meaning::ExactStopHere => request.exact_stop = true,
            Meaning::Special(special) => request.special = Some((special, code)),
            Meaning::Cycle(name) => {
                self.end_cycle();
                self.cycle = Some(Cycle { code, name, place, holes: 0 });
            }
            Meaning::CycleEnd => self.end_cycle(),
            Meaning::WorkOffset => {
                let before = self.modal.work_offset.replace(tenths.unwrap_or_default());
                let is_another = before.is_some() && before != self.modal.work_offset;
                if is_another && !self.modal.has_several_offsets {
                    self.modal.has_several_offsets = true;
                    self.remarks.add(place, Untraced::WorkOffsets { code });
                }
            }
            Meaning::Compensation => self.remarks.add(place, Untraced::Compensation { code }),
            Meaning::SurfaceSpeed => self.remarks.add(place, Untraced::SurfaceSpeed),
            Meaning::ControlSetting => self.remarks.add(place, Untraced::ControlSetting { code }),
            Meaning::Transformation(name) => self.remarks.add(place, Untraced::Transformation { code, name }),
            Meaning::Neutral => {}
        }
    }

    /// F, under G94 only: what it means in the other modes is not understood.
    fn take_feed(&mut self, block: Block) {
        let Some(value) = self.given.get(b'F').filter(|_| self.modal.has_feed_per_minute) else { return };
        let feedrate = mm_per_s(value * self.modal.unit);
        if FEEDRATES.contains(&feedrate) {
            self.modal.feedrate = Some(feedrate);
        } else {
            self.remarks.add(block.place_of_letter(b'F'), Untraced::BadFeed { value });
        }
    }

    fn m_words(&mut self, block: Block, when: When) {
        for word in block.words.iter().filter(|word| word.letter == b'M') {
            let code = Code { letter: 'M', value: word.value };
            let number = whole(word.value);
            let acts = match number {
                Some(0 | 1 | 2 | 5 | 9 | 30 | 60) => When::AfterMotion,
                _ => When::BeforeMotion,
            };
            if acts != when {
                continue;
            }
            let cause = match number {
                None => {
                    self.remarks.add(block.place_of(word), Untraced::UnknownM { code });
                    continue;
                }
                Some(97..=99 | 198) => {
                    self.remarks.add(block.place_of(word), Untraced::Subprogram { code });
                    continue;
                }
                Some(6) => StopCause::ToolChange { tool: self.modal.tool },
                Some(number) => StopCause::MCode { code: number },
            };
            self.stop(block, cause);
            if matches!(number, Some(2 | 30)) {
                self.ended = Some(code);
            }
        }
    }

    /// What the block does with its axis words.
    fn act(&mut self, block: Block, request: &Request) {
        let special = request.special;
        let is_dwell = matches!(special, Some((Special::Dwell, _)));
        if self.given.has(UNMODELLED_WORDS) && !is_dwell {
            for letter in (b'A'..=b'Z').filter(|letter| self.given.has(bits(&[*letter]) & UNMODELLED_WORDS)) {
                let remark = Untraced::UnmodelledWord { letter: letter as char };
                self.remarks.add(block.place_of_letter(letter), remark);
            }
        }
        match special {
            Some((special, code)) => self.special(block, special, code),
            None if request.is_obscure => {}
            None => self.motion(block, request.has_motion_word),
        }
    }

    fn special(&mut self, block: Block, special: Special, code: Code) {
        match special {
            Special::Dwell => self.dwell(block, code),
            Special::DataSetting => self.remarks.add(block.place(), Untraced::DataSetting),
            Special::Reference => self.reference(block),
            Special::MachineCoordinates => self.machine_coordinates(block),
            Special::SetPosition => {
                for (axis, letter) in AXES.into_iter().enumerate() {
                    if let Some(value) = self.given.get(letter as u8) {
                        let shift = self.position[axis] - value * self.modal.unit - self.local_shift[axis];
                        if self.is_within_reach(block, letter, shift) {
                            self.shift[axis] = shift;
                        }
                    }
                }
            }
            Special::LocalShift => {
                for (axis, letter) in AXES.into_iter().enumerate() {
                    if let Some(value) = self.given.get(letter as u8) {
                        let shift = value * self.modal.unit;
                        if self.is_within_reach(block, letter, shift) {
                            self.local_shift[axis] = shift;
                        }
                    }
                }
            }
            Special::ForgetShift => {
                self.shift = Vector::zeros();
                self.suspended_shift = Vector::zeros();
            }
            Special::SuspendShift => self.suspended_shift = std::mem::take(&mut self.shift),
            Special::RestoreShift => self.shift = self.suspended_shift,
        }
    }

    fn dwell(&mut self, block: Block, code: Code) {
        let given_as = |letter: u8| block.words.iter().rfind(|word| word.letter == letter);
        let Some(word) = given_as(b'P').or(given_as(b'X')).or(given_as(b'U')) else {
            self.remarks.add(block.place(), Untraced::NoDwellTime);
            return;
        };
        let milliseconds = word.letter == b'P' && !word.has_point && self.is_tape;
        if word.letter == b'P' {
            self.remarks.add(block.place_of(word), Untraced::DwellUnit { milliseconds });
        }
        let seconds = if milliseconds { word.value / 1000.0 } else { word.value };
        if (0.0..=LONGEST_DWELL).contains(&seconds) {
            self.stop(block, StopCause::Dwell { seconds });
        } else {
            self.remarks.add(block.place_of(word), Untraced::BadDwell { seconds });
        }
        let others = if word.letter == b'X' { bits(b"YZ") } else { AXIS_WORDS };
        if self.given.has(others) {
            self.remarks.add(block.place(), Untraced::UnusedAxisWords { code });
        }
    }

    /// G28 and G30: over the programmed point to the reference point, in the axes that are
    /// given, or in all where none is. One reference point serves both.
    fn reference(&mut self, block: Block) {
        let Some(over) = self.target(block) else { return };
        self.rapid_to(block, over);
        let goes = |letter: char| !self.given.has(AXIS_WORDS) || self.given.get(letter as u8).is_some();
        let axes = AXES.map(goes);
        let mut home = self.position;
        for (axis, _) in axes.into_iter().enumerate().filter(|(_, goes)| *goes) {
            home[axis] = self.home(block, axis).unwrap_or(home[axis]);
        }
        self.rapid_to(block, home);
    }

    /// G53: absolute machine coordinates, at the feedrate under G1 and in rapid otherwise.
    fn machine_coordinates(&mut self, block: Block) {
        let mut target = self.position;
        for (axis, letter) in AXES.into_iter().enumerate() {
            let Some(value) = self.given.get(letter as u8) else { continue };
            let Some(home) = self.home(block, axis) else { continue };
            target[axis] = home + value * self.modal.unit;
            if !self.is_within_reach(block, letter, target[axis]) {
                return;
            }
        }
        match self.modal.mode {
            Some(Mode::Straight) => self.feed_to(block, target),
            _ => self.rapid_to(block, target),
        }
    }

    /// Reference point of an axis, mm, or a remark that it is not known.
    fn home(&mut self, block: Block, axis: usize) -> Option<f64> {
        let home = self.machine.axes[axis].home;
        if home.is_none() {
            let (axis, key) = (AXES[axis], AXES[axis].to_ascii_lowercase());
            self.remarks.add(block.place(), Untraced::UnknownHome { axis, key });
        }
        home
    }

    /// The move of a block, where it has one.
    fn motion(&mut self, block: Block, has_motion_word: bool) {
        let has_axis_words = self.given.has(AXIS_WORDS);
        if self.cycle.is_some() {
            if has_axis_words {
                self.hole(block);
            }
            return;
        }
        let is_arc = matches!(self.modal.mode, Some(Mode::Arc(_)));
        let is_circle =
            is_arc && (self.given.has(CENTER_WORDS) || (has_motion_word && self.given.has(bits(b"R"))));
        if !has_axis_words && !is_circle {
            return;
        }
        let Some(target) = self.target(block) else { return };
        if !is_arc && self.given.has(CENTER_WORDS) {
            self.remarks.add(block.place(), Untraced::UnusedCenter);
        }
        match self.modal.mode {
            None => {
                self.remarks.add(block.place(), Untraced::NoMotionWord);
                self.modal.mode = Some(Mode::Rapid);
                self.rapid_to(block, target);
            }
            Some(Mode::Rapid) => self.rapid_to(block, target),
            Some(Mode::Straight) => self.feed_to(block, target),
            Some(Mode::Arc(turn)) => self.arc_to(block, target, turn),
        }
    }

    /// Where the axis words point, mm; none where that is out of reach.
    pub(super) fn target(&mut self, block: Block) -> Option<Point> {
        let mut target = self.position;
        for (axis, letter) in AXES.into_iter().enumerate() {
            let Some(value) = self.given.get(letter as u8) else { continue };
            let value = value * self.modal.unit;
            target[axis] = match self.modal.is_incremental {
                true => self.position[axis] + value,
                false => value + self.shift[axis] + self.local_shift[axis],
            };
            if !self.is_within_reach(block, letter, target[axis]) {
                return None;
            }
        }
        Some(target)
    }

    fn is_within_reach(&mut self, block: Block, letter: char, coordinate: f64) -> bool {
        let is_within = coordinate.abs() <= REACH;
        if !is_within {
            self.remarks.add(block.place_of_letter(letter as u8), Untraced::OutOfReach { letter });
        }
        is_within
    }

    fn arc_to(&mut self, block: Block, end: Point, turn: Turn) {
        for letter in *b"IJKR" {
            let value = self.given.get(letter).unwrap_or_default() * self.modal.unit;
            if !self.is_within_reach(block, letter as char, value) {
                return;
            }
        }
        let (ends, turns) = ((self.position, end), self.turns(block));
        let center = self.center(block, ends, turn);
        match center.and_then(|center| Ok(self.modal.plane.arc(ends, center, turn, turns)?)) {
            Ok(arc) => {
                let (start, end_radius) = (arc.start_radius, arc.end_radius);
                if tolerated_difference(start) < (start - end_radius).abs() {
                    self.remarks.add(block.place(), Untraced::UnequalRadii { start, end: end_radius });
                }
                let length = arc.length();
                let feedrate = self.feedrate(block);
                self.push(block, end, Curve::Arc(Box::new(arc)), length, Motion::Feed { feedrate });
            }
            Err(no_circle) => {
                self.remarks.add(block.place(), no_circle);
                self.feed_to(block, end);
            }
        }
    }

    /// The centre by R, or by two of I, J and K; one that is left out is that of the start.
    fn center(&mut self, block: Block, ends: (Point, Point), turn: Turn) -> Result<Point, Untraced> {
        let [a, b, _] = self.modal.plane.axes();
        let axes = [(a, self.given.get(b"IJK"[a])), (b, self.given.get(b"IJK"[b]))];
        let has_center = axes.iter().any(|(_, value)| value.is_some());
        if let Some(radius) = self.given.get(b'R') {
            if has_center {
                self.remarks.add(block.place(), Untraced::RadiusAndCenter);
            }
            return Ok(self.modal.plane.center_of_radius(ends, turn, radius * self.modal.unit)?);
        }
        if !has_center {
            return Err(Untraced::NoCenter);
        }
        let mut center = ends.0;
        for (axis, value) in axes {
            let Some(value) = value.map(|value| value * self.modal.unit) else { continue };
            center[axis] = match self.modal.has_incremental_center {
                true => ends.0[axis] + value,
                false => value + self.shift[axis] + self.local_shift[axis],
            };
        }
        Ok(center)
    }

    /// P of an arc.
    fn turns(&mut self, block: Block) -> u32 {
        match self.given.get(b'P') {
            Some(value) if (1.0..=MOST_TURNS).contains(&value) && value.fract() == 0.0 => value as u32,
            Some(value) => {
                self.remarks.add(block.place_of_letter(b'P'), Untraced::BadTurns { value });
                1
            }
            None => 1,
        }
    }

    pub(super) fn rapid_to(&mut self, block: Block, end: Point) {
        let length = (end - self.position).norm();
        self.push(block, end, Curve::Line, length, Motion::Rapid);
    }

    fn feed_to(&mut self, block: Block, end: Point) {
        let length = (end - self.position).norm();
        if SHORTEST <= length {
            let feedrate = self.feedrate(block);
            self.push(block, end, Curve::Line, length, Motion::Feed { feedrate });
        }
    }

    /// The feedrate in force, mm/s.
    fn feedrate(&mut self, block: Block) -> f64 {
        self.modal.feedrate.unwrap_or_else(|| {
            let assumed = mm_per_min(ASSUMED_FEEDRATE);
            self.remarks.add(block.place(), Untraced::NoFeed { assumed });
            ASSUMED_FEEDRATE
        })
    }

    fn push(&mut self, block: Block, end: Point, curve: Curve, length: f64, motion: Motion) {
        if length < SHORTEST {
            return;
        }
        let (start, exact_stop, line) = (self.position, self.exact_stop, block.line);
        self.toolpath.segments.push(Segment { start, end, curve, length, motion, exact_stop, line });
        self.position = end;
    }

    fn stop(&mut self, block: Block, cause: StopCause) {
        let after = self.toolpath.segments.len();
        self.toolpath.stops.push(Stop { after, cause, line: block.line });
    }
}

/// The value as a whole number, where it is one that M and T words can have.
fn whole(value: f64) -> Option<u32> {
    ((0.0..=99_999_999.0).contains(&value) && value.fract() == 0.0).then_some(value as u32)
}

#[cfg(test)]
mod tests;
