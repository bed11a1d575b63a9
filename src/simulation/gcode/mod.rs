//! G-code bytes → blocks: what was written, not what the machine would do.
//!
//! Reading never fails: every byte sequence gives a [`Program`], and what could not be
//! understood is in its diagnostics, each with line and columns.
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
//! Values and assignments (`#5=[1+2]`) are those of the expression module. A value that is more
//! than a number is kept as a formula, for the stage that knows what the parameters hold.
//!
//! That is ISO, which Fanuc, Haas, LinuxCNC, grbl and most others read; the dialect is found by
//! what stands in the text, or chosen. The other dialects have a reader of their own, and all
//! give the same [`Program`]: words by address, formulas, and the flow of blocks.
//!
//! A file in UTF-16 is read as what it stands for, and said.
//! A line ends with LF, CR LF or a lone CR. White space within a block means nothing, not even
//! inside a number; lower case is upper case; there is no exponent (`X1E3` is X1 and E3).
//! N words, program numbers (`O1234`, `:1234`) and checksums are no words; what a jump or a call
//! needs of them is kept as labels. A `%` line
//! opens the program, or closes it where something to run came before and no other `%` follows. Behind a
//! closing one a program number goes on with a subprogram, where something is called (DNC punch-out).
//! A word that is not a word is left out and the rest of its block kept; a block that holds
//! anything else that is not understood (a broken expression, names) is left out as a whole.
//!
//! Source: NIST RS274/NGC (Kramer, Proctor, Messina 2000), Sect. 3.3; expressions as on
//! LinuxCNC; `%`, `/` and `:` as on
//! Fanuc controls.

pub mod address;
mod branch;
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
mod reader;
mod remark;
mod siemens;
mod statement;
mod structure;
mod title;

pub use diagnostic::{Diagnostic, Place, Remark, Remarks, Severity, counted, in_line_order};
pub use dialect::{ArcCenters, Dialect};
pub use doubt::{Cause, Doubt, Effect, Letters};
pub use encoding::characters;
pub use expression::{LOCAL_PARAMETERS, STORED_PARAMETERS};
pub use flow::{Action, Destination, Direction, Flow, Label, LabelKind, SectionEnd, When};
pub use formula::{Formula, Function, Operator, Step, Target};
pub use klartext::{ContourWay, KlartextStatement, POSITION_PARAMETERS, Transformation};
pub use line::lines;
pub use number::{nearest_whole, whole_number};
pub use reader::{Options, Parts, Scope, read, read_with};
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

/// A program as it was written: all words in one list, and the blocks as ranges of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Program {
    /// The words of all blocks, in order.
    pub words: Vec<Word>,
    /// The blocks that hold at least one word, formula or action, in order.
    pub blocks: Vec<Block>,
    /// What blocks do apart from their words, by ascending block.
    pub flow: Vec<Flow>,
    /// The labels that jumps and calls may name, each with its block, ascending.
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
    /// Comments that stand alone on their line or beside a tool, in order; bounded in number and length.
    pub comments: Vec<Comment>,
    /// The control it was written for.
    pub dialect: Dialect,
    /// What I, J and K of arcs count from, if chosen.
    pub arc_centers: Option<ArcCenters>,
    /// The text has a `%` line or a program number, as programs for Fanuc and its relatives do.
    pub is_tape: bool,
    /// What could not be read, in line order.
    pub diagnostics: Vec<Diagnostic>,
    /// What that leaves in doubt, by ascending number of blocks before it.
    pub doubts: Vec<Doubt>,
}

impl Program {
    /// The words of `block`.
    pub fn words(&self, block: &Block) -> &[Word] {
        &self.words[block.words.start as usize..block.words.end as usize]
    }

    /// The formulas of the block with this index; a block does not carry them, so that plain ones
    /// stay small.
    pub fn formulas(&self, block: u32) -> &[Formula] {
        let first = self.formulas.partition_point(|formula| formula.block < block);
        let count = self.formulas[first..].partition_point(|formula| formula.block == block);
        &self.formulas[first..first + count]
    }

    /// The statements of the block with this index. The search begins at `from`, which becomes the place behind them, where
    /// those of the next block begin.
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

    /// The arguments of statements that follow one another.
    pub fn arguments(&self, statements: &[Statement]) -> &[Argument] {
        let first = statements.first().map_or(0, |statement| statement.arguments.start);
        let end = statements.last().map_or(0, |statement| statement.arguments.end);
        &self.arguments[first as usize..end as usize]
    }

    /// What reading left in doubt right before the block with this index.
    pub fn doubts_before(&self, block: u32) -> &[Doubt] {
        let first = self.doubts.partition_point(|doubt| doubt.after < block as usize);
        let count = self.doubts[first..].partition_point(|doubt| doubt.after == block as usize);
        &self.doubts[first..first + count]
    }

    /// The steps of `formula`.
    pub fn steps(&self, formula: &Formula) -> &[Step] {
        &self.steps[formula.steps.start as usize..formula.steps.end as usize]
    }
}

/// One line of the program, as a range of its words.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Where it stands.
    pub line: LineNumber,
    /// Its words in [`Program::words`].
    pub words: Range<u32>,
}

/// An address and its value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Word {
    /// Finite, in whatever unit the program uses; NaN where a formula gives it.
    pub value: f64,
    /// Where it stands in its line.
    pub columns: Columns,
    /// `A` to `Z`, or a longer address of [`address`].
    pub letter: u8,
    /// Written with a decimal point.
    pub has_point: bool,
    /// What the value counts from, where the word says so itself (`X=IC(5)`, `IX+5`).
    pub reference: Reference,
}

/// Columns of a word, 1-based, counted in characters. A long program has millions of words, so a place is
/// kept in five bytes: no more than the first 255 columns of a word are told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Columns {
    first: [u8; 4],
    width: u8,
}

impl Columns {
    /// From the first and how many they are.
    #[inline]
    pub fn of_width(first: u32, width: u8) -> Columns {
        Columns { first: first.to_ne_bytes(), width }
    }
}

impl From<(u32, u32)> for Columns {
    /// From the first and one past the last.
    #[inline]
    fn from((first, past): (u32, u32)) -> Columns {
        Columns::of_width(first, past.saturating_sub(first).min(u32::from(u8::MAX)) as u8)
    }
}

impl From<Columns> for (u32, u32) {
    /// The first and one past the last.
    fn from(columns: Columns) -> (u32, u32) {
        let first = u32::from_ne_bytes(columns.first);
        (first, first + u32::from(columns.width))
    }
}

/// What the value of a word counts from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reference {
    /// As the distance mode in force says.
    #[default]
    Modal,
    /// The origin, whatever the distance mode.
    Absolute,
    /// Where the tool is, whatever the distance mode.
    Incremental,
    /// A position of a rotary axis, gone to by the shortest way.
    Shortest,
    /// The same, gone to by turning on, with growing angles.
    Onward,
    /// The same, with falling angles.
    Backward,
}

/// A comment that may name an operation or a tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Comment {
    /// Line of the program.
    pub line: LineNumber,
    /// Its text without the signs around it, shortened.
    pub text: String,
    /// It stands alone on its line; otherwise beside a T word.
    pub is_alone: bool,
}
