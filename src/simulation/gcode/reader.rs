//! The reader: one pass over the bytes, line by line, each line by the rules of its dialect.
//!
//! A program is read as a whole, or part by part if the words of a part are not needed once the next one is read.

use crate::simulation::gcode::dialect::{detect, without_comments};
use crate::simulation::gcode::diameters::diameter_word;
use crate::simulation::gcode::doubt::{breaks_off, letters_of_line};
use crate::simulation::gcode::encoding;
use crate::simulation::gcode::expression::{Expressions, Fault, Names, Notation};
use crate::simulation::gcode::heidenhain::HeidenhainState;
use crate::simulation::gcode::line::{Line, MAX_WORDS, lines, split_line};
use crate::simulation::gcode::number::{is_blank, skip_blanks};
use crate::simulation::gcode::remark::Unread;
use crate::simulation::gcode::structure::{Open, Structures};
use crate::simulation::gcode::{
    Action, Argument, Block, Comment, Dialect, Doubt, DoubtCause, DoubtEffect, Formula, Keyword, Label,
    LabelKind, Letters, LineNumber, Options, Place, Program, Reference, Remark, Remarks, Statement, Target,
    Word,
};
use std::borrow::Cow;

/// Reads a program in the dialect detected from its text. Reading never fails: the diagnostics of the program list
/// all that is not understood, with line and columns.
///
/// # Examples
///
/// ```
/// use truefeed::simulation::gcode::{Dialect, read};
///
/// let program = read(b"G21 G90\nG1 X10 F600 (a cut)\nG1 X?20");
/// assert_eq!(program.dialect, Dialect::Iso);
/// assert_eq!(program.blocks.len(), 2, "the last one is left out as a whole");
/// assert_eq!(program.diagnostics[0].line.0, 3, "and why is said");
/// ```
pub fn read(bytes: &[u8]) -> Program {
    read_with(bytes, &Options::default())
}

/// Reads a program.
pub fn read_with(bytes: &[u8], options: &Options) -> Program {
    let mut parts = Parts::new(bytes, options, Scope::ALL).expect("all are read");
    if parts.read_on(SAMPLED_LINES) {
        parts.make_room();
        parts.read_on(u32::MAX);
    }
    parts.finish()
}

/// A program that is read part by part.
pub struct Parts<'a> {
    text: Cow<'a, [u8]>,
    is_utf16: bool,
    /// The first dash that was taken for a minus sign.
    dash: Option<(&'static str, Place)>,
    /// Number of bytes read so far.
    read: usize,
    reader: Reader<'a>,
}

