//! Formulas as they are stored: what a word or a parameter is to get, in postfix order.
//!
//! `X[#<scale>*10.]` is the word X with the steps `scale`, `10`, `×`: each step takes its
//! operands from a stack and leaves its result there. All steps of a program lie in one table,
//! so that a program without formulas carries two empty lists. What the parameters hold is not
//! known here: that is for the stage that runs the blocks.

use std::ops::Range;

/// How deep brackets and `#` may stand within each other.
pub(super) const MAX_NESTING: usize = 64;

/// A value of a block that has to be worked out when the block is run.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    /// Index of its block.
    pub block: u32,
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
    /// The argument of a statement with this index in
    /// [`Program::arguments`](crate::simulation::gcode::Program::arguments).
    StatementArgument(u32),
    /// The parameter whose number the steps leave below the value.
    Numbered,
    /// The parameter with this index in [`Program::names`](crate::simulation::gcode::Program::names).
    Named(u32),
    /// The condition of the block's jump.
    Condition,
    /// How often the block's loop or call is run.
    Count,
    /// The number of the label that the block goes to.
    Destination,
    /// The numbered parameter that a subprogram finds its argument in.
    Argument(u32),
    /// What a subprogram gives back.
    Result,
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
    /// Puts down 1 if the parameter with this index has a value, else 0.
    Exists(u32),
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
    Truncate,
    Fraction,
    Square,
    Sign,
    Not,
}

/// All functions as they are written.
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
    // Other spellings of the same.
    ("POT", Function::Square),
    ("INT", Function::Truncate),
    ("ROUNDUP", Function::Fup),
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

/// One operator as it is written, and how tightly it binds.
pub(super) type Written = (&'static str, u8, Operator);

/// The operators that stand between their operands in ISO programs. Of two that begin alike the
/// longer one comes first.
pub(super) const OPERATORS: &[Written] = &[
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

/// The same in Siemens programs.
pub(super) const SIEMENS_OPERATORS: &[Written] = &[
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

/// The same in Klartext, with the words of the FN functions.
pub(super) const KLARTEXT_OPERATORS: &[Written] = &[
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
