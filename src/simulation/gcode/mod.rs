//! G-code bytes → blocks: the program as written, not yet its meaning for the machine.
//!
//! Reading never fails: every byte sequence gives a [`Program`], and its diagnostics list everything that could
//! not be read, with line and columns.
//!
//! ```text
//! program = [ leader "%" line ] { line } { "%" line O number { line } } [ "%" line { anything } ]
//! line    = [ "/" [ digit ] ] [ N number ] { item } [ "*" checksum ]   end of line
//! item    = word | assignment | comment
//! word    = letter value
//! number  = [ "+" | "-" ] digits [ "." [ digits ] ]  |  [ "+" | "-" ] "." digits
//! comment = "(" … ")"  |  ";" … end of line
//! ```
//!
//! The expression module describes values and assignments (`#5=[1+2]`). A value that is more than a number becomes
//! a formula, which the interpreter computes with the values of the parameters.
//!
//! This is ISO, which Fanuc, Haas, LinuxCNC, grbl and most others read; the dialect is detected from the text, or
//! chosen. Each of the other dialects has its own reader, and all give the same [`Program`]: words by address,
//! formulas, and the flow of blocks.
//!
//! A file in UTF-16 is decoded, with a remark. A line ends with LF, CR LF or a lone CR. White space within a block is
//! ignored, even inside a number; lower case is upper case; there is no exponent (`X1E3` is X1 and E3).
//! N words, program numbers (`O1234`, `:1234`) and checksums do not become words; labels keep those that jumps and calls
//! need. A `%` line opens the program. It closes the program if blocks came before and no other `%` follows. Behind a
//! closing `%`, a program number begins a subprogram if the program calls any (DNC punch-out). A malformed word is left
//! out and the rest of its block kept; a block with any other fault (a broken expression, names) is left out as a whole.
//!
//! Source: NIST RS274/NGC (Kramer, Proctor, Messina 2000), Sect. 3.3; expressions as on LinuxCNC; `%`, `/` and `:`
//! as on Fanuc controls.

pub mod address;
mod branch;
mod computed_word;
mod dialect;
mod diagnostic;
mod diameters;
mod doubt;
mod encoding;
mod expression;
mod flow;
mod formula;
mod heidenhain;
mod iso;
mod klartext;
mod line;
mod number;
mod options;
mod reader;
mod remark;
mod siemens;
mod statement;
mod structure;
mod title;

pub use diagnostic::{Diagnostic, Place, Remark, Remarks, Severity, counted, in_line_order};
pub use dialect::{ArcCenters, Dialect};
pub use doubt::{Doubt, DoubtCause, DoubtEffect, Letters};
pub use encoding::characters;
pub use expression::{LOCAL_PARAMETERS, STORED_PARAMETERS};
pub use flow::{Action, Destination, Direction, Flow, Label, LabelKind, SectionEnd, When};
pub use formula::{Formula, Function, Operator, Step, Target};
pub use klartext::{ContourWay, KlartextStatement, POSITION_PARAMETERS, Transformation};
pub use line::lines;
pub use number::{nearest_whole, whole_number};
pub use options::Options;
pub use reader::{Parts, Scope, read, read_with};
pub use siemens::{
    DrillingCycle, DrillingKind, FrameChange, HolePattern, PatternShape, SiemensKeyword, SiemensStatement,
    ThreadPitch, Unmodelled,
};
pub use statement::{Argument, Keyword, Statement};
pub use title::title;

use std::ops::Range;

/// 1-based number of a line in the program text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct LineNumber(pub u32);

/// A program as written: all words in one list, and the blocks as ranges of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Program {
    /// The words of all blocks, in order.
    pub words: Vec<Word>,
    /// The blocks with at least one word, formula or action, in order.
    pub blocks: Vec<Block>,
    /// The actions of blocks on the order of execution, by ascending block.
    pub flow: Vec<Flow>,
    /// The labels that jumps and calls may name, each with the index of its block, ascending.
    pub labels: Vec<(Label, u32)>,
    /// The statements of all blocks, in order.
    pub statements: Vec<Statement>,
    /// The arguments of all statements, in order.
    pub arguments: Vec<Argument>,
    /// The formulas of all blocks, in order.
    pub formulas: Vec<Formula>,
    /// The steps of all formulas, in order.
    pub steps: Vec<Step>,
    /// The named parameters, lower case and without white space.
    pub names: Vec<String>,
    /// Texts that words and actions refer to by index: tool names, messages.
    pub texts: Vec<String>,
    /// Comments alone on their line or beside a tool, in order; bounded in number and length.
    pub comments: Vec<Comment>,
    /// The control it was written for.
    pub dialect: Dialect,
    /// The reference point of I, J and K of arcs, if chosen.
    pub arc_centers: Option<ArcCenters>,
    /// `true` if the text has a `%` line or a program number, as programs for Fanuc and its relatives do.
    pub is_tape: bool,
    /// The remarks of reading, in line order.
    pub diagnostics: Vec<Diagnostic>,
    /// The doubts that these leave, by ascending number of blocks before them.
    pub doubts: Vec<Doubt>,
}