impl<'a> Parts<'a> {
    /// Returns a program of which nothing is read yet, or `None` if the scope leaves its dialect out.
    pub fn new(bytes: &'a [u8], options: &'a Options, scope: Scope) -> Option<Parts<'a>> {
        let (text, is_utf16) = encoding::text(bytes);
        let (text, dash) = encoding::in_plain_signs(text);
        let dialect = options.dialect.unwrap_or_else(|| detect(&text));
        let reader = Reader::new(options, dialect, (scope.line)(dialect)?, scope.more);
        Some(Parts { text, is_utf16, dash, read: 0, reader })
    }

    /// Reads the next part of `lines` lines, and drops words and blocks of the part before. Returns `false` at the
    /// end of the program.
    pub fn next_part(&mut self, lines: u32) -> bool {
        let is_first = self.read == 0;
        self.reader.forget_blocks();
        let has_more = self.read_on(lines);
        // No earlier part was returned before the first.
        self.reader.has_restarted &= !is_first;
        has_more
    }

    /// Returns the program with words and blocks of the last part, and everything else of all parts read so far.
    pub fn part(&self) -> &Program {
        &self.reader.program
    }

    /// Returns the doubts of reading so far, by ascending number of blocks before them, counted from the first
    /// part.
    pub fn doubts(&self) -> &[Doubt] {
        &self.reader.remarks.doubts
    }

    /// Returns `true` if blocks can be run one after another as they are read: so far there is no flow, no
    /// formula, no item beyond the scope, and no sign that earlier parts do not belong to the program.
    pub fn runs_straight(&self) -> bool {
        let Program { flow, formulas, .. } = self.part();
        flow.is_empty() && formulas.is_empty() && !self.reader.is_beyond_scope && !self.reader.has_restarted
    }

    /// Returns an estimate of the number of blocks of the whole program, from the part read so far.
    pub fn expected_blocks(&self) -> usize {
        let blocks = self.reader.index() as usize;
        blocks + self.more(blocks)
    }

    /// Returns an estimate, slightly too high, of how often an item occurs in the rest of the text, given its
    /// `count` in the text read.
    fn more(&self, count: usize) -> usize {
        let rest = 1.02 * (self.text.len() as f64 / self.read.max(1) as f64 - 1.0);
        (rest * count as f64) as usize
    }

    /// Reserves memory for the rest of the text; lists that grow by doubling would for a moment take three times
    /// their size. If there is not enough memory, nothing happens.
    fn make_room(&mut self) {
        let Program { words, blocks, .. } = self.part();
        let (more_words, more_blocks) = (self.more(words.len()), self.more(blocks.len()));
        let Program { words, blocks, .. } = &mut self.reader.program;
        words.try_reserve_exact(more_words).ok();
        blocks.try_reserve_exact(more_blocks).ok();
    }

    /// Returns the program; words and blocks are those of the last part.
    pub fn finish(mut self) -> Program {
        if self.is_utf16 {
            self.reader.remarks.add(Place::line(LineNumber(1)), Unread::Utf16);
        }
        if let Some((sign, place)) = self.dash {
            self.reader.remarks.add(place, Unread::Dash { sign });
        }
        self.reader.finish(&self.text)
    }

    /// Reads up to `most` more lines. Returns `false` if there was none.
    fn read_on(&mut self, most: u32) -> bool {
        let reader = &mut self.reader;
        let mut rest = &self.text[self.read..];
        let last = reader.line.0.saturating_add(most);
        let has_more = !rest.is_empty();
        let is_iso = reader.is_iso();
        while reader.line.0 < last && !rest.is_empty() {
            reader.line.0 += 1;
            if is_iso && let Some(after) = reader.plain_line(rest) {
                rest = after;
                continue;
            }
            let Some((line, after)) = split_line(rest) else { break };
            rest = after;
            let is_percent = is_iso && line.get(skip_blanks(line, 0)) == Some(&b'%');
            if !is_percent {
                reader.block(line);
            } else if reader.percent_closes(rest) {
                reader.trailer(rest);
                rest = &[];
            }
        }
        self.read = self.text.len() - rest.len();
        reader.settle_tape();
        has_more
    }
}

/// The reason why a block is not run, with its columns.
pub(super) type Refusal = (Unread, (u32, u32));

/// Most comments that are kept.
pub(super) const MAX_COMMENTS: usize = 20_000;
/// Longest comment that is kept, in characters.
const MAX_COMMENT_CHARACTERS: usize = 80;

/// Most texts that are kept; any further text is replaced by the last one.
const MAX_TEXTS: usize = 100_000;

/// Number of lines from which the memory for the others is estimated.
const SAMPLED_LINES: u32 = 2_000;

/// A function that reads one line by the rules of a dialect.
type LineReader = fn(&mut Reader, &[u8], &mut Line) -> Result<(), Refusal>;

/// A function that reads from a byte on an item of an ISO line that is more than a letter with its number; it
/// returns the end.
type MoreReader = fn(&mut Reader, &[u8], usize, &mut Line) -> Result<usize, Refusal>;

/// The part of the dialects that is read, as functions, so that a WebAssembly module for plain programs does not
/// include the readers of the others.
#[derive(Clone, Copy)]
pub struct Scope {
    line: fn(Dialect) -> Option<LineReader>,
    more: MoreReader,
}

