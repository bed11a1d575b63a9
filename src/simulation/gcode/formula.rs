//! Formulas: values of words and parameters that the interpreter computes, in postfix order.
//!
//! `X[#<scale>*10.]` is the word X with the steps `scale`, `10`, `×`: each step takes its operands from a stack
//! and leaves its result there. All steps of a program are in one table, so a program without formulas has two
//! empty lists. The values of parameters are unknown here; the interpreter has them.

use std::ops::Range;

/// Most levels of nested brackets and `#`.
pub(super) const MAX_NESTING: usize = 64;

/// A value of a block that the interpreter computes when it runs the block.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    /// Index of its block.
    pub block: u32,
    /// The place for the value.
    pub target: Target,
    /// Its steps in [`Program::steps`](crate::simulation::gcode::Program::steps).
    pub steps: Range<u32>,
    /// Columns, 1-based, first and one past the last, counted in characters.
    pub columns: (u32, u32),
}

/// The place for the value of a formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// The word with this index in [`Program::words`](crate::simulation::gcode::Program::words).
    Word(u32),
    /// The argument of a statement with this index in
    /// [`Program::arguments`](crate::simulation::gcode::Program::arguments).
    StatementArgument(u32),
    /// The parameter whose number the steps leave below the value.
    Numbered,
    /// The parameter with this index in [`Program::names`](crate::simulation::gcode::Program::names).
    Named(u32),
    /// The condition of the block's jump.
    Condition,
    /// The number of times that the block's loop or call is run.
    Count,
    /// The number of the label that the block jumps to.
    Destination,
    /// The numbered parameter in which a subprogram finds its argument.
    Argument(u32),
    /// The result of a subprogram.
    Result,
}

/// One step of a formula, on a stack of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Pushes a finite number.
    Number(f64),
    /// Pushes the value of the parameter with this index in
    /// [`Program::names`](crate::simulation::gcode::Program::names).
    Named(u32),
    /// Pops a number and pushes the value of the parameter with that number.
    Numbered,
    /// Pushes 1 if the parameter with this index has a value, else 0.
    Exists(u32),
    /// Pops a value and pushes its negative.
    Negate,
    /// Pops a value and pushes a function of it.
    Function(Function),
    /// Pops two values, the right one first, and pushes the result of the operator.
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
    Truncate,
    Fraction,
    Square,
    Sign,
    Not,
}

/// All functions with their spelling.
pub(super) const FUNCTIONS: &[(&str, Function)] = &[
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
    ("TRUNC", Function::Truncate),
    ("FRAC", Function::Fraction),
    ("SQ", Function::Square),
    ("SGN", Function::Sign),
    ("NOT", Function::Not),
    // Other spellings.
    ("POT", Function::Square),
    ("INT", Function::Truncate),
    ("ROUNDUP", Function::Fup),
];

impl Function {
    /// Returns its spelling.
    pub fn name(self) -> &'static str {
        FUNCTIONS.iter().find(|(_, function)| *function == self).map_or("", |(name, _)| name)
    }
}

/// An operator on two values.
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
    /// The whole part of the quotient.
    Quotient,
    /// The angle whose tangent is left over right: `ATAN[left]/[right]`, `FN 13: left ANG right`.
    Angle,
    /// The root of the sum of both squares.
    Length,
    /// The lesser of both.
    Least,
    /// The greater of both.
    Greatest,
}

/// An operator: its spelling, its tightness (higher binds first) and its meaning.
pub(super) type OperatorRow = (&'static str, u8, Operator);

/// The operators of ISO programs. Of two that begin alike the longer one comes first.
pub(super) const OPERATORS: &[OperatorRow] = &[
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

/// The operators of Siemens programs.
pub(super) const SIEMENS_OPERATORS: &[OperatorRow] = &[
    ("*", 4, Operator::Times),
    ("/", 4, Operator::Over),
    ("DIV", 4, Operator::Quotient),
    ("MOD", 4, Operator::Modulo),
    ("+", 3, Operator::Plus),
    ("-", 3, Operator::Minus),
    ("==", 2, Operator::Equal),
    ("<>", 2, Operator::NotEqual),
    (">=", 2, Operator::GreaterOrEqual),
    ("<=", 2, Operator::LessOrEqual),
    (">", 2, Operator::Greater),
    ("<", 2, Operator::Less),
    ("AND", 1, Operator::And),
    ("XOR", 1, Operator::Xor),
    ("OR", 1, Operator::Or),
];

/// The operators of Klartext, with the words of the FN functions.
pub(super) const KLARTEXT_OPERATORS: &[OperatorRow] = &[
    ("^", 5, Operator::Power),
    ("*", 4, Operator::Times),
    ("/", 4, Operator::Over),
    ("DIV", 4, Operator::Over),
    ("%", 4, Operator::Modulo),
    ("+", 3, Operator::Plus),
    ("-", 3, Operator::Minus),
    ("LEN", 3, Operator::Length),
    ("ANG", 3, Operator::Angle),
    ("EQU", 2, Operator::Equal),
    ("NE", 2, Operator::NotEqual),
    ("GT", 2, Operator::Greater),
    ("LT", 2, Operator::Less),
];
