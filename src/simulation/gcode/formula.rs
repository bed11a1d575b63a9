//! Formulas as they are stored: what a word or a parameter is to get, in postfix order.
//!
//! `X[#<scale>*10.]` is the word X with the steps `scale`, `10`, `×`: each step takes its
//! operands from a stack and leaves its result there. All steps of a program lie in one table,
//! so that a program without formulas carries two empty lists. What the parameters hold is not
//! known here: that is for the stage that runs the blocks.

use crate::simulation::gcode::LineNumber;
use std::ops::Range;

/// A value of a block that has to be worked out when the block is run.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    /// The line of its block.
    pub line: LineNumber,
    /// What gets the value.
    pub target: Target,
    /// Its steps in [`Program::steps`](crate::simulation::gcode::Program::steps).
    pub steps: Range<u32>,
    /// Columns, 1-based, first and one past the last, counted in characters.
    pub columns: (u32, u32),
}

/// What gets the value of a formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// The word with this index in [`Program::words`](crate::simulation::gcode::Program::words).
    Word(u32),
    /// The parameter whose number the steps leave below the value.
    Numbered,
    /// The parameter with this index in [`Program::names`](crate::simulation::gcode::Program::names).
    Named(u32),
}

/// One step of a formula, on a stack of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Puts down a finite number.
    Number(f64),
    /// Puts down the parameter with this index in
    /// [`Program::names`](crate::simulation::gcode::Program::names).
    Named(u32),
    /// Takes a number and puts down the parameter it numbers.
    Numbered,
    /// Takes a value and puts down its negative.
    Negate,
    /// Takes a value and puts down a function of it.
    Function(Function),
    /// Takes two values, the right one first, and puts down what they make.
    Operator(Operator),
}

/// A function of one value; angles are in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Function {
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sqrt,
    Abs,
    Exp,
    Ln,
    Round,
    Fix,
    Fup,
}

/// All functions as they are written.
pub(super) const FUNCTIONS: [(&str, Function); 13] = [
    ("SIN", Function::Sin),
    ("COS", Function::Cos),
    ("TAN", Function::Tan),
    ("ASIN", Function::Asin),
    ("ACOS", Function::Acos),
    ("ATAN", Function::Atan),
    ("SQRT", Function::Sqrt),
    ("ABS", Function::Abs),
    ("EXP", Function::Exp),
    ("LN", Function::Ln),
    ("ROUND", Function::Round),
    ("FIX", Function::Fix),
    ("FUP", Function::Fup),
];

impl Function {
    /// As it is written.
    pub fn name(self) -> &'static str {
        FUNCTIONS.iter().find(|(_, function)| *function == self).map_or("", |(name, _)| name)
    }
}

/// What makes one value of two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Operator {
    Power,
    Times,
    Over,
    Modulo,
    Plus,
    Minus,
    Equal,
    NotEqual,
    Greater,
    GreaterOrEqual,
    Less,
    LessOrEqual,
    And,
    Or,
    Xor,
    /// `ATAN[left]/[right]`, which is written before its operands.
    Angle,
}

/// All operators that stand between their operands: as written, how tightly they bind. Of two
/// that begin alike the longer one comes first.
pub(super) const OPERATORS: [(&str, u8, Operator); 15] = [
    ("**", 5, Operator::Power),
    ("*", 4, Operator::Times),
    ("/", 4, Operator::Over),
    ("MOD", 4, Operator::Modulo),
    ("+", 3, Operator::Plus),
    ("-", 3, Operator::Minus),
    ("EQ", 2, Operator::Equal),
    ("NE", 2, Operator::NotEqual),
    ("GT", 2, Operator::Greater),
    ("GE", 2, Operator::GreaterOrEqual),
    ("LT", 2, Operator::Less),
    ("LE", 2, Operator::LessOrEqual),
    ("AND", 1, Operator::And),
    ("OR", 1, Operator::Or),
    ("XOR", 1, Operator::Xor),
];