impl Scope {
    /// All dialects.
    pub const ALL: Scope = Scope {
        line: |dialect| {
            (Scope::STRAIGHT.line)(dialect).or(Some(match dialect {
                Dialect::Klartext => |reader, text, line| reader.klartext_line(text, line),
                _ => |reader, text, line| reader.heidenhain_iso_line(text, line),
            }))
        },
        more: |reader, text, at, line| reader.more(text, at, line),
    };

    /// The dialects whose programs may run straight. Those of Heidenhain nearly always have parameters, cycles or
    /// labels.
    pub const STRAIGHT: Scope = Scope {
        line: |dialect| match dialect {
            Dialect::Klartext | Dialect::HeidenhainIso => None,
            Dialect::Siemens => Some(|reader, text, line| reader.siemens_line(text, line)),
            _ => Some(|reader, text, line| reader.iso_line(text, line)),
        },
        more: |reader, text, at, line| reader.more(text, at, line),
    };

    /// Letters with their numbers, and comments, of ISO programs: nearly all of most programs.
    pub const PLAIN: Scope = Scope {
        line: |dialect| match dialect {
            Dialect::Klartext | Dialect::HeidenhainIso | Dialect::Siemens => None,
            _ => Some(|reader, text, line| reader.iso_line(text, line)),
        },
        more: |reader, text, _, _| {
            reader.is_beyond_scope = true;
            Ok(text.len())
        },
    };
}

/// State of reading a program.
pub(super) struct Reader<'a> {
    pub(super) options: &'a Options,
    read_line: LineReader,
    pub(super) read_more: MoreReader,
    /// `true` if the program has an item beyond its scope.
    is_beyond_scope: bool,
    pub(super) line: LineNumber,
    pub(super) program: Program,
    pub(super) names: Names,
    pub(super) remarks: Remarks<Unread>,
    pub(super) structures: Structures,
    pub(super) heidenhain: HeidenhainState,
    /// Number of blocks that began with `/`.
    pub(super) optional: usize,
    /// Line of the first of these.
    pub(super) first_optional: LineNumber,
    /// `true` if a jump may go to a block by its N number.
    pub(super) names_sequence: bool,
    /// `true` if the program calls a subprogram or a macro by its number.
    pub(super) calls: bool,
    /// `true` once a `%` line was read.
    has_percent: bool,
    /// Numbers of words, formulas, steps, actions, statements and arguments before the block being read.
    before: [usize; 6],
    /// Number of blocks that were read and dropped.
    forgotten: u32,
    /// `true` if a `%` line came behind the first part: what was read before does not belong to the program.
    has_restarted: bool,
}