impl Program {
    /// Returns the words of `block`.
    pub fn words(&self, block: &Block) -> &[Word] {
        &self.words[block.words.start as usize..block.words.end as usize]
    }

    /// Returns the formulas of the block with this index. Blocks do not store them, so that plain blocks are
    /// small.
    pub fn formulas(&self, block: u32) -> &[Formula] {
        let first = self.formulas.partition_point(|formula| formula.block < block);
        let count = self.formulas[first..].partition_point(|formula| formula.block == block);
        &self.formulas[first..first + count]
    }

    /// Returns the statements of the block with this index. The search begins at `from`, which becomes the index
    /// behind them, where the statements of the next block begin.
    pub fn statements(&self, block: u32, from: &mut usize) -> &[Statement] {
        let all = &self.statements;
        let is_first = |at: usize| {
            let begins_block = at == 0 || all[at - 1].block < block;
            begins_block && all.get(at).is_none_or(|statement| block <= statement.block)
        };
        let first = match *from {
            from if from <= all.len() && is_first(from) => from,
            _ => all.partition_point(|statement| statement.block < block),
        };
        let count = all[first..].iter().take_while(|statement| statement.block == block).count();
        *from = first + count;
        &all[first..*from]
    }

    /// Returns the arguments of consecutive statements.
    pub fn arguments(&self, statements: &[Statement]) -> &[Argument] {
        let first = statements.first().map_or(0, |statement| statement.arguments.start);
        let end = statements.last().map_or(0, |statement| statement.arguments.end);
        &self.arguments[first as usize..end as usize]
    }

    /// Returns the doubts of reading directly before the block with this index.
    pub fn doubts_before(&self, block: u32) -> &[Doubt] {
        let first = self.doubts.partition_point(|doubt| doubt.after < block as usize);
        let count = self.doubts[first..].partition_point(|doubt| doubt.after == block as usize);
        &self.doubts[first..first + count]
    }

    /// Returns the steps of `formula`.
    pub fn steps(&self, formula: &Formula) -> &[Step] {
        &self.steps[formula.steps.start as usize..formula.steps.end as usize]
    }
}

/// One line of the program, as a range of its words.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Its line in the text.
    pub line: LineNumber,
    /// Its words in [`Program::words`].
    pub words: Range<u32>,
}

/// An address and its value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Word {
    /// Its value, finite, in the unit of the program; NaN if a formula gives it.
    pub value: f64,
    /// Its columns in its line.
    pub columns: Columns,
    /// Its address: `A` to `Z`, or a longer one of [`address`].
    pub letter: u8,
    /// `true` if it is written with a decimal point.
    pub has_point: bool,
    /// The reference point of its value, if the word itself states it (`X=IC(5)`, `IX+5`).
    pub reference: Reference,
}

/// Columns of a word, 1-based, counted in characters. A long program has millions of words, so they take five
/// bytes: columns beyond the first 255 of a word are dropped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Columns {
    first: [u8; 4],
    width: u8,
}

impl Columns {
    /// Returns columns by the first and their number.
    #[inline]
    pub fn of_width(first: u32, width: u8) -> Columns {
        Columns { first: first.to_ne_bytes(), width }
    }
}

impl From<(u32, u32)> for Columns {
    /// Returns columns by the first and one past the last.
    #[inline]
    fn from((first, past): (u32, u32)) -> Columns {
        Columns::of_width(first, past.saturating_sub(first).min(u32::from(u8::MAX)) as u8)
    }
}

impl From<Columns> for (u32, u32) {
    /// Returns the first column and one past the last.
    fn from(columns: Columns) -> (u32, u32) {
        let first = u32::from_ne_bytes(columns.first);
        (first, first + u32::from(columns.width))
    }
}

/// The reference point of the value of a word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reference {
    /// By the distance mode in force.
    #[default]
    Modal,
    /// The origin, whatever the distance mode.
    Absolute,
    /// The position of the tool, whatever the distance mode.
    Incremental,
    /// A position of a rotary axis, reached by the shortest way.
    Shortest,
    /// A position of a rotary axis, reached by a turn of growing angles.
    Onward,
    /// A position of a rotary axis, reached by a turn of falling angles.
    Backward,
}

/// A comment that may name an operation or a tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Comment {
    /// Line of the program.
    pub line: LineNumber,
    /// Its text without delimiters, shortened.
    pub text: String,
    /// `true` if it is alone on its line, `false` beside a T word.
    pub is_alone: bool,
}