impl<'a> Reader<'a> {
    fn new(
        options: &'a Options,
        dialect: Dialect,
        read_line: LineReader,
        read_more: MoreReader,
    ) -> Reader<'a> {
        Reader {
            options,
            read_line,
            read_more,
            is_beyond_scope: false,
            line: LineNumber(0),
            program: Program { dialect, arc_centers: options.arc_centers, ..Program::default() },
            names: Names::default(),
            remarks: Remarks::default(),
            structures: Structures::default(),
            heidenhain: HeidenhainState::default(),
            optional: 0,
            first_optional: LineNumber(0),
            names_sequence: false,
            calls: false,
            has_percent: false,
            before: [0; 6],
            forgotten: 0,
            has_restarted: false,
        }
    }

    /// Returns `true` for dialects with the lines of ISO, including plain ones and `%` lines.
    fn is_iso(&self) -> bool {
        !matches!(self.program.dialect, Dialect::Siemens | Dialect::Klartext | Dialect::HeidenhainIso)
    }

    /// Reads a `%` line; returns `true` if it ends the text. The text before an opening one is leader.
    fn percent_closes(&mut self, rest: &[u8]) -> bool {
        let another_follows = || lines(rest).any(|line| line.get(skip_blanks(line, 0)) == Some(&b'%'));
        let is_first = self.index() == 0 && self.remarks.is_empty();
        self.program.is_tape = true;
        if self.is_followed_by_subprogram(rest) {
            self.has_percent = true;
            return false;
        }
        if self.has_percent || (!is_first && !another_follows()) {
            return true;
        }
        self.has_percent = true;
        let blocks = self.index() as usize;
        self.forgotten = 0;
        self.has_restarted = true;
        let Program { dialect, arc_centers, .. } = self.program;
        self.program = Program { dialect, arc_centers, is_tape: true, ..Program::default() };
        self.names = Names::default();
        self.structures = Structures::default();
        self.remarks = Remarks::default();
        self.optional = 0;
        self.calls = false;
        self.before = [0; 6];
        if 0 < blocks {
            self.remarks.add(Place::line(self.line), Unread::Leader { blocks });
        }
        false
    }

    /// Returns `true` if the text behind a `%` line is a subprogram. Controls punch out a program and its
    /// subprograms one after another, each between its own `%` lines. If the program calls nothing, the text is
    /// another job. Of several `%` lines in a row the last one decides.
    fn is_followed_by_subprogram(&self, rest: &[u8]) -> bool {
        let mut signs = lines(rest).filter_map(|line| line.get(skip_blanks(line, 0)));
        self.calls
            && self.program.dialect == Dialect::Iso
            && matches!(signs.next(), Some(b'%' | b'O' | b'o' | b':'))
    }

    /// Remarks on text behind the closing `%`, which is not read.
    fn trailer(&mut self, rest: &[u8]) {
        let is_empty = |line: &[u8]| line.iter().all(|byte| is_blank(*byte) || *byte == b'%');
        if let Some(offset) = lines(rest).position(|line| !is_empty(line)) {
            let line = LineNumber(self.line.0.saturating_add(offset as u32 + 1));
            self.remarks.add(Place::line(line), Unread::Trailer);
        }
    }

    /// Returns the program, with its labels and remarks complete.
    fn finish(mut self, text: &[u8]) -> Program {
        self.remarks.set_place(self.index() as usize);
        if 0 < self.optional {
            let blocks = self.optional;
            let remark = match self.options.block_delete {
                true => Unread::OptionalSkipped { blocks },
                false => Unread::OptionalRun { blocks },
            };
            self.remarks.add(Place::line(self.first_optional), remark);
        }
        for open in self.structures.finish() {
            self.unclosed(&open);
        }
        if self.names_sequence {
            self.label_sequence(text);
        }
        self.program.labels.sort_unstable();
        self.program.labels.dedup();
        self.program.names = self.names.finish();
        self.program.doubts = std::mem::take(&mut self.remarks.doubts);
        self.program.diagnostics = self.remarks.finish();
        self.program
    }

    /// Clears the mark of tape programs for LinuxCNC and its relatives, which accept % lines but keep their own
    /// unit of dwells.
    fn settle_tape(&mut self) {
        self.program.is_tape &=
            !matches!(self.program.dialect, Dialect::LinuxCnc | Dialect::Grbl | Dialect::Mach);
    }

    /// Drops the blocks read so far, with their words and statements.
    fn forget_blocks(&mut self) {
        self.forgotten = self.index();
        self.program.blocks.clear();
        self.program.words.clear();
        self.program.statements.clear();
        self.program.arguments.clear();
        self.before = self.sizes();
    }

    /// Remarks on an opening word without its closing one; the jumps that wait for it lead to the end.
    pub(super) fn unclosed(&mut self, open: &Open) {
        let end = self.index();
        let indices: Vec<usize> = open.next.iter().chain(&open.exits).chain(&open.to_end).copied().collect();
        self.program.complete(&indices, end);
        self.remarks.add(Place::line(open.line), Unread::Unclosed { word: open.kind.word() });
    }

    /// Returns the index of the block being read.
    pub(super) fn index(&self) -> u32 {
        self.forgotten + self.program.blocks.len() as u32
    }

    /// Returns the words of the block being read.
    pub(super) fn block_words(&self) -> &[Word] {
        &self.program.words[self.before[0].min(self.program.words.len())..]
    }

    /// Returns the numbers of words, formulas, steps, actions, statements and arguments so far.
    fn sizes(&self) -> [usize; 6] {
        let Program { words, formulas, steps, flow, statements, arguments, .. } = &self.program;
        [words.len(), formulas.len(), steps.len(), flow.len(), statements.len(), arguments.len()]
    }

    /// Reads one line; a block with a fault leaves no words.
    fn block(&mut self, text: &[u8]) {
        let mut line = Line::default();
        self.remarks.set_place(self.index() as usize);
        let known_doubts = self.remarks.doubts.len();
        let outcome = (self.read_line)(self, text, &mut line);
        if let Err((remark, columns)) = outcome.and_then(|()| self.check_length()) {
            self.drop_block();
            if remark.doubt().is_none() {
                self.remarks.doubt(
                    self.line,
                    DoubtCause::BlocksNotRun,
                    DoubtEffect::Words(letters_of_line(text)),
                );
            }
            self.remarks.add(Place { line: self.line, columns }, remark);
            self.keep_diameter_word(text);
        }
        if known_doubts < self.remarks.doubts.len() && breaks_off(text) {
            self.remarks.doubt(self.line, DoubtCause::UnreadWords, DoubtEffect::Words(Letters::of(b"F")));
        }
        self.keep_comment(text, &line);
        self.end_block();
        let next = self.index();
        let skip = line.skips.filter(|index| *index < self.program.flow.len());
        self.program.complete(skip.as_slice(), next);
    }

    /// Checks the number of words and assignments of a block, so that searches in a block remain cheap.
    ///
    /// # Errors
    ///
    /// If there are more than any control accepts.
    fn check_length(&self) -> Result<(), Refusal> {
        let [words, _, _, _, statements, arguments] = self.sizes();
        let words = words + statements + arguments - self.before[0] - self.before[4] - self.before[5];
        let is_assignment =
            |formula: &&Formula| matches!(formula.target, Target::Numbered | Target::Named(_));
        let words = words + self.program.formulas.iter().skip(self.before[1]).filter(is_assignment).count();
        if words <= MAX_WORDS {
            Ok(())
        } else {
            Err((Unread::LongBlock { words }, Place::line(self.line).columns))
        }
    }

    /// Removes all that was read of the block.
    fn drop_block(&mut self) {
        let [words, formulas, steps, flow, statements, arguments] = self.before;
        self.program.words.truncate(words);
        self.program.formulas.truncate(formulas);
        self.program.steps.truncate(steps);
        self.program.flow.truncate(flow);
        self.program.statements.truncate(statements);
        self.program.arguments.truncate(arguments);
        self.structures.drop_block(self.index(), flow);
    }

    /// Keeps the word that makes X words diameters in a line that is not run: only the Siemens dialect reads it,
    /// and in every dialect it marks a lathe program.
    fn keep_diameter_word(&mut self, text: &[u8]) {
        let mut code = Vec::new();
        without_comments(&text.to_ascii_uppercase(), &mut code);
        if let Some(word) = diameter_word(&code) {
            self.push_statement(Keyword::Diameters(word), Place::line(self.line).columns);
        }
    }

    /// Ends the block being read; the rest of the line becomes another block.
    pub(super) fn end_block(&mut self) {
        let sizes = self.sizes();
        if sizes != self.before {
            let words = self.before[0] as u32..sizes[0] as u32;
            self.program.blocks.push(Block { line: self.line, words });
            self.before = sizes;
        }
    }

    /// Ends the block being read, which has words only.
    #[inline]
    pub(super) fn end_block_of_words(&mut self) {
        let (before, words) = (self.before[0], self.program.words.len());
        if MAX_WORDS < words - before {
            self.program.words.truncate(before);
            self.remarks.add(Place::line(self.line), Unread::LongBlock { words: words - before });
        } else if before < words {
            self.program.blocks.push(Block { line: self.line, words: before as u32..words as u32 });
            self.before[0] = words;
        }
    }

    /// Adds a plain word.
    pub(super) fn push_word(&mut self, letter: u8, value: f64, columns: (u32, u32)) {
        self.push_number(letter, value, true, columns);
    }

    /// Adds a word whose number is written with or without a decimal point.
    pub(super) fn push_number(&mut self, letter: u8, value: f64, has_point: bool, columns: (u32, u32)) {
        let reference = Reference::Modal;
        self.program.words.push(Word { value, columns: columns.into(), letter, has_point, reference });
    }

    /// Adds a statement to the block being read; its arguments follow.
    pub(super) fn push_statement(&mut self, keyword: Keyword, columns: (u32, u32)) {
        let (block, first) = (self.index(), self.program.arguments.len() as u32);
        let columns = columns.into();
        self.program.statements.push(Statement { block, columns, keyword, arguments: first..first });
    }

    /// Adds an argument to the last statement, with `position` others before it.
    pub(super) fn push_argument(&mut self, position: u8, value: f64) {
        self.program.arguments.push(Argument { position, value });
        if let Some(statement) = self.program.statements.last_mut() {
            statement.arguments.end += 1;
        }
    }

    /// Labels the block being read, or the next one if it is empty.
    pub(super) fn label(&mut self, kind: LabelKind, id: u32) {
        let block = self.index();
        self.program.labels.push((Label { kind, id }, block));
    }

    /// Keeps a text; returns its index.
    pub(super) fn text(&mut self, text: String) -> u32 {
        if self.program.texts.len() < MAX_TEXTS {
            self.program.texts.push(text);
        }
        self.program.texts.len() as u32 - 1
    }

    /// Adds an action of the block being read; returns its index in the flow.
    pub(super) fn act(&mut self, action: Action) -> usize {
        self.program.act(self.index(), action)
    }

    /// Adds the formula that `read` reads from the second of `starts` on, with columns from the first. Returns its
    /// end and its columns.
    pub(super) fn formula(
        &mut self,
        notation: Notation,
        text: &[u8],
        starts: (usize, usize),
        line: &mut Line,
        read: impl FnOnce(&mut Expressions) -> Result<Target, Fault>,
    ) -> Result<(usize, (u32, u32)), Refusal> {
        let first_step = self.program.steps.len() as u32;
        let (first, _) = line.columns(starts.0, starts.0);
        let mut expressions =
            Expressions::new(notation, text, starts.1, &mut self.program.steps, &mut self.names);
        let outcome = read(&mut expressions);
        let end = expressions.at;
        line.continuation += expressions.continuation;
        line.begun = true;
        let target = outcome.map_err(|(remark, bytes)| (remark, line.columns(bytes.start, bytes.end)))?;
        let (past, _) = line.columns(end, end);
        let steps = first_step..self.program.steps.len() as u32;
        let block = self.index();
        self.program.formulas.push(Formula { block, target, steps, columns: (first, past) });
        Ok((end, (first, past)))
    }

    /// Keeps the first comment of the line if it may name an operation or a tool.
    fn keep_comment(&mut self, text: &[u8], line: &Line) {
        let Some((start, end)) = line.comment else { return };
        let words = self.block_words();
        let is_alone = self.sizes() == self.before;
        if (is_alone || words.iter().any(|word| word.letter == b'T'))
            && self.program.comments.len() < MAX_COMMENTS
        {
            let text = text[start..end].trim_ascii();
            let text = text.get(..4 * MAX_COMMENT_CHARACTERS).unwrap_or(text);
            let shown = |character: char| if character.is_control() { ' ' } else { character };
            let text: String =
                encoding::characters(text).chars().take(MAX_COMMENT_CHARACTERS).map(shown).collect();
            if !text.is_empty() {
                self.program.comments.push(Comment { line: self.line, text, is_alone });
            }
        }
    }
}

#[cfg(test)]
#[path = "reader_tests.rs"]
mod tests;
